// The server beside the page, where there is one.
const token = new URLSearchParams(location.search).get("token");
const KEPT_ALIVE = 60000; // characters: browsers refuse more in a request that outlives its page
export const served = Boolean(token) && location.protocol.startsWith("http");
export const address = (path, more = {}) => (served ? `${path}?${new URLSearchParams({ token, ...more })}` : path);

export async function post(path, body, more = {}) {
  const answer = await fetch(address(path, more), { method: "POST", body });
  const text = await answer.text();
  if (!answer.ok) throw new Error(text);
  return text;
}

// What is saved at once, one after another, so that revisions agree; the browser finishes it when the tab closes.
export class Saver {
  constructor(path, more = {}) { Object.assign(this, { path, more, queue: Promise.resolve() }); }

  // `body` is asked for when its turn comes; `heard(text, status)` hears the answer, status 0 where there is none.
  save(body, heard) {
    this.queue = this.queue.then(async () => {
      const text = body();
      const answer = await fetch(address(this.path, this.more), { method: "POST", body: text, keepalive: text.length < KEPT_ALIVE });
      await heard(await answer.text(), answer.status);
    }).catch(() => heard("not saved: the server has ended", 0));
  }
}
