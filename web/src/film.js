// The take as a film: frame by frame through the server as MP4, or, in a page without one, as it plays (WebM).
import { save } from "./dom.js";
import { post, served } from "./remote.js";

const SIZE = [1280, 720], MOST_FPS = 30, QUALITY = 0.95;

export async function film(studio, say) {
  const { clock, stage } = studio, canvas = stage.renderer.domElement;
  studio.timeline.play.press(false);
  if (!served) return recorded(studio, canvas, say);
  const every = Math.max(1, Math.ceil(clock.rate / MOST_FPS - 1e-6)), count = Math.floor(clock.duration * clock.rate + 1e-6) + 1, film = crypto.randomUUID?.() ?? String(Math.random());
  stage.size = [SIZE[0] * Math.min(studio.shown.length, 2) / (studio.shown.length > 1 ? 2 : 1), SIZE[1]];
  try {
    for (let frame = 0; frame < count; frame += every) {
      clock.seek(frame);
      stage.touch(); stage.draw();
      const blob = await new Promise((done) => canvas.toBlob(done, "image/jpeg", QUALITY));
      await post("film", blob, { film });
      say(`film: frame ${frame + 1} of ${count}`);
    }
    say(await post("film-done", "", { film, rate: clock.rate / every }));
  } catch (fault) { say(`no film: ${fault.message}`); } finally { stage.size = null; stage.touch(); }
}

function recorded(studio, canvas, say) {
  const recorder = new MediaRecorder(canvas.captureStream(MOST_FPS)), parts = [], { clock } = studio;
  recorder.ondataavailable = ({ data }) => parts.push(data);
  recorder.onstop = () => { save("mien.webm", new Blob(parts, { type: "video/webm" })); say("mien.webm"); };
  const { loop } = clock;
  clock.loop = false; clock.set(0);
  recorder.start();
  studio.timeline.play.press(true);
  const wait = setInterval(() => { if (!clock.playing) { clearInterval(wait); clock.loop = loop; recorder.stop(); } }, 100);
}
