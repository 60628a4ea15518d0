// Lamps, alarms, the hover view, the test points and the log.

import { warn } from "./warning.js";
import { ask, channels, element, known, now, on, told, time, write } from "./station.js";

const byId = (name) => document.getElementById(name);
const SIGNS = { good: "✓", care: "!", bad: "✖", unknown: "?" };

function lamp(node, light, name, why) {
  if (!node.firstChild) node.append(element("b", "sign"), element("span"), element("em"));
  const [sign, label, words] = node.children;
  const is = `lamp ${light}`;
  if (node.className !== is) node.className = is;
  write(sign, SIGNS[light]);
  write(label, name);
  if (words) write(words, why);
}

export let flows = true;
/** The vehicle's messages about the flight mode, with their times. */
let reasons = [];

on("state", (state) => {
  const { link, what, recording } = state;
  flows = link.wanted;
  linkLamp(link, what.silence, state.record);
  warn(state.record ? null : what.silence, link.wanted && known(link.age_s));
  const place = byId("lamps");
  while (place.children.length > what.lamps.length) place.lastChild.remove();
  what.lamps.forEach((one, k) => {
    if (!place.children[k]) place.append(element("div"));
    lamp(place.children[k], one.light, one.name, one.why);
  });
  alarms(state);
  readyChip(what.control.engagement);
  write(byId("flies"), what.control.mode ? `${what.control.flies} · ${what.control.mode}` : what.control.flies);
  const chip = byId("recording");
  chip.hidden = !recording;
  if (recording) {
    const trouble = recording.fault ? ` · NOT WRITTEN: ${recording.fault}` : recording.lost ? ` · ${recording.lost} lost` : "";
    write(chip, `● ${recording.name} ${recording.duration_s.toFixed(0)} s${trouble}`);
  }
  byId("record").lastChild.textContent = recording ? " Stop" : " Record";
  byId("record").setAttribute("aria-pressed", Boolean(recording));
  write(byId("flow"), link.wanted ? "$ pause vehicle" : "# start vehicle");
  byId("flow").disabled = link.protocol === "MAVLink 2";
  texts(state.texts);
  control(what, state.record?.at ?? Infinity);
  points(what);
});

/** Whether an engagement is possible, in the bar; nothing for a vehicle that does not report it. */
function readyChip({ light, why }) {
  const chip = byId("can");
  chip.hidden = light === "unknown";
  write(chip, why);
  chip.className = `chip ${light}`;
}

const LOST = "no connection to the station";

/** Without the station, nothing on the page describes the vehicle. */
on("lost", (why) => {
  lamp(byId("link"), "bad", LOST, "");
  for (const node of byId("lamps").children) lamp(node, "unknown", node.children[1].textContent, LOST);
  write(byId("flies"), LOST);
  readyChip({ light: "unknown", why: LOST });
  control({ control: { flies: LOST, mode: null, states: [], refusals: [], engagement: { light: "unknown", why: LOST } }, silence: LOST }, Infinity);
  stepNow(null, LOST);
  warn(LOST, true);
  byId("alarms").dataset.text = "lost";
  byId("alarms").replaceChildren(element("span", "", why ? `The ground station refuses this page: ${why}` : "The ground station does not answer: all values on this page are old"));
});

function linkLamp(link, silence, record) {
  if (record) return lamp(byId("link"), "care", `record ${record.name}${record.is_cut ? " (truncated)" : ""}`, "");
  if (link.name === "no link") return lamp(byId("link"), "unknown", "no vehicle: records only", "");
  const light = silence ? (link.wanted ? "bad" : "care") : link.lost + link.late > 0.02 * link.frames + 5 ? "care" : "good";
  const counts = `${link.lost} lost, ${link.damaged} damaged, ${link.late} late`;
  const words = silence
    ? known(link.age_s) ? silence : `${silence} (${link.port || link.name})`
    : `${link.rate_hz.toFixed(0)} Hz`;
  const detail = silence ? "" : ` · ${(link.bytes_per_s / 1000).toFixed(1)} kB/s · ${counts}`;
  lamp(byId("link"), light, words, detail);
  byId("link").title = `${link.name}, ${link.protocol ?? "protocol unknown"}: ${link.frames} frames, ${counts}, silent ${link.outages} times, last frame ${known(link.age_s) ? link.age_s.toFixed(2) : "–"} s ago`;
}

function alarms({ link, what, record }) {
  const list = [];
  if (!record && link.wanted && what.silence) list.push(what.silence);
  const bad = what.lamps.filter((one) => one.light === "bad");
  for (const one of bad) list.push(`${one.name}: ${one.why}`);
  for (const [name, value] of what.alarms) {
    const channel = channels.get(name);
    const [below, above] = channel.alarm;
    const limit = above !== null && value > above ? `above ${above}` : `below ${below}`;
    list.push(`${`${channel.label} ${told(name, value)} ${channel.unit}`.trim()}, ${limit}`);
  }
  const shown = list.slice(0, 6);
  if (list.length > 6) shown.push(`and ${list.length - 6} more`);
  const place = byId("alarms");
  const text = shown.join("|");
  if (place.dataset.text === text) return;
  place.dataset.text = text;
  place.replaceChildren(...shown.map((one) => element("span", "", one)));
}

function items(node, list, none) {
  const text = list.join("|");
  if (node.dataset.text === text) return;
  node.dataset.text = text;
  node.replaceChildren(...(list.length ? list : [none]).filter(Boolean).map((one) => element("li", "", one)));
}

function control({ control: state, since, span, silence }, at) {
  const mode = `${state.flies}${state.mode ? `, ${state.mode}` : ""}`;
  const seconds = since ? Math.max(0, Math.min(at, span[1]) - since[0]) : 0;
  const least = since && !since[1] ? "≥ " : "";
  write(byId("mode"), since ? `${mode} · ${least}${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}` : mode);
  write(byId("mode-why"), silence ? "" : reasons.findLast((one) => one.time_s <= at)?.text ?? "");
  items(byId("states"), state.states, "");
  write(byId("ready"), state.engagement.why);
  byId("ready").className = `large ${state.engagement.light}`;
  items(byId("refusals"), state.refusals, "");
}

const STICKS = ["lateral", "longitudinal", "collective", "pedal"];

/** Updates sticks and set-points; called with the ticks. */
export function hover() {
  const place = byId("sticks");
  STICKS.forEach((stick, k) => {
    if (!place.children[k]) {
      place.append(element("div", "stick", element("span", "", stick), element("div", "way", element("i"), element("b")), element("span", "numbers")));
    }
    const [pilot, flown] = [now.get(`stick_${stick}_pct`), now.get(`flown_${stick}_pct`)];
    const [, way, text] = place.children[k].children;
    [pilot, flown].forEach((value, which) => {
      const bar = way.children[which];
      bar.hidden = !known(value);
      if (known(value)) bar.style.left = `${50 + Math.max(-50, Math.min(50, value / 2))}%`;
    });
    write(text, `${known(pilot) ? pilot.toFixed(0) : "–"} / ${known(flown) ? flown.toFixed(0) : "–"} %`);
  });
  if (place.children.length === 4) place.append(element("p", "quiet legend", element("i"), "pilot", element("b"), "flown"));
  const rows = [["VelN, m/s", "asked_vel_n_mps", "vel_n_mps"], ["VelE, m/s", "asked_vel_e_mps", "vel_e_mps"], ["VelU, m/s", "asked_vel_u_mps", "vel_u_mps"], ["heading, °", "asked_heading_deg", "yaw_deg"]];
  const body = byId("asked").tBodies[0];
  rows.forEach(([label, asked, flown], k) => {
    if (!body.rows[k]) body.append(element("tr", "", element("th", "", label), element("td"), element("td"), element("td")));
    const [a, b] = [now.get(asked), now.get(flown)];
    const apart = known(a) && known(b) ? (asked.endsWith("deg") ? ((b - a + 540) % 360) - 180 : b - a) : null;
    [told(asked, a), told(flown, b), told(asked, apart)].forEach((text, j) => write(body.rows[k].cells[j + 1], text));
  });
}

function cells(body, rows) {
  const text = JSON.stringify(rows);
  if (body.dataset.text === text) return;
  body.dataset.text = text;
  body.replaceChildren(...rows.map(({ light, row }) => element("tr", light ?? "", ...row.map((cell) => element("td", "", cell)))));
}

/** The step that is flown now. */
function stepNow(flown, silence) {
  const card = byId("now-flown");
  const [bar, size] = [card.querySelector("i"), card.querySelector("em")];
  write(card.querySelector("p"), flown ? `${flown.stick} ${flown.size_pct.toFixed(1)} %, ${flown.held_s.toFixed(1)} s of 1.5 s` : silence ?? "at trim");
  size.style.left = flown ? `${Math.min(100, 5 * Math.abs(flown.size_pct))}%` : "0";
  bar.style.width = flown ? `${Math.min(100, flown.held_s / 1.5 * 100)}%` : "0";
}

function points({ under_way: flown, steps, progress, silence }) {
  stepNow(flown, silence);
  cells(byId("progress").tBodies[0], progress.map((one) => ({
    light: one.verdict === "good" ? "good" : one.verdict.includes("again") ? "bad" : "",
    row: [one.stick, `${one.good} of ${one.wanted}`, `${one.drift_pct.toFixed(1)} %`, known(one.coherence) ? one.coherence.toFixed(2) : "–", one.verdict],
  })));
  cells(byId("steps").tBodies[0], [...steps].reverse().map((one) => ({
    row: [one.stick, time(one.start_s), `${one.size_pct.toFixed(1)} %`, `${one.held_s.toFixed(2)} s`, one.fault ? `no: ${one.fault}` : "yes"],
  })));
}

function texts(lines) {
  const list = byId("texts");
  for (const line of lines) {
    const row = element("li", line.level, `${time(line.time_s)}  ${line.text}`);
    list.prepend(row);
    if (/autopilot|pilot flies|control/.test(line.text)) reasons = [...reasons.slice(-199), line];
  }
  while (list.children.length > 500) list.lastChild.remove();
}

export function clear() {
  byId("texts").replaceChildren();
  reasons = [];
}

byId("flow").onclick = () => ask({ do: "flow", on: !flows });
