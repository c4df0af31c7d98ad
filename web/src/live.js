// A face that is tracked right now: weights, head, the sensor's picture and the time of each stage, as they come.
import * as THREE from "three";
import { button, heading, make, row, toggle } from "./dom.js";
import { address, post } from "./remote.js";

const RATE_S = 1; // frames a second are counted over this

export class Live {
  constructor(place, studio) {
    Object.assign(this, { studio, frames: 0, times: [], bytes: 0 });
    this.picture = make("img", { id: "sensor", alt: "the sensor's picture" });
    document.getElementById("film").append(this.picture);
    this.told = make("p", { id: "stages", className: "quiet" });
    const say = (text) => { this.said.textContent = text; };
    this.said = make("p", { id: "said", className: "quiet", textContent: "Hold a calm face, then calibrate." });
    const calibrate = button("calibrate: hold neutral", () => post("calibrate", "on").then(say, say), { id: "calibrate" });
    const record = toggle("record", () => post("record", "").then(say, say));
    record.id = "record";
    place.append(heading("Live"), row(calibrate, button("as tracked", () => post("calibrate", "off").then(say, say)), record), this.said, this.told);
    this.listen();
  }

  async listen() {
    try {
      const answer = await fetch(address("live")), reader = answer.body.getReader();
      let held = new Uint8Array(0);
      for (;;) {
        const { done, value } = await reader.read();
        if (done) break;
        const joined = new Uint8Array(held.length + value.length);
        joined.set(held); joined.set(value, held.length);
        held = this.take(joined);
      }
    } catch { /* told below */ }
    this.said.textContent = "The source has ended.";
  }

  // Take whole messages off the front; what is left waits for more.
  take(data) {
    for (;;) {
      if (data.length < 12) return data;
      const [whole, text, numbers] = [0, 4, 8].map((at) => new DataView(data.buffer, data.byteOffset).getUint32(at, true));
      if (data.length < 12 + whole) return data;
      const body = data.slice(12, 12 + whole);
      if (numbers) this.show(JSON.parse(new TextDecoder().decode(body.subarray(0, text))), new Float32Array(body.buffer, text, numbers / 4), body.subarray(text + numbers));
      this.bytes = numbers;
      data = data.subarray(12 + whole);
    }
  }

  show({ tracked, ms, recording }, numbers, picture) {
    const { studio } = this, k = studio.current.face.names.length, pose = new THREE.Matrix4();
    pose.compose(new THREE.Vector3().fromArray(numbers, k), new THREE.Quaternion().fromArray(numbers, k + 3), new THREE.Vector3(1, 1, 1));
    studio.now = { weights: numbers.subarray(0, k), pose };
    studio.show();
    if (picture.length) {
      URL.revokeObjectURL(this.picture.src);
      this.picture.src = URL.createObjectURL(new Blob([picture], { type: "image/jpeg" }));
    }
    const now = performance.now() / 1000;
    this.frames++;
    this.times = [...this.times.filter((time) => now - time < RATE_S), now];
    const stages = Object.entries(ms).map(([name, spent]) => `${name} ${spent} ms`).join("\n");
    this.told.textContent = `${tracked ? "" : "no face. "}${this.times.length} frames a second${recording === null ? "" : `, ${recording} recorded`}\n${stages}`;
  }
}
