// Names beside markers: of the one under the pointer, or of all that this side of the head shows.
import * as THREE from "three";
import { make } from "./dom.js";

const NEAR_PX = 12, SEEN = 0.05; // cosine between where a marker sits on the head and where the camera is, at the least

export class MarkerNames {
  constructor(stage, clouds) {
    Object.assign(this, { stage, clouds, all: false, tags: make("div", { id: "marker-names" }) });
    const canvas = stage.renderer.domElement;
    canvas.parentElement.append(this.tags);
    canvas.addEventListener("pointermove", ({ clientX, clientY }) => { this.pointer = [clientX, clientY]; this.show(); });
    canvas.addEventListener("pointerleave", () => { this.pointer = null; this.show(); });
  }

  show() {
    const box = this.tags.getBoundingClientRect(), seen = this.seen();
    const nearest = this.pointer && seen.filter(({ away }) => away < NEAR_PX).sort((a, b) => a.away - b.away)[0];
    const shown = this.all ? seen : nearest ? [nearest] : [];
    this.tags.replaceChildren(...shown.map(({ label, at }) => {
      const tag = make("span", { textContent: label });
      tag.style.transform = `translate(${at[0] - box.left + 6}px, ${at[1] - box.top - 7}px)`;
      return tag;
    }));
  }

  // Markers on this side of the head, where they are in the window, and how far from the pointer.
  seen() {
    const { stage } = this, { face } = stage.views[0], found = [];
    const middle = stage.bounds(face).middle.clone().applyMatrix4(face.mesh.matrix), eye = new THREE.Vector3().setFromMatrixPosition(stage.camera.matrixWorld).sub(middle).normalize();
    for (const cloud of this.clouds) {
      if (!cloud.points.visible) continue;
      cloud.labels.forEach((label, m) => {
        const place = new THREE.Vector3().fromArray(cloud.at.array, 3 * m).applyMatrix4(cloud.points.matrix);
        if (place.length() > 1e6 || place.clone().sub(middle).normalize().dot(eye) < SEEN) return;
        const at = stage.onScreen(place, 0);
        found.push({ label, at, away: this.pointer ? Math.hypot(at[0] - this.pointer[0], at[1] - this.pointer[1]) : Infinity });
      });
    }
    return found;
  }
}
