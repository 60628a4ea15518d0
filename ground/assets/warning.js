// A lost link in the title of the page and by sound.

import { write } from "./station.js";

const byId = (name) => document.getElementById(name);
const TITLE = document.title;
/** Interval between two sounds, ms. */
const AGAIN = 5000;
let sounds = true;
try { sounds = localStorage.getItem("sound") !== "off"; } catch { /* The page works without storage. */ }
let context = null;
let sounded = -Infinity;

// A browser plays sound only after the user has touched the page.
for (const kind of ["pointerdown", "keydown"]) {
  addEventListener(kind, () => { context ??= new AudioContext(); context.resume(); }, { once: true });
}

/** Two falling tones. */
function sound() {
  [[880, 0], [440, 0.18]].forEach(([pitch, after]) => {
    const [tone, volume] = [context.createOscillator(), context.createGain()];
    tone.frequency.value = pitch;
    volume.gain.value = 0.2;
    tone.connect(volume).connect(context.destination);
    tone.start(context.currentTime + after);
    tone.stop(context.currentTime + after + 0.15);
  });
}

/** Shows `silence`, the reason why no present values exist, in the title; sounds if it is an alarm. */
export function warn(silence, alarm) {
  const title = silence ? `⚠ ${silence} · ${TITLE}` : TITLE;
  if (document.title !== title) document.title = title;
  document.documentElement.classList.toggle("silent", Boolean(silence));
  if (!silence) sounded = -Infinity;
  if (!silence || !alarm || !sounds || performance.now() - sounded < AGAIN) return;
  sounded = performance.now();
  document.documentElement.dataset.sounds = Number(document.documentElement.dataset.sounds ?? 0) + 1;
  // A browser reports vibration before a touch of the page as an error.
  if (navigator.userActivation?.hasBeenActive) navigator.vibrate?.([200, 100, 200]);
  if (context?.state === "running") sound();
}

function show() {
  write(byId("sound"), sounds ? "♪ Sound" : "♪ Off");
  byId("sound").setAttribute("aria-pressed", sounds);
}

/** Turns the sound on or off, and remembers it. */
export function turnSound() {
  sounds = !sounds;
  try { localStorage.setItem("sound", sounds ? "on" : "off"); } catch { /* The page works without storage. */ }
  show();
}
show();
