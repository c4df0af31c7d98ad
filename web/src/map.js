// A capture's map: landmarks moved, added and dropped, points pinned, and what is to count as unseen painted out.
import { button, choice, heading, make, row, toggle } from "./dom.js";
import { History } from "./history.js";
import { address, Saver } from "./remote.js";

const NEAR_PX = 9, MOST_ZOOM = 12; // a press this near to a dot takes it; nearest look
const FOUND = "#7fb4ff", BY_HAND = "#ffb35c", TAKEN = "#8fd694", PIN = "#e58fb1";
const TOOLS = [["landmarks", "move landmarks"], ["pins", "pin points"], ["paint", "paint out"], ["erase", "paint back"]];

export class MapPanel {
  constructor(place, studio) {
    Object.assign(this, { studio, picture: {}, told: "", taken: null, found: {}, said: { landmarks: {}, pins: {}, mask: "" }, ready: Promise.resolve() });
    this.canvas = make("canvas", { id: "map", ariaLabel: "the capture's map; drag dots, paint, wheel to come nearer", hidden: true });
    document.getElementById("picture").append(this.canvas);
    this.mask = make("canvas");
    this.tool = choice("what a press on the map does", TOOLS, "landmarks", () => { this.taken = null; this.show(); });
    this.tool.id = "map-tool";
    this.brush = make("input", { type: "range", min: 2, max: 60, value: 14, ariaLabel: "size of the brush" });
    this.number = make("input", { type: "text", id: "landmark", placeholder: "add landmark number", ariaLabel: "number of the landmark that a click adds" });
    this.drop = button("drop", () => this.change((said) => this.dropped(said)), { id: "drop" });
    this.as = button("as found", () => this.change(({ landmarks }) => { delete landmarks[this.taken]; }));
    this.undo = button("undo", () => this.history.undo(), { id: "undo-map" });
    this.redo = button("redo", () => this.history.redo(), { id: "redo-map" });
    this.open = toggle("map", (on) => { this.canvas.hidden = !on; studio.stage.renderer.domElement.classList.toggle("half", on); this.show(); });
    this.open.id = "map-open";
    this.text = make("p", { id: "map-told", className: "quiet" });
    place.append(heading("Map"), row(this.open, this.tool, this.undo, this.redo), this.number, row(this.drop, this.as, this.brush), this.text);
    this.listen();
    new ResizeObserver(() => this.show()).observe(this.canvas);
    this.turnTo(studio.current);
  }

  // To the map of another capture.
  turnTo({ name }) {
    if (!name.endsWith(".exr")) return;
    Object.assign(this, { name, taken: null, found: {}, zoom: 1, at: [0, 0], told: "", saver: new Saver("map", { map: name }) });
    this.history = new History(() => this.said, (said) => { this.said = said; this.save(); this.repaint(); });
    this.ready = this.load();
  }

  async load() {
    const { name } = this, ask = (path) => fetch(address(path, { map: name }));
    const { width, height, revision, ...said } = await (await ask("map")).json();
    Object.assign(this, { width, height, said });
    this.saver.revision = revision;
    this.picture[name] ??= await createImageBitmap(await (await ask("map-picture")).blob());
    await this.repaint();
    this.text.textContent = "looking for landmarks";
    const answer = await ask("map-landmarks");
    if (name !== this.name) return;
    if (answer.ok) this.found = await answer.json(); else this.told = await answer.text();
    this.show();
  }

  // The mask as the state has it; a picture that the state has left behind meanwhile is dropped.
  async repaint() {
    const { mask } = this.said, painted = mask && await createImageBitmap(await (await fetch(mask)).blob());
    if (mask !== this.said.mask) return;
    Object.assign(this.mask, { width: this.width, height: this.height });
    const pen = this.mask.getContext("2d");
    pen.fillStyle = "#fff"; pen.fillRect(0, 0, this.width, this.height);
    if (painted) pen.drawImage(painted, 0, 0);
    this.show();
  }

  change(change) { this.history.keep(); change(this.said); this.save(); }

  dropped({ landmarks, pins }) {
    if (this.taken === null) return;
    if (this.tool.value === "pins") delete pins[this.taken]; else landmarks[this.taken] = null;
    this.taken = null;
  }

  save() {
    this.show();
    const { saver } = this, said = structuredClone(this.said);
    saver.save(() => JSON.stringify({ ...said, revision: saver.revision }), async (text, status) => {
      if (status === 200) { const { revision, rerun } = JSON.parse(text); saver.revision = revision; this.told = `saved; again with\n${rerun}`; } else this.told = text;
      if (status === 409) await this.load();
      this.show();
    });
  }

  // Dots of the tool: places by number or name.
  get dots() {
    if (this.tool.value === "pins") return this.said.pins;
    const { landmarks } = this.said, dots = { ...this.found, ...landmarks };
    return Object.fromEntries(Object.entries(dots).filter(([, place]) => place));
  }

  // Window pixels of one pixel of the map, at this zoom.
  get scale() { return this.zoom * Math.min(this.canvas.clientWidth / this.width, this.canvas.clientHeight / this.height); }
  inMap({ offsetX, offsetY }) { return [(offsetX - this.at[0]) / this.scale - 0.5, (offsetY - this.at[1]) / this.scale - 0.5]; } // pixels' centres are whole numbers
  onCanvas([x, y]) { return [(x + 0.5) * this.scale + this.at[0], (y + 0.5) * this.scale + this.at[1]]; }

  show() {
    this.history.press(this.undo, this.redo);
    const counts = [["landmarks", "landmarks by hand"], ["pins", "pins"]].map(([key, what]) => `${Object.keys(this.said[key]).length} ${what}`);
    this.text.textContent = [`${this.name}: ${Object.keys(this.found).length} landmarks found, ${counts.join(", ")}${this.said.mask ? ", painted" : ""}`, this.taken === null ? "" : `${this.tool.value === "pins" ? "pin" : "landmark"} ${this.taken}`, this.told].filter(Boolean).join("\n");
    this.number.hidden = this.tool.value !== "landmarks";
    this.brush.hidden = !["paint", "erase"].includes(this.tool.value);
    this.drop.hidden = this.as.hidden = !this.brush.hidden;
    this.drop.disabled = this.as.disabled = this.taken === null;
    if (!this.canvas.hidden && this.picture[this.name]) this.draw();
  }

  draw() {
    const { canvas, scale } = this, ratio = window.devicePixelRatio || 1, pen = canvas.getContext("2d");
    canvas.width = canvas.clientWidth * ratio; canvas.height = canvas.clientHeight * ratio;
    pen.setTransform(ratio * scale, 0, 0, ratio * scale, ratio * this.at[0], ratio * this.at[1]);
    pen.drawImage(this.picture[this.name], 0, 0);
    pen.globalCompositeOperation = "multiply"; pen.globalAlpha = 0.75; pen.drawImage(this.mask, 0, 0);
    pen.globalCompositeOperation = "source-over"; pen.globalAlpha = 1;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    if (!this.brush.hidden) return;
    for (const [key, place] of Object.entries(this.dots)) {
      const [x, y] = this.onCanvas(place), big = key === this.taken || this.tool.value === "pins";
      pen.fillStyle = key === this.taken ? TAKEN : this.tool.value === "pins" ? PIN : this.said.landmarks[key] ? BY_HAND : FOUND;
      pen.beginPath(); pen.arc(x, y, big ? 4.5 : 2.2, 0, 7); pen.fill();
      if (big) pen.fillText(key, x + 7, y + 3);
    }
  }

  nearest({ offsetX, offsetY }) {
    let best = NEAR_PX, found = null;
    for (const [key, place] of Object.entries(this.dots)) {
      const [x, y] = this.onCanvas(place), away = Math.hypot(x - offsetX, y - offsetY);
      if (away < best) { best = away; found = key; }
    }
    return found;
  }

  // A press where no dot is: a new pin, or the landmark whose number stands in the field.
  added(place) {
    const { pins } = this.said, number = this.number.value.trim();
    if (this.tool.value === "landmarks" && !/^\d+$/.test(number)) return null;
    let key = number;
    if (this.tool.value === "pins") for (let i = 1; pins[(key = `p${i}`)]; i++);
    this.history.keep();
    this.said[this.tool.value][key] = place;
    this.number.value = "";
    return key;
  }

  listen() {
    const { canvas } = this;
    let last = null;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      last = [event.offsetX, event.offsetY];
      this.moved = false;
      if (!this.brush.hidden) { this.history.keep(); this.stroke(event, event); this.moved = true; return; }
      this.taken = this.nearest(event);
      if (this.taken === null) { this.taken = this.added(this.inMap(event)); this.moved = this.taken !== null; }
      this.show();
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      const [dx, dy] = [event.offsetX - last[0], event.offsetY - last[1]];
      if (!this.brush.hidden) this.stroke({ offsetX: last[0], offsetY: last[1] }, event);
      else if (this.taken === null) this.at = [this.at[0] + dx, this.at[1] + dy];
      else { if (!this.moved) this.history.keep(); this.moved = true; this.said[this.tool.value][this.taken] = this.inMap(event); }
      last = [event.offsetX, event.offsetY];
      this.show();
    });
    const done = () => {
      if (!last) return;
      last = null;
      if (!this.brush.hidden) this.said.mask = this.mask.toDataURL("image/png");
      if (this.moved) this.save();
    };
    canvas.addEventListener("pointerup", done);
    canvas.addEventListener("pointercancel", done);
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const before = this.zoom, [x, y] = [event.offsetX, event.offsetY];
      this.zoom = Math.min(Math.max(before * Math.exp(-event.deltaY / 500), 1), MOST_ZOOM);
      this.at = this.zoom === 1 ? [0, 0] : this.at.map((a, d) => [x, y][d] - ([x, y][d] - a) * (this.zoom / before));
      this.show();
    }, { passive: false });
  }

  // Black is unseen, white is not.
  stroke(from, to) {
    const pen = this.mask.getContext("2d"), [a, b] = [this.inMap(from), this.inMap(to)];
    pen.strokeStyle = pen.fillStyle = this.tool.value === "paint" ? "#000" : "#fff";
    pen.lineWidth = 2 * Number(this.brush.value); pen.lineCap = "round";
    pen.beginPath(); pen.moveTo(a[0] + 0.5, a[1] + 0.5); pen.lineTo(b[0] + 0.501, b[1] + 0.5); pen.stroke();
    this.show();
  }
}
