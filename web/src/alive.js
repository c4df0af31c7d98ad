// Eyes that blink and look about, made up where a take says nothing of them.
const SAID = 0.02, BLINK_S = 0.28, LOOKS = 0.28; // weights below this say nothing; a blink's length; widest look

// Even numbers in 0..1 that belong to a whole number.
const dice = (i, salt) => { const x = Math.sin(i * 127.1 + salt * 311.7) * 43758.5453; return x - Math.floor(x); };

export class Alive {
  constructor(names, motion) {
    const index = (name) => names.indexOf(name);
    const silent = (k) => { for (let t = 0; t < motion.frames; t++) if (Math.abs(motion.weights[t * motion.shapes + k]) > SAID) return false; return true; };
    const all = (...shapes) => { const found = shapes.map(index); return found.every((k) => k >= 0 && silent(k)) ? found : null; };
    this.blink = all("eyeBlinkLeft", "eyeBlinkRight");
    this.look = all("eyeLookOutLeft", "eyeLookInRight", "eyeLookInLeft", "eyeLookOutRight", "eyeLookUpLeft", "eyeLookUpRight", "eyeLookDownLeft", "eyeLookDownRight");
  }

  get any() { return Boolean(this.blink || this.look); }

  apply(time, weights) {
    if (this.blink) {
      const i = Math.floor(time / 3.1), at = time - (i + 0.15 + 0.6 * dice(i, 1)) * 3.1, shut = Math.max(0, 1 - Math.abs(at / BLINK_S * 2 - 1));
      for (const k of this.blink) weights[k] = Math.max(weights[k], Math.min(1, 1.3 * shut));
    }
    if (this.look) {
      const i = Math.floor(time / 1.4), into = Math.min((time - 1.4 * i) / 0.06, 1), ease = into * into * (3 - 2 * into);
      const aim = (n, salt) => (dice(n, salt) < 0.4 ? 0 : (dice(n, salt + 7) - 0.5) * 2 * LOOKS);
      const [x, y] = [2, 3].map((salt) => aim(i - 1, salt) * (1 - ease) + aim(i, salt) * ease), up = y * 0.5;
      const [outL, inR, inL, outR, upL, upR, downL, downR] = this.look;
      weights[outL] = weights[inR] = Math.max(x, 0); weights[inL] = weights[outR] = Math.max(-x, 0);
      weights[upL] = weights[upR] = Math.max(up, 0); weights[downL] = weights[downR] = Math.max(-up, 0);
    }
  }
}
