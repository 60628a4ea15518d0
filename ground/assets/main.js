// The page: views, buttons, keys, and the stored layout.

import { ask, clock, connect, element, now, on, time, write } from "./station.js";
import { Board, MOST, axis, dragPans, follow, forget, hideAll, onMoved, pause, range, rebuild, seriesOf, setMarkers, shift, stay, watch, zoom } from "./plots.js";
import { choose, question, say } from "./chooser.js";
import { angles, attitude, heading } from "./instruments.js";
import { drawn, map, turnColours, turnExtent } from "./map.js";
import { cornerOf, tileAt } from "./tiles.js";
import { clear, hover } from "./panels.js";
import { turnSound } from "./warning.js";
import * as records from "./records.js";

const byId = (name) => document.getElementById(name);
const FIRST = [["roll_deg"], ["pitch_deg"], ["yaw_deg"], ["vel_n_mps"], ["vel_e_mps"], ["vel_u_mps"]];
const HOVER = [["vel_n_mps", "asked_vel_n_mps"], ["vel_e_mps", "asked_vel_e_mps"], ["stick_lateral_pct", "flown_lateral_pct"], ["stick_longitudinal_pct", "flown_longitudinal_pct"]];
const POINTS = [["stick_lateral_pct", "stick_longitudinal_pct"], ["p_degps", "q_degps"], ["stick_collective_pct", "stick_pedal_pct"], ["accel_z_g"]];
const THEMES = ["auto", "light", "dark", "sun"];

const kept = (() => {
  try { return JSON.parse(localStorage.getItem("layout")) ?? {}; } catch { return {}; }
})();
let recording = false;
let tab = "plots";
let theme = THEMES.includes(kept.theme) ? kept.theme : "auto";
let pans = false;

function keep() {
  const plots = boards.plots.lists;
  try { localStorage.setItem("layout", JSON.stringify({ plots, window: axis.window, theme, tab })); } catch { /* The page works without storage. */ }
}

const pick = (plot) => choose((name) => plot.choose([name]));
const boards = {
  plots: new Board(byId("plots"), { changed: keep, choose: pick }),
  hover: new Board(byId("hover-plots"), { fixed: true }),
  points: new Board(byId("points-plots"), { fixed: true }),
};

function show(name) {
  tab = name;
  for (const button of document.querySelectorAll("[role=tab]")) button.setAttribute("aria-selected", button.dataset.tab === name);
  for (const panel of document.querySelectorAll("[role=tabpanel]")) panel.hidden = panel.id !== `tab-${name}`;
  byId("tools").hidden = !boards[name];
  byId("add").hidden = name !== "plots";
  if (boards[name]) boards[name].show(); else hideAll();
  if (name === "records") records.refresh();
  keep();
}

function paint() {
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  document.documentElement.dataset.theme = theme === "auto" ? (dark ? "dark" : "light") : theme;
  write(byId("theme"), { auto: "◐ Auto", light: "○ Light", dark: "● Dark", sun: "☀ Sun" }[theme]);
  rebuild();
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);

function turnPause() { if (axis.follows) pause(); else follow(); }
function turnTheme() { theme = THEMES[(THEMES.indexOf(theme) + 1) % THEMES.length]; paint(); keep(); }
function turnDrag() {
  pans = !pans;
  dragPans(pans);
  byId("tool").setAttribute("aria-pressed", pans);
  write(byId("tool"), pans ? "Drag: pan" : "Drag: zoom");
}
function addPlot() {
  if (boards.plots.plots.length >= MOST) return say(`${MOST} plots are the maximum`);
  choose((name) => boards.plots.add([name]));
}
function record() {
  if (recording) return ask({ do: "stop" });
  const stamp = new Date().toISOString().slice(0, 19).replace("T", " ").replaceAll(":", "-");
  question("Name of the record", `flight ${stamp}`, (name) => ask({ do: "record", name: name.trim() }));
}
function mark() {
  if (!records.opened()) question("Text of the marker", "", (note) => ask({ do: "mark", note: note.trim() || "mark" }));
}
function exportCsv() {
  const names = (boards[tab] ?? boards.plots).lists.flat();
  records.exportRange([...new Set(names)]);
}
function find() { const plot = boards.plots.plots[0]; if (tab !== "plots") show("plots"); if (plot) pick(plot); else addPlot(); }

onMoved(() => {
  write(byId("pause"), axis.follows ? "❚❚ Pause" : "▶ Continue");
  byId("pause").setAttribute("aria-pressed", !axis.follows);
  const listed = [...byId("window").options].some((option) => Number(option.value) === axis.window);
  if (listed) byId("window").value = axis.window;
  keep();
});

byId("pause").onclick = turnPause;
byId("window").onchange = () => { axis.window = Number(byId("window").value); follow(); };
byId("closer").onclick = () => zoom(0.5);
byId("wider").onclick = () => zoom(2);
byId("earlier").onclick = () => shift(-0.25);
byId("later").onclick = () => shift(0.25);
byId("whole").onclick = follow;
byId("tool").onclick = turnDrag;
byId("export").onclick = exportCsv;
byId("add").onclick = addPlot;
byId("record").onclick = record;
byId("mark").onclick = mark;
byId("theme").onclick = turnTheme;
byId("track").onclick = () => { turnExtent(); map(byId("track")); };
byId("colours").onclick = () => { write(byId("colours"), turnColours() ? "Track: by mode" : "Track: by time"); map(byId("track")); };
byId("sound").onclick = turnSound;
for (const button of document.querySelectorAll("[role=tab]")) button.onclick = () => show(button.dataset.tab);

const KEYS = {
  " ": () => { if (records.opened()) records.playOrPause(); else turnPause(); },
  "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2),
  ArrowLeft: () => shift(-0.25), ArrowRight: () => shift(0.25),
  0: follow, a: addPlot, d: turnDrag, e: exportCsv, m: mark, r: record, t: turnTheme, "/": find,
  l: () => { if (records.opened()) records.close(); else follow(); },
  1: () => show("plots"), 2: () => show("hover"), 3: () => show("points"), 4: () => show("records"), 5: () => show("log"),
};
addEventListener("keydown", (event) => {
  const typing = event.target.closest("input, select, textarea, dialog");
  const pressing = event.key === " " && event.target.closest("button");
  if (typing || pressing || event.ctrlKey || event.metaKey || event.altKey) return;
  const act = KEYS[event.key] ?? KEYS[event.key.toLowerCase()];
  if (act) { event.preventDefault(); act(); }
});

let source = null;
let markers = [];
function listMarkers() {
  setMarkers(markers);
  byId("markers").replaceChildren(...(markers.length ? markers : [null]).map((marker) => {
    if (!marker) return element("li", "quiet", "none");
    const button = element("button", "", `⚑ ${time(marker.time_s)} ${marker.note}`);
    button.onclick = () => stay(marker.time_s - 5, marker.time_s + 5);
    return element("li", "", button);
  }));
}

on("hello", () => {
  if (!boards.plots.plots.length) {
    const lists = Array.isArray(kept.plots) && kept.plots.every(Array.isArray) && kept.plots.length ? kept.plots : FIRST;
    boards.plots.set(lists.slice(0, MOST).map((names) => names.filter((name) => typeof name === "string")).filter((names) => names.length));
    boards.hover.set(HOVER);
    boards.points.set(POINTS);
    if (kept.window > 0) axis.window = kept.window;
    byId("window").value = axis.window;
    show(document.getElementById(`tab-${kept.tab}`) ? kept.tab : "plots");
  }
  clear();
  source = null;
  forget();
  watch();
});

on("state", (state) => {
  recording = Boolean(state.recording);
  const name = state.record?.name ?? "";
  if (name !== source) {
    source = name;
    markers = [];
    // Show the whole record first.
    if (state.record && state.what.span) {
      if (tab === "records") show("plots");
      stay(...state.what.span);
    }
    listMarkers();
  }
  if (state.markers.length) { markers = markers.concat(state.markers).slice(-500); listMarkers(); }
});
on("error", say);

let beat = 0;
on("tick", () => {
  beat += 1;
  if (beat % 2 === 0) {
    attitude(byId("attitude"));
    heading(byId("heading"));
    angles(byId("angles"));
    hover();
  }
  if (beat % 6 === 0) {
    map(byId("track"));
    const [from, to] = range();
    write(byId("range"), axis.follows ? "" : `${time(from)} to ${time(to)}, ${(to - from).toFixed(1)} s`);
  }
});

paint();
connect();
// For the tests.
const fixed = () => boards.plots.plots.map((plot) => plot.y !== null);
Object.assign(window, { station: { clock, now, axis, seriesOf, fixed, drawn, tileAt, cornerOf } });
