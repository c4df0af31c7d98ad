// The panel of corrections: what sliders do becomes keys; bad ranges; undo and redo.
import { button, heading, make, row, toggle } from "./dom.js";

export class CorrectPanel {
  constructor(place, studio) {
    this.studio = studio;
    this.undo = button("undo", () => studio.edits.history.undo(), { id: "undo", title: "ctrl+Z" });
    this.redo = button("redo", () => studio.edits.history.redo(), { id: "redo", title: "ctrl+shift+Z" });
    this.remove = button("remove keys here", () => this.removeKeys());
    this.mark = button("mark as bad", () => { const [from, to] = this.range; studio.edits.mark(from, to); }, { id: "mark", disabled: true, title: "drag over the curves with shift held" });
    this.clear = button("not bad", () => studio.edits.unmark(studio.clock.time));
    this.told = make("p", { id: "saved", className: "quiet" });
    this.keying = toggle("sliders set keys", () => {}, true);
    studio.selected = (range) => { this.range = range; this.mark.disabled = false; this.show(); };
    studio.moved = () => { if (this.keying.getAttribute("aria-pressed") === "true") this.setKeys(); };
    place.append(heading("Correct"), row(this.undo, this.redo, this.keying), row(this.remove, this.mark, this.clear), this.told);
  }

  // What sliders hold at this frame, as keys over the capture.
  setKeys() {
    const { current, edits, clock } = this.studio, { held, motion, face } = current, captured = motion.weightsAt(clock.time, new Float32Array(motion.shapes));
    for (const [k, value] of held) edits.key(face.names[k], clock.time, value - captured[k]);
    held.clear();
    this.studio.show();
  }

  removeKeys() {
    const { edits, clock } = this.studio;
    for (const [name, keys] of Object.entries(edits.layer.keys)) for (const { time } of keys) if (Math.abs(time - clock.time) < 0.5 / clock.rate) edits.unkey(name, time);
  }

  show() {
    const { edits } = this.studio;
    if (!edits) return;
    edits.history.press(this.undo, this.redo);
    const range = this.range ? `${this.range[0].toFixed(2)} to ${this.range[1].toFixed(2)} s chosen. ` : "";
    this.told.textContent = `${range}${edits.count} corrections${edits.told ? `, ${edits.told}` : ""}`;
  }
}
