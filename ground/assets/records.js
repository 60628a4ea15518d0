// Records: list, open, play, export, evaluate.

import { address, ask, element, on, time, write } from "./station.js";
import { follow, range } from "./plots.js";
import { say } from "./chooser.js";
import { clear } from "./panels.js";

const byId = (name) => document.getElementById(name);
let record = null;
let span = null;
let seeking = false;
let job = "";

export const opened = () => record;

export function refresh() { ask({ do: "list" }); }

export function open(name) {
  clear();
  ask({ do: "open", name });
  follow();
}

export function close() {
  clear();
  ask({ do: "live" });
  follow();
}

export function playOrPause() {
  if (record.plays) return ask({ do: "pause" });
  ask({ do: "play", speed: Number(byId("speed").value) });
  follow();
}

export function exportRange(names) {
  const [from, to] = range();
  const fields = { from, to, channels: names.join(",") };
  if (record) fields.record = record.name;
  const link = element("a");
  link.href = address("/export.csv", fields);
  link.download = `${record?.name ?? "live"}.csv`;
  link.click();
}

on("records", (records) => {
  byId("list").tBodies[0].replaceChildren(...records.map((one) => {
    const look = element("button", "first", "Open");
    look.onclick = () => open(one.name);
    const evaluate = element("button", "", "Estimate and identify");
    evaluate.onclick = () => { ask({ do: "evaluate", name: one.name }); say(`Running estimate and identify on ${one.name}`); };
    const size = one.bytes > 2e6 ? `${(one.bytes / 1e6).toFixed(1)} MB` : `${(one.bytes / 1e3).toFixed(0)} kB`;
    return element("tr", "", element("td", "", one.name), element("td", "", new Date(1000 * one.modified_s).toLocaleString()), element("td", "", size), element("td", "tools", look, evaluate));
  }));
  if (!records.length) byId("list").tBodies[0].append(element("tr", "", element("td", "quiet", "no records yet")));
});

on("recorded", (one) => { say(`Recorded ${one.name}: ${one.frames} entries, ${one.duration_s.toFixed(0)} s`); refresh(); });

on("state", (state) => {
  record = state.record;
  span = state.what.span;
  byId("player").hidden = !record;
  byId("mark").disabled = Boolean(record);
  // A record has one control for play and pause: that of the player.
  byId("pause").hidden = Boolean(record);
  if (record && span) {
    write(byId("play"), record.plays ? "❚❚ Pause" : "▶ Play");
    const seconds = record.at - span[0];
    write(byId("moment"), `${time(record.at)} · ${seconds.toFixed(1)} of ${(span[1] - span[0]).toFixed(1)} s`);
    if (!seeking) byId("seek").value = span[1] > span[0] ? 1000 * seconds / (span[1] - span[0]) : 1000;
  }
  evaluation(state.job);
});

function evaluation(now) {
  const text = JSON.stringify(now);
  if (text === job) return;
  job = text;
  const card = byId("job");
  card.hidden = !now;
  if (!now) return;
  card.replaceChildren(element("h2", "", `Evaluation of ${now.record}`), element("p", "large", now.words));
  for (const [title, path] of now.pages) {
    const link = element("a", "", `${title}: report`);
    link.href = address(`/results/${path.split("/").map(encodeURIComponent).join("/")}`);
    link.target = "_blank";
    link.rel = "noopener";
    card.append(element("p", "", link));
  }
  for (const fault of now.faults) card.append(element("p", "bad", fault));
}

byId("refresh").onclick = refresh;
byId("play").onclick = playOrPause;
byId("live").onclick = close;
byId("speed").onchange = () => { if (record?.plays) ask({ do: "play", speed: Number(byId("speed").value) }); };
byId("seek").oninput = () => {
  seeking = true;
  if (span) ask({ do: "seek", to: span[0] + byId("seek").value / 1000 * (span[1] - span[0]) });
};
byId("seek").onchange = () => { seeking = false; };
