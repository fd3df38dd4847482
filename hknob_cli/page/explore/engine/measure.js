// A motion piece by piece: [start, span, x, v, drive with friction, mode, torque].
const chartHold = (x, v, u, start, span, cell, pieces) => {
  let left = span, at = start, mode = way(v, u + cell.drive - cell.beta * x, cell.friction);
  while (left > 0) {
    const free = u + cell.drive;
    if (mode === 0) {
      pieces.push({ start: at, span: left, x, v: 0, drive: cell.beta * x, mode, u });
      X = x; V = 0;
      return;
    }
    const drive = free - mode * cell.friction, t = untilZero(x, v, drive, mode, left, false, cell), over = ended;
    if (t > 0) pieces.push({ start: at, span: t, x, v, drive, mode, u });
    const pull = drive - cell.beta * x, next = F * v + S * pull;
    x += S * v + G * pull;
    v = over || next * mode < 0 ? 0 : next;
    left -= t;
    at += t;
    if (!over) break;
    mode = way(v, free - cell.beta * x, cell.friction);
    if (pieces.length > 400000) throw new RangeError("the knob rings too often between samples");
  }
  X = x; V = v;
};
const chart = (trial, from, samples, cell, pieces) => {
  for (let i = 0; i < samples; i += 1) {
    decide(read(trial.x, cell), trial, cell);
    X = trial.x; V = trial.v;
    const [older, newer] = [OLDER, NEWER];
    if (cell.split > 0) chartHold(X, V, older, from + i, cell.split, cell, pieces);
    chartHold(X, V, newer, from + i + cell.split, 1 - cell.split, cell, pieces);
    trial.x = X; trial.v = V;
  }
};

// Position and speed `t` after the start of a piece.
const within = (piece, t, cell) => {
  if (piece.mode === 0) { X = piece.x; V = 0; return; }
  respond(cell.alpha, cell.beta, t);
  const y = piece.drive - cell.beta * piece.x;
  X = piece.x + (S * piece.v + G * y);
  V = F * piece.v + S * y;
};

// What a cycle amounts to: measure/general_orbit.py.
const measure = (found, cell) => {
  const pieces = [];
  chart(copy(found.orbit), 0, found.period, cell, pieces);
  const moving = pieces.filter((piece) => piece.mode !== 0), n = moving.length;
  const maxima = [], minima = [];
  for (let i = 0; i < n; i += 1) {
    if (moving[i].mode === moving[(i + n - 1) % n].mode) continue;
    (moving[i].mode < 0 ? maxima : minima).push(moving[i].x);
  }
  const mean = (values) => values.reduce((sum, one) => sum + one, 0) / values.length;
  const rad = (x) => (x + cell.shift) * cell.quantum;
  if (found.still || !maxima.length || !minima.length) {
    return { outcome: "rest", pieces, p2p: 0, frequency: 0, cycles: 0, min: rad(found.orbit.x), max: rad(found.orbit.x) };
  }
  const p2p = mean(maxima) - mean(minima);
  return {
    outcome: "cycle", pieces, cycles: maxima.length,
    p2p: p2p * cell.quantum,
    p2pCounts: p2p,
    min: rad(Math.min(...minima)),
    max: rad(Math.max(...maxima)),
    frequency: maxima.length / (found.period * cell.period),
  };
};

// Complex amplitudes, counts, of the harmonics 1..count of a period: those of the drive times the plant's response.
const harmonics = (result, count) => {
  const { cell, period, pieces } = result, m = pieces.length;
  const middle = pieces.reduce((sum, piece) => sum + piece.drive * piece.span, 0) / period;
  const base = (2 * Math.PI) / period;
  const cos = new Float64Array(m), sin = new Float64Array(m), jump = new Float64Array(m);
  for (let j = 0; j < m; j += 1) {
    cos[j] = Math.cos(base * pieces[j].start);
    sin[j] = -Math.sin(base * pieces[j].start);
    jump[j] = pieces[j].drive - pieces[(j + m - 1) % m].drive;
  }
  const turnRe = Float64Array.from(cos), turnIm = Float64Array.from(sin);
  const re = new Float64Array(count), im = new Float64Array(count);
  for (let k = 1; k <= count; k += 1) {
    let sumRe = 0, sumIm = 0;
    for (let j = 0; j < m; j += 1) {
      sumRe += jump[j] * turnRe[j];
      sumIm += jump[j] * turnIm[j];
      const next = turnRe[j] * cos[j] - turnIm[j] * sin[j];
      turnIm[j] = turnRe[j] * sin[j] + turnIm[j] * cos[j];
      turnRe[j] = next;
    }
    const w = base * k; // the sum over jumps, over i w, is the drive's integral
    const driveRe = sumIm / w, driveIm = -sumRe / w;
    const a = cell.beta - w * w, b = cell.alpha * w, size = a * a + b * b;
    re[k - 1] = ((2 / period) * (driveRe * a + driveIm * b)) / size;
    im[k - 1] = ((2 / period) * (driveIm * a - driveRe * b)) / size;
  }
  return { re, im, middle };
};

// Level of touch, dB above the threshold of an average person, and the harmonic (Hz) that is felt best; null if the
// thresholds have none in their range. `touch`: points (Hz, m), range, and the radius of the knob: perception/touch.py.
const touchLevel = (result, touch) => {
  if (result.outcome !== "cycle") return null;
  const { cell, period } = result, first = 1 / (period * cell.period);
  const count = Math.floor(touch.high * period * cell.period * (1 + 1e-12));
  if (count < 1 || count * result.pieces.length > 4e7) return null;
  const lines = harmonics(result, count), powers = [];
  let best = null;
  for (let k = 1; k <= count; k += 1) {
    const hertz = k * first;
    if (hertz < touch.low || hertz > touch.high) continue;
    const points = touch.points, where = Math.log(hertz);
    let j = 1;
    while (j < points.length - 1 && points[j][0] < hertz) j += 1;
    const [f0, d0] = points[j - 1], [f1, d1] = points[j];
    const part = (where - Math.log(f0)) / (Math.log(f1) - Math.log(f0));
    const least = Math.exp(Math.log(d0) + part * (Math.log(d1) - Math.log(d0)));
    const skin = Math.hypot(lines.re[k - 1], lines.im[k - 1]) * cell.quantum * touch.radius;
    const level = 20 * Math.log10(skin / least);
    if (!Number.isFinite(level)) continue;
    powers.push(level);
    if (best === null || level > best.level) best = { level, hertz };
  }
  if (best && touch.combine === "power_sum") {
    best.level += 10 * Math.log10(powers.reduce((sum, one) => sum + 10 ** (0.1 * (one - best.level)), 0));
  }
  return best;
};
