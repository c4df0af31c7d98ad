// Time: play, scrub, speed, loop. Listeners hear every change of time.
export class Clock {
  constructor(duration, rate) {
    Object.assign(this, { duration, rate, time: 0, speed: 1, loop: true, playing: false, heard: [] });
  }

  listen(heard) { this.heard.push(heard); }

  set(time) {
    this.time = Math.min(Math.max(time, 0), this.duration);
    for (const heard of this.heard) heard(this.time);
  }

  // To the frame that is `frame` frames from the start.
  seek(frame) { this.playing = false; this.set(frame / this.rate); }

  get frame() { return Math.round(this.time * this.rate); }

  tick(seconds) {
    if (!this.playing || !this.duration) return;
    let time = this.time + seconds * this.speed;
    if (time >= this.duration) { if (this.loop) time %= this.duration; else { time = this.duration; this.playing = false; } }
    this.set(time);
  }
}
