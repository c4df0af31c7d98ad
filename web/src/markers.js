// Markers on the skin: which one is where, what it is called, when it is bad; dragged and named here, saved at once.
import * as THREE from "three";
import { button, heading, make, row, toggle } from "./dom.js";
import { SILENT } from "./gpu_face.js";
import { History } from "./history.js";
import { dots } from "./overlays.js";
import { address, post, Saver } from "./remote.js";

const NEAR_PX = 12; // a press this near to a dot takes it
const PLAIN = [1, 0.7, 0.36], TAKEN = [0.5, 0.95, 0.6]; // colours of dots on the skin

export class MarkersPanel {
  constructor(place, studio, cloud) {
    Object.assign(this, { studio, cloud, shown: studio.current, taken: -1, told: "", saver: new Saver("markers") });
    this.state = { places: {}, names: {}, bad: {} };
    this.history = new History(() => this.state, (state) => { this.state = state; this.save(); });
    this.undo = button("undo", () => this.history.undo(), { id: "undo-marker" });
    this.redo = button("redo", () => this.history.redo(), { id: "redo-marker" });
    this.name = make("input", { type: "text", id: "marker-name", placeholder: "click a marker", ariaLabel: "the marker's name", disabled: true, on: { change: () => this.rename(this.name.value.trim()) } });
    this.worn = button("off the face", () => this.change(({ places }) => { places[this.label] = null; }), { id: "marker-off" });
    this.mark = button("mark as bad", () => this.markBad(), { id: "marker-bad", title: "in the range that is dragged over the curves with shift held" });
    this.clear = button("not bad", () => this.change(({ bad }) => { delete bad[this.label]; }));
    this.said = make("p", { id: "markers-saved", className: "quiet" });
    const seen = toggle("places on the skin", (on) => { this.dots.visible = this.lines.visible = on; this.show(); }, true);
    place.append(heading("Markers"), row(seen, this.undo, this.redo), this.name, row(this.worn, this.mark, this.clear), this.said);
    this.draw();
    this.listen(studio.stage);
    this.ready = this.load();
  }

  // Dots on the skin and lines from them to the markers.
  draw() {
    const count = this.cloud.labels.length, floats = (n) => new THREE.BufferAttribute(new Float32Array(3 * n), 3);
    this.at = floats(count); this.tint = floats(count); this.ends = floats(2 * count);
    this.dots = new THREE.Points(new THREE.BufferGeometry().setAttribute("position", this.at).setAttribute("color", this.tint), dots(9));
    this.lines = new THREE.LineSegments(new THREE.BufferGeometry().setAttribute("position", this.ends), new THREE.LineBasicMaterial({ color: 0xffb35c }));
    for (const one of [this.dots, this.lines]) { one.frustumCulled = false; this.shown.view.scene.add(one); }
  }

  get label() { return this.cloud.labels[this.taken]; }
  get range() { return this.studio.correct?.range; }

  async load() {
    const answer = await fetch(address("markers"));
    if (!answer.ok) { this.told = await answer.text(); this.show(); return; }
    const { places, names, bad, revision } = await answer.json();
    Object.assign(this, { state: { places, names, bad }, revision });
    this.studio.show();
  }

  change(change) {
    if (this.taken < 0) return;
    this.history.keep();
    change(this.state);
    this.save();
  }

  rename(name) {
    this.change(({ names }) => { if (name && name !== this.label) names[this.label] = name; else delete names[this.label]; });
  }

  markBad() {
    if (!this.range) { this.told = "drag over the curves with shift held: that range is marked"; this.show(); return; }
    const [from, to] = this.range;
    this.change(({ bad }) => { bad[this.label] = [...(bad[this.label] ?? []), { from, to }]; });
  }

  save() {
    this.studio.show();
    this.saver.save(() => JSON.stringify({ ...this.state, revision: this.revision }), async (text, status) => {
      if (status === 200) { const { revision, rerun } = JSON.parse(text); this.revision = revision; this.told = `saved; again with\n${rerun}`; } else this.told = text;
      if (status === 409) await this.load();
      this.show();
    });
  }

  // Where a place on the skin is under these weights, face space.
  skin({ corners, barycentric }) {
    const { face, weights } = this.shown, out = [0, 0, 0], texels = face.deltaTexels, at = face.neutral.image.data;
    corners.forEach((corner, c) => { for (let d = 0; d < 3; d++) out[d] += barycentric[c] * at[4 * corner + d]; });
    weights.forEach((weight, k) => {
      if (Math.abs(weight) < SILENT) return;
      corners.forEach((corner, c) => { for (let d = 0; d < 3; d++) out[d] += barycentric[c] * weight * face.steps[k] * face.deltas[3 * (k * texels + corner) + d]; });
    });
    return out;
  }

  isBad(label, time) { return (this.state.bad[label] ?? []).some(({ from, to }) => time >= from && time <= to); }

  show() {
    const { cloud, state, studio } = this, { face } = this.shown, place = new THREE.Vector3(), { time } = studio.clock;
    cloud.labels.forEach((label, m) => {
      const entry = state.places[label], held = this.held && m === this.taken ? this.held : entry && this.skin(entry);
      place.fromArray(held ?? [1e7, 1e7, 1e7]).applyMatrix4(face.mesh.matrix).toArray(this.at.array, 3 * m);
      const marker = new THREE.Vector3().fromArray(cloud.at.array, 3 * m).applyMatrix4(cloud.points.matrix), linked = held && marker.length() < 1e6;
      place.toArray(this.ends.array, 6 * m);
      (linked ? marker : place).toArray(this.ends.array, 6 * m + 3);
      this.tint.array.set(m === this.taken ? TAKEN : PLAIN, 3 * m);
      cloud.tint.array.set(this.isBad(label, time) ? [1, 0.3, 0.3] : m === this.taken ? TAKEN : [0.97, 0.97, 0.97], 3 * m);
    });
    for (const changed of [this.at, this.tint, this.ends, cloud.tint]) changed.needsUpdate = true;
    this.history.press(this.undo, this.redo);
    for (const one of [this.name, this.worn, this.mark, this.clear]) one.disabled = this.taken < 0;
    const bad = (state.bad[this.label] ?? []).map(({ from, to }) => `${from.toFixed(2)} to ${to.toFixed(2)} s`).join(", ");
    this.said.textContent = [this.taken < 0 ? "Drag a dot along the skin." : `${this.label}${bad ? `: bad ${bad}` : ""}`, this.told].filter(Boolean).join("\n");
    studio.stage.touch();
  }

  take(m) {
    this.taken = m;
    this.name.value = this.state.names[this.label] ?? this.label;
    this.show();
  }

  listen(stage) {
    const canvas = stage.renderer.domElement;
    canvas.addEventListener("pointerdown", (event) => {
      const found = this.dots.visible ? this.nearest(stage, event) : -1;
      if (found < 0) return;
      this.take(found);
      stage.controls.enabled = false;
      this.studio.clock.playing = false;
      this.from = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    }, { capture: true });
    canvas.addEventListener("pointermove", (event) => {
      if (!this.from || (!this.held && Math.hypot(event.clientX - this.from[0], event.clientY - this.from[1]) < 4)) return;
      const found = stage.pick(event.clientX, event.clientY);
      if (found && this.studio.shown[found.index] === this.shown) { this.held = found.place; this.show(); }
    });
    const done = () => { if (!this.from) return; this.from = null; stage.controls.enabled = true; if (this.held) this.drop(this.held); };
    canvas.addEventListener("pointerup", done);
    canvas.addEventListener("pointercancel", done);
  }

  // The dot or marker nearest to a press, or -1.
  nearest(stage, { clientX, clientY }) {
    const view = stage.views.indexOf(this.shown.view), place = new THREE.Vector3();
    const far = (array, m, matrix) => {
      place.fromArray(array, 3 * m);
      if (matrix) place.applyMatrix4(matrix);
      const at = stage.onScreen(place, view);
      return Math.hypot(at[0] - clientX, at[1] - clientY);
    };
    let best = NEAR_PX, found = -1;
    this.cloud.labels.forEach((_, m) => {
      const away = Math.min(far(this.at.array, m), far(this.cloud.at.array, m, this.cloud.points.matrix));
      if (away < best) { best = away; found = m; }
    });
    return found;
  }

  async drop(point) {
    const { label } = this;
    try {
      const entry = JSON.parse(await post("marker-place", JSON.stringify({ point, weights: Array.from(this.shown.weights) })));
      this.held = null;
      this.change(({ places }) => { places[label] = entry; });
    } catch (fault) { this.held = null; this.told = `not moved: ${fault.message}`; this.show(); }
  }
}
