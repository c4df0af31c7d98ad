// A slider a shape: shows the take's weight; where it is moved, the weight is held, or keyed into the corrections.
import { heading, make } from "./dom.js";

export class Sliders {
  constructor(place, studio) {
    this.studio = studio;
    this.place = make("div");
    const find = make("input", { type: "search", placeholder: "find a shape", ariaLabel: "find a shape", on: { input: () => this.filter(find.value) } });
    place.append(heading("Shapes"), find, this.place);
    this.fill();
  }

  fill() {
    const { studio } = this, { face } = studio.current;
    this.rows = face.names.map((name, k) => {
      const slider = make("input", { type: "range", min: 0, max: 1, step: 0.005, value: 0, ariaLabel: name, data: { shape: name }, on: { input: () => studio.moveShape(k, Number(slider.value)), change: () => studio.moved?.() } });
      const told = make("output", { textContent: "0.00" });
      const title = make("button", { type: "button", textContent: name, title: name, on: { click: () => { studio.choose(k); } }, aria: { pressed: "false" } });
      const row = make("div", { className: "shape" }, title, slider, told);
      return { name, slider, told, title, row };
    });
    this.place.replaceChildren(...this.rows.map(({ row }) => row));
  }

  filter(text) {
    const asked = text.trim().toLowerCase();
    for (const { name, row } of this.rows) row.hidden = !name.toLowerCase().includes(asked), row.style.display = row.hidden ? "none" : "";
  }

  show(weights) {
    const { studio } = this;
    this.rows.forEach(({ name, slider, told, title, row }, k) => {
      const shown = weights[k].toFixed(2);
      if (told.textContent !== shown) { told.textContent = shown; slider.value = weights[k]; }
      const pressed = String(studio.chosen.has(k));
      if (title.ariaPressed !== pressed) title.ariaPressed = pressed;
      row.classList.toggle("keyed", (studio.edits?.keys(name).length ?? 0) > 0);
    });
  }
}
