// The server beside the page, where there is one.
const token = new URLSearchParams(location.search).get("token");
export const served = Boolean(token) && location.protocol.startsWith("http");
export const address = (path, more = {}) => (served ? `${path}?${new URLSearchParams({ token, ...more })}` : path);

export async function post(path, body, more = {}) {
  const answer = await fetch(address(path, more), { method: "POST", body });
  const text = await answer.text();
  if (!answer.ok) throw new Error(text);
  return text;
}
