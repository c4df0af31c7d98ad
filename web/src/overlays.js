// Markers and films over the face.
import * as THREE from "three";
import { make } from "./dom.js";

export class MarkerCloud {
  constructor(told, file) {
    Object.assign(this, told);
    this.places = file.array(told.places);
    const geometry = new THREE.BufferGeometry();
    this.at = new THREE.BufferAttribute(new Float32Array(3 * told.labels.length), 3);
    this.tint = new THREE.BufferAttribute(new Float32Array(3 * told.labels.length).fill(0.97), 3);
    geometry.setAttribute("position", this.at).setAttribute("color", this.tint);
    this.points = new THREE.Points(geometry, dots(7));
    this.points.frustumCulled = false;
    this.points.matrixAutoUpdate = false;
  }

  // `back` takes them to a head that is held still.
  show(time, back) {
    this.points.matrix.copy(back);
    const frame = Math.min(Math.max(Math.round(time * this.rate), 0), this.frames - 1), n = 3 * this.labels.length;
    this.at.array.set(this.places.subarray(frame * n, (frame + 1) * n));
    this.at.needsUpdate = true;
  }
}

// Round dots with a rim, `size` pixels wide at any distance.
export const dots = (size) => new THREE.PointsMaterial({ size: size * (window.devicePixelRatio || 1), sizeAttenuation: false, vertexColors: true, map: disc(), alphaTest: 0.4, transparent: true });

function disc() {
  const canvas = Object.assign(document.createElement("canvas"), { width: 64, height: 64 }), pen = canvas.getContext("2d");
  pen.beginPath(); pen.arc(32, 32, 26, 0, 7); pen.fillStyle = "#fff"; pen.fill();
  pen.lineWidth = 7; pen.strokeStyle = "#285a96"; pen.stroke();
  return new THREE.CanvasTexture(canvas);
}

// A video that keeps to the clock.
export function filmOf(told, clock) {
  const film = make("video", { src: told.address, muted: true, playsInline: true, preload: "auto", title: told.name });
  clock.listen((time) => {
    const off = Math.abs(film.currentTime - time);
    if (clock.playing && clock.speed === 1) { if (film.paused) film.play().catch(() => {}); if (off > 0.15) film.currentTime = time; } else { film.pause(); if (off > 0.01) film.currentTime = time; }
  });
  return film;
}
