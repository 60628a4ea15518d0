// The map: track, home and geofence, north up, on a grid with a scale.

import { clock, known, now, scene } from "./station.js";
import { range, seriesOf } from "./plots.js";
import { fresh, radians, style, unknown } from "./canvas.js";
import { tiles } from "./tiles.js";

const METRES = 111_195;
/** Opacity of the tiles. */
const TILES = 0.8;
/** Largest time between two points that are joined, s. */
const GAP = 3;
/** Names and colours of the modes, by `system_mode`: pilot, autopilot, failsafe. */
const MODES = { 3: ["pilot", "--three"], 4: ["autopilot", "--one"], 5: ["failsafe", "--two"] };
let byMode = false;
let whole = false;
/** Whether words have a pale edge, so that they stay readable on a picture. */
let hasHalo = false;
/** The pixels of a latitude and longitude on the map as last drawn. */
export const drawn = { place: null };

/** The value of a series at a time; `null` without one within a second. Times must be in order. */
function follower([times, values]) {
  let k = 0;
  return (t) => {
    while (k + 1 < times.length && Math.abs(times[k + 1] - t) <= Math.abs(times[k] - t)) k += 1;
    return times.length && Math.abs(times[k] - t) < 1 ? values[k] : null;
  };
}

/** The points of the track in the time window of the plots: `[t, latitude, longitude, mode]`; `null` is a gap. */
function flown() {
  const [times, latitudes] = seriesOf("lat_deg");
  const [longitude, mode] = [follower(seriesOf("lon_deg")), follower(seriesOf("system_mode"))];
  const [from, to] = range();
  const points = [];
  times.forEach((t, k) => {
    if (t < from || t > to) return;
    const [x, y] = [longitude(t), latitudes[k]];
    points.push(known(x) && known(y) ? [t, y, x, mode(t)] : null);
  });
  return points;
}

function words(context, text, x, y) {
  if (hasHalo) {
    context.save();
    context.strokeStyle = style("--card");
    context.lineWidth = 4;
    context.lineJoin = "round";
    context.strokeText(text, x, y);
    context.restore();
  }
  context.fillText(text, x, y);
}

function line(context, a, b) {
  context.beginPath();
  context.moveTo(...a);
  context.lineTo(...b);
  context.stroke();
}

export function turnColours() { byMode = !byMode; return byMode; }
export function turnExtent() { whole = !whole; return whole; }

export function map(canvas) {
  const sheet = fresh(canvas);
  const points = flown();
  const real = points.filter(Boolean);
  const here = known(now.get("lat_deg")) && known(now.get("lon_deg")) ? [now.get("lat_deg"), now.get("lon_deg")] : null;
  const { home, geofence } = scene;
  const origin = home ?? here ?? (real.length ? real[0].slice(1, 3) : geofence && [geofence.lat_deg, geofence.lon_deg]);
  if (!origin) return unknown(sheet, "position");
  const { context, width, height } = sheet;
  const narrow = Math.cos(radians(origin[0]));
  const metres = ([latitude, longitude]) => [(longitude - origin[1]) * METRES * narrow, (latitude - origin[0]) * METRES];

  const shown = real.map(([, ...place]) => metres(place)).concat([here, home].filter(Boolean).map(metres));
  if (geofence && (whole || !shown.length)) {
    const [x, y] = metres([geofence.lat_deg, geofence.lon_deg]);
    shown.push([x - geofence.radius_m, y - geofence.radius_m], [x + geofence.radius_m, y + geofence.radius_m]);
  }
  const edge = (axis, best) => shown.reduce((found, point) => best(found, point[axis]), shown[0][axis]);
  const [west, east, south, north] = [edge(0, Math.min), edge(0, Math.max), edge(1, Math.min), edge(1, Math.max)];
  const scale = Math.min((width - 60) / Math.max(east - west, 10), (height - 70) / Math.max(north - south, 10));
  const place = ([x, y]) => [width / 2 + (x - 0.5 * (west + east)) * scale, height / 2 - (y - 0.5 * (south + north)) * scale];

  const inverse = (x, y) => [
    origin[0] + ((height / 2 - y) / scale + 0.5 * (south + north)) / METRES,
    origin[1] + ((x - width / 2) / scale + 0.5 * (west + east)) / METRES / narrow,
  ];
  drawn.place = (position) => place(metres(position));
  context.globalAlpha = TILES;
  const overTiles = tiles(context, inverse(0, 0), inverse(width, height), scale, drawn.place);
  context.globalAlpha = 1;

  const step = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000].find((one) => one * scale > 45) ?? 10_000;
  context.strokeStyle = style(overTiles ? "--line" : "--grid");
  context.lineWidth = 1;
  const [left, bottom] = [0.5 * (west + east) - width / 2 / scale, 0.5 * (south + north) - height / 2 / scale];
  for (let x = Math.ceil(left / step) * step; x < left + width / scale; x += step) line(context, place([x, bottom]), place([x, bottom + height / scale]));
  for (let y = Math.ceil(bottom / step) * step; y < bottom + height / scale; y += step) line(context, place([left, y]), place([left + width / scale, y]));

  hasHalo = overTiles;
  context.font = "12px system-ui, sans-serif";
  if (geofence) {
    context.strokeStyle = context.fillStyle = style("--two");
    context.lineWidth = 2;
    context.setLineDash([9, 5]);
    context.beginPath();
    const [x, y] = place(metres([geofence.lat_deg, geofence.lon_deg]));
    context.arc(x, y, geofence.radius_m * scale, 0, 2 * Math.PI);
    context.stroke();
    context.setLineDash([]);
    context.textAlign = "center";
    const top = y - geofence.radius_m * scale;
    if (top > 4 && top < height && x > 20 && x < width - 20) words(context, "geofence", x, top + 14);
  }
  if (home) mark(context, place(metres(home)));

  const [from, to] = range();
  const pairs = points.slice(1).map((point, k) => [points[k], point]).filter(([a, b]) => a && b && b[0] - a[0] <= GAP)
    .map(([a, b]) => [place(metres(a.slice(1, 3))), place(metres(b.slice(1, 3))), ...b]);
  const seen = new Set();
  context.lineWidth = Number(style("--width")) + 1;
  if (overTiles) {
    // One wide pale line below the track.
    context.lineWidth += 3;
    context.strokeStyle = style("--card");
    context.beginPath();
    for (const [a, b] of pairs) { context.moveTo(...a); context.lineTo(...b); }
    context.stroke();
    context.lineWidth -= 3;
  }
  for (const [a, b, t, , , mode] of pairs) {
    const [name, colour] = (byMode && MODES[mode]) || [byMode ? "other" : null, byMode ? "--soft" : "--one"];
    if (name) seen.add(name);
    context.strokeStyle = style(colour);
    // The older, the fainter.
    context.globalAlpha = byMode ? 1 : 0.2 + 0.8 * Math.min(1, (t - from) / Math.max(to - from, 1));
    line(context, a, b);
  }
  context.globalAlpha = 1;
  if (here) vehicle(context, place(metres(here)), scale);
  frame(context, { width, height, scale, step }, byMode ? [...seen] : null, Math.min(to, clock.t ?? to) - from);
}

function mark(context, [x, y]) {
  context.strokeStyle = context.fillStyle = style("--ink");
  context.lineWidth = 1.5;
  context.beginPath();
  context.arc(x, y, 8, 0, 2 * Math.PI);
  context.stroke();
  context.textAlign = "center";
  context.textBaseline = "middle";
  words(context, "H", x, y + 0.5);
  context.textBaseline = "alphabetic";
}

function vehicle(context, [x, y], scale) {
  const sigma = now.get("sigma_horizontal_m");
  if (known(sigma)) {
    context.strokeStyle = style("--soft");
    context.lineWidth = 1;
    context.setLineDash([3, 3]);
    context.beginPath();
    context.arc(x, y, Math.min(3 * sigma * scale, 2000), 0, 2 * Math.PI);
    context.stroke();
    context.setLineDash([]);
  }
  context.save();
  context.translate(x, y);
  context.rotate(radians(now.get("yaw_deg") ?? 0));
  context.fillStyle = style("--two");
  context.beginPath();
  context.moveTo(0, -11); context.lineTo(7, 8); context.lineTo(0, 4); context.lineTo(-7, 8);
  context.fill();
  context.restore();
}

/** Scale, north, and the meaning of the colours. */
function frame(context, { width, height, scale, step }, modes, seconds) {
  context.strokeStyle = context.fillStyle = style("--ink");
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(10, height - 14); context.lineTo(10, height - 9); context.lineTo(10 + step * scale, height - 9); context.lineTo(10 + step * scale, height - 14);
  context.stroke();
  context.textAlign = "left";
  words(context, step < 1000 ? `${step} m` : `${step / 1000} km`, 14, height - 15);
  context.beginPath();
  context.moveTo(width - 16, 8); context.lineTo(width - 10, 26); context.lineTo(width - 16, 21); context.lineTo(width - 22, 26);
  context.fill();
  context.textAlign = "center";
  words(context, "N", width - 16, 40);
  context.textAlign = "right";
  if (!modes) return words(context, `faint: ${seconds.toFixed(0)} s ago`, width - 8, height - 9);
  let x = width - 8;
  for (const name of modes) {
    context.fillStyle = style(Object.values(MODES).find(([own]) => own === name)?.[1] ?? "--soft");
    words(context, `▬ ${name}`, x, height - 9);
    x -= context.measureText(`▬ ${name}`).width + 10;
  }
}
