// Points and lines that are the same on two scans: clicked on one, then on the other; saved at once.
import * as THREE from "three";
import { button, choice, heading, make, row } from "./dom.js";
import { History } from "./history.js";
import { address, Saver, served } from "./remote.js";

const REGION = 0.45; // of a head: half of what is seen of a region
const COLOURS = [0xffb35c, 0x7fb4ff, 0x8fd694, 0xe58fb1, 0xc9a6ff, 0x6fd3d3];

export class Correspond {
  constructor(place, studio) {
    Object.assign(this, { studio, done: "", saver: new Saver("constraints") });
    this.scans = studio.shown.slice(0, 2);
    this.pair = { points: [[], []], curves: [] }; // as clicked: on the first scan, on the second
    this.history = new History(() => this.pair, (pair) => { this.pair = pair; this.save(); });
    this.kind = choice("what a click makes", [["points", "points"], ["curves", "a line"]], "points", () => this.show());
    this.undo = button("undo", () => this.history.undo(), { id: "undo-pair" });
    this.redo = button("redo", () => this.history.redo(), { id: "redo-pair" });
    this.next = button("next line", () => this.change(() => this.pair.curves.push([[], []])));
    this.told = make("p", { id: "pairs", className: "quiet" });
    place.append(heading("Correspond"), row(this.kind, this.next, this.undo, this.redo), this.told, this.worst());
    this.dots = this.scans.map(({ view }) => { const group = new THREE.Group(); view.scene.add(group); return group; });
    this.listen(studio.stage.renderer.domElement);
    this.load();
  }

  // Regions of both scans, worst first: a click goes there.
  worst() {
    const list = make("div", { id: "worst" }), all = this.scans.flatMap((one) => one.face.told.regions.map((region) => ({ ...region, one })));
    all.sort((a, b) => b.unreliable - a.unreliable || b.error - a.error);
    if (all.length) list.append(make("p", { className: "quiet", textContent: "Worst first; ! is not reliable." }));
    for (const { name, error, unreliable, middle, one } of all) {
      const go = () => this.studio.stage.near(new THREE.Vector3(...middle).applyMatrix4(one.face.mesh.matrix), this.studio.stage.bounds(one.face).radius * REGION);
      list.append(row(button(`${name.replaceAll("_", " ")} of ${one.name}`, go), make("span", { className: "quiet", textContent: `${error.toFixed(3)}${unreliable ? " !" : ""}` })));
    }
    return list;
  }

  listen(canvas) {
    let down;
    canvas.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
    canvas.addEventListener("pointerup", (event) => {
      if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return; // a drag turns the scan
      const found = this.studio.stage.pick(event.clientX, event.clientY);
      if (found && found.index < 2) this.add(found.index, found.place);
    });
  }

  add(side, place) {
    this.change(() => {
      if (this.kind.value === "points") {
        const { points } = this.pair;
        if (points[side].length > points[1 - side].length) points[side].pop(); // the same again moves it
        points[side].push(place);
      } else {
        if (!this.pair.curves.length) this.pair.curves.push([[], []]);
        this.pair.curves.at(-1)[side].push(place);
      }
    });
  }

  change(change) {
    this.history.keep();
    change();
    this.save();
  }

  // What is complete: as many points as both have, lines of two corners on both.
  get complete() {
    const { points, curves } = this.pair, count = Math.min(points[0].length, points[1].length);
    return {
      scans: this.scans.map(({ name }) => name),
      points: Array.from({ length: count }, (_, i) => [points[0][i], points[1][i]]),
      curves: curves.filter((line) => line.every((corners) => corners.length > 1)),
    };
  }

  async load() {
    if (served) {
      const answer = await fetch(address("constraints"));
      const { pairs = [] } = answer.ok ? await answer.json() : {}, names = JSON.stringify(this.scans.map(({ name }) => name));
      const mine = pairs.find(({ scans }) => JSON.stringify(scans) === names);
      if (mine) this.pair = { points: [0, 1].map((side) => (mine.points ?? []).map((both) => both[side])), curves: mine.curves ?? [] };
    }
    this.show();
  }

  save() {
    this.show();
    if (!served) return;
    const body = JSON.stringify(this.complete);
    this.saver.save(() => body, (text) => { this.done = text; this.show(); });
  }

  show() {
    const { points, curves } = this.pair, radius = this.studio.stage.bounds(this.scans[0].face).radius / 60;
    this.scans.forEach(({ face }, side) => {
      const dots = this.dots[side];
      dots.clear();
      dots.matrixAutoUpdate = false;
      dots.matrix.copy(face.mesh.matrix);
      const dot = (place, i) => { const ball = new THREE.Mesh(new THREE.SphereGeometry(radius, 12, 8), new THREE.MeshBasicMaterial({ color: COLOURS[i % COLOURS.length] })); ball.position.fromArray(place); dots.add(ball); };
      points[side].forEach(dot);
      curves.forEach((line, i) => {
        line[side].forEach((place) => dot(place, i + 2));
        const path = new THREE.BufferGeometry().setFromPoints(line[side].map((place) => new THREE.Vector3(...place)));
        dots.add(new THREE.Line(path, new THREE.LineBasicMaterial({ color: COLOURS[(i + 2) % COLOURS.length], depthTest: false })));
      });
    });
    this.next.hidden = this.kind.value === "points";
    this.history.press(this.undo, this.redo);
    const { complete } = this, open = points[0].length !== points[1].length ? " Now the same place on the other scan." : "";
    this.told.textContent = `on both: points ${complete.points.length}, lines ${complete.curves.length}.${open} ${this.done}`;
    this.studio.stage.touch();
  }
}
