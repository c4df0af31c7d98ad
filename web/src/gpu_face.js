// A face whose shape is made on the GPU: shapes summed, subdivided, normals found anew, all in textures.
import * as THREE from "three";
import { FaceTextures, noShares } from "./face_textures.js";
import { textureOf } from "./picture_texture.js";
import { COVER, DEPTH_FRAGMENT, DEPTH_VERTEX, FACE_FRAGMENT, FACE_VERTEX, LAMP_FRAGMENT, LAMP_VERTEX, MORPH, NORMALS, PICK_FRAGMENT, PICK_VERTEX, SUBDIVIDE, WIDTH } from "./shaders.js";

const SKIN = [0.8, 0.66, 0.58], WHITE = [0.88, 0.86, 0.84]; // of faces without colours: skin, eyes
export const SILENT = 1e-5; // weights below this are none

const cover = new THREE.Mesh(new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3)));
cover.frustumCulled = false;
const coverScene = new THREE.Scene().add(cover);
const coverCamera = new THREE.Camera();

export const raw = (vertexShader, fragmentShader, uniforms, more = {}) =>
  new THREE.RawShaderMaterial({ vertexShader, fragmentShader, uniforms, glslVersion: THREE.GLSL3, ...more });

function floats(data, channels, width = WIDTH) {
  const format = { 1: THREE.RedFormat, 2: THREE.RGFormat, 4: THREE.RGBAFormat }[channels];
  const texture = new THREE.DataTexture(data, width, data.length / channels / width, format, THREE.FloatType);
  texture.needsUpdate = true;
  return texture;
}

function target(count) {
  return new THREE.WebGLRenderTarget(WIDTH, Math.max(Math.ceil(count / WIDTH), 1), {
    type: THREE.FloatType, format: THREE.RGBAFormat, depthBuffer: false,
    minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter,
  });
}

const BLANK = new THREE.DataTexture(new Uint8Array([128, 128, 128, 255]), 1, 1);
BLANK.needsUpdate = true;

export class GpuFace {
  constructor(told, file, palette) {
    Object.assign(this, { told, names: told.names, count: told.vertices });
    this.steps = file.array(told.steps);
    this.weights = new Float32Array(told.names.length);
    this.used = floats(new Float32Array(2 * Math.max(told.names.length, 1)), 2, Math.max(told.names.length, 1));
    const neutral = floats(file.array(told.neutral), 4);
    this.neutral = neutral;
    const layers = Math.max(told.names.length, 1), rows = neutral.image.height;
    this.deltas = told.names.length ? file.array(told.deltas) : new Int16Array(3 * WIDTH * rows);
    this.deltaTexels = WIDTH * rows;
    const deltas = new THREE.DataArrayTexture(this.deltas, WIDTH, rows, layers);
    Object.assign(deltas, { format: "RGB_INTEGER", type: THREE.ShortType, internalFormat: "RGB16I", needsUpdate: true });
    this.morph = { material: raw(COVER, MORPH, { neutral: { value: neutral }, used: { value: this.used }, deltas: { value: deltas }, count: { value: 0 } }), target: target(told.vertices) };
    const lists = (name, shader, from, count) => ({
      material: raw(COVER, shader, {
        places: { value: from.target.texture },
        spans: { value: floats(file.array(told[name].spans), 2) }, entries: { value: floats(file.array(told[name].entries), 2) },
      }),
      target: target(count),
    });
    this.finer = told.subdivide ? lists("subdivide", SUBDIVIDE, this.morph, told.fine) : this.morph;
    this.turned = lists("around", NORMALS, this.finer, told.fine);
    this.still = target(told.fine);
    this.mesh = this.surface(file, palette);
    this.stale = true;
  }

  surface(file, palette) {
    const { told } = this, geometry = new THREE.BufferGeometry(), source = Float32Array.from(file.array(told.source));
    const attribute = (name, size, values) => geometry.setAttribute(name, new THREE.BufferAttribute(values, size));
    attribute("source", 1, source);
    attribute("sky", 2, file.array(told.sky));
    attribute("uv", 2, told.uv ? file.array(told.uv) : new Float32Array(2 * source.length));
    const material = file.array(told.material), plain = (i) => (material[2 * Math.floor(i / 3)] > 0.5 ? WHITE : SKIN)[i % 3];
    attribute("material", 2, material);
    attribute("colour", 3, told.colors ? file.array(told.colors) : new Float32Array(3 * source.length).map((_, i) => plain(i)));
    geometry.setIndex(new THREE.BufferAttribute(file.array(told.faces), 1));
    geometry.setDrawRange(0, file.array(told.faces).length);
    const eyes = [0, 1].map((i) => new THREE.Vector4(...(told.eyes?.[i] ?? [0, 0, 0, 0])));
    this.uniforms = {
      places: { value: this.finer.target.texture }, normals: { value: this.turned.target.texture },
      others: { value: this.still.texture }, still: { value: this.still.texture }, palette: { value: palette },
      skin: { value: BLANK }, textured: { value: false }, shadow: { value: null }, lamp: { value: new THREE.Matrix4() },
      radius: { value: 1 }, limit: { value: 5 }, opened: { value: 0 },
      heat: { value: 0 }, look: { value: 0 }, lines: { value: false }, eyes: { value: eyes }, ...noShares(),
    };
    this.material = raw(FACE_VERTEX, FACE_FRAGMENT, this.uniforms, { side: THREE.DoubleSide });
    this.wire = raw(FACE_VERTEX, FACE_FRAGMENT, { ...this.uniforms, lines: { value: true } }, { wireframe: true, transparent: true, depthFunc: THREE.LessEqualDepth, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1 });
    this.depthMaterial = raw(DEPTH_VERTEX, DEPTH_FRAGMENT, { places: this.uniforms.places }, { side: THREE.DoubleSide, colorWrite: false });
    this.lampMaterial = raw(LAMP_VERTEX, LAMP_FRAGMENT, { places: this.uniforms.places, lamp: this.uniforms.lamp }, { side: THREE.DoubleSide });
    this.pickMaterial = raw(PICK_VERTEX, PICK_FRAGMENT, { places: this.uniforms.places }, { side: THREE.DoubleSide });
    const mesh = new THREE.Mesh(geometry, this.material);
    mesh.frustumCulled = false;
    mesh.matrixAutoUpdate = false;
    if (told.captures) {
      this.textures = new FaceTextures(told, file, this.uniforms);
      this.textures.loading.then(() => this.onready?.());
    }
    if (told.texture) textureOf(file.picture(told.texture)).then((texture) => { this.uniforms.skin.value = texture; this.uniforms.textured.value = true; this.texture = texture; this.onready?.(); });
    return mesh;
  }

  // Take over weights; the passes run when the face is next drawn.
  setWeights(weights) {
    let same = !this.stale;
    for (let k = 0; same && k < weights.length; k++) same = weights[k] === this.weights[k];
    if (same) return;
    this.weights.set(weights);
    this.textures?.setWeights(weights);
    const pairs = this.used.image.data;
    let count = 0;
    for (let k = 0; k < weights.length; k++) {
      if (Math.abs(weights[k]) < SILENT) continue;
      pairs[2 * count] = k; pairs[2 * count++ + 1] = weights[k] * this.steps[k];
    }
    this.used.needsUpdate = true;
    this.morph.material.uniforms.count.value = count;
    this.uniforms.opened.value = this.told.opens < 0 ? 0 : weights[this.told.opens];
    this.stale = true;
  }

  setPose(matrix) { this.mesh.matrix.copy(matrix); this.mesh.matrixWorldNeedsUpdate = true; }

  // Run the passes where weights have changed.
  update(renderer) {
    if (!this.stale) return;
    if (!this.settled) {
      const count = this.morph.material.uniforms.count.value;
      this.morph.material.uniforms.count.value = 0;
      run(renderer, this.morph.material, this.morph.target);
      if (this.finer !== this.morph) run(renderer, this.finer.material, this.still);
      else run(renderer, this.morph.material, this.still);
      this.morph.material.uniforms.count.value = count;
      this.settled = true;
    }
    run(renderer, this.morph.material, this.morph.target);
    if (this.finer !== this.morph) run(renderer, this.finer.material, this.finer.target);
    run(renderer, this.turned.material, this.turned.target);
    this.stale = false;
  }

  // Places of the vertices as the GPU has them (fine: after subdivision), for tests, picking and the frame.
  read(renderer, fine = false) {
    const { target, count } = fine ? { target: this.finer.target, count: this.told.fine } : { target: this.morph.target, count: this.count };
    return readTexels(renderer, target, count);
  }

  readNormals(renderer) { return readTexels(renderer, this.turned.target, this.told.fine); }
}

function readTexels(renderer, from, count) {
  const all = new Float32Array(4 * from.width * from.height);
  renderer.readRenderTargetPixels(from, 0, 0, from.width, from.height, all);
  const out = new Float32Array(3 * count);
  for (let i = 0; i < count; i++) for (let d = 0; d < 3; d++) out[3 * i + d] = all[4 * i + d];
  return out;
}

export function run(renderer, material, into) {
  const before = renderer.getRenderTarget();
  cover.material = material;
  renderer.setRenderTarget(into);
  renderer.render(coverScene, coverCamera);
  renderer.setRenderTarget(before);
}
