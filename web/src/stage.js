// The picture: camera, lamp, one view for each face, and what lies over it.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { raw, run } from "./gpu_face.js";
import { BACKDROP, COVER } from "./shaders.js";

const FOV = 24, FREE = 0.06; // degrees over the shorter side; share of the picture left free on every side
const KEY = new THREE.Vector3(-0.55, 0.62, 0.72).normalize(); // towards the key lamp, camera space
export const SHADOW_MM = 1.5; // half the width of a shadow's edge
export const PRESETS = { front: [0, 0], left: [35, 5], right: [-35, 5], "left side": [88, 0], "right side": [-88, 0], below: [0, -28] };

export class Stage {
  constructor(canvas) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    if (!this.renderer.getContext().getExtension("EXT_color_buffer_float")) throw new Error("this page needs WebGL 2 with float targets");
    this.renderer.autoClear = false;
    this.camera = new THREE.PerspectiveCamera(FOV, 1, 1, 1e5);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.touch());
    this.views = []; // one a face: { face, scene, overlay }
    this.through = null; // of a picture's size, the matrices of a camera that the face is seen through, with nothing behind it
    this.backdrop = raw(COVER, BACKDROP, {}, { depthTest: false, depthWrite: false });
    this.shadows = new THREE.WebGLRenderTarget(64, 64, { type: THREE.FloatType, format: THREE.RedFormat, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
    this.picked = new THREE.WebGLRenderTarget(1, 1, { type: THREE.FloatType, format: THREE.RGBAFormat });
    this.dirty = true;
  }

  add(face) {
    const scene = new THREE.Scene(), overlay = new THREE.Group();
    overlay.matrixAutoUpdate = false;
    scene.add(face.mesh, overlay);
    const view = { face, scene, overlay };
    this.views.push(view);
    face.onready = () => this.touch();
    return view;
  }

  touch() { this.dirty = true; }

  // Middle and radius of what is shown, at rest.
  bounds(face) {
    if (face.bounds) return face.bounds;
    const at = face.neutral.image.data, low = [1e9, 1e9, 1e9], high = [-1e9, -1e9, -1e9];
    for (let i = 0; i < face.count; i++) for (let d = 0; d < 3; d++) {
      low[d] = Math.min(low[d], at[4 * i + d]); high[d] = Math.max(high[d], at[4 * i + d]);
    }
    const middle = new THREE.Vector3(...low.map((x, d) => (x + high[d]) / 2));
    let radius = 0;
    for (let i = 0; i < face.count; i++) radius = Math.max(radius, Math.hypot(...[0, 1, 2].map((d) => at[4 * i + d] - middle.getComponent(d))));
    const top = new THREE.Vector3(...high).sub(middle);
    return (face.bounds = { middle, radius, top });
  }

  frame(name = "front") {
    const { middle, top, radius } = this.bounds(this.views[0].face), [yaw, pitch] = PRESETS[name].map((x) => (x * Math.PI) / 180);
    const [wide, high] = this.shape(), aspect = wide / high, half = Math.tan((FOV * Math.PI) / 360) * (1 - 2 * FREE);
    const side = Math.max(top.x, top.z), [across, up] = aspect < 1 ? [half, half / aspect] : [half * aspect, half]; // tangents
    const away = Math.max(top.y / up, side / across) + 0.5 * radius;
    const direction = new THREE.Vector3(Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), Math.cos(yaw) * Math.cos(pitch));
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(direction, away);
    this.camera.near = away / 50; this.camera.far = away * 20;
    this.fixed = null;
    this.controls.update();
    this.touch();
  }

  // Near a place of the world, seen from between where the camera is and outside.
  near(place, radius) {
    const { middle } = this.bounds(this.views[0].face), out = place.clone().sub(middle).normalize();
    const direction = this.camera.position.clone().sub(this.controls.target).normalize().add(out).normalize();
    this.controls.target.copy(place);
    this.camera.position.copy(place).addScaledVector(direction, radius / Math.tan((FOV * Math.PI) / 360));
    this.fixed = null;
    this.controls.update();
    this.touch();
  }

  shape() { const { width, height } = this.renderer.domElement; return [width / Math.max(this.views.length, 1), height]; }

  resize() {
    const { clientWidth, clientHeight, width, height } = this.renderer.domElement, ratio = this.size ? 1 : window.devicePixelRatio || 1;
    const [w, h] = this.size ?? [Math.round(clientWidth * ratio), Math.round(clientHeight * ratio)];
    if (w === width && h === height) return;
    this.renderer.setSize(w, h, false);
    this.touch();
  }

  draw() {
    this.resize();
    if (!this.dirty) return false;
    this.dirty = false;
    for (const { face } of this.views) face.update(this.renderer);
    const [wide, high] = this.shape(), { camera, renderer } = this;
    camera.aspect = wide / high;
    camera.fov = camera.aspect >= 1 ? FOV : (Math.atan(Math.tan((FOV * Math.PI) / 360) / camera.aspect) * 360) / Math.PI;
    camera.updateProjectionMatrix();
    if (this.through) this.fixed = this.through(wide, high);
    if (this.fixed) { camera.matrixAutoUpdate = false; camera.matrixWorld.fromArray(this.fixed.matrix); camera.projectionMatrix.fromArray(this.fixed.projection); camera.matrix.copy(camera.matrixWorld); camera.matrixWorldInverse.copy(camera.matrixWorld).invert(); } else { camera.matrixAutoUpdate = true; camera.updateMatrixWorld(); }
    renderer.setScissorTest(true);
    this.views.forEach((view, i) => {
      this.light(view);
      renderer.setViewport(i * wide, 0, wide, high);
      renderer.setScissor(i * wide, 0, wide, high);
      renderer.setClearColor(0x000000, 0);
      renderer.clear();
      if (!this.through) run(renderer, this.backdrop, null);
      this.depth(view.face);
      renderer.render(view.scene, camera);
      if (view.wireframe) this.lines(view);
    });
    renderer.setScissorTest(false);
    return true;
  }

  // The nearest surface alone: what lies behind it is not shaded.
  depth(face) {
    face.mesh.material = face.depthMaterial;
    this.renderer.render(face.mesh, this.camera);
    face.mesh.material = face.material;
  }

  lines({ face, scene, overlay }) {
    face.mesh.material = face.wire; overlay.visible = false;
    this.renderer.render(scene, this.camera);
    face.mesh.material = face.material; overlay.visible = true;
  }

  // Where a point of the world is in the window, in one of the views.
  onScreen(place, index) {
    const box = this.renderer.domElement.getBoundingClientRect(), wide = box.width / this.views.length, at = place.clone().project(this.camera);
    return [box.left + wide * (index + (at.x + 1) / 2), box.top + (box.height * (1 - at.y)) / 2];
  }

  // The face under a point of the window, and where on it; null where there is none.
  pick(x, y) {
    const { renderer, camera } = this, box = renderer.domElement.getBoundingClientRect(), wide = box.width / this.views.length;
    const index = Math.floor((x - box.left) / wide), view = this.views[index];
    if (!view) return null;
    const across = (2 * (x + 0.5 - box.left)) / wide - 2 * index - 1, up = 1 - (2 * (y + 0.5 - box.top)) / box.height;
    const whole = camera.projectionMatrix.clone();
    camera.projectionMatrix.premultiply(new THREE.Matrix4().set(wide, 0, 0, -wide * across, 0, box.height, 0, -box.height * up, 0, 0, 1, 0, 0, 0, 0, 1));
    view.face.mesh.material = view.face.pickMaterial;
    renderer.setRenderTarget(this.picked);
    renderer.setScissorTest(false);
    renderer.setClearColor(0x000000, 0);
    renderer.clear();
    renderer.render(view.face.mesh, camera);
    const read = new Float32Array(4);
    renderer.readRenderTargetPixels(this.picked, 0, 0, 1, 1, read);
    renderer.setRenderTarget(null);
    view.face.mesh.material = view.face.material;
    camera.projectionMatrix.copy(whole);
    return read[3] ? { index, place: Array.from(read.subarray(0, 3)) } : null;
  }

  // What the lamp sees, from where it stands beside the camera.
  light({ face, scene }) {
    const { renderer, camera, shadows } = this, { middle, radius } = this.bounds(face);
    face.mesh.updateMatrixWorld(true);
    const seen = middle.clone().applyMatrix4(face.mesh.matrixWorld).applyMatrix4(camera.matrixWorldInverse);
    const across = new THREE.Vector3(0, 1, 0).cross(KEY).normalize(), up = KEY.clone().cross(across);
    const size = Math.min(Math.max(Math.round((4 * radius) / SHADOW_MM), 128), 1024) + 12, reach = (radius * 1.08 * size) / (size - 12);
    if (shadows.width !== size) shadows.setSize(size, size);
    const rows = [across, up, KEY.clone().negate()].flatMap((axis) => [axis.x / reach, axis.y / reach, axis.z / reach, -axis.dot(seen) / reach]);
    face.uniforms.lamp.value.set(...rows, 0, 0, 0, 1);
    Object.assign(face.uniforms.radius, { value: reach });
    face.uniforms.shadow.value = null;
    face.mesh.material = face.lampMaterial;
    renderer.setRenderTarget(shadows);
    renderer.setScissorTest(false);
    renderer.setClearColor(0x000000, 0);
    renderer.clear();
    const overlays = scene.children.filter((one) => one !== face.mesh && one.visible);
    overlays.forEach((one) => { one.visible = false; });
    renderer.render(scene, camera);
    overlays.forEach((one) => { one.visible = true; });
    renderer.setRenderTarget(null);
    renderer.setScissorTest(true);
    face.mesh.material = face.material;
    face.uniforms.shadow.value = shadows.texture;
  }
}
