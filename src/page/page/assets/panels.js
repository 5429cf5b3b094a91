// The panels beside the view: tabs, the report in words, events, tables of the model.

function byId(id) {
  return document.getElementById(id);
}

// An element with these properties.
function make(name, properties = {}) {
  return Object.assign(document.createElement(name), properties);
}

// Panels of which one is shown; the first is at the beginning.
class Tabs {
  constructor() {
    this.all = new Map();
  }

  add(name) {
    const button = make("button", { textContent: name });
    button.setAttribute("role", "tab");
    const panel = make("div", { className: "panel" });
    panel.setAttribute("role", "tabpanel");
    button.addEventListener("click", () => this.show(name));
    byId("tabs").append(button);
    byId("panels").append(panel);
    this.all.set(name.toLowerCase(), { button, panel });
    this.show([...this.all.keys()][0]);
    return panel;
  }

  show(name) {
    if (!this.all.has(name.toLowerCase())) return;
    for (const [key, { button, panel }] of this.all) {
      const chosen = key === name.toLowerCase();
      button.setAttribute("aria-selected", chosen);
      panel.hidden = !chosen;
    }
  }
}

// The report: facts, warnings, and what the page does not show.
function fillReport(panel, header) {
  const list = make("dl");
  for (const [label, text] of header.facts) list.append(make("dt", { textContent: label }), make("dd", { textContent: text }));
  panel.append(make("h2", { textContent: header.kind === "run" ? "The run" : "The model" }), list);
  const said = (title, lines, kind) => {
    const items = make("ul", { className: `said ${kind}` });
    for (const line of lines) items.append(make("li", { textContent: line }));
    panel.append(make("h2", { textContent: title }), items);
  };
  if (header.warnings.length > 0) said(`Warnings (${header.warnings.length})`, header.warnings, "warnings");
  else panel.append(make("h2", { textContent: "Warnings" }), make("p", { className: "quiet", textContent: "None." }));
  if (header.notes.length > 0) said("About this page", header.notes, "notes");
}

// The events in a table; a row leads to its time.
class Events {
  constructor(panel, events, seek) {
    this.events = events;
    this.rows = [];
    this.current = null;
    if (events.length === 0) {
      panel.append(make("p", { className: "quiet", textContent: "Nothing happened that counts as an event: no impact, no sticking or slipping, no motor at its bound." }));
      return;
    }
    const table = make("table");
    const head = make("tr");
    for (const title of ["time [s]", "event", "joint or a|b", "impulse [N s, N m s]"]) head.append(make("th", { textContent: title }));
    table.append(head);
    for (const event of events) {
      const row = make("tr", { className: "jump" });
      const impulse = event.impulse === undefined || event.impulse === null ? "" : plain(event.impulse);
      [event.time.toFixed(6), event.kind.replaceAll("_", " "), event.what, impulse].forEach((text, k) =>
        row.append(make("td", { textContent: text, className: k === 0 || k === 3 ? "number" : "" })));
      row.addEventListener("click", () => seek(event.time));
      table.append(row);
      this.rows.push(row);
    }
    panel.append(make("p", { className: "quiet", textContent: "Click an event to go to its time." }), table);
  }

  // Marks the last event at or before a time.
  place(time) {
    let last = -1;
    while (last + 1 < this.events.length && this.events[last + 1].time <= time + 1e-9) last++;
    if (this.rows[last] === this.current) return;
    if (this.current) this.current.classList.remove("now");
    this.current = this.rows[last];
    if (this.current) this.current.classList.add("now");
  }
}

// Tables as they are.
function fillTables(panel, tables) {
  if (tables.length === 0) panel.append(make("p", { className: "quiet", textContent: "Nothing moves in this model." }));
  for (const { title, columns, rows } of tables) {
    const table = make("table");
    const head = make("tr");
    for (const column of columns) head.append(make("th", { textContent: column }));
    table.append(head);
    for (const cells of rows) {
      const row = make("tr");
      for (const cell of cells) row.append(make("td", { textContent: cell }));
      table.append(row);
    }
    const scroll = make("div", { className: "scroll" });
    scroll.append(table);
    panel.append(make("h2", { textContent: title }), scroll);
  }
}
