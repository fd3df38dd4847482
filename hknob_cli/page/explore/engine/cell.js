// A scene in SI units, reduced to the numbers of one cell: scene/general_knob.py.
const reduce = (scene) => {
  const hand = scene.hand || { inertia: 0, damping: 0, stiffness: 0 };
  const period = 1 / scene.rate, quantum = (2 * Math.PI) / scene.counts;
  const inertia = scene.inertia + hand.inertia, square = (period * period) / inertia;
  const rounding = scene.rounding || "floor", offset = scene.offset || 0;
  const shift = offset - (rounding === "nearest" ? 0.5 : 0);
  const delay = scene.delay || 0, whole = Math.trunc(delay), split = delay - whole;
  const kappa = scene.stiffness * square, stiffness = scene.stiffness;
  const alpha = ((scene.damping + hand.damping) * period) / inertia, beta = hand.stiffness * square;
  const push = scene.halfQuantum ? 0.5 * scene.stiffness * square : ((scene.push || 0) * square) / quantum;
  const squared = beta - 0.25 * alpha * alpha;
  const cell = {
    period, quantum, inertia, shift, kappa, stiffness, alpha, beta, push, offset, split,
    drive: -push - beta * shift,
    friction: ((scene.friction || 0) * square) / quantum,
    damping: ((scene.wallDamping || 0) * period) / inertia,
    sense: rounding === "ceil" || rounding === "truncate" ? -1 : 1,
    truncate: rounding === "truncate",
    step: ((scene.step || 0) * square) / quantum,
    limit: scene.limit === null || scene.limit === undefined ? Infinity : (scene.limit * square) / quantum,
    band: ((scene.band || 0) * square) / quantum,
    spacing: squared > 0 ? Math.PI / Math.sqrt(squared) : Infinity,
    line: delay > 0 ? whole + 1 : 0,
    torque: (inertia * quantum) / (period * period),
  };
  respond(alpha, beta, split);
  [cell.s1, cell.g1, cell.f1] = [S, G, F];
  respond(alpha, beta, 1 - split);
  [cell.s2, cell.g2, cell.f2] = [S, G, F];
  if (scene.controller && !(stiffness > 0)) throw new RangeError("a controller needs a wall of some stiffness");
  cell.law = scene.controller ? LAWS[scene.controller.kind](cell, scene.controller) : null;
  cell.apart = cell.damping > 0 || (cell.law !== null && cell.law.outside === true); // counts outside the wall differ
  for (const name of ["alpha", "beta", "kappa", "push", "friction", "s2", "g2"]) {
    if (!Number.isFinite(cell[name] * cell[name])) throw new RangeError("the scene's numbers overflow");
  }
  return cell;
};

// The encoder, the wall, the converter and the amplifier: engine/general/controller.py.
const read = (x, cell) => {
  if (cell.truncate && x > 0) return Math.floor(x);
  return cell.sense * Math.floor(cell.sense * x);
};
const send = (u, cell) => {
  if (Math.abs(u) < cell.band) u = 0;
  if (cell.step > 0) u = cell.step * Math.floor(u / cell.step + 0.5);
  return Math.min(cell.limit, Math.max(-cell.limit, u));
};
const command = (shown, trial, cell) => {
  const brake = cell.damping > 0 && shown < 0 ? cell.damping * (shown - trial.before) : 0;
  let u = 0;
  if (cell.law) u = send(cell.kappa * cell.law.act(shown, trial.past) - brake, cell);
  else if (shown < 0) u = send(-cell.kappa * (shown + cell.offset) - brake, cell);
  trial.before = shown;
  return u;
};
// How far x may move until the reading matters: edge_gap.
const edgeGap = (x, shown, cell) => {
  let low = shown, high = shown;
  if (!cell.apart && !(shown < 0)) { low = 0; high = Infinity; }
  const below = cell.sense > 0 || (cell.truncate && low > 0) ? low : low - 1;
  const above = cell.sense > 0 || (cell.truncate && !(high < 0)) ? high + 1 : high;
  return Math.min(x - below, above - x);
};
