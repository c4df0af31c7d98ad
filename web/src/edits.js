// Corrections over a take: keys on curves and ranges that are bad. The twin of mien.rig.edits; saved at once.
import { History } from "./history.js";
import { address, Saver, served } from "./remote.js";

const FADE_S = 0.2, SAME_S = 1e-4; // keys nearer than this are one

// What keys add at a time: smooth steps from key to key, nothing beyond the fades.
export function correction(keys, time, fade) {
  if (!keys.length) return 0;
  const at = [keys[0].time - fade, ...keys.map((key) => key.time), keys.at(-1).time + fade], add = [0, ...keys.map((key) => key.add), 0];
  if (time <= at[0] || time >= at.at(-1)) return 0;
  let left = 0;
  while (left < at.length - 2 && at[left + 1] <= time) left++;
  const share = (time - at[left]) / Math.max(at[left + 1] - at[left], 1e-9), step = share * share * (3 - 2 * share);
  return add[left] * (1 - step) + add[left + 1] * step;
}

export class Edits {
  constructor(face, name, changed) {
    Object.assign(this, { face, changed, place: `mien.edits.${name}`, told: "", saver: new Saver("edits", { face }) });
    this.layer = { keys: {}, bad: [], fade_s: FADE_S };
    this.history = new History(() => [this.layer.keys, this.layer.bad], ([keys, bad]) => { Object.assign(this.layer, { keys, bad }); this.save(); });
  }

  async load() {
    if (served) {
      const answer = await fetch(address("edits", { face: this.face }));
      if (answer.ok) this.take(await answer.json());
    } else {
      try { this.take(JSON.parse(localStorage.getItem(this.place) ?? "{}")); } catch { /* pages from files may have no storage */ }
    }
    this.changed();
  }

  take(layer) { this.layer = { keys: {}, bad: [], fade_s: FADE_S, ...layer }; }

  keys(name) { return this.layer.keys[name] ?? []; }
  bad() { return this.layer.bad; }
  get count() { return Object.values(this.layer.keys).reduce((sum, keys) => sum + keys.length, 0) + this.layer.bad.length; }

  edited(name, base, time) {
    const keys = this.layer.keys[name];
    if (!keys) return base;
    return Math.min(Math.max(base + correction(keys, time, this.layer.fade_s), Math.min(base, 0)), Math.max(base, 1));
  }

  change(change) {
    this.history.keep();
    change(this.layer);
    this.save();
  }

  key(name, time, add) {
    this.change(({ keys }) => {
      const others = (keys[name] ?? []).filter((key) => Math.abs(key.time - time) > SAME_S);
      keys[name] = [...others, { time, add }].sort((a, b) => a.time - b.time);
    });
  }

  unkey(name, time) {
    this.change(({ keys }) => {
      keys[name] = (keys[name] ?? []).filter((key) => Math.abs(key.time - time) > SAME_S);
      if (!keys[name].length) delete keys[name];
    });
  }

  mark(from, to) { this.change((layer) => { layer.bad = [...layer.bad, { from, to }]; }); }
  unmark(time) { this.change((layer) => { layer.bad = layer.bad.filter(({ from, to }) => time < from || time > to); }); }

  save() {
    this.changed();
    if (!served) { try { localStorage.setItem(this.place, JSON.stringify(this.layer)); } catch { /* as above */ } return; }
    this.saver.save(() => JSON.stringify(this.layer), async (text, status) => {
      if (status === 200) { const { revision, file } = JSON.parse(text); this.layer.revision = revision; this.told = `saved in ${file}`; } else this.told = text;
      if (status === 409) await this.load();
      this.changed();
    });
  }
}
