// The bar below: play, speed, loop, and the curves that are scrubbed.
import { button, choice, make, row, toggle } from "./dom.js";

const COLOURS = ["#7fb4ff", "#ffb35c", "#8fd694", "#e58fb1", "#c9a6ff", "#6fd3d3"];
const SPEEDS = [0.1, 0.25, 0.5, 1, 2];
const MOST_CURVES = 6;

export class Timeline {
  constructor(place, studio) {
    this.studio = studio;
    const { clock } = studio;
    this.play = toggle("play", (on) => { if (on) studio.release(); if (on && clock.time >= clock.duration) clock.set(0); clock.playing = on; });
    this.play.id = "play";
    this.told = make("output", { id: "time" });
    const speed = choice("speed", SPEEDS.map((x) => [x, `${x} x`]), 1, (value) => { clock.speed = Number(value); });
    const loop = toggle("loop", (on) => { clock.loop = on; }, true);
    const step = (by) => button(by < 0 ? "‹" : "›", () => { this.play.press(false); clock.seek(clock.frame + by); }, { ariaLabel: by < 0 ? "one frame back" : "one frame on" });
    this.legend = make("span", { className: "quiet" });
    this.canvas = make("canvas", { id: "curves", tabIndex: 0, ariaLabel: "curves over time; drag to scrub" });
    place.append(row(this.play, step(-1), step(1), this.told, speed, loop, make("span", { className: "spacer" }), this.legend), this.canvas);
    this.scrub();
    this.picture = make("canvas");
    new ResizeObserver(() => this.anew()).observe(this.canvas);
  }

  scrub() {
    const { canvas, studio } = this, { clock } = studio;
    const to = (event) => { const box = canvas.getBoundingClientRect(); this.play.press(false); clock.seek(Math.round(((event.clientX - box.left) / box.width) * clock.duration * clock.rate)); };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      if (event.shiftKey) this.from = this.timeAt(event); else to(event);
    });
    canvas.addEventListener("pointermove", (event) => { if (event.buttons && this.from === undefined) to(event); });
    canvas.addEventListener("pointerup", (event) => {
      if (this.from !== undefined) studio.selected?.([this.from, this.timeAt(event)].sort((a, b) => a - b));
      this.from = undefined;
    });
  }

  timeAt(event) {
    const box = this.canvas.getBoundingClientRect();
    return Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1) * this.studio.clock.duration;
  }

  // Curves of shapes: of the chosen ones, else of those that move most.
  curves() {
    const { studio } = this, { motion, face } = studio.current;
    if (!motion) return [];
    const chosen = [...studio.chosen];
    if (!this.ranked) {
      const moved = face.names.map((_, k) => { const c = motion.curve(k); return Math.max(...c) - Math.min(...c); });
      this.ranked = moved.map((x, k) => [x, k]).sort((a, b) => b[0] - a[0]).map(([, k]) => k);
    }
    return (chosen.length ? chosen : this.ranked).slice(0, MOST_CURVES);
  }

  // Curves, corrections or the bar's size have changed.
  anew() { this.stale = true; this.draw(); }

  // Every frame: the time, over the picture of the curves.
  draw() {
    const { canvas, studio: { clock } } = this, ratio = window.devicePixelRatio || 1;
    this.play.setAttribute("aria-pressed", String(clock.playing));
    this.told.textContent = `${clock.time.toFixed(2)} s   frame ${clock.frame}`;
    if (this.stale !== false) this.drawCurves(ratio);
    const { width, height } = canvas, pen = canvas.getContext("2d");
    if (!width || !height) return;
    pen.clearRect(0, 0, width, height);
    pen.drawImage(this.picture, 0, 0);
    pen.fillStyle = "#ffffffc0"; pen.fillRect(this.across(clock.time, width) - ratio / 2, 0, ratio, height);
  }

  across(time, width) { const { duration } = this.studio.clock; return duration ? (time / duration) * width : 0; }

  drawCurves(ratio) {
    const { canvas, picture, studio } = this;
    this.stale = false;
    const w = (canvas.width = picture.width = canvas.clientWidth * ratio), h = (canvas.height = picture.height = canvas.clientHeight * ratio), pen = picture.getContext("2d");
    const x = (time) => this.across(time, w), pad = 6 * ratio;
    for (const { from, to } of studio.edits?.bad() ?? []) { pen.fillStyle = "#ff5c5c33"; pen.fillRect(x(from), 0, x(to) - x(from), h); }
    const shown = this.curves(), { motion, face } = studio.current;
    shown.forEach((k, i) => {
      const base = motion.curve(k), every = Math.max(1, Math.floor(base.length / w / 2));
      const line = (value, dash) => {
        pen.beginPath(); pen.setLineDash(dash);
        for (let t = 0; t < base.length; t += every) pen.lineTo(x(t / motion.rate), h - pad - (h - 2 * pad) * Math.min(Math.max(value(t), -0.2), 1.2));
        pen.stroke();
      };
      pen.strokeStyle = COLOURS[i]; pen.lineWidth = ratio * 1.3;
      const keys = studio.edits?.keys(face.names[k]) ?? [];
      if (keys.length) { pen.globalAlpha = 0.45; line((t) => base[t], [4, 4]); pen.globalAlpha = 1; }
      line((t) => studio.edits?.edited(face.names[k], base[t], t / motion.rate) ?? base[t], []);
      pen.fillStyle = COLOURS[i];
      for (const key of keys) { const at = Math.round(key.time * motion.rate), y = h - pad - (h - 2 * pad) * studio.edits.edited(face.names[k], base[Math.min(at, base.length - 1)], key.time); pen.beginPath(); pen.arc(x(key.time), y, 3.5 * ratio, 0, 7); pen.fill(); }
    });
    pen.setLineDash([]);
    this.legend.replaceChildren(...shown.map((k, i) => make("span", { textContent: ` ${face.names[k]} `, style: `color:${COLOURS[i]}` })));
  }
}
