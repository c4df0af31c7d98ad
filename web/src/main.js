// The studio's page: loads the scene, makes a face of each thing, and lets them be played and looked at.
import * as THREE from "three";
import { Alive } from "./alive.js";
import { Clock } from "./clock.js";
import { Correspond } from "./correspond.js";
import { CorrectPanel } from "./correct.js";
import { showDetail } from "./detail.js";
import { button, choice, heading, make, row, save, toggle } from "./dom.js";
import { Edits } from "./edits.js";
import { film } from "./film.js";
import { Live } from "./live.js";
import { OverFilm } from "./over_film.js";
import { GpuFace } from "./gpu_face.js";
import { MapPanel } from "./map.js";
import { MarkersPanel } from "./markers.js";
import { Motion } from "./motion.js";
import { MarkerNames } from "./marker_names.js";
import { filmOf, MarkerCloud } from "./overlays.js";
import { address, served } from "./remote.js";
import { loadScene } from "./scene_file.js";
import { Sliders } from "./sliders.js";
import { PRESETS, Stage } from "./stage.js";
import { Timeline } from "./timeline.js";

const told = document.getElementById("told");
const WATCH_MS = 2000; // between two looks at whether files have changed
const began = performance.now();

function paletteOf(file) {
  const colours = file.array(file.header.palette), count = colours.length / 3, data = new Uint8Array(4 * count);
  for (let i = 0; i < count; i++) for (let d = 0; d < 4; d++) data[4 * i + d] = d < 3 ? Math.round(255 * colours[3 * i + d]) : 255;
  const texture = new THREE.DataTexture(data, count, 1);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

// When the page's files were last written; null where nobody answers.
const stampNow = () => fetch(address("stamp")).then((answer) => (answer.ok ? answer.text() : ""), () => null);

class Studio {
  // `stamp` says when the files of the page were written.
  constructor(file, stamp) {
    const { header } = file, decoded = performance.now();
    this.stamp = stamp;
    this.stage = new Stage(document.getElementById("canvas"));
    const palette = paletteOf(file);
    this.shown = header.faces.map((one, i) => {
      const face = new GpuFace(one, file, palette), motion = one.motion && new Motion(one.motion, file);
      const edits = motion && new Edits(i, one.name, () => this.corrected());
      return { name: one.name, kind: one.kind, face, motion, edits, view: this.stage.add(face), weights: new Float32Array(one.names.length), held: new Map(), alive: motion && new Alive(one.names, motion) };
    });
    this.current = this.shown[0];
    Object.defineProperty(this, "edits", { get: () => this.current.edits });
    const moving = this.shown.filter((one) => one.motion);
    const duration = Math.max(0, ...moving.map(({ motion }) => (motion.frames - 1) / motion.rate));
    this.clock = new Clock(duration, moving[0]?.motion.rate ?? 30);
    this.chosen = new Set();
    this.pose = new THREE.Matrix4();
    this.stillHead = false;
    this.clouds = header.markers.map((one) => new MarkerCloud(one, file));
    for (const cloud of this.clouds) this.current.view.scene.add(cloud.points);
    this.compare();
    this.show();
    this.page(header);
    this.clock.listen(() => this.show());
    const opening = (window.MIEN_OPENING ?? new URLSearchParams(location.search).get("opening") ?? "").split(",");
    this.stage.frame("front");
    this.clock.set(0);
    this.ready = Promise.all(moving.map(({ edits }) => edits.load()));
    this.stage.draw();
    this.stage.renderer.getContext().finish();
    if (opening.includes("alive")) this.livelier?.press(true);
    if (opening.includes("play")) this.timeline?.play.press(true);
    this.cost = { decode_ms: decoded - began, start_ms: performance.now() - began, frame_bytes: Math.max(0, ...moving.map(({ motion }) => 4 * (motion.shapes + 7))) };
    told.textContent = `${this.current.face.told.fine.toLocaleString("en")} vertices, ${this.current.face.names.length} shapes; started in ${(this.cost.start_ms / 1000).toFixed(1)} s, ${this.cost.frame_bytes} bytes a frame`;
  }

  // Two faces of the same vertices can be coloured by how far apart they are, one alone by how far it moved.
  compare() {
    for (const one of this.shown) {
      const other = this.shown.find((face) => face !== one && face.face.told.fine === one.face.told.fine);
      one.face.uniforms.others.value = (other ? other.face.finer.target : one.face.still).texture;
      this.compared = Boolean(other);
    }
  }

  page(header) {
    document.getElementById("names").replaceChildren(...this.shown.map(({ name }) => make("span", { textContent: name })));
    document.title = `${this.shown.map(({ name }) => name).join(", ")}: mien`;
    const panel = document.getElementById("panel"), every = (change) => (value) => { for (const one of this.shown) change(one, value); this.stage.touch(); };
    const uniform = (name) => every(({ face }, value) => { face.uniforms[name].value = value; });
    panel.append(heading("Look"), row(...Object.keys(PRESETS).map((name) => button(name, () => this.lookFrom(name)))));
    this.hold = toggle("hold the head", (on) => { if (on) this.over?.button.press(false); this.stillHead = on; this.show(); });
    const surface = choice("surface", [["0", "colours"], ["1", "clay"], ["2", this.compared ? "distance" : "movement"]], "0", (value) => { uniform("look")(value === "1" ? 1 : 0); uniform("heat")(value === "2" ? 1 : 0); limit.hidden = value !== "2"; });
    surface.id = "surface";
    const limit = make("input", { type: "range", min: 0.5, max: 20, step: 0.5, value: 5, hidden: true, ariaLabel: "millimetres at the top of the scale", on: { input: () => { uniform("limit")(Number(limit.value)); told.textContent = `blue 0 mm, yellow ${limit.value} mm`; } } });
    panel.append(row(surface, toggle("wireframe", every(({ view }, value) => { view.wireframe = value; })), this.hold), limit);
    const films = header.films.map((one) => filmOf({ ...one, address: address(one.address) }, this.clock)), lying = header.films.findIndex(({ camera }) => camera);
    document.getElementById("film").append(...films);
    if (lying >= 0 && this.shown.length === 1) this.over = new OverFilm(panel, this, header.films[lying], films[lying]);
    if (this.clouds.length) {
      this.names = new MarkerNames(this.stage, this.clouds);
      panel.append(row(toggle("markers", (on) => { for (const cloud of this.clouds) cloud.points.visible = on; this.stage.touch(); }, true), toggle("names", (on) => { this.names.all = on; this.stage.touch(); })));
    }
    if (this.shown.some(({ alive }) => alive?.any)) {
      this.livelier = toggle("eyes alive (made up)", (on) => { this.lively = on; this.show(); });
      panel.append(row(this.livelier));
    }
    const say = (text) => { told.textContent = text; };
    const shots = row(button("screenshot", () => this.screenshot()));
    if (this.clock.duration) shots.append(button("film", () => film(this, say), { id: "film-out" }));
    panel.append(shots);
    if (served) this.watch(say);
    if (this.shown.length > 1) panel.append(row(choice("face", this.shown.map(({ name }, i) => [i, name]), 0, (i) => this.turnTo(this.shown[i]))));
    const isMap = ({ name }) => name.endsWith(".exr");
    if (served && isMap(this.current)) this.map = new MapPanel(panel, this);
    if (this.shown.length > 1 && this.shown.slice(0, 2).every((one) => one.kind === "scan" && !isMap(one))) this.correspond = new Correspond(panel, this);
    if (header.live) this.live = new Live(panel, this);
    if (this.current.motion) this.correct = new CorrectPanel(panel, this);
    if (served && this.clouds.length && this.current.motion) this.markers = new MarkersPanel(panel, this, this.clouds[0]);
    if (this.current.face.names.length) this.sliders = new Sliders(panel, this);
    if (this.clock.duration) this.timeline = new Timeline(document.getElementById("timeline"), this);
    else document.getElementById("timeline").hidden = true;
    addEventListener("keydown", (event) => this.key(event));
  }

  // The files of a page may be written anew while it is open.
  watch(say) {
    setInterval(async () => {
      const stamp = await stampNow();
      if (stamp && stamp !== this.stamp) say("the file was written anew: reload the page to see it");
      if (stamp === null) say("the server has ended; what was saved is on disk");
    }, WATCH_MS);
  }

  lookFrom(name) { this.over?.button.press(false); this.stage.frame(name); }

  turnTo(one) { this.current = one; this.chosen.clear(); this.map?.turnTo(one); this.sliders?.fill(); if (this.timeline) Object.assign(this.timeline, { ranked: null, stale: true }); this.show(); }

  key(event) {
    if (event.target.matches("input[type=text], input[type=search], select")) return;
    if (event.key === " ") { this.timeline?.play.press(!this.clock.playing); event.preventDefault(); }
    if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
      if (event.target.matches("input")) return;
      this.clock.seek(this.clock.frame + (event.key === "ArrowLeft" ? -1 : 1));
    }
  }

  // Shapes that sliders held follow the take again.
  release() { for (const { held } of this.shown) held.clear(); }

  choose(k) { if (!this.chosen.delete(k)) this.chosen.add(k); this.timeline?.anew(); this.show(); }

  // A slider was moved: the shape is held there, on top of what plays.
  // Rigs side by side move together, such as one face before and after a correction.
  moveShape(k, value) {
    const { current } = this, together = current.motion ? [current] : this.shown.filter(({ motion }) => !motion);
    for (const { held, face } of together) { const own = face.names.indexOf(current.face.names[k]); if (own >= 0) held.set(own, value); }
    this.clock.playing = false;
    this.show();
  }

  show() {
    const { time } = this.clock;
    for (const one of this.shown) {
      const { face, motion, weights, held, edits } = one;
      if (motion) motion.weightsAt(time, weights);
      if (motion) for (const name of Object.keys(edits.layer.keys)) { const k = face.names.indexOf(name); if (k >= 0) weights[k] = edits.edited(name, weights[k], time); }
      if (motion && this.lively) one.alive.apply(time, weights);
      if (this.now) weights.set(this.now.weights);
      for (const [k, value] of held) weights[k] = value;
      face.setWeights(weights);
      if (this.now && !this.stillHead) face.setPose(this.now.pose);
      else if (motion && !this.stillHead) face.setPose(motion.poseAt(time, this.pose)); else face.setPose(this.resting(one));
    }
    for (const cloud of this.clouds) cloud.show(time, this.headBack(time));
    this.markers?.show();
    this.sliders?.show(this.current.weights);
    this.timeline?.draw();
    this.stage.touch();
  }

  // What takes the world to where a head that is held still is.
  headBack(time) {
    const { motion } = this.shown.find((one) => one.motion) ?? {};
    return this.stillHead && motion ? motion.poseAt(time, new THREE.Matrix4()).invert() : new THREE.Matrix4();
  }

  // Scans stand in frames of their own: each is shown with its middle where the first one's is.
  resting({ face, kind }) {
    this.pose.identity();
    if (kind === "scan") this.pose.setPosition(this.stage.bounds(this.shown[0].face).middle.clone().sub(this.stage.bounds(face).middle));
    return this.pose;
  }

  // Corrections have changed: bridge what is bad, draw anew.
  corrected() {
    for (const { motion, edits } of this.shown) motion?.bridge(edits.bad());
    this.correct?.show();
    this.timeline?.anew();
    this.show();
  }

  screenshot() { this.stage.touch(); this.stage.draw(); this.stage.renderer.domElement.toBlob((blob) => save("mien.png", blob)); }

  run() {
    let last = performance.now();
    const step = (now) => {
      this.clock.tick((now - last) / 1000);
      last = now;
      if (this.stage.draw()) this.names?.show();
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
}

// The stamp is asked for before the scene: files that are written while it comes are told.
async function openStudio() {
  const stamp = served ? await stampNow() : null;
  return new Studio(await loadScene(address("scene.bin")), stamp);
}

if (window.DETAIL) showDetail(window.DETAIL);
else openStudio().then((studio) => {
  window.studio = studio;
  studio.run();
}).catch((fault) => { told.textContent = String(fault.message ?? fault); document.body.dataset.fault = "yes"; console.error(fault); });
