// The cycle that a trial is on. A trial that repeats its readings is compared with the periodic motion of these readings,
// which is solved for. What the trial still is away from it can only shrink. Once that is less than the distance to the
// nearest count edge, the trial reads the same for ever, and the cycle is the one it reaches.

// The periodic motion of the readings that a trial has had over its last period.
// Run once through a period under given torques; leaves X, V.
const through = (x, v, torques, cell) => {
  X = x; V = v;
  for (let i = 0; i < torques.length; i += 2) {
    if (cell.split > 0) move(X, V, torques[i], true, cell);
    move(X, V, torques[i + 1], false, cell);
  }
};
// The fixed point (x, v) of a period under these torques, from a state near it; null if none is found.
const fixedPoint = (x, v, torques, cell) => {
  const loose = cell.beta === 0; // a cycle moved by any angle is one, too: only the speed is solved for
  const h = cell.friction > 0 ? 1e-6 : 1;
  let best = Infinity, found = null;
  for (let again = 0; again < 16; again += 1) {
    through(x, v, torques, cell);
    const rx = X - x, rv = V - v, size = Math.abs(rx) + Math.abs(rv);
    if (!(size < best)) break;
    best = size;
    found = { x, v, residual: size };
    if (size === 0) break;
    const px = X, pv = V;
    through(x, v + h, torques, cell);
    const bx = (X - px) / h, bv = (V - pv) / h;
    if (loose) {
      if (bv === 1) break;
      v += rv / (1 - bv);
      continue;
    }
    through(x + h, v, torques, cell);
    const ax = (X - px) / h, av = (V - pv) / h;
    const det = (1 - ax) * (1 - bv) - bx * av;
    if (!(Math.abs(det) > 1e-300)) break;
    x += ((1 - bv) * rx + bx * rv) / det;
    v += (av * rx + (1 - ax) * rv) / det;
  }
  return found;
};

const CLOSED = 1e-11; // counts, relative: by which a period must come back
// The cycle that a trial is on, if it has read the same over `period` samples as over those before; else null.
const cycleOf = (trial, period, cell) => {
  const walk = copy(trial), readings = new Array(period), torques = new Array(2 * period);
  for (let i = 0; i < period; i += 1) {
    readings[i] = read(walk.x, cell);
    decide(readings[i], walk, cell);
    push(walk, cell);
  }
  // What is remembered: fading means at their fixed point, and the rest as the readings leave it.
  const memory = copy(trial), law = cell.law, fades = law && law.fades;
  let behind = 0;
  if (fades) {
    const left = trial.past[fades.row];
    memory.past[fades.row] = left + (walk.past[fades.row] - left) / -Math.expm1(period * Math.log(fades.fade));
    behind = (cell.kappa * fades.weight * Math.abs(memory.past[fades.row] - left)) / (1 - fades.fade);
  }
  for (let done = 0; done <= cell.line + (law ? law.rows : 0); done += period) {
    for (let i = 0; i < period; i += 1) decide(readings[i], memory, cell);
  }
  const orbit = copy(memory), other = (j) => !fades || j !== fades.row;
  if ((cell.damping > 0 && trial.before !== orbit.before)
    || trial.past.some((one, j) => other(j) && Math.abs(one - orbit.past[j]) > 1e-9)) return null;
  for (let i = 0; i < period; i += 1) {
    decide(readings[i], memory, cell);
    torques[2 * i] = OLDER;
    torques[2 * i + 1] = NEWER;
  }
  const point = fixedPoint(trial.x, trial.v, torques, cell);
  if (!point || !(point.residual <= CLOSED * (1 + Math.abs(point.x)))) return null;
  orbit.x = point.x;
  orbit.v = point.v;
  const run = copy(orbit);
  let margin = Infinity;
  for (let i = 0; i < period; i += 1) {
    const shown = read(run.x, cell);
    if (shown !== readings[i]) return null;
    margin = Math.min(margin, edgeGap(run.x, shown, cell));
    decide(shown, run, cell);
    push(run, cell);
  }
  let reach = distance(trial.x - orbit.x, trial.v - orbit.v, cell);
  reach += behind > 0 ? (cell.beta > 0 ? behind / Math.sqrt(cell.beta) : behind / cell.alpha) : 0;
  if (behind > 1e-9 && (cell.step > 0 || cell.band > 0)) return null;
  // The line of torques under way is its own after as many samples; until then the trial must be on it.
  for (let j = 0; j < cell.line; j += 1) {
    const at = (one) => one.ring[(one.head + j) % cell.line];
    if (Math.abs(at(trial) - at(orbit)) > behind + 1e-9 * (1 + Math.abs(at(orbit)))) return null;
  }
  if (cell.beta === 0 && cell.friction > 0) reach = Math.abs(trial.x - orbit.x) + Math.abs(trial.v - orbit.v);
  const still = torques.every((u) => u === torques[0]);
  return reach < margin ? { orbit, period, margin, closure: point.residual, still } : null;
};
