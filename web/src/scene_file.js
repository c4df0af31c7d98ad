// The binary that a page loads (src/mien/viewer/scene_file.py): header, then arrays.
const KINDS = { f4: Float32Array, i2: Int16Array, u4: Uint32Array, u2: Uint16Array, u1: Uint8Array };

export class SceneFile {
  constructor(buffer) {
    const length = new DataView(buffer).getUint32(0, true);
    this.buffer = buffer;
    this.start = 4 + length;
    this.header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  }

  array(told) {
    const count = told.shape.reduce((a, b) => a * b, 1);
    return new KINDS[told.type](this.buffer, this.start + told.at, count);
  }

  picture(told) {
    return new Blob([new Uint8Array(this.buffer, this.start + told.at, told.bytes)], { type: told.mime });
  }
}

// The scene beside the page: from the server, or, in a page that was written out, from a script.
export async function loadScene(address) {
  if (!window.MIEN_SCENE) {
    const answer = await fetch(address);
    if (!answer.ok) throw new Error(`${answer.status}: ${await answer.text()}`);
    return new SceneFile(await answer.arrayBuffer());
  }
  const packed = Uint8Array.from(atob(window.MIEN_SCENE), (c) => c.charCodeAt(0));
  window.MIEN_SCENE = null;
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new SceneFile(await new Response(stream).arrayBuffer());
}
