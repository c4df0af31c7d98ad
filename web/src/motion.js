// A face's recorded weights and head poses, and the layer of corrections over them.
import * as THREE from "three";

export class Motion {
  constructor(told, file) {
    Object.assign(this, { rate: told.rate, frames: told.frames, shapes: told.shapes });
    this.weights = file.array(told.weights);
    this.poses = file.array(told.poses); // translation (mm), then quaternion, T_mean_face
    this.captured = { weights: this.weights, poses: this.poses };
  }

  // Bridge bad ranges: frames within go straight from the one before to the one after.
  bridge(bad) {
    Object.assign(this, this.captured);
    if (!bad.length) return;
    this.weights = this.weights.slice(); this.poses = this.poses.slice();
    const { shapes: k, rate, frames } = this, inside = (f) => Math.min(Math.max(f, 0), frames - 1);
    for (const { from, to } of bad) {
      const before = inside(Math.ceil(from * rate - 1e-9) - 1), after = inside(Math.floor(to * rate + 1e-9) + 1);
      for (let f = before + 1; f < after; f++) {
        const share = (f - before) / (after - before), mix = (of, n, d) => of[n * before + d] * (1 - share) + of[n * after + d] * share;
        for (let i = 0; i < k; i++) this.weights[k * f + i] = mix(this.weights, k, i);
        for (let d = 0; d < 3; d++) this.poses[7 * f + d] = mix(this.poses, 7, d);
        const turn = (n) => new THREE.Quaternion().fromArray(this.poses, 7 * n + 3);
        turn(before).slerp(turn(after), share).toArray(this.poses, 7 * f + 3);
      }
    }
  }

  // Two frames and how far between them.
  between(time) {
    const at = Math.min(Math.max(time * this.rate, 0), this.frames - 1), first = Math.floor(at + 1e-6);
    return [first, Math.min(first + 1, this.frames - 1), Math.max(at - first, 0)];
  }

  weightsAt(time, out) {
    const [a, b, share] = this.between(time), { shapes: k, weights } = this;
    for (let i = 0; i < k; i++) out[i] = weights[a * k + i] * (1 - share) + weights[b * k + i] * share;
    return out;
  }

  poseAt(time, out) {
    const [a, b, share] = this.between(time), p = this.poses;
    const place = (f) => new THREE.Vector3().fromArray(p, 7 * f), turn = (f) => new THREE.Quaternion().fromArray(p, 7 * f + 3);
    return out.compose(place(a).lerp(place(b), share), turn(a).slerp(turn(b), share), new THREE.Vector3(1, 1, 1));
  }

  curve(shape) {
    const out = new Float32Array(this.frames);
    for (let t = 0; t < this.frames; t++) out[t] = this.weights[t * this.shapes + shape];
    return out;
  }
}
