// The page: sliders, the answer in words, the moving pictures, the sound. The motion is the engine's. The files of this
// folder are one program.

const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);
const still = matchMedia("(prefers-reduced-motion: reduce)"), dark = matchMedia("(prefers-color-scheme: dark)");
const MOST = 262144; // samples that a trial is followed
const AT_ONCE = 32768; // of them while a slider moves; the rest a moment later
const HEAVY = 2e6; // pieces times harmonics of a touch level that waits for that moment, too
const MOMENT_MS = 300;

// Numbers in words.
const short = (value, digits = 4) => {
  if (value === 0) return "0";
  const text = Number(value.toPrecision(digits));
  return (Math.abs(text) >= 1e5 || Math.abs(text) < 1e-3 ? text.toExponential() : String(text)).replace("-", "−");
};
const element = (name, attributes = {}, ...children) => {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in made && key !== "list") made[key] = value; else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
};
