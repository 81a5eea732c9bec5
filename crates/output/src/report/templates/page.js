"use strict";
(() => {
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const byId = id => document.getElementById(id);
const words = new Intl.Collator("en", { numeric: true });

function make(tag, attributes = {}, text = "", parent = null, space = parent && parent.namespaceURI) {
  const made = space ? document.createElementNS(space, tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text) made.textContent = text;
  if (parent) parent.append(made);
  return made;
}

// Tables: a click on a heading sorts, largest first, then smallest first, then as it was.

/** The sort key of a cell: a number, a text, or null for an empty cell. */
function key(cell) {
  if (!cell) return null;
  if (cell.dataset.v !== undefined) return Number.isNaN(Number(cell.dataset.v)) ? null : Number(cell.dataset.v);
  const text = cell.textContent.trim();
  const counts = text.split(" / ").map(Number);
  if (counts.length === 3) return counts[1] + counts[2];
  if (cell.tagName === "TH" || cell.classList.contains("text")) return text || null;
  return null;
}

function sorted(items, keyOf, direction) {
  const way = direction === "descending" ? -1 : 1;
  const keyed = items.map(item => ({ item, key: keyOf(item) }));
  keyed.sort((a, b) => {
    if (a.key === null || b.key === null) return (a.key === null) - (b.key === null);
    return way * (typeof a.key === "number" && typeof b.key === "number"
      ? a.key - b.key : words.compare(a.key, b.key));
  });
  return keyed.map(k => k.item);
}

const sorters = new Map();

function sortButton(th, heads, sort) {
  const button = make("button", { type: "button", class: "sort" });
  button.append(...th.childNodes);
  th.append(button);
  const next = { none: "descending", descending: "ascending", ascending: "none" };
  const by = direction => {
    for (const head of heads) head.removeAttribute("aria-sort");
    if (direction !== "none") th.setAttribute("aria-sort", direction);
    sort(direction);
  };
  button.addEventListener("click", () => by(next[th.getAttribute("aria-sort") || "none"]));
  sorters.set(th, by);
}

function sortable(table) {
  const head = table.tHead.rows[0];
  const bodies = [...table.tBodies].map(body => ({
    body, rows: [...body.rows].filter(row => !row.querySelector(".group")),
  }));
  const heads = [...head.cells];
  for (const th of heads) {
    sortButton(th, heads, direction => {
      for (const { body, rows } of bodies) {
        const order = direction === "none" ? rows : sorted(rows, row => key(row.cells[th.cellIndex]), direction);
        body.append(...order);
      }
    });
  }
  if (!table.classList.contains("both")) return;
  const rows = bodies.flatMap(b => b.rows);
  // Only rows of one measure can be put in order.
  const measures = rows.filter(row => row.dataset.sorts !== undefined);
  const labels = measures.map(row => row.cells[0]);
  const original = heads.slice(1);
  for (const row of measures) {
    sortButton(row.cells[0], labels, direction => {
      const now = [...head.cells].slice(1);
      const order = direction === "none" ? original : sorted(now, th => key(row.cells[th.cellIndex]), direction);
      const places = order.map(th => th.cellIndex);
      for (const each of [head, ...rows]) {
        const cells = [...each.cells];
        each.append(...places.map(place => cells[place]));
      }
    });
  }
}

all("table.numbers").forEach(sortable);

// A folded table opens when a link leads to it.
for (const link of all(".contents a")) {
  link.addEventListener("click", () => { byId(link.hash.slice(1)).closest("details").open = true; });
}

// Filters of the table of sequences.

const table = byId("sequence-table");
if (!table) return;
const rows = [...table.tBodies[0].rows];
const fixed = 4;
const filter = { sequence: byId("by-sequence"), tracker: byId("by-tracker"), method: byId("by-method"), attribute: byId("by-attribute") };
const series = JSON.parse(byId("series").textContent);

function passes(row) {
  const { sequence, tracker, method, attribute } = filter;
  const name = series.sequences[row.dataset.s].name.toLowerCase();
  return name.includes(sequence.value.trim().toLowerCase())
    && (tracker.value === "" || tracker.value === row.dataset.t)
    && (attribute.value === "" || row.dataset.a.split(" ").includes(attribute.value))
    && (method.value === "" || row.cells[fixed + Number(method.value)].textContent !== "");
}

function applyFilters() {
  closeExplained();
  for (const row of rows) row.hidden = !passes(row);
  const method = filter.method.value;
  for (const row of table.rows) {
    series.methods.forEach((_, k) => { row.cells[fixed + k].hidden = method !== "" && method !== String(k); });
  }
  const shown = rows.filter(row => !row.hidden);
  series.methods.forEach((_, k) => {
    const cells = shown.map(row => row.cells[fixed + k].textContent).filter(text => text !== "");
    const sums = cells.map(text => text.split(" / ").map(Number)).reduce((a, b) => a.map((v, i) => v + b[i]), [0, 0, 0]);
    table.tFoot.rows[0].cells[fixed + k].textContent = cells.length ? sums.join(" / ") : "";
  });
  byId("shown").textContent = `${shown.length} of ${rows.length} rows are shown.`;
  if (shown.length && !shown.includes(rowOf(state.s, state.t))) {
    openFirst();
  } else if (method !== "" && state.m !== Number(method)) {
    open(state.s, state.t, Number(method));
  } else {
    fillChoices();
  }
}

/** Shows the first track of the table. */
function openFirst() {
  const top = [...table.tBodies[0].rows].find(row => !row.hidden);
  const method = filter.method.value;
  if (top) open(Number(top.dataset.s), Number(top.dataset.t), method === "" ? state.m : Number(method));
}

// A number of a table links to the sequences behind it, and moves the keyboard focus there.

const explained = byId("explained");
let origin = null;
for (const link of all("a.origin")) link.hash = "#explained";

function closeExplained() {
  if (origin) origin.classList.remove("open");
  origin = null;
  explained.hidden = true;
}

function explainNumber(link) {
  const { t, m, a } = link.dataset;
  filter.sequence.value = "";
  [filter.tracker.value, filter.method.value, filter.attribute.value] = [t ?? "", m ?? "", a ?? ""];
  applyFilters();
  if (m !== undefined) sorters.get(table.tHead.rows[0].cells[fixed + Number(m)])("descending");
  openFirst();
  const [number, formula, command] = link.title.split("\n");
  byId("explained-number").textContent = number;
  byId("explained-formula").textContent = formula;
  byId("explained-by").textContent = m === undefined
    ? "This point of the grid is not among the methods below."
    : `${series.methods[m].counted}${series.methods[m].counted && "; "}the sequences with most misses and false alarms come first.`;
  byId("explained-command").textContent = command;
  origin = link;
  link.classList.add("open");
  explained.hidden = false;
}

document.addEventListener("click", event => {
  const link = event.target.closest("a.origin");
  if (link && !event.ctrlKey && !event.metaKey && !event.shiftKey) explainNumber(link);
});
byId("explained-back").addEventListener("click", () => {
  const link = origin;
  link.closest("details").open = true;
  link.focus({ preventScroll: true });
  link.scrollIntoView({ block: "center" });
});

// Series: columns of differences, decoded when they are first shown.

const decoded = new Map();
window.trackfail = part => {
  Object.assign(series.truth, part.truth);
  Object.assign(series.data, part.data);
};

function column(differences, scale) {
  let sum = 0;
  return differences.map(d => (d === null ? null : (sum += d) * scale));
}

function loaded(s, t) {
  const name = `${s}-${t}`;
  if (series.data[name]) return Promise.resolve();
  const place = series.tracks.find(track => track[0] === s && track[1] === t);
  if (!place || place[2] === null) return Promise.reject(new Error("no such track"));
  return new Promise((resolve, reject) => {
    const script = make("script");
    script.onload = () => (series.data[name] ? resolve() : reject(new Error(series.files[place[2]])));
    script.onerror = () => reject(new Error(`${series.files[place[2]]} is not beside this page`));
    script.src = series.files[place[2]];
    document.head.append(script);
  });
}

function decode(s, t) {
  const name = `${s}-${t}`;
  if (!decoded.has(name)) {
    const raw = series.data[name];
    const boxes = columns => columns.map(c => column(c, 0.1));
    decoded.set(name, {
      box: boxes(raw.box),
      background: raw.background && boxes(raw.background),
      truth: boxes(series.truth[s]),
      error: column(raw.error, 0.001),
      said: Object.fromEntries(Object.entries(raw.said).map(([m, said]) => [m, {
        ...said,
        score: column(said.score, 1).map(v => (v === null ? null : Number(`${v}e${-said.digits}`))),
        marks: said.marks.map(markOf),
      }])),
    });
  }
  return decoded.get(name);
}

/** Label of a mark: its frame and kind, the frame it is matched with, and the notes of event and detection. */
function markOf([event, detection, found, clear]) {
  const kind = series.unannotated ? (clear ? "hit" : "miss") : event === null ? "false" : detection === null ? "miss" : "hit";
  return { frame: event ?? detection, other: detection, event, detection, found, clear, kind };
}

