// The engine of the page: one trial of a sampled knob, exact from event to event, and the cycle that it reaches.
//
// It is the program's own arithmetic (engine/propagator.py, turning.py, general/, general/laws/step.py, controllers/) over again:
// angles in encoder counts, times in sample periods, x'' + alpha x' + beta x = drive in closed form. The tests compare
// its numbers with the program's. It draws nothing and asks for nothing. The files of this folder are one program.

// The plant over one hold: S, G, F of engine/propagator.py.
let S = 0, G = 0, F = 1;
const respond = (alpha, beta, t) => {
  const a = 0.5 * alpha * t, c = beta * t * t;
  let s, g, f;
  if (a <= 0.5 && c <= 1) {
    let before = 0, term = 0.5, n = 2;
    g = term; s = 1;
    while (Math.abs(term) + Math.abs(before) > 1e-20) {
      [before, term] = [term, -(2 * a * n * term + c * before) * (1 / ((n + 1) * n))];
      n += 1;
      g += term;
      s += n * term;
    }
    f = 1 - c * g - 2 * a * s;
  } else if (a * a > c) {
    const r = Math.sqrt(a * a - c), slow = c / (a + r), fast = a + r;
    s = (Math.exp(-slow) * -Math.expm1(-2 * r)) / (2 * r);
    g = ((slow > 0 ? -Math.expm1(-slow) / slow : 1) - s) / fast;
    f = Math.exp(-fast) - slow * s;
  } else {
    const w = Math.sqrt(c - a * a), decay = Math.exp(-a), sinc = w > 0 ? Math.sin(w) / w : 1;
    s = decay * sinc;
    g = (1 - decay * (Math.cos(w) + a * sinc)) / c;
    f = decay * (Math.cos(w) - a * sinc);
  }
  S = s * t; G = g * t * t; F = f;
};

// Time of the first zero of the velocity after a start at v with y = drive - beta x: engine/turning.py.
const firstZero = (v, y, alpha, beta) => {
  const a = 0.5 * alpha, rate = y - a * v, square = beta - a * a;
  if (square > 0) {
    const w = Math.sqrt(square);
    if (rate === 0) return (0.5 * Math.PI) / w;
    const t = Math.atan((-v * w) / rate) / w;
    return t > 0 ? t : t + Math.PI / w;
  }
  if (rate === 0) return Infinity;
  const z = -v / rate;
  if (z <= 0) return Infinity;
  const r = Math.sqrt(-square);
  if (r === 0) return z;
  if (r * z >= 1) return Infinity;
  return (Math.log1p(r * z) - Math.log1p(-r * z)) / (2 * r);
};

const slowestRate = (alpha, beta) => {
  const a = 0.5 * alpha;
  if (beta === 0) return alpha;
  return a * a > beta ? beta / (a + Math.sqrt(a * a - beta)) : a;
};
