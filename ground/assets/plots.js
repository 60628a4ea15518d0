// Linked plots over time, with a common time window, a common cursor, and their data.

import { ask, channels, clock, element, now, on, time, told, write } from "./station.js";

const HEIGHT = 190;
/** Largest number of plots on a board. */
export const MOST = 12;
const SIGMAS = 3;
/** The time axis of all plots. */
export const axis = { window: 60, follows: true, from: 0, to: 0 };
/** Times and values of each watched channel. */
const data = new Map();
/** All boards; one of them is shown. */
const boards = [];
let shown = null;
let pans = false;
let asked = 0;
let answered = 0;
let dirty = true;
let whenMoved = () => {};
let markers = [];

const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export function onMoved(listener) { whenMoved = listener; }
export function setMarkers(list) { markers = list; dirty = true; }
export function dragPans(value) { pans = value; }
export function redraw() { dirty = true; }
export const seriesOf = (name) => data.get(name) ?? [[], []];

/** The channels of the shown plots, plus those of the map's track. */
function wanted() {
  const names = new Set(["lat_deg", "lon_deg", "system_mode"]);
  for (const plot of shown?.plots ?? []) {
    for (const name of plot.names) {
      names.add(name);
      const sigma = channels.get(name)?.sigma;
      if (sigma && plot.names.length === 1) names.add(sigma);
    }
  }
  return [...names].filter((name) => channels.has(name)).slice(0, 48);
}

let watched = "";
export function watch() {
  const names = wanted();
  const key = names.join();
  if (key !== watched) {
    watched = key;
    for (const name of data.keys()) if (!names.includes(name)) data.delete(name);
    ask({ do: "watch", channels: names });
  }
  look();
}
export function forget() { watched = ""; }

/** Requests the data of the shown plots. */
let pending = 0;
export function look() {
  clearTimeout(pending);
  pending = setTimeout(() => {
    const [from, to] = range();
    if (!(to > from)) return;
    const columns = Math.min(2000, Math.max(200, Math.round(shown?.plots[0]?.width() ?? 600)));
    asked += 1;
    ask({ do: "view", id: asked, from, to: axis.follows ? to + 1 : to, columns });
  }, 15);
}

export function range() {
  if (!axis.follows) return [axis.from, axis.to];
  const t = clock.t ?? 0;
  return [t - axis.window, t];
}

on("view", (view) => {
  if (view.id < answered) return;
  answered = view.id;
  for (const [name, points] of Object.entries(view.series)) data.set(name, points);
  dirty = true;
});

on("tick", (tick) => {
  if (tick.turned) return look();
  if (axis.follows) {
    const first = tick.t - 1.3 * axis.window;
    for (const [name, [times, values]] of Object.entries(tick.points)) {
      if (!data.has(name)) continue;
      const own = data.get(name);
      const last = own[0][own[0].length - 1] ?? -Infinity;
      for (let k = 0; k < times.length; k += 1) {
        if (times[k] > last) { own[0].push(times[k]); own[1].push(values[k]); }
      }
      if (own[0][0] < first - 0.3 * axis.window) {
        const cut = own[0].findIndex((t) => t >= first);
        own[0].splice(0, cut);
        own[1].splice(0, cut);
      }
    }
    dirty = true;
  }
});

/** Fixes the time range of the plots, s since the start of 1970. */
export function stay(from, to) {
  const middle = 0.5 * (from + to);
  const span = Math.min(Math.max(to - from, 0.05), 6 * 3600);
  Object.assign(axis, { follows: false, from: middle - span / 2, to: middle + span / 2 });
  dirty = true;
  look();
  whenMoved();
}
export function pause() { const [from, to] = range(); stay(from, to); }
export function follow() {
  axis.follows = true;
  for (const board of boards) for (const plot of board.plots) plot.y = null;
  dirty = true;
  look();
  whenMoved();
}
export function zoom(factor, centre = null) {
  const [from, to] = range();
  if (axis.follows && centre === null) {
    axis.window = Math.min(1200, Math.max(2, axis.window * factor));
    dirty = true;
    look();
    return whenMoved();
  }
  const about = centre ?? 0.5 * (from + to);
  stay(about - (about - from) * factor, about + (to - about) * factor);
}
export function shift(part) {
  const [from, to] = range();
  stay(from + part * (to - from), to + part * (to - from));
}

/** A list of plots in an element. */
export class Board {
  constructor(place, { fixed = false, changed = () => {}, choose = null } = {}) {
    Object.assign(this, { place, fixed, changed, choose, plots: [] });
    boards.push(this);
  }
  set(lists) {
    this.plots.forEach((plot) => plot.remove());
    this.plots = lists.map((names) => new Plot(this, names));
    if (shown === this) watch();
  }
  add(names) {
    this.plots.push(new Plot(this, names));
    this.changed();
    watch();
  }
  drop(plot) {
    plot.remove();
    this.plots = this.plots.filter((other) => other !== plot);
    this.changed();
    watch();
  }
  show() { shown = this; dirty = true; watch(); }
  get lists() { return this.plots.map((plot) => plot.names); }
}

export function hideAll() { shown = null; watch(); }

/** The plots share the pointer, not the box that is dragged: it would change the values of all of them. */
const points = (type) => type === "mousemove" || type === "mouseleave";

class Plot {
  constructor(board, names) {
    Object.assign(this, { board, names, y: null, chart: null, at: null });
    this.title = element("button", "name");
    this.value = element("span", "value");
    this.away = element("button", "small", "✕");
    this.away.title = "Remove this plot";
    this.title.title = "Choose another channel";
    this.place = element("div", "chart");
    const head = element("div", "head", this.title, this.value);
    if (!board.fixed) {
      head.append(this.away);
      this.title.onclick = () => board.choose?.(this);
      this.away.onclick = () => board.drop(this);
    }
    this.node = element("div", "plot", head, this.place);
    board.place.append(this.node);
  }
  choose(names) {
    this.names = names;
    this.y = null;
    this.chart?.destroy();
    this.chart = null;
    this.read();
    this.board.changed();
    watch();
  }
  remove() { this.chart?.destroy(); this.node.remove(); }
  width() { return this.place.clientWidth; }
  rebuild() { this.chart?.destroy(); this.chart = null; }

  build() {
    const [soft, grid] = [style("--soft"), style("--grid")];
    const thick = Number(style("--width"));
    const size = matchMedia("(max-width: 700px)").matches ? 0.8 * HEIGHT : HEIGHT;
    const line = (variable, more = {}) => ({ stroke: style(variable), width: thick, points: { show: false }, ...more });
    const band = this.names.length === 1 && channels.get(this.names[0])?.sigma;
    const series = [{}, ...this.names.map((_, k) => line(["--one", "--two", "--three"][k % 3], k ? { dash: [8, 4] } : {}))];
    if (band) series.push({ stroke: "transparent", points: { show: false } }, { stroke: "transparent", points: { show: false } });
    const plain = { stroke: soft, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, width: 1 }, font: "12px system-ui, sans-serif" };
    this.chart = new uPlot({
      width: Math.max(200, this.width()), height: size,
      padding: [8, 28, 0, 0],
      legend: { show: false },
      scales: { x: { time: true, range: () => range() }, y: { range: (_, low, high) => this.span(low, high) } },
      axes: [
        { ...plain, space: 80, size: 28, values: (_, ticks, axis, space, step) => ticks.map((t) => (step < 1 ? `${time(t)}${(t % 1).toFixed(2).slice(1)}` : time(t))) },
        this.valueAxis({ ...plain, size: 58 }),
      ],
      series,
      bands: band ? [{ series: [2, 3], fill: style("--band") }] : [],
      cursor: { sync: { key: "plots", setSeries: false, filters: { pub: points, sub: points } }, drag: { x: true, y: true, uni: 30, setScale: false }, points: { show: false }, focus: { prox: -1 } },
      hooks: { setSelect: [(u) => this.selected(u)], setCursor: [(u) => this.pointed(u)], draw: [(u) => this.mark(u)] },
    }, this.table(band), this.place);
    this.band = band;
    this.gestures(this.chart.over);
  }
  /** The axis of the values; states have names in place of numbers. */
  valueAxis(plain) {
    const names = channels.get(this.names[0])?.names;
    if (!names?.length) return { ...plain, values: (_, ticks) => ticks.map((tick) => String(Number(tick.toPrecision(8)))) };
    return { ...plain, size: 96, space: 14, incrs: [1, 2, 5], values: (_, ticks) => ticks.map((tick) => names[tick] ?? "") };
  }
  /** The range of the values, with a margin. */
  span(low, high) {
    if (this.y) return this.y;
    if (low === null || high === null) return [-1, 1];
    if (channels.get(this.names[0])?.names?.length) return [low - 0.6, high + 0.6];
    const digits = channels.get(this.names[0])?.digits ?? 2;
    const room = Math.max(0.08 * (high - low), 2 * 10 ** -digits);
    return [low - room, high + room];
  }
  table(band = this.band) {
    const own = this.names.map((name) => data.get(name) ?? [[], []]);
    if (own.length > 1) return uPlot.join(own);
    const [times, values] = own[0];
    if (!band) return [times, values];
    const [at, sigmas] = data.get(band) ?? [[], []];
    const high = new Array(values.length);
    const low = new Array(values.length);
    for (let k = 0, j = 0; k < values.length; k += 1) {
      while (j + 1 < at.length && at[j + 1] <= times[k]) j += 1;
      const sigma = sigmas[j];
      const known = values[k] !== null && sigma !== null && sigma !== undefined && Math.abs((at[j] ?? 0) - times[k]) < 2;
      high[k] = known ? values[k] + SIGMAS * sigma : null;
      low[k] = known ? values[k] - SIGMAS * sigma : null;
    }
    return [times, values, high, low];
  }
  draw() {
    if (!this.width()) return;
    if (!this.chart) this.build();
    const width = this.width();
    if (Math.abs(this.chart.width - width) > 2) this.chart.setSize({ width, height: this.chart.height });
    this.chart.setData(this.table(), true);
  }
  read() {
    const name = this.names[0];
    const channel = channels.get(name);
    if (!channel) return;
    write(this.title, this.names.map((one) => channels.get(one)?.label ?? one).join(" · "));
    const value = this.at ?? now.get(name);
    write(this.value, `${told(name, value)} ${channel.unit}`);
    const latest = now.get(name);
    const [below, above] = channel.alarm;
    const alarms = latest !== null && latest !== undefined && ((below !== null && latest < below) || (above !== null && latest > above));
    this.node.classList.toggle("alarm", alarms);
    this.node.classList.toggle("stale", latest === null || latest === undefined);
  }
  pointed(u) {
    const place = u.cursor.idx;
    this.at = place === null || place === undefined || u.cursor.left < 0 ? null : u.data[1][place] ?? null;
    this.read();
  }
  selected(u) {
    const { left, top, width, height } = u.select;
    if (pans || width + height < 8) return;
    const [from, to] = width > 4 ? [u.posToVal(left, "x"), u.posToVal(left + width, "x")] : range();
    if (height > 0 && height < u.over.clientHeight - 2) this.y = [u.posToVal(top + height, "y"), u.posToVal(top, "y")];
    u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    stay(from, to);
  }
  mark(u) {
    const { ctx, bbox } = u;
    const [from, to] = range();
    ctx.save();
    ctx.strokeStyle = style("--two");
    ctx.fillStyle = style("--two");
    ctx.setLineDash([4, 4]);
    for (const { time_s: t } of markers) {
      if (t < from || t > to) continue;
      const x = Math.round(u.valToPos(t, "x", true));
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      ctx.fillText("⚑", x + 2, bbox.top + 12);
    }
    ctx.restore();
  }
  /** Wheel, pan and pinch gestures. */
  gestures(over) {
    const touches = new Map();
    let last = null;
    let pulled = false;
    over.addEventListener("wheel", (event) => {
      event.preventDefault();
      if (event.shiftKey) return shift(Math.sign(event.deltaY || event.deltaX) * 0.1);
      zoom(event.deltaY < 0 ? 0.8 : 1.25, this.chart.posToVal(event.offsetX, "x"));
    }, { passive: false });
    over.addEventListener("dblclick", () => { this.y = null; follow(); });
    over.addEventListener("mousedown", (event) => {
      if (pans || event.shiftKey || event.button === 1) {
        event.stopImmediatePropagation();
        event.preventDefault();
      }
    }, { capture: true });
    const drags = (event) => event.pointerType === "touch" || pans || event.shiftKey || event.button === 1;
    over.addEventListener("pointerdown", (event) => {
      if (!drags(event)) return;
      touches.set(event.pointerId, event.clientX);
      over.setPointerCapture(event.pointerId);
      last = measure();
      pulled = false;
    });
    const measure = () => {
      const all = [...touches.values()];
      return { middle: all.reduce((sum, x) => sum + x, 0) / all.length, apart: all.length > 1 ? Math.abs(all[0] - all[1]) : 0 };
    };
    over.addEventListener("pointermove", (event) => {
      if (!touches.has(event.pointerId)) return;
      touches.set(event.pointerId, event.clientX);
      const measured = measure();
      // A vertical swipe scrolls the page.
      pulled ||= touches.size > 1 || Math.abs(measured.middle - last.middle) > 8;
      if (!pulled) return;
      const [from, to] = range();
      const perPixel = (to - from) / over.clientWidth;
      const move = (last.middle - measured.middle) * perPixel;
      const factor = last.apart > 10 && measured.apart > 10 ? last.apart / measured.apart : 1;
      if (Math.abs(measured.middle - last.middle) < 2 && factor === 1) return;
      const about = from + (measured.middle - over.getBoundingClientRect().left) * perPixel;
      stay(about - (about - from) * factor + move, about + (to - about) * factor + move);
      last = measured;
    });
    for (const what of ["pointerup", "pointercancel"]) {
      over.addEventListener(what, (event) => { touches.delete(event.pointerId); if (touches.size) last = measure(); });
    }
  }
}

export function rebuild() {
  for (const board of boards) board.plots.forEach((plot) => plot.rebuild());
  dirty = true;
}
addEventListener("resize", () => { dirty = true; });

/** Times of the frames drawn in the last second; the tests read their number. */
const drawn = [];
function draw(at) {
  if (shown && (dirty || axis.follows && clock.t !== null && performance.now() - clock.received < 200)) {
    const changed = dirty;
    dirty = false;
    if (changed) {
      shown.plots.forEach((plot) => { plot.draw(); plot.read(); });
      drawn.push(at);
      while (drawn.length && at - drawn[0] > 1000) drawn.shift();
      document.documentElement.dataset.frames = drawn.length;
      document.documentElement.dataset.delayMs = Math.round(1000 * clock.delay);
    }
  }
  requestAnimationFrame(draw);
}
requestAnimationFrame(draw);
