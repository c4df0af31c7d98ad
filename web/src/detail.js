// The detail page: a take with its displacement maps, evaluated frame by frame on the GPU.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { detailFragment, detailVertex } from "./detail_shaders.js";

const AWAY = 3.2; // radii from the face's middle
const FIELD_DEG = 42;

const input = (name) => document.getElementById(name);
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const floats = (text) => new Float32Array(bytes(text));

// Three numbers a texel as four: what GPUs filter and three.js knows.
function fourth(values, kind) {
  const out = new kind(values.length / 3 * 4);
  for (let i = 0, j = 0; i < values.length; i += 3, j += 4) out.set(values.subarray(i, i + 3), j);
  return out;
}

function ready(texture, type, filter) {
  Object.assign(texture, { type, format: THREE.RGBAFormat, minFilter: filter, magFilter: filter, needsUpdate: true });
  return texture;
}

class DetailPage {
  constructor(D) {
    this.D = D;
    const canvas = input("picture");
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace; // the shader encodes
    this.renderer.setClearColor(new THREE.Color().setHex(0x17181a, THREE.LinearSRGBColorSpace));
    this.camera = new THREE.PerspectiveCamera(FIELD_DEG, 1, D.radius / 20, 40 * D.radius);
    const middle = new THREE.Vector3(...D.middle);
    this.camera.position.copy(middle).add(new THREE.Vector3(0, 0, AWAY * D.radius));
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.target.copy(middle);
    this.controls.update();
    this.amounts = floats(D.amounts);
    this.forms = floats(D.forms);
    this.material = new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, vertexShader: detailVertex(D), fragmentShader: detailFragment, uniforms: this.uniforms(), side: THREE.DoubleSide });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * D.vertices), 3)); // three.js counts it
    geometry.setAttribute("place", new THREE.BufferAttribute(floats(D.place), 3));
    geometry.setAttribute("kind", new THREE.BufferAttribute(floats(D.kind), 1));
    geometry.setAttribute("uv", new THREE.BufferAttribute(floats(D.uv), 2));
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes(D.faces)), 1));
    this.face = new THREE.Mesh(geometry, this.material);
    this.face.frustumCulled = false;
    this.scene = new THREE.Scene().add(this.face);
    for (const part of [input("colours"), document.querySelector("label[for=colours]")]) part.hidden = !D.reflectance;
  }

  uniforms() {
    const { D } = this, values = {}, layers = (text, count) => ready(new THREE.DataArrayTexture(fourth(floats(text), Float32Array), D.width, D.rows, count), THREE.FloatType, THREE.NearestFilter);
    values.modes = layers(D.modes_texture, 3 * (D.modes + 1));
    values.coefficients = layers(D.coefficients, 8);
    for (const name of ["fine", "medium"]) {
      const half = new Uint16Array(bytes(D[name])), size = D[`${name}_size`], split = 4 * size * size;
      values[`${name}4`] = ready(new THREE.DataTexture(half.subarray(0, split), size, size), THREE.HalfFloatType, THREE.LinearFilter);
      values[`${name}2`] = ready(new THREE.DataTexture(half.subarray(split), size, size), THREE.HalfFloatType, THREE.LinearFilter);
    }
    const size = D.reflectance ? D.medium_size : 1, colours = D.reflectance ? fourth(new Uint16Array(bytes(D.reflectance)), Uint16Array) : new Uint16Array(32);
    values.reflectance = ready(new THREE.DataArrayTexture(colours, size, size, 8), THREE.HalfFloatType, THREE.LinearFilter);
    values.forms = ready(new THREE.DataTexture(new Float32Array(12 * D.triangles), 3, D.triangles), THREE.FloatType, THREE.NearestFilter);
    Object.assign(values, { amount: new Float32Array(D.modes), fine: 1, medium: 1, light: 0, fields: false, colours: false, readback: 0 });
    return Object.fromEntries(Object.entries(values).map(([name, value]) => [name, { value }]));
  }

  show(frame) {
    const { D, material: { uniforms } } = this, count = 12 * D.triangles;
    uniforms.amount.value = this.amounts.subarray(frame * D.modes, (frame + 1) * D.modes);
    uniforms.forms.value.image.data.set(this.forms.subarray(frame * count, (frame + 1) * count));
    uniforms.forms.value.needsUpdate = true;
    for (const name of ["medium", "fine", "light"]) uniforms[name].value = Number(input(name).value);
    uniforms.fields.value = input("fields").checked;
    uniforms.colours.value = Boolean(D.reflectance) && input("colours").checked;
  }

  draw(frame) {
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement;
    this.renderer.setPixelRatio(window.devicePixelRatio || 1);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.show(frame);
    this.renderer.render(this.scene, this.camera);
  }

  // Every vertex's place and fine height (1), or albedo (2), as the shader finds them, one texel each: what tests compare
  // with the library.
  check(frame, what) {
    const { D, renderer } = this, target = new THREE.WebGLRenderTarget(D.width, D.rows, { type: THREE.FloatType, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
    const geometry = this.face.geometry.clone().setIndex(null), points = new THREE.Points(geometry, this.material);
    points.frustumCulled = false;
    this.show(frame);
    this.material.uniforms.readback.value = what;
    renderer.setRenderTarget(target);
    renderer.render(new THREE.Scene().add(points), this.camera);
    const out = new Float32Array(4 * D.width * D.rows);
    renderer.readRenderTargetPixels(target, 0, 0, D.width, D.rows, out);
    return btoa(Array.from(new Uint8Array(out.buffer), (byte) => String.fromCharCode(byte)).join(""));
  }

  run() {
    const { D } = this;
    input("frame").max = D.frames - 1;
    input("controls").addEventListener("submit", (event) => event.preventDefault());
    input("frame").addEventListener("input", () => { input("play").checked = false; });
    const asked = location.hash.match(/(check|albedo)=(\d+)/), still = location.hash.match(/frame=(\d+)/);
    if (asked) {
      const found = document.createElement("pre");
      found.id = "readback";
      found.textContent = this.check(Number(asked[2]), asked[1] === "check" ? 1 : 2);
      document.body.replaceChildren(found);
      return;
    }
    if (still) {
      input("play").checked = false;
      input("frame").value = still[1];
    }
    const step = (now) => {
      if (input("play").checked) input("frame").value = Math.floor(now / 1000 * D.rate) % D.frames;
      this.draw(Number(input("frame").value));
      input("told").textContent = `frame ${input("frame").value} of ${D.frames}`;
      requestAnimationFrame(step);
    };
    step(0);
  }
}

export function showDetail(D) {
  try { (window.detail = new DetailPage(D)).run(); } catch (fault) { input("told").textContent = String(fault.message ?? fault); throw fault; }
}
