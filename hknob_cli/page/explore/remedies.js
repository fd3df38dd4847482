// What can be changed about a knob: its numbers with their units and ranges, its controllers, and the remedies.
// Every remedy changes the scene itself, so that the same engine follows it, and the same spec says it.
const Choices = (() => {
  "use strict";
  // key, label, unit, SI per unit, least, most, scale ("log", "zero": 0 and then logarithmic, "even", "whole").
  const slider = (key, label, unit, si, low, high, scale) => ({ key, label, unit, si, low, high, scale });
  const MAIN = [
    slider("stiffness", "Wall stiffness", "N·m/rad", 1, 0.01, 10, "log"),
    slider("rate", "Sample rate", "Hz", 1, 100, 20000, "log"),
    slider("counts", "Counts per revolution", "counts", 1, 32, 32768, "whole"),
    slider("push", "Push into the wall", "mN·m", 1e-3, 0.01, 20, "zero"),
  ];
  const KNOB = [
    slider("inertia", "Inertia of knob and motor", "g·cm²", 1e-7, 0.5, 5000, "log"),
    slider("damping", "Damping of the knob", "mN·m·s/rad", 1e-3, 0.001, 20, "zero"),
    slider("friction", "Coulomb friction", "mN·m", 1e-3, 0.001, 20, "zero"),
  ];
  const HAND = [
    slider("hand.stiffness", "Stiffness of the hand", "N·m/rad", 1, 0.001, 5, "zero"),
    slider("hand.damping", "Damping of the hand", "mN·m·s/rad", 1e-3, 0.01, 50, "zero"),
    slider("hand.inertia", "Inertia of the hand", "g·cm²", 1e-7, 0.1, 200, "zero"),
  ];
  const WALL = [slider("wallDamping", "Virtual damping (difference of counts)", "mN·m·s/rad", 1e-3, 0.001, 20, "zero")];
  const AMPLIFIER = [
    slider("offset", "Edges above the wall's edge", "counts", 1, 0, 0.99, "even"),
    slider("delay", "Delay", "samples", 1, 0, 5, "even"),
    slider("limit", "Torque limit (0: none)", "mN·m", 1e-3, 0.1, 500, "zero"),
    slider("step", "Torque step of the converter", "mN·m", 1e-3, 0.0001, 5, "zero"),
    slider("band", "Smaller torques are not sent", "mN·m", 1e-3, 0.0001, 5, "zero"),
  ];
  const START = [
    slider("start.angle", "Let go at", "mrad", 1e-3, -100, 100, "even"),
    slider("start.velocity", "Turning at", "rad/s", 1, -5, 5, "even"),
    slider("start.phase", "First sample after (part of a period)", "periods", 1, 0.01, 0.99, "even"),
  ];
  const period = (scene) => 1 / scene.rate;
  const tidy = (value) => Number(value.toPrecision(2));

  const KEEP = slider("keep", "Part of a step that acts at once", "", 1, 0.01, 1, "log");
  const TIME_CONSTANT = 0.2;
  // The part of a step that leaves the smallest buzz, 2r/(1 + r) with r = J/(b tau); 1, the plain wall, where none does.
  const bestKeep = (scene) => {
    const hand = scene.hand || { inertia: 0, damping: 0 };
    const r = (scene.inertia + hand.inertia) / ((scene.damping + hand.damping) * TIME_CONSTANT);
    return r < 1 ? tidy((2 * r) / (1 + r)) : 1;
  };
  const LATE = slider("time_constant", "Time constant of the rest", "ms", 1e-3, 1, 2000, "log");
  // Controllers by the name that a spec has; `from`: what the numbers are at first, by the scene.
  const CONTROLLERS = {
    bounded_lag: { label: "bounded lag", sliders: [KEEP, LATE], from: (scene) => ({ keep: bestKeep(scene), time_constant: TIME_CONSTANT }) },
    first_order_hold: { label: "first-order hold", sliders: [], from: () => ({ correct: true }) },
    half_sample: { label: "half-sample prediction", sliders: [], from: () => ({}) },
    matched_wall: { label: "matched wall (state feedback)", sliders: [], from: () => ({}) },
    stiffening: {
      label: "stiffening wall",
      sliders: [
        slider("surface", "Part of the stiffness at the surface", "", 1, 0.02, 1, "even"),
        slider("depth", "All of it from", "mrad", 1e-3, 0.1, 200, "log"),
      ],
      from: () => ({ surface: 0.3, depth: 0.01 }),
    },
    velocity_damping: {
      label: "filtered velocity damping",
      sliders: [
        slider("damping", "Virtual damping", "mN·m·s/rad", 1e-3, 0.001, 20, "log"),
        slider("low_pass", "Low-pass on the velocity", "ms", 1e-3, 0.01, 100, "zero"),
      ],
      from: (scene) => ({ damping: tidy(0.5 * scene.stiffness * period(scene)), low_pass: tidy(2 * period(scene)) }),
    },
  };
  const CHANGES = {
    virtual_damping: {
      label: "virtual damping", sliders: [WALL[0]],
      from: (scene) => ({ wallDamping: tidy(0.5 * scene.stiffness * period(scene)) }),
      change: (scene, values) => ({ ...scene, wallDamping: values.wallDamping }),
    },
    nearest: {
      label: "counts rounded to the nearest", sliders: [], from: () => ({}),
      change: (scene) => ({ ...scene, rounding: "nearest" }),
    },
    finer: {
      label: "four times the counts", sliders: [], from: () => ({}),
      change: (scene) => ({ ...scene, counts: 4 * scene.counts }),
    },
    faster: {
      label: "four times the sample rate", sliders: [], from: () => ({}),
      change: (scene) => ({ ...scene, rate: 4 * scene.rate }),
    },
    damper: {
      label: "a damper on the knob", sliders: [slider("more", "Damping added", "mN·m·s/rad", 1e-3, 0.01, 20, "log")],
      from: (scene) => ({ more: tidy(0.5 * scene.stiffness * period(scene)) }),
      change: (scene, values) => ({ ...scene, damping: scene.damping + values.more }),
    },
    brake: {
      label: "friction on the knob", sliders: [slider("more", "Friction added", "mN·m", 1e-3, 0.001, 20, "log")],
      from: (scene) => ({ more: tidy((0.5 * scene.stiffness * 2 * Math.PI) / scene.counts) }),
      change: (scene, values) => ({ ...scene, friction: scene.friction + values.more }),
    },
    softer: {
      label: "half the stiffness", sliders: [], from: () => ({}),
      change: (scene) => ({ ...scene, stiffness: 0.5 * scene.stiffness }),
    },
  };
  const REMEDIES = {
    ...Object.fromEntries(Object.entries(CONTROLLERS).map(([kind, one]) => [kind, {
      ...one,
      change: (scene, values) => ({ ...scene, controller: { kind, ...values } }),
    }])),
    ...CHANGES,
  };

  // The scene as a spec that the command takes: 17 digits, so that it computes the same.
  const yaml = (scene, name) => {
    const full = (value) => (value !== 0 && Math.abs(value) < 1e-3 ? value.toExponential() : String(value)).replace(/^(-?\d+)e/, "$1.0e");
    const map = (part) => `{${Object.entries(part).map(([key, value]) => `${key}: ${typeof value === "number" ? full(value) : value}`).join(", ")}}`;
    const some = (part) => Object.fromEntries(Object.entries(part).filter(([, value]) => value !== 0 && value !== null && value !== undefined));
    const lines = ["kind: sweep", `name: ${name}`, "scene:"];
    lines.push(`  knob: ${map({ inertia: scene.inertia, ...some({ damping: scene.damping, coulomb_torque: scene.friction }) })}`);
    if (scene.hand) lines.push(`  hand: ${map(scene.hand)}`);
    lines.push(`  wall: ${map({ stiffness: scene.stiffness, ...some({ damping: scene.wallDamping }) })}`);
    if (scene.halfQuantum) lines.push("  bias: {half_quantum: true}");
    else if (scene.push > 0) lines.push(`  bias: ${map({ torque: scene.push })}`);
    const encoder = some({ rounding: scene.rounding === "floor" ? 0 : scene.rounding, offset_counts: scene.offset });
    if (Object.keys(encoder).length) lines.push(`  encoder: ${map(encoder)}`);
    const actuator = some({ delay_samples: scene.delay, torque_limit: scene.limit, torque_step: scene.step, dead_band: scene.band });
    if (Object.keys(actuator).length) lines.push(`  actuator: ${map(actuator)}`);
    if (scene.controller) lines.push(`  controller: ${map(some(scene.controller))}`);
    lines.push(`grid: ${map({ sample_rate_hz: scene.rate, counts_per_rev: scene.counts })}`);
    // A spec has phases (i + 1/2)/n: one alone is that of n = 1.
    const one = scene.start.phase === 0.5;
    lines.push(`starts: ${map({ angle: scene.start.angle, velocity: scene.start.velocity, ...(one ? { phases: 1 } : {}) })}${one ? "" : "   # every phase of the clock"}`);
    return `${lines.join("\n")}\n`;
  };

  return { MAIN, KNOB, HAND, WALL, AMPLIFIER, START, CONTROLLERS, REMEDIES, bestKeep, yaml };
})();
