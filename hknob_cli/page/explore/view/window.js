// Pictures: what is seen of both knobs in the window that ends now, and in which range.
let colours = {};
const recolour = () => {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["paper", "ink", "soft", "line", "one", "other", "wall", "edge", "count"]) colours[name] = style.getPropertyValue(`--${name}`).trim();
};
const sizes = new Map();
const canvas = (id) => {
  let known = sizes.get(id);
  if (!known) {
    const node = $(id), scale = Math.min(devicePixelRatio || 1, 2);
    known = { node, context: node.getContext("2d"), width: node.clientWidth, height: node.clientHeight, scale };
    node.width = Math.max(1, Math.round(known.width * scale));
    node.height = Math.max(1, Math.round(known.height * scale));
    sizes.set(id, known);
  }
  const { context, scale, width, height } = known;
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "11px system-ui, sans-serif";
  context.lineJoin = "round";
  return known;
};
const POINTS = 320;
const trace = { one: null, other: null };
// Angle, speed and torque over the window that ends now.
const sample = (name) => {
  const result = results[name];
  const kept = (trace[name] ||= { t: new Float64Array(POINTS), angle: new Float64Array(POINTS), speed: new Float64Array(POINTS), torque: new Float64Array(POINTS) });
  const end = timeOf(name), wide = windowOf(), first = Math.max(0, end - wide);
  kept.first = end - wide;
  kept.end = end;
  for (let i = 0; i < POINTS; i += 1) {
    const t = first + ((end - first) * i) / (POINTS - 1), now = Knob.at(result, t / result.cell.period);
    kept.t[i] = t;
    kept.angle[i] = now.angle;
    kept.speed[i] = now.speed;
    kept.torque[i] = now.torque;
  }
  return kept;
};
// What the encoder shows from sample to sample in the window, rad; null where samples are too many to be drawn.
const readings = (name) => {
  const kept = trace[name], { cell, scene: of } = results[name];
  const begin = Math.max(0, Math.floor(kept.first / cell.period)), finish = Math.floor(kept.end / cell.period), found = [];
  if (finish - begin > 400) return null;
  for (let i = begin; i <= finish; i += 1) {
    const x = Knob.at(results[name], i + 1e-9).angle / cell.quantum - cell.shift;
    found.push(((cell.truncate && x > 0 ? Math.floor(x) : cell.sense * Math.floor(cell.sense * x)) + (of.offset || 0)) * cell.quantum);
  }
  return { begin, shows: found };
};
// One range for both knobs, so that they compare; it follows what is seen, smoothly.
let ranges = {};
const rangeOf = (what, least) => {
  let low = Infinity, high = -Infinity;
  for (const name of ["one", "other"]) {
    if (!results[name].cell) continue;
    for (const value of trace[name][what] || []) { if (value < low) low = value; if (value > high) high = value; }
  }
  const middle = 0.5 * (low + high), half = Math.max(0.62 * (high - low), least);
  const wanted = [middle - half, middle + half], now = ranges[what];
  if (!now) return (ranges[what] = wanted);
  const part = clock.playing ? 0.12 : 1;
  return (ranges[what] = [now[0] + part * (wanted[0] - now[0]), now[1] + part * (wanted[1] - now[1])]);
};
