// Controllers: from what the encoder shows and what is remembered to a torque in steps of the wall. `fades`
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
