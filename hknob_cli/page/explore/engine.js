// The engine of the page: one trial of a sampled knob, exact from event to event, and the cycle that it reaches.
//
// It is the program's own arithmetic (engine/propagator.py, turning.py, general/, general/laws/kinds.py) over again:
// angles in encoder counts, times in sample periods, x'' + alpha x' + beta x = drive in closed form. The tests compare
// its numbers with the program's. It draws nothing and asks for nothing.
//
// A trial that repeats its readings is compared with the periodic motion of these readings, which is solved for. What
// the trial still is away from it can only shrink; once that is less than the distance to the nearest count edge, the
// trial reads the same for ever, and the cycle is the one it reaches.
const Knob = (() => {
  "use strict";

  // ---- The plant over one hold: S, G, F of engine/propagator.py.
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

  // ---- Controllers: from what the encoder shows and what is remembered to a torque in steps of the wall. `fades`
  // tells the row of the memory that is a fading mean, by what it shrinks in a sample, and how a torque depends on it.
  const depthOf = (shown, offset) => (shown < 0 ? -(shown + offset) : 0);
  const LONGEST = 1 - 2 ** -50;
  const LAWS = {
    bounded_lag: (cell, with_) => ({
      rows: 1, goes: -Math.expm1(-cell.period / with_.time_constant), keep: with_.keep,
      fades: { row: 0, fade: Math.min(Math.exp(-cell.period / with_.time_constant), LONGEST), weight: 1 - with_.keep },
      act(shown, past) {
        const w = depthOf(shown, cell.offset);
        past[0] += this.goes * (w - past[0]);
        return w - (1 - this.keep) * Math.min(Math.max(w - past[0], -1), 1);
      },
    }),
    first_order_hold: (cell, with_) => ({
      rows: 2,
      act(shown, past) {
        const now = depthOf(shown, cell.offset), before = past[0], earlier = past[1];
        let torque = 1.5 * now - 0.5 * before;
        if (with_.correct !== false) torque += 0.5 * (now + before) - (1.5 * before - 0.5 * earlier);
        past[0] = now; past[1] = before;
        return torque;
      },
    }),
    half_sample: (cell) => {
      respond(cell.alpha, cell.beta, 0.5);
      const s = S, left = 1 - G * cell.beta, yielding = 1 / (1 + G * cell.kappa);
      return {
        rows: 1, places: 1, outside: true,
        act(shown, past) {
          const at = shown + cell.offset, pace = at - past[0];
          past[0] = at;
          return Math.max(-((left * at + s * pace) * yielding), 0);
        },
      };
    },
    matched_wall: (cell) => {
      respond(cell.alpha, cell.beta, 1);
      const s = S, g = G, f = F;
      respond(cell.alpha, cell.beta + cell.kappa, 1);
      const more = 2 * cell.kappa * G + 2 * cell.beta * (G - g) + cell.alpha * (S - s);
      const both = more / (cell.kappa * (g * s - s * (g * f - s * s)));
      const place = both * s, rate = both * (s * s - g * f);
      return {
        rows: 1, places: 1, outside: true,
        act(shown, past) {
          const at = shown + cell.offset, pace = at - past[0];
          past[0] = at;
          return shown < 0 ? -(place * at + rate * pace) : 0;
        },
      };
    },
    stiffening: (cell, with_) => ({
      rows: 0,
      act(shown) {
        const now = depthOf(shown, cell.offset);
        return now * (with_.surface + (1 - with_.surface) * Math.min(now * (cell.quantum / with_.depth), 1));
      },
    }),
    velocity_damping: (cell, with_) => {
      const window = with_.window || 1, filtered = with_.low_pass > 0;
      const gain = -with_.damping / (cell.stiffness * cell.period);
      const goes = filtered ? -Math.expm1(-cell.period / with_.low_pass) : 0;
      const fade = filtered ? Math.min(Math.exp(-cell.period / with_.low_pass), LONGEST) : 0;
      return {
        rows: window + (filtered ? 1 : 0), places: window, outside: true,
        fades: filtered ? { row: window, fade, weight: Math.abs(gain) } : null,
        act(shown, past) {
          const at = shown + cell.offset;
          let pace = (at - past[window - 1]) / window;
          for (let j = window - 1; j > 0; j -= 1) past[j] = past[j - 1];
          past[0] = at;
          if (filtered) pace = past[window] += goes * (pace - past[window]);
          const torque = depthOf(shown, cell.offset);
          return with_.everywhere || shown < 0 ? torque + gain * pace : torque;
        },
      };
    },
  };

  // ---- A scene in SI units, reduced to the numbers of one cell: scene/general_knob.py.
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
    cell.law = scene.controller ? LAWS[scene.controller.kind](cell, scene.controller) : null;
    cell.apart = cell.damping > 0 || (cell.law !== null && cell.law.outside === true); // counts outside the wall differ
    for (const name of ["alpha", "beta", "kappa", "push", "friction", "s2", "g2"]) {
      if (!Number.isFinite(cell[name] * cell[name])) throw new RangeError("the scene's numbers overflow");
    }
    return cell;
  };

  // ---- The encoder, the wall, the converter and the amplifier: engine/general/controller.py.
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

  // ---- Motion under one torque, with Coulomb friction from event to event: engine/general/slide_two.py.
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

  // ---- A trial.
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

  // ---- The periodic motion of the readings that a trial has had over its last period.
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

  // ---- A motion piece by piece: [start, span, x, v, drive with friction, mode, torque].
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

  // ---- What a cycle amounts to: measure/general_orbit.py.
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

  // ---- One trial of a scene, to the cycle or the rest that it reaches.
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
})();
