// Channel search, input of one line of text, and short messages.

import { channels, element, now, told } from "./station.js";

const chooser = document.getElementById("chooser");
const search = document.getElementById("search");
const found = document.getElementById("found");
let chosen = null;
let place = 0;

function matches() {
  const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
  return [...channels.values()].filter((channel) => {
    const text = `${channel.name} ${channel.label} ${channel.unit} ${channel.group}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

function list() {
  const all = matches();
  place = Math.min(Math.max(place, 0), Math.max(all.length - 1, 0));
  found.replaceChildren(...all.map((channel, k) => {
    const name = element("span", "", channel.label);
    const row = element("li", "", name, element("small", "", `${channel.group} · ${told(channel.name, now.get(channel.name))} ${channel.unit}`));
    row.setAttribute("role", "option");
    row.setAttribute("aria-selected", k === place);
    row.dataset.name = channel.name;
    row.onclick = () => finish(channel.name);
    return row;
  }));
  found.children[place]?.scrollIntoView({ block: "nearest" });
}

function finish(name) {
  chooser.close();
  if (name) chosen?.(name);
}

search.oninput = () => { place = 0; list(); };
search.onkeydown = (event) => {
  if (event.key === "ArrowDown" || event.key === "ArrowUp") {
    event.preventDefault();
    place += event.key === "ArrowDown" ? 1 : -1;
    list();
  } else if (event.key === "Enter") {
    event.preventDefault();
    finish(matches()[place]?.name);
  }
};

/** Opens the channel search; calls `done` with the name of the chosen channel. */
export function choose(done) {
  chosen = done;
  search.value = "";
  place = 0;
  list();
  chooser.showModal();
  search.focus();
}

const asker = document.getElementById("asker");
const reply = document.getElementById("reply");

/** Asks for a line of text and calls `done` with it. */
export function question(text, given, done) {
  document.getElementById("question").textContent = text;
  reply.value = given;
  asker.onclose = () => { if (asker.returnValue === "ok") done(reply.value); };
  asker.returnValue = "cancel";
  asker.showModal();
  reply.select();
}

const toast = document.getElementById("toast");
let fading = 0;

/** Shows a message for 6 s. */
export function say(text) {
  toast.textContent = text;
  toast.hidden = false;
  clearTimeout(fading);
  fading = setTimeout(() => { toast.hidden = true; }, 6000);
}
