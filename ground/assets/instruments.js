// Attitude, heading and track on canvases.

import { now, told, write } from "./station.js";
import { range, seriesOf } from "./plots.js";

const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const radians = (degrees) => degrees * Math.PI / 180;

/** The context of a canvas, cleared, with its size in CSS pixels. */
function fresh(canvas) {
  const ratio = devicePixelRatio || 1;
  canvas.dataset.width ??= canvas.width;
  canvas.dataset.height ??= canvas.height;
  const [width, height] = [Number(canvas.dataset.width), Number(canvas.dataset.height)];
  if (canvas.width !== Math.round(width * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    canvas.style.width = `${width}px`;
    canvas.style.aspectRatio = `${width} / ${height}`;
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

function unknown({ context, width, height }, what) {
  context.fillStyle = style("--soft");
  context.textAlign = "center";
  context.font = "14px system-ui, sans-serif";
  context.fillText(`no ${what}`, width / 2, height / 2);
}

const known = (value) => value !== null && value !== undefined;

export function attitude(canvas) {
  const sheet = fresh(canvas);
  const [roll, pitch] = [now.get("roll_deg"), now.get("pitch_deg")];
  if (!known(roll) || !known(pitch)) return unknown(sheet, "attitude");
  const { context, width, height } = sheet;
  const [x, y, radius] = [width / 2, height / 2, width / 2 - 6];
  const perDegree = radius / 35;
  context.save();
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.clip();
  context.translate(x, y);
  context.rotate(-radians(roll));
  context.translate(0, pitch * perDegree);
  context.fillStyle = style("--sky");
  context.fillRect(-300, -600, 600, 600);
  context.fillStyle = style("--soil");
  context.fillRect(-300, 0, 600, 600);
  context.strokeStyle = context.fillStyle = style("--ink");
  context.lineWidth = 1.5;
  context.font = "10px system-ui, sans-serif";
  context.textAlign = "left";
  context.textBaseline = "middle";
  for (let degrees = -90; degrees <= 90; degrees += 5) {
    const half = degrees === 0 ? 300 : degrees % 10 === 0 ? 24 : 12;
    context.beginPath();
    context.moveTo(-half, -degrees * perDegree);
    context.lineTo(half, -degrees * perDegree);
    context.stroke();
    if (degrees !== 0 && degrees % 10 === 0) context.fillText(Math.abs(degrees), half + 3, -degrees * perDegree);
  }
  context.restore();
  context.strokeStyle = style("--two");
  context.lineWidth = 4;
  context.beginPath();
  context.moveTo(x - 46, y); context.lineTo(x - 16, y); context.lineTo(x, y + 12); context.lineTo(x + 16, y); context.lineTo(x + 46, y);
  context.stroke();
}

export function heading(canvas) {
  const sheet = fresh(canvas);
  const yaw = now.get("yaw_deg");
  if (!known(yaw)) return unknown(sheet, "heading");
  const { context, width, height } = sheet;
  const [x, y, radius] = [width / 2, height / 2, width / 2 - 6];
  context.save();
  context.translate(x, y);
  context.strokeStyle = context.fillStyle = style("--ink");
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (let degrees = 0; degrees < 360; degrees += 10) {
    context.save();
    context.rotate(radians(degrees - yaw));
    context.lineWidth = degrees % 30 === 0 ? 2 : 1;
    context.beginPath();
    context.moveTo(0, -radius);
    context.lineTo(0, -radius + (degrees % 30 === 0 ? 12 : 7));
    context.stroke();
    if (degrees % 30 === 0) {
      context.font = degrees % 90 === 0 ? "bold 15px system-ui, sans-serif" : "11px system-ui, sans-serif";
      context.fillText({ 0: "N", 90: "E", 180: "S", 270: "W" }[degrees] ?? degrees / 10, 0, -radius + 22);
    }
    context.restore();
  }
  const arrow = (degrees, colour, length, dash) => {
    context.save();
    context.rotate(radians(degrees));
    context.strokeStyle = style(colour);
    context.lineWidth = 4;
    context.setLineDash(dash);
    context.beginPath();
    context.moveTo(0, length); context.lineTo(0, -length); context.moveTo(-8, -length + 12); context.lineTo(0, -length); context.lineTo(8, -length + 12);
    context.stroke();
    context.restore();
  };
  const asked = now.get("asked_heading_deg");
  if (known(asked)) arrow(asked - yaw, "--one", 50, []);
  arrow(0, "--two", 30, []);
  context.restore();
}

const METRES = 111_195;

/** The values of a series at the times of another. Both are thinned independently, so their times differ. */
function paired(times, [own, values]) {
  let k = 0;
  return times.map((t) => {
    while (k + 1 < own.length && Math.abs(own[k + 1] - t) <= Math.abs(own[k] - t)) k += 1;
    return own.length && Math.abs(own[k] - t) < 1 ? values[k] : null;
  });
}

/** The horizontal track in the time window of the plots, north up, on a grid. */
export function track(canvas) {
  const sheet = fresh(canvas);
  const [times, latitudes] = seriesOf("lat_deg");
  const longitudes = paired(times, seriesOf("lon_deg"));
  const [from, to] = range();
  const points = [];
  const first = latitudes.findIndex((value, k) => known(value) && known(longitudes[k]));
  if (first < 0) return unknown(sheet, "position");
  const origin = [latitudes[first], longitudes[first]];
  const narrow = Math.cos(radians(origin[0]));
  const metres = (latitude, longitude) => [(longitude - origin[1]) * METRES * narrow, (latitude - origin[0]) * METRES];
  for (let k = 0; k < times.length; k += 1) {
    if (times[k] >= from && times[k] <= to && known(latitudes[k]) && known(longitudes[k])) points.push(metres(latitudes[k], longitudes[k]));
    else if (points.length && points[points.length - 1]) points.push(null);
  }
  const here = known(now.get("lat_deg")) && known(now.get("lon_deg")) ? metres(now.get("lat_deg"), now.get("lon_deg")) : null;
  const real = points.filter(Boolean).concat(here ? [here] : []);
  if (!real.length) return unknown(sheet, "position");
  const { context, width, height } = sheet;
  const edge = (axis, best) => best(...real.map((point) => point[axis]));
  const [west, east, south, north] = [edge(0, Math.min), edge(0, Math.max), edge(1, Math.min), edge(1, Math.max)];
  const scale = Math.min((width - 40) / Math.max(east - west, 4), (height - 40) / Math.max(north - south, 4));
  const place = ([x, y]) => [width / 2 + (x - 0.5 * (west + east)) * scale, height / 2 - (y - 0.5 * (south + north)) * scale];
  const step = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 5000].find((one) => one * scale > 45) ?? 20_000;
  context.strokeStyle = style("--grid");
  context.lineWidth = 1;
  const [left, bottom] = [0.5 * (west + east) - width / 2 / scale, 0.5 * (south + north) - height / 2 / scale];
  for (let x = Math.ceil(left / step) * step; x < left + width / scale; x += step) stroke(context, [place([x, bottom]), place([x, bottom + height / scale])]);
  for (let y = Math.ceil(bottom / step) * step; y < bottom + height / scale; y += step) stroke(context, [place([left, y]), place([left + width / scale, y])]);
  context.strokeStyle = style("--one");
  context.lineWidth = Number(style("--width")) + 0.5;
  stroke(context, points.map((point) => point && place(point)));
  context.fillStyle = style("--ink");
  context.font = "12px system-ui, sans-serif";
  context.textAlign = "left";
  context.fillText(`grid ${step} m · N ↑`, 8, height - 8);
  if (!here) return;
  const [x, y] = place(here);
  const sigma = now.get("sigma_horizontal_m");
  if (known(sigma)) {
    context.strokeStyle = style("--soft");
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

function stroke(context, points) {
  context.beginPath();
  let draws = false;
  for (const point of points) {
    if (point) { if (draws) context.lineTo(...point); else context.moveTo(...point); }
    draws = Boolean(point);
  }
  context.stroke();
}

export function angles(node) {
  const of = (name) => told(name, now.get(name));
  const [roll, pitch, yaw] = ["roll_deg", "pitch_deg", "yaw_deg"].map(of);
  // Other vehicles report only their altitude above sea level.
  const height = known(now.get("height_m")) || !known(now.get("altitude_m")) ? `height ${of("height_m")} m` : `altitude ${of("altitude_m")} m`;
  write(node, `roll ${roll}°  pitch ${pitch}°  heading ${yaw}°  ${height}`);
}
