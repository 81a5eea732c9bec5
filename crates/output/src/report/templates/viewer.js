// The viewer.

const state = { s: 0, t: 0, m: 0, f: 0 };
const choice = { s: byId("show-sequence"), t: byId("show-tracker"), m: byId("show-method") };
const [strip, stage, readout, marksList] = ["strip", "stage", "readout", "marks"].map(byId);
let view = null;
let frameOf = () => 0;
let cursor = null;
const rowOf = (s, t) => rows.find(row => row.dataset.s === String(s) && row.dataset.t === String(t));
const methodsOf = row => series.methods.map((_, k) => k).filter(k => row.cells[fixed + k].textContent !== "");
const number = f => series.sequences[state.s].first + f;
const short = v => (v === null || v === undefined ? "–" : String(Number(v.toPrecision(4))));

/** A number beside an axis, where there is room for seven letters. */
function tick(v) {
  const text = String(Number(v.toPrecision(3)));
  return text.length <= 7 ? text : v.toExponential(1);
}

function options(select, values, names, value) {
  select.replaceChildren(...values.map(v => {
    const option = make("option", { value: v, dir: "auto" }, names(v));
    option.selected = v === value;
    return option;
  }));
  // Where there is nothing to choose, the picture is what one came for.
  select.parentElement.hidden = values.length < 2;
}

function fillChoices() {
  const shown = rows.filter(row => !row.hidden || row === rowOf(state.s, state.t));
  const unique = values => [...new Set(values)].sort((a, b) => a - b);
  const only = filter.method.value;
  options(choice.s, unique(shown.map(row => Number(row.dataset.s))), s => series.sequences[s].name, state.s);
  const here = rows.filter(row => row.dataset.s === String(state.s) && (!row.hidden || row.dataset.t === String(state.t)));
  options(choice.t, unique(here.map(row => Number(row.dataset.t))), t => series.trackers[t], state.t);
  const methods = methodsOf(rowOf(state.s, state.t)).filter(k => only === "" || only === String(k));
  options(choice.m, methods, m => series.methods[m].name, state.m);
}

/** Shows a track at a frame; by default at its first event or detection. */
function open(s, t, m, f = null) {
  stop();
  if (!rowOf(s, t)) t = Number(rows.find(row => row.dataset.s === String(s)).dataset.t);
  const can = methodsOf(rowOf(s, t));
  Object.assign(state, { s, t, m: can.includes(m) ? m : can[0] });
  for (const row of rows) row.classList.toggle("open", row === rowOf(s, t));
  fillChoices();
  readout.textContent = "Loading …";
  loaded(s, t).then(() => {
    if (state.s !== s || state.t !== t) return;
    view = decode(s, t);
    const marks = said().marks;
    state.f = f ?? (marks.length ? marks[0].frame : 0);
    drawStrip();
    listMarks();
    listThumbnails();
    step(0);
  }).catch(error => { readout.textContent = `Cannot be shown: ${error.message}.`; });
}

const said = () => view.said[state.m] || { score: [], alarms: [], marks: [] };
const kinds = Object.fromEntries(["hit", "miss", "false"].map((kind, k) => [kind, series.words.outcome[k]]));

function describe(mark) {
  const { event, detection } = series.words;
  const what = mark.event === null ? detection[mark.clear] : event[mark.found];
  if (series.unannotated) return `Frame ${number(mark.frame)}: ${what}`;
  const text = `Frame ${number(mark.frame)}: ${mark.kind === "false" && !mark.clear ? "" : `${what}, `}${kinds[mark.kind]}`;
  if (mark.kind !== "hit") return text;
  const late = mark.detection - mark.event;
  const when = late === 0 ? "at once" : `${Math.abs(late)} frame${Math.abs(late) === 1 ? "" : "s"} ${late > 0 ? "later" : "before"}`;
  return `${text} by ${detection[mark.clear]} ${when}`;
}

function listMarks() {
  const marks = said().marks;
  marksList.replaceChildren(...marks.map(mark => {
    const item = make("li");
    const button = make("button", { type: "button", class: mark.kind, "data-f": mark.frame });
    const sign = make("svg", { viewBox: "-7 -7 14 14", "aria-hidden": "true" }, "", null, strip.namespaceURI);
    shape(sign, mark.kind, 0, 0);
    button.append(sign, describe(mark));
    button.addEventListener("click", () => go(mark.frame));
    item.append(button);
    return item;
  }));
  byId("no-marks").hidden = marks.length > 0;
}

/** Hits are discs, misses crosses, false alarms triangles. */
function shape(parent, kind, x, y) {
  const at = { transform: `translate(${x} ${y})`, class: `mark ${kind}` };
  if (kind === "hit") make("circle", { ...at, r: 5 }, "", parent);
  else if (kind === "miss") make("path", { ...at, d: "M-5-5L5 5M5-5L-5 5" }, "", parent);
  else make("path", { ...at, d: "M0-6L6 5H-6Z" }, "", parent);
}

function line(values, x, y) {
  let path = "", pen = false;
  values.forEach((v, f) => {
    if (v === null) { pen = false; return; }
    path += `${pen ? "L" : "M"}${x(f + 0.5).toFixed(1)} ${y(v).toFixed(1)}`;
    pen = true;
  });
  return path;
}

function drawStrip() {
  const width = Math.max(240, strip.parentNode.clientWidth), left = 56, right = 8;
  const frames = view.error.length, now = said();
  const threshold = series.methods[state.m].thresholds[state.t];
  const x = f => left + (width - left - right) * f / frames;
  frameOf = at => Math.min(frames - 1, Math.max(0, Math.floor((at - left) / (width - left - right) * frames)));
  const panels = series.unannotated
    ? { score: [14, 124], alarms: [134, 144], marks: [148, 170] }
    : { error: [14, 62], score: [84, 180], alarms: [190, 200], marks: [204, 226] };
  const top = 14, bottom = panels.marks[1], height = bottom + 20;
  strip.replaceChildren();
  strip.setAttribute("viewBox", `0 0 ${width} ${height}`);
  strip.setAttribute("height", height);
  const draw = (tag, attributes, text) => make(tag, attributes, text, strip);
  const label = (at, y, text, anchor = "end") => draw("text", { x: at, y, "text-anchor": anchor }, text);
  // Frames in which the target is lost, behind everything.
  const shade = (name, from, to) => draw("rect", { class: name, x: x(from), width: Math.max(1, x(to + 1) - x(from)), y: top, height: bottom - top });
  for (const name of ["lost", "absent"]) {
    const runs = now[name] || [];
    for (let k = 0; k < runs.length; k += 2) shade(name, runs[k], runs[k + 1]);
  }
  for (let f = 0; f < frames; f++) {
    if (view.error[f] === null || view.error[f] < 1) continue;
    let end = f;
    while (end + 1 < frames && view.error[end + 1] >= 1) end++;
    shade("lost", f, end);
    f = end;
  }
  const panel = ([top, bottom], low, high, title) => {
    draw("path", { class: "axis", d: `M${left} ${top}V${bottom}H${width - right}` });
    label(left - 4, top + 8, tick(high));
    label(left - 4, bottom, tick(low));
    label(left + 2, top - 4, title, "start");
    return v => bottom - (bottom - top) * (Math.min(high, Math.max(low, v)) - low) / (high - low || 1);
  };
  if (panels.error) {
    const error = panel(panels.error, 0, 1, "tracking error Oₜ");
    draw("path", { class: "line error", d: line(view.error, x, error) });
  }
  const values = now.score.filter(v => v !== null);
  if (threshold !== null) values.push(threshold);
  const low = values.reduce((a, b) => Math.min(a, b), values.length ? values[0] : 0);
  const high = values.reduce((a, b) => Math.max(a, b), values.length ? values[0] : 1);
  const score = panel(panels.score, low, high, threshold === null ? "score" : `score, threshold ${short(threshold)}`);
  if (threshold !== null) draw("path", { class: "line threshold", d: `M${left} ${score(threshold)}H${width - right}` });
  draw("path", { class: "line score", d: line(now.score, x, score) });
  label(left - 4, panels.alarms[1] - 1, "alarm");
  for (let k = 0; k < now.alarms.length; k += 2) {
    const [from, to] = [now.alarms[k], now.alarms[k + 1] + 1];
    draw("rect", { class: "alarm", x: x(from), width: Math.max(1, x(to) - x(from)), y: panels.alarms[0], height: 10 });
  }
  label(left - 4, panels.marks[1] - 6, "marks");
  for (const mark of now.marks) {
    const group = draw("g", { class: "jump", "data-f": mark.frame });
    make("title", {}, describe(mark), group);
    const middle = panels.marks[0] + 11;
    make("rect", { x: x(mark.frame + 0.5) - 9, y: middle - 12, width: 18, height: 24, class: "hit-area" }, "", group);
    if (mark.event !== null && mark.kind === "hit") make("path", { class: "join", d: `M${x(mark.frame + 0.5)} ${middle}H${x(mark.other + 0.5)}v-6v12` }, "", group);
    shape(group, mark.kind, x(mark.frame + 0.5), middle);
  }
  label(left, height - 5, String(number(0)), "start");
  label(width - right, height - 5, `frame ${number(frames - 1)}`);
  cursor = draw("path", { class: "cursor" });
  cursor.place = f => cursor.setAttribute("d", `M${x(f + 0.5)} ${top - 4}V${bottom}`);
  cursor.place(state.f);
  strip.parentNode.setAttribute("aria-valuemin", number(0));
  strip.parentNode.setAttribute("aria-valuemax", number(frames - 1));
}

function boxAt(columns, f) {
  const at = columns.map(c => c[f]);
  if (at.some(v => v === null || v === undefined)) return null;
  if (at.length === 8) return at;
  const [x, y, w, h] = at;
  return [x, y, x + w, y, x + w, y + h, x, y + h];
}

/** The visible area: the frame with a margin, or the area that all boxes cover where the frame's size is unknown. */
function extent() {
  const size = series.sequences[state.s].size;
  if (size) return [0, 0, size[0], size[1]];
  if (!view.extent) {
    let [left, top, right, bottom] = [Infinity, Infinity, -Infinity, -Infinity];
    for (let f = 0; f < view.error.length; f++) {
      for (const corners of [boxAt(view.box, f), boxAt(view.truth, f)]) {
        if (!corners) continue;
        for (let k = 0; k < 8; k += 2) {
          [left, right] = [Math.min(left, corners[k]), Math.max(right, corners[k])];
          [top, bottom] = [Math.min(top, corners[k + 1]), Math.max(bottom, corners[k + 1])];
        }
      }
    }
    view.extent = left < right && top < bottom ? [left, top, right - left, bottom - top] : [0, 0, 4, 3];
  }
  return view.extent;
}

/** State of the target in a frame, where there is no ground truth. */
function stateAt(f) {
  const within = runs => (runs || []).some((from, k) => k % 2 === 0 && from <= f && f <= runs[k + 1]);
  return ["lost", "absent"].find(name => within(said()[name])) || "tracking";
}

/** The frame of the picture that is nearest to a frame; null where there is none. */
function nearestPicture(f) {
  const frames = Object.keys(series.sequences[state.s].pictures).map(Number);
  return frames.length ? frames.reduce((best, g) => (Math.abs(g - f) < Math.abs(best - f) ? g : best)) : null;
}

function drawBoxes(parent, f) {
  const kinds = series.unannotated
    ? [[stateAt(f), view.box]]
    : [["background", view.background], ["tracker", view.box], ["truth", view.truth]];
  for (const [kind, columns] of kinds) {
    const corners = columns && boxAt(columns, f);
    if (!corners) continue;
    make("polygon", { class: "halo", points: corners.join(" ") }, "", parent);
    make("polygon", { class: `box ${kind}`, points: corners.join(" ") }, "", parent);
  }
}

/** Thumbnails of the frames in which losses begin and end, and of the first and last frame. */
function listThumbnails() {
  const sequence = series.sequences[state.s];
  const wanted = [0, ...said().marks.map(mark => mark.frame), view.error.length - 1];
  const frames = [...new Set(wanted)].filter(f => sequence.pictures[f]).slice(0, 24);
  byId("thumbnails").replaceChildren(...frames.map(f => {
    const item = make("li"), button = make("button", { type: "button", "data-f": f }, "", item);
    const [w, h] = sequence.size;
    const picture = make("svg", { viewBox: `0 0 ${w} ${h}`, "aria-hidden": "true" }, "", button, strip.namespaceURI);
    make("image", { href: sequence.pictures[f], x: 0, y: 0, width: w, height: h, preserveAspectRatio: "none" }, "", picture);
    drawBoxes(picture, f);
    make("span", {}, `${number(f)} ${stateAt(f)}`, button);
    button.addEventListener("click", () => go(f));
    return item;
  }));
}

function drawStage() {
  const [x, y, w, h] = extent(), sequence = series.sequences[state.s], margin = 0.04 * Math.max(w, h);
  stage.replaceChildren();
  stage.setAttribute("viewBox", `${x - margin} ${y - margin} ${w + 2 * margin} ${h + 2 * margin}`);
  make("rect", { class: sequence.size ? "frame" : "frame unknown", x, y, width: w, height: h }, "", stage);
  if (sequence.stills.includes(state.f)) {
    const name = `stills/${String(state.s).padStart(3, "0")}-${String(state.f).padStart(6, "0")}.png`;
    make("image", { href: name, x, y, width: w, height: h, preserveAspectRatio: "none" }, "", stage);
  }
  const near = nearestPicture(state.f);
  if (near !== null) {
    const other = near === state.f ? "" : "other";
    make("image", { class: other, href: sequence.pictures[near], x, y, width: w, height: h, preserveAspectRatio: "none" }, "", stage);
    if (other) make("text", { x: x + w - margin / 3, y: y + h - margin / 3, "text-anchor": "end", "font-size": margin }, `picture of frame ${number(near)}`, stage);
  }
  drawBoxes(stage, state.f);
  byId("attributes").textContent = sequence.attributes && `Attributes: ${sequence.attributes}.`;
  byId("background-key").hidden = !view.background;
  byId("size").textContent = sequence.size ? `Frame of ${w} × ${h} pixels.` : "The size of the frame is not known; the stage is what the boxes cover.";
}

function step(by) {
  state.f = Math.min(view.error.length - 1, Math.max(0, state.f + by));
  cursor.place(state.f);
  drawStage();
  const now = said(), threshold = series.methods[state.m].thresholds[state.t];
  let alarm = false;
  for (let k = 0; k < now.alarms.length; k += 2) alarm ||= now.alarms[k] <= state.f && state.f <= now.alarms[k + 1];
  const here = now.marks.filter(mark => mark.frame === state.f).map(mark => kinds[mark.kind]);
  if (now.marks.some(mark => mark.kind === "hit" && mark.other === state.f)) here.push(`${series.words.detection[0]} of a hit`);
  const error = view.error[state.f];
  const parts = [
    `Frame ${number(state.f)} (${state.f + 1} of ${view.error.length})`,
    series.unannotated ? stateAt(state.f) : `Oₜ ${short(error)}${error !== null && error >= 1 ? ", lost" : ""}`,
    `score ${short(now.score[state.f])}${threshold === null ? "" : `, threshold ${short(threshold)}`}`,
    alarm ? "alarm" : "no alarm", ...(series.unannotated ? [] : here),
  ];
  readout.textContent = parts.join(" · ");
  byId("link").hash = addressOf();
  const slider = strip.parentNode;
  slider.setAttribute("aria-valuenow", number(state.f));
  slider.setAttribute("aria-valuetext", readout.textContent);
  for (const button of all("button", marksList)) {
    if (Number(button.dataset.f) === state.f) button.setAttribute("aria-current", "true");
    else button.removeAttribute("aria-current");
  }
}

function go(f) { state.f = f; step(0); }

// A link leads to a sequence, a tracker, a method and a frame, all by their names.

function addressOf() {
  const names = {
    sequence: series.sequences[state.s].name, tracker: series.trackers[state.t],
    method: series.methods[state.m].name, frame: number(state.f),
  };
  return new URLSearchParams(names).toString();
}

/** Opens what the page's address names; says whether it names something that is there. */
function follow() {
  const asked = new URLSearchParams(location.hash.slice(1));
  const s = series.sequences.findIndex(sequence => sequence.name === asked.get("sequence"));
  if (s < 0 || !rows.some(row => row.dataset.s === String(s))) return false;
  const t = series.trackers.indexOf(asked.get("tracker"));
  const m = series.methods.findIndex(method => method.name === asked.get("method"));
  const frame = Number(asked.get("frame") ?? NaN) - series.sequences[s].first;
  open(s, t < 0 ? state.t : t, m < 0 ? state.m : m, Number.isInteger(frame) ? frame : null);
  byId("viewer").hidden = false;
  byId("viewer").scrollIntoView({ block: "start" });
  return true;
}
window.addEventListener("hashchange", follow);

// Playing goes on to the end of the track, or until something else is done.

let player = null;
function stop() {
  clearInterval(player);
  player = null;
  byId("play").textContent = "▶ play";
  byId("play").setAttribute("aria-pressed", "false");
}
function play() {
  if (player !== null) { stop(); return; }
  if (state.f >= view.error.length - 1) go(0);
  byId("play").textContent = "❚❚ stop";
  byId("play").setAttribute("aria-pressed", "true");
  player = setInterval(() => {
    step(1);
    if (state.f >= view.error.length - 1) stop();
  }, 1000 / Number(byId("speed").value));
}
byId("speed").addEventListener("change", () => { if (player !== null) { stop(); play(); } });

/** To the next (1) or previous (-1) event or detection. */
function jump(way) {
  const all = said().marks.flatMap(mark => [mark.event, mark.detection]).filter(f => f !== null);
  const frames = [...new Set(all)].sort((a, b) => way * (a - b));
  const next = frames.find(f => way * (f - state.f) > 0);
  if (next !== undefined) go(next);
}

const actions = {
  first: () => go(0), back: () => step(-1), ahead: () => step(1),
  last: () => go(view.error.length - 1), previous: () => jump(-1), next: () => jump(1), play,
};
const keys = {
  ArrowLeft: "back", ArrowRight: "ahead", Home: "first", End: "last", n: "next", p: "previous", k: "play",
};
const viewer = byId("viewer");
viewer.addEventListener("keydown", event => {
  if (!view || event.ctrlKey || event.altKey || event.metaKey || /^(SELECT|INPUT)$/.test(event.target.tagName)) return;
  const ten = event.shiftKey && { ArrowLeft: -10, ArrowRight: 10 }[event.key];
  if (ten) step(ten);
  else if (keys[event.key]) actions[keys[event.key]]();
  else return;
  event.preventDefault();
});
for (const button of all("button[data-do]", viewer)) {
  button.addEventListener("click", () => view && actions[button.dataset.do]());
}
function point(event) {
  const mark = event.type === "pointerdown" && event.target.closest("[data-f]");
  if (mark) go(Number(mark.dataset.f));
  else go(frameOf(event.clientX - strip.getBoundingClientRect().left));
}
strip.addEventListener("pointerdown", event => {
  if (!view || event.button !== 0) return;
  strip.setPointerCapture(event.pointerId);
  strip.parentNode.focus();
  event.preventDefault();
  point(event);
});
strip.addEventListener("pointermove", event => { if (view && event.buttons === 1 && strip.hasPointerCapture(event.pointerId)) point(event); });
new ResizeObserver(() => { if (view) drawStrip(); }).observe(strip.parentNode);

choice.s.addEventListener("change", () => open(Number(choice.s.value), state.t, state.m));
choice.t.addEventListener("change", () => open(state.s, Number(choice.t.value), state.m));
choice.m.addEventListener("change", () => open(state.s, state.t, Number(choice.m.value)));
for (const each of Object.values(filter)) each.addEventListener(each === filter.sequence ? "input" : "change", applyFilters);
byId("clear").addEventListener("click", () => {
  for (const each of Object.values(filter)) each.value = "";
  applyFilters();
});

// A row's name opens it; so does a click on one of its counts, with that method.
for (const row of rows) {
  const show = make("button", { type: "button", class: "show" });
  show.append(...row.cells[0].childNodes);
  row.cells[0].append(show);
}
table.tBodies[0].addEventListener("click", event => {
  const row = event.target.closest("tr");
  const cell = event.target.closest("td, th");
  if (!row || !cell || (cell.tagName === "TH" && !event.target.closest("button"))) return;
  const m = cell.cellIndex - fixed;
  if (m >= 0 && cell.textContent === "") return;
  open(Number(row.dataset.s), Number(row.dataset.t), m >= 0 ? m : state.m);
  viewer.scrollIntoView({ block: "nearest" });
});

options(filter.tracker, ["", ...series.trackers.keys()], t => (t === "" ? "all" : series.trackers[t]), "");
options(filter.method, ["", ...series.methods.keys()], m => (m === "" ? "all" : series.methods[m].name), "");
for (const hidden of all("[data-js]")) hidden.hidden = false;
if (!follow()) open(...series.start);
})();
