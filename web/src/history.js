// Undo and redo of a state that JSON holds; the last one that was changed hears ctrl+Z.
let last = null;

export class History {
  // `read` gives the state, `write` takes one back and saves it.
  constructor(read, write) { Object.assign(this, { read, write, past: [], future: [] }); }

  // Before a change.
  keep() { this.past.push(JSON.stringify(this.read())); this.future = []; last = this; }

  step(from, into) {
    if (!from.length) return;
    into.push(JSON.stringify(this.read()));
    last = this;
    this.write(JSON.parse(from.pop()));
  }

  undo() { this.step(this.past, this.future); }
  redo() { this.step(this.future, this.past); }

  // Buttons that can be pressed only where there is something to take back.
  press(undo, redo) { undo.disabled = !this.past.length; redo.disabled = !this.future.length; }
}

addEventListener("keydown", (event) => {
  if (!last || !(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z" || event.target.matches?.("input[type=text], input[type=search]")) return;
  event.preventDefault();
  if (event.shiftKey) last.redo(); else last.undo();
});
