// Motion under one torque, with Coulomb friction from event to event: engine/general/slide_two.py.
let X = 0, V = 0;
const way = (v, pull, friction) => {
  if (v > 0) return 1;
  if (v < 0) return -1;
  if (Math.abs(pull) <= friction) return 0;
  return pull > 0 ? 1 : -1;
};
const skipTurns = (x, drive, left, cell) => {
  const rest = drive / cell.beta, q = cell.friction / cell.beta;
  let away = Math.abs(x - rest), last;
  const k = 0.5 * cell.alpha * cell.spacing;
  if (k > 0) {
    const fall = -Math.expm1(-k), bound = ((2 - fall) * q) / fall;
    last = Math.log((away + bound) / (q + bound)) / k;
  } else last = (away - q) / (2 * q);
  const turns = Math.floor(Math.min(last, left / cell.spacing)) - 2;
  if (turns < 1) return 0;
  if (k > 0) {
    const decay = Math.expm1(-k * turns), one = Math.expm1(-k);
    away = (decay + 1) * away - (q * (2 + one) * decay) / one;
  } else away -= 2 * q * turns;
  let side = x > rest ? 1 : -1;
  if (turns % 2 !== 0) side = -side;
  X = rest + side * away;
  return turns * cell.spacing;
};
// Length of the slide in `mode` until the velocity vanishes or `left` is over; S, G, F over it. Sets `ended`.
let ended = false;
const untilZero = (x, v, drive, mode, left, known, cell) => {
  const y = drive - cell.beta * x;
  ended = false;
  if (known && cell.spacing >= left && (F * v + S * y) * mode >= 0) return left;
  if (v !== 0 && v * mode < -1e-290 * y * mode) {
    S = 0; G = 0; F = 1;
    ended = true;
    return 0;
  }
  const t = firstZero(v, y, cell.alpha, cell.beta);
  if (t >= left) {
    if (!known) respond(cell.alpha, cell.beta, left);
    return left;
  }
  respond(cell.alpha, cell.beta, t);
  ended = true;
  return t;
};
const rub = (x, v, u, span, cell) => { // S, G, F over span are set; leaves X, V
  const free = u + cell.drive, { beta, friction } = cell;
  let mode = way(v, free - beta * x, friction);
  if (mode === 0) { X = x; V = 0; return; }
  const y = free - mode * friction - beta * x, slow = F * v + S * y;
  if (cell.spacing >= span && slow * mode > 0) { X = x + (S * v + G * y); V = slow; return; }
  let left = span, known = true;
  while (left > 0 && mode !== 0) {
    if (v === 0 && left > 8 * cell.spacing) {
      const skipped = skipTurns(x, free, left, cell);
      if (skipped > 0) {
        x = X;
        left -= skipped;
        known = false;
        mode = way(v, free - beta * x, friction);
        continue;
      }
    }
    const drive = free - mode * friction, t = untilZero(x, v, drive, mode, left, known, cell);
    const pull = drive - beta * x, next = F * v + S * pull;
    x += S * v + G * pull;
    v = ended || next * mode < 0 ? 0 : next;
    if (!ended) break;
    left -= t;
    known = false;
    mode = way(v, free - beta * x, friction);
  }
  X = x; V = v;
};
const move = (x, v, u, first, cell) => { // over the part before the split, or the rest; leaves X, V
  if (first) { S = cell.s1; G = cell.g1; F = cell.f1; } else { S = cell.s2; G = cell.g2; F = cell.f2; }
  if (cell.friction > 0) return rub(x, v, u, first ? cell.split : 1 - cell.split, cell);
  const y = u + cell.drive - cell.beta * x;
  X = x + (S * v + G * y);
  V = F * v + S * y;
};
