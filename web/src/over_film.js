// The face over the film that it was tracked in, through that film's camera.
import * as THREE from "three";
import { make, row, toggle } from "./dom.js";

const NEAR = 10, FAR = 1e5; // mm

// A pinhole camera (pixel centres at integers) whose picture stands whole in the middle of a window, as a projection.
export function lens({ width, height, fx, fy, cx, cy }, wide, high) {
  const scale = Math.min(wide / width, high / height);
  const across = ((2 * cx + 1 - width) * scale) / wide, down = ((2 * cy + 1 - height) * scale) / high;
  return new THREE.Matrix4().set(
    (2 * scale * fx) / wide, 0, -across, 0,
    0, (2 * scale * fy) / high, down, 0,
    0, 0, -(FAR + NEAR) / (FAR - NEAR), (-2 * FAR * NEAR) / (FAR - NEAR),
    0, 0, -1, 0);
}

export class OverFilm {
  constructor(place, studio, told, film) {
    Object.assign(this, { studio, told, film, box: document.getElementById("picture"), canvas: studio.stage.renderer.domElement });
    const [x, y, z, ...turn] = told.place;
    this.matrix = new THREE.Matrix4().compose(new THREE.Vector3(x, y, z), new THREE.Quaternion(...turn), new THREE.Vector3(1, 1, 1)).toArray();
    this.button = toggle("over the film", (on) => this.turn(on));
    this.button.id = "over-film";
    this.strength = make("input", { type: "range", min: 0, max: 1, step: 0.02, value: 1, hidden: true, ariaLabel: "how much of the face is seen", on: { input: () => { this.canvas.style.opacity = this.strength.value; } } });
    place.append(row(this.button), this.strength);
  }

  turn(on) {
    const { stage } = this.studio;
    this.box.classList.toggle("over", on);
    this.film.classList.toggle("behind", on);
    this.strength.hidden = !on;
    this.canvas.style.opacity = on ? this.strength.value : 1;
    if (on) this.studio.hold.press(false);
    stage.through = on ? (wide, high) => ({ matrix: this.matrix, projection: lens(this.told.camera, wide, high).toArray() }) : null;
    stage.controls.enabled = !on;
    if (!on) stage.fixed = null;
    stage.touch();
  }
}
