// One trial of a scene, to the cycle or the rest that it reaches.
// Outcome: cycle, rest, diverged or undecided. `samples`: until it was there. `lead`: the way there, piece by piece,
// as far as it is kept.
const CLOSE = 1e-3; // counts, within which a state may have come back
const KEPT = 6000; // samples of the way there that are kept
const solve = (scene, options = {}) => {
  const cell = reduce(scene), start = scene.start;
  const trial = begin(cell, start), first = copy(trial);
  const fade = cell.law && cell.law.fades ? -Math.log(cell.law.fades.fade) : Infinity;
  const plant = slowestRate(cell.alpha, cell.beta), rate = Math.min(plant, fade);
  const damped = cell.alpha > 0 || cell.friction > 0;
  const most = options.samples || (damped ? Math.min(Math.max(rate > 0 ? 600 / rate : Infinity, 65536), 2 ** 20) : 65536);
  const spring = cell.kappa + cell.beta;
  const coast = Math.abs(trial.v) * Math.min(1000, cell.beta > 0 ? 1 / Math.sqrt(cell.beta) : Infinity);
  const far = 1e6 * Math.max(1, Math.abs(trial.x), spring > 0 ? cell.push / spring : 0, coast);
  let check = copy(trial), since = 0, window = 1, close = CLOSE, found = null, samples = 0, outcome = "undecided";
  const settled = Math.min(rate > 0 ? 3 / rate : 0, most / 8);
  while (samples < most) {
    decide(read(trial.x, cell), trial, cell);
    push(trial, cell);
    samples += 1;
    since += 1;
    if (!(trial.x > -far && trial.x < far)) { outcome = "diverged"; break; }
    const gap = Math.abs(trial.x - check.x) + Math.abs(trial.v - check.v);
    if (gap < close && read(trial.x, cell) === read(check.x, cell)) {
      found = cycleOf(trial, since, cell);
      if (found) break;
      close = gap / 4; // what comes back no closer than that is tried no more
    }
    if (since === window) {
      check = copy(trial);
      close = Math.min(CLOSE, Math.max(4 * close, 1e-9));
      if (samples > settled) window = Math.min(window * 2, 65536);
      since = 0;
    }
  }
  const result = { cell, scene, samples, period: 0, pieces: [], outcome, p2p: 0, frequency: 0, cycles: 0 };
  if (found) {
    Object.assign(result, measure(found, cell), { period: found.period, margin: found.margin, closure: found.closure });
    result.orbit = found.orbit;
  }
  if (options.motion !== false) {
    // Whole periods more, until nothing is seen of what the trial still is away from its cycle.
    let last = samples;
    const apart = () => Math.abs(trial.x - found.orbit.x) + Math.abs(trial.v - found.orbit.v);
    while (found && last + found.period <= KEPT && apart() > 1e-10) {
      for (let i = 0; i < found.period; i += 1) {
        decide(read(trial.x, cell), trial, cell);
        push(trial, cell);
      }
      last += found.period;
    }
    const kept = Math.min(last, KEPT);
    result.lead = [];
    chart(first, 0, kept, cell, result.lead);
    result.kept = kept;
  }
  return result;
};

// State at a time in samples since the first: on the way there, then on the cycle, for ever.
const search = (pieces, t) => {
  let low = 0, high = pieces.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (pieces[middle].start <= t) low = middle; else high = middle - 1;
  }
  return pieces[low];
};
const at = (result, t) => {
  const { cell, lead, pieces, period, kept } = result;
  let list = lead, when = Math.max(t, 0);
  if (pieces.length && when >= kept) {
    list = pieces;
    when = (when - kept) % period;
  } else if (when >= kept) when = kept - 1e-9;
  const piece = search(list, when);
  within(piece, Math.min(when - piece.start, piece.span), cell);
  return { angle: (X + cell.shift) * cell.quantum, speed: (V * cell.quantum) / cell.period, torque: piece.u * cell.torque };
};

return { reduce, solve, at, harmonics, touchLevel, kinds: Object.keys(LAWS) };
