// Attitude and heading on canvases, and their numbers.

import { known, now, write } from "./station.js";
import { fresh, radians, style, unknown } from "./canvas.js";

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

export function angles(node) {
  // Fewer decimals than in the plots: one line, and digits that can be read while they change.
  const of = (name, digits = 1) => known(now.get(name)) ? now.get(name).toFixed(digits) : "–";
  const [roll, pitch, yaw] = [of("roll_deg"), of("pitch_deg"), known(now.get("yaw_deg")) ? String((Math.round(now.get("yaw_deg")) + 360) % 360) : "–"];
  // Other vehicles report only their altitude above sea level.
  const height = known(now.get("height_m")) || !known(now.get("altitude_m")) ? `height ${of("height_m")} m` : `altitude ${of("altitude_m")} m`;
  write(node, `roll ${roll}°  pitch ${pitch}°  heading ${yaw}°  ${height}`);
}
