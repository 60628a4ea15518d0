// The connection to the station: requests out, ticks, views and states in.

/** The token in the page's address. A token that is added while the page is open is used from the next attempt on. */
let token = sessionStorage.getItem("token") ?? "";
function takeToken() {
  token = new URLSearchParams(location.hash.slice(1)).get("token") ?? token;
  if (token) sessionStorage.setItem("token", token);
}
takeToken();
addEventListener("hashchange", takeToken);

/** The address of a resource of the station, with the token. */
export function address(path, fields = {}) {
  const query = new URLSearchParams(fields);
  if (token) query.set("token", token);
  const text = query.toString();
  return text ? `${path}?${text}` : path;
}

/** Listeners by message type: `on("tick", …)`. */
const listeners = new Map();
export function on(what, listener) {
  if (!listeners.has(what)) listeners.set(what, []);
  listeners.get(what).push(listener);
}
function tell(what, value) {
  for (const listener of listeners.get(what) ?? []) listener(value);
}

/** The description and the newest value of each channel. */
export const channels = new Map();
export const now = new Map();
export const clock = { t: null, received: 0, delay: 0 };
/** Home, geofence and zoom levels of the tiles, for the map. */
export const scene = { home: null, geofence: null, zooms: [] };
/** Time without a message after which the connection is lost, ms; the station sends every 40 ms. */
const SILENT = 2000;
let order = [];
let socket = null;
let wait = 250;
let refused = null;
let heard = 0;

export function ask(request) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(request));
}

/** The station's reason for a refusal. A browser does not report why a socket was refused. */
async function refusal() {
  try {
    const answer = await fetch(address("/socket"));
    return [403, 503].includes(answer.status) ? await answer.text() : null;
  } catch { return null; }
}

export function connect() {
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  socket = new WebSocket(`${scheme}://${location.host}${address("/socket")}`);
  heard = performance.now();
  socket.onopen = () => { wait = 250; refused = null; };
  socket.onmessage = ({ data }) => {
    heard = performance.now();
    const message = JSON.parse(data);
    if (message.tick) {
      clock.t = message.tick.t;
      clock.received = performance.now();
      clock.delay = message.tick.newest === null ? 0 : Date.now() / 1000 - message.tick.newest;
      message.tick.now.forEach((value, place) => now.set(order[place], value));
      tell("tick", message.tick);
    } else if (message.hello) {
      order = message.hello.channels.map((channel) => channel.name);
      for (const channel of message.hello.channels) channels.set(channel.name, channel);
      scene.geofence = message.hello.geofence;
      scene.zooms = message.hello.zooms;
      tell("hello", message.hello);
    } else {
      if (message.state) scene.home = message.state.what.home;
      for (const what of ["state", "view", "records", "recorded", "error"]) {
        if (message[what] !== undefined) tell(what, message[what]);
      }
    }
  };
  socket.onclose = () => {
    lose();
    refusal().then((why) => {
      if (why === refused) return;
      refused = why;
      if (socket.readyState !== WebSocket.OPEN) tell("lost", refused);
    });
    setTimeout(connect, wait);
    wait = Math.min(2 * wait, 4000);
  };
}

/** Forgets the present values: they are the past from now on. */
function lose() {
  clock.t = null;
  now.clear();
  tell("lost", refused);
}

/** A connection that is open but silent is lost too. */
setInterval(() => {
  if (socket?.readyState === WebSocket.OPEN && performance.now() - heard > SILENT) lose();
}, 500);

export const known = (value) => value !== null && value !== undefined;

/** A value with its significant decimals, or its name. */
export function told(name, value) {
  if (!known(value) || Number.isNaN(value)) return "–";
  const names = channels.get(name)?.names;
  if (names?.length) return names[value] ?? String(value);
  return value.toFixed(channels.get(name)?.digits ?? 2);
}

export const time = (t) => new Date(1000 * t).toLocaleTimeString([], { hour12: false });

/** Sets the text of a node if it differs; setting the same text would cause a new layout. */
export function write(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** An element with a class and children. */
export function element(kind, className = "", ...children) {
  const node = document.createElement(kind);
  if (className) node.className = className;
  node.append(...children);
  return node;
}
