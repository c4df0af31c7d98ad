// Small makers of page elements.
export function make(tag, more = {}, ...inside) {
  const { on = {}, data = {}, aria = {}, ...rest } = more, made = document.createElement(tag);
  Object.assign(made, rest);
  Object.assign(made.dataset, data);
  for (const [name, heard] of Object.entries(on)) made.addEventListener(name, heard);
  for (const [name, value] of Object.entries(aria)) made.setAttribute(`aria-${name}`, value);
  made.append(...inside);
  return made;
}

export const button = (text, click, more = {}) => make("button", { type: "button", textContent: text, on: { click }, ...more });

// A button that stays in; `changed` hears whether it is.
export function toggle(text, changed, on = false) {
  const made = button(text, () => press(made.getAttribute("aria-pressed") !== "true"), { aria: { pressed: String(on) } });
  const press = (value) => { made.setAttribute("aria-pressed", String(value)); changed(value); };
  made.press = press;
  return made;
}

export function choice(label, options, chosen, changed) {
  const made = make("select", { ariaLabel: label, on: { change: () => changed(made.value) } }, ...options.map(([value, text]) => make("option", { value, textContent: text })));
  made.value = chosen;
  return made;
}

export const heading = (text) => make("h2", { textContent: text });
export const row = (...inside) => make("div", { className: "row" }, ...inside);

export function save(name, blob) {
  const link = make("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
