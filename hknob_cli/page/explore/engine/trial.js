// A trial.
let OLDER = 0, NEWER = 0; // torques of an interval
const decide = (shown, trial, cell) => {
  NEWER = OLDER = command(shown, trial, cell);
  if (cell.line > 0) {
    OLDER = trial.ring[trial.head];
    trial.ring[trial.head] = NEWER;
    trial.head = (trial.head + 1) % cell.line;
    NEWER = trial.ring[trial.head];
  }
};
const push = (trial, cell) => {
  if (cell.split > 0) {
    move(trial.x, trial.v, OLDER, true, cell);
    trial.x = X; trial.v = V;
  }
  move(trial.x, trial.v, NEWER, false, cell);
  trial.x = X; trial.v = V;
};
const copy = (trial) => ({ ...trial, ring: trial.ring.slice(), past: trial.past.slice() });

// The state at the first sample, `phase` of a period after the start; no torque acts before it.
const begin = (cell, start) => {
  const x = start.angle / cell.quantum - cell.shift, v = (start.velocity * cell.period) / cell.quantum;
  respond(cell.alpha, cell.beta, start.phase);
  if (cell.friction > 0) rub(x, v, 0, start.phase, cell);
  else {
    const y = cell.drive - cell.beta * x;
    X = x + (S * v + G * y);
    V = F * v + S * y;
  }
  const law = cell.law, past = new Array(law ? law.rows : 0).fill(0), shown = read(X, cell);
  for (let j = 0; law && j < (law.places || 0); j += 1) past[j] = shown + cell.offset;
  return { x: X, v: V, before: shown, ring: new Array(cell.line).fill(0), head: 0, past };
};

// Bound on how far apart two motions get under the same torques, from their difference now: body.distance.
const distance = (dx, dv, cell) => {
  if (cell.beta === 0 && cell.friction === 0) {
    return cell.alpha === 0 ? (dv === 0 ? Math.abs(dx) : Infinity) : Math.abs(dx) + Math.abs(dv) / cell.alpha;
  }
  if (cell.beta === 0) return Infinity;
  return Math.sqrt(dv * dv + cell.beta * dx * dx) / Math.sqrt(cell.beta);
};
