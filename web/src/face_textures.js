// Textures that change with a face's shapes (the twin of mien.blendshapes.build.masks.texture_weights).
import * as THREE from "three";
import { MOST_BLENDED } from "./shaders.js";
import { textureOf } from "./picture_texture.js";

const FAINT = 1e-3; // shares below this are none
const SWEEPS = 40; // of coordinate descent: shares of a dozen captures have settled

const EMPTY = new THREE.DataArrayTexture(new Uint8Array(4), 1, 1, 1);
EMPTY.needsUpdate = true;

export const noShares = () => ({
  captures: { value: EMPTY }, masks: { value: null }, sharing: { value: 0 },
  blended: { value: Array.from({ length: MOST_BLENDED }, () => new THREE.Vector4()) },
});

export class FaceTextures {
  constructor(told, file, uniforms) {
    Object.assign(this, { uniforms, count: told.captures.length, ready: false });
    for (const name of ["gram", "mixes", "regions"]) this[name] = file.array(told[name]);
    this.shares = new Float32Array(this.count);
    this.loading = this.load(told, file);
  }

  async load(told, file) {
    this.uniforms.masks.value = await textureOf(file.picture(told.masks));
    this.uniforms.captures.value = await layered(told.captures.map((one) => file.picture(one)));
    this.ready = true;
    this.tell();
  }

  // c in 0..1, the least of c' gram c / 2 - c' mixes w.
  setWeights(weights) {
    const { count, gram, mixes, shares } = this, wanted = new Float32Array(count);
    for (let k = 0; k < count; k++) for (let i = 0; i < weights.length; i++) wanted[k] += mixes[k * weights.length + i] * weights[i];
    for (let sweep = 0; sweep < SWEEPS; sweep++) for (let k = 0; k < count; k++) {
      let pull = wanted[k];
      for (let j = 0; j < count; j++) pull -= gram[k * count + j] * shares[j];
      shares[k] = Math.min(Math.max(shares[k] + pull / gram[k * count + k], 0), 1);
    }
    this.tell();
  }

  tell() {
    const strongest = [...this.shares.keys()].filter((k) => this.shares[k] > FAINT).sort((a, b) => this.shares[b] - this.shares[a]).slice(0, MOST_BLENDED);
    strongest.forEach((k, i) => this.uniforms.blended.value[i].set(...this.regions.subarray(3 * k, 3 * k + 3).map((on) => on * this.shares[k]), k));
    this.uniforms.sharing.value = this.ready ? strongest.length : 0;
  }
}

// Pictures of one size as the layers of one texture, bottom row first as all of a face's are.
async function layered(blobs) {
  const images = await Promise.all(blobs.map((blob) => createImageBitmap(blob, { imageOrientation: "flipY", colorSpaceConversion: "none" })));
  if (!images.length) return EMPTY;
  const { width, height } = images[0], all = new Uint8Array(4 * width * height * images.length);
  const canvas = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  images.forEach((image, k) => { canvas.drawImage(image, 0, 0); all.set(canvas.getImageData(0, 0, width, height).data, 4 * width * height * k); });
  const texture = new THREE.DataArrayTexture(all, width, height, images.length);
  Object.assign(texture, { wrapS: THREE.RepeatWrapping, wrapT: THREE.RepeatWrapping, magFilter: THREE.LinearFilter, minFilter: THREE.LinearMipmapLinearFilter, generateMipmaps: true, needsUpdate: true });
  return texture;
}
