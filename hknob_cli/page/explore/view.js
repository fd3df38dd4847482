// The page: sliders, the answer in words, the moving pictures, the sound. The motion is the engine's.
(() => {
  "use strict";
  const $ = (id) => document.getElementById(id);
  const data = JSON.parse($("data").textContent);
  const still = matchMedia("(prefers-reduced-motion: reduce)"), dark = matchMedia("(prefers-color-scheme: dark)");
  const MOST = 262144; // samples that a trial is followed

  // ---- Numbers in words.
  const short = (value, digits = 4) => {
    if (value === 0) return "0";
    const text = Number(value.toPrecision(digits));
    return (Math.abs(text) >= 1e5 || Math.abs(text) < 1e-3 ? text.toExponential() : String(text)).replace("-", "−");
  };
  const element = (name, attributes = {}, ...children) => {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) {
      if (key in made && key !== "list") made[key] = value; else made.setAttribute(key, value);
    }
    made.append(...children);
    return made;
  };

  // ---- The scene that the sliders show, and the numbers of controllers and remedies by their names.
  let scene = null, remedy = "bounded_lag", numbers = {}, results = {};
  const get = (from, key) => key.split(".").reduce((part, name) => (part ? part[name] : 0), from);
  const set = (into, key, value) => {
    const names = key.split("."), last = names.pop();
    let part = into;
    for (const name of names) part = part[name] = { ...part[name] };
    part[last] = value;
  };
  const valuesOf = (kind) => (numbers[kind] ||= Choices.REMEDIES[kind].from(scene));

  // ---- Sliders: a range and a number, both of the same value.
  const STEPS = 1000;
  const toPlace = (one, value) => {
    const { low, high, scale } = one;
    if (scale === "even") return ((value - low) / (high - low)) * STEPS;
    if (scale === "zero" && value < low) return 0;
    const part = Math.log(Math.max(value, low) / low) / Math.log(high / low);
    return scale === "zero" ? 1 + part * (STEPS - 1) : part * STEPS;
  };
  const toValue = (one, place) => {
    const { low, high, scale } = one;
    if (scale === "even") return Number((low + ((high - low) * place) / STEPS).toPrecision(4));
    if (scale === "zero" && place < 1) return 0;
    const part = scale === "zero" ? (place - 1) / (STEPS - 1) : place / STEPS;
    const value = low * (high / low) ** part;
    return scale === "whole" ? Math.round(value) : Number(value.toPrecision(3));
  };
  let made = 0;
  const addSlider = (box, one, read, write) => {
    const id = `slider-${(made += 1)}`;
    const range = element("input", { type: "range", id, min: 0, max: STEPS, step: 1 });
    const number = element("input", { type: "number", step: "any", "aria-label": `${one.label}${one.unit ? `, ${one.unit}` : ""}` });
    const show = () => {
      const value = (read() || 0) / one.si, text = String(Number(value.toPrecision(5)));
      range.value = Math.round(toPlace(one, value));
      range.setAttribute("aria-valuetext", `${text} ${one.unit}`);
      if (document.activeElement !== number) number.value = text;
    };
    const wrong = (value) => !Number.isFinite(value)
      || (one.scale === "even" ? value < one.low && one.low >= 0 : one.scale === "zero" ? value < 0 : value <= 0)
      || ((one.key === "keep" || one.key === "surface") && value > 1)
      || ((one.key === "offset" || one.key === "start.phase") && value >= 1) || (one.key === "delay" && value > 1000);
    range.addEventListener("input", () => {
      const value = toValue(one, Number(range.value));
      number.value = value;
      number.removeAttribute("aria-invalid");
      write(value * one.si);
      range.setAttribute("aria-valuetext", `${value} ${one.unit}`);
      later();
    });
    number.addEventListener("input", () => {
      let value = Number(number.value);
      if (number.value === "" || wrong(value)) { number.setAttribute("aria-invalid", "true"); return; }
      number.removeAttribute("aria-invalid");
      if (one.scale === "whole") value = Math.max(1, Math.round(value));
      write(value * one.si);
      range.value = Math.round(toPlace(one, value));
      range.setAttribute("aria-valuetext", `${value} ${one.unit}`);
      later();
    });
    number.addEventListener("change", () => { number.removeAttribute("aria-invalid"); number.blur(); show(); });
    box.append(element("div", {}, element("label", { htmlFor: id }, one.label), range, number, element("span", {}, one.unit)));
    show();
    return show;
  };
  let shown = [];
  const sceneSliders = () => {
    shown = [];
    for (const [id, list] of [["main-sliders", Choices.MAIN], ["knob-sliders", Choices.KNOB], ["hand-sliders", Choices.HAND],
      ["wall-sliders", Choices.WALL], ["amplifier-sliders", Choices.AMPLIFIER], ["start-sliders", Choices.START]]) {
      $(id).replaceChildren();
      for (const one of list) {
        shown.push(addSlider($(id), one, () => get(scene, one.key), (value) => {
          set(scene, one.key, one.key === "limit" && value === 0 ? null : value);
          if (one.key === "push") scene.halfQuantum = false;
        }));
      }
    }
    $("hand-group").hidden = !scene.hand;
    $("rounding").value = scene.rounding;
  };
  const controllerSliders = () => {
    const kind = scene.controller ? scene.controller.kind : "";
    $("controller").value = kind;
    $("controller-sliders").replaceChildren();
    for (const one of kind ? Choices.CONTROLLERS[kind].sliders : []) {
      addSlider($("controller-sliders"), one, () => scene.controller[one.key], (value) => {
        scene.controller = { ...scene.controller, [one.key]: value };
      });
    }
  };
  const remedySliders = () => {
    $("remedy").value = remedy;
    $("remedy-sliders").replaceChildren();
    for (const one of Choices.REMEDIES[remedy].sliders) {
      addSlider($("remedy-sliders"), one, () => valuesOf(remedy)[one.key], (value) => {
        numbers[remedy] = { ...valuesOf(remedy), [one.key]: value };
      });
    }
  };

  // ---- From the scene to both results, and to words.
  const solve = (what) => {
    try { return Knob.solve(what, { samples: MOST }); } catch (error) {
      if (error instanceof RangeError) return { outcome: "wrong", why: error.message, scene: what };
      throw error;
    }
  };
  const touchOf = (result) => {
    if (result.touch === undefined) result.touch = result.outcome === "cycle" ? Knob.touchLevel(result, data.touch) : null;
    return result.touch;
  };
  const feltWords = (result) => {
    const touch = touchOf(result);
    if (!touch) return "; no touch threshold is published there";
    return touch.level > 0
      ? `, felt: ${short(touch.level, 2)} dB above the threshold of an average person`
      : `, not felt by an average person: ${short(-touch.level, 2)} dB below the threshold`;
  };
  const verdict = (result, first) => {
    const n = first.length ? `${first} it` : "It";
    if (result.outcome === "cycle") {
      return `${n} buzzes: ${short(1e3 * result.p2p, 3)} mrad peak to peak at ${short(result.frequency, 3)} Hz${feltWords(result)}.`;
    }
    if (result.outcome === "rest") return `${n} does not buzz: it comes to rest.`;
    if (result.outcome === "diverged") return `${n} runs away: nothing holds the knob at the wall.`;
    if (result.outcome === "wrong") return `${n} cannot be computed: ${result.why}.`;
    return `${n} is not settled after ${result.samples} samples (${short(result.samples * result.cell.period, 3)} s), so no cycle is named.`;
  };
  const compared = (one, other) => {
    if (one.outcome !== "cycle" || other.outcome !== "cycle") return "";
    const ratio = one.p2p / other.p2p, a = touchOf(one), b = touchOf(other);
    const size = Math.abs(ratio - 1) < 0.005 ? "The size is the same" : ratio > 1 ? `That is ${short(ratio, 2)} times smaller` : `That is ${short(1 / ratio, 2)} times larger`;
    const less = a && b ? a.level - b.level : null;
    if (less === null) return ` ${size}.`;
    return ` ${size}, and ${Math.abs(less) < 0.05 ? "felt as much" : less > 0 ? `${short(less, 2)} dB less to feel` : `${short(-less, 2)} dB more to feel`}.`;
  };
  const ROWS = [
    ["What it does", (r) => ({ cycle: "buzzes", rest: "comes to rest", diverged: "runs away", undecided: "not settled", wrong: "not computed" })[r.outcome]],
    ["Peak to peak", (r) => (r.outcome === "cycle" ? `${short(1e3 * r.p2p, 6)} mrad` : r.outcome === "rest" ? "0" : "–")],
    ["Peak to peak in counts", (r) => (r.outcome === "cycle" ? short(r.p2pCounts, 4) : r.outcome === "rest" ? "0" : "–")],
    ["Frequency", (r) => (r.outcome === "cycle" ? `${short(r.frequency, 6)} Hz` : r.outcome === "rest" ? "0" : "–")],
    ["The motion repeats after", (r) => (r.outcome === "cycle" ? `${r.period} samples, ${short(1e3 * r.period * r.cell.period, 4)} ms, ${r.cycles} ${r.cycles === 1 ? "swing" : "swings"}` : "–")],
    ["Angle from, to", (r) => (r.period ? `${short(1e3 * r.min, 5)} mrad, ${short(1e3 * r.max, 5)} mrad` : "–")],
    ["Torque of one count", (r) => (r.cell ? `${short(1e3 * r.scene.stiffness * r.cell.quantum, 4)} mN·m` : "–")],
    ["Touch level", (r) => { const t = r.outcome === "cycle" ? touchOf(r) : null; return t ? `${short(t.level, 4)} dB, most by ${short(t.hertz, 4)} Hz` : "–"; }],
    ["Nearest count edge at a sample", (r) => (r.period ? `${short(r.margin, 3)} counts away` : "–")],
    ["Settled after", (r) => (r.period ? `${short(1e3 * r.samples * r.cell.period, 3)} ms` : "–")],
  ];
  const fill = () => {
    const { one, other } = results, label = Choices.REMEDIES[remedy].label;
    $("said").textContent = verdict(one, "");
    $("said-other").textContent = `${verdict(other, `With ${label}`)}${compared(one, other)}`;
    $("other-title").textContent = `With ${label}`;
    $("other-head").textContent = `With ${label}`;
    const parts = [`${short(scene.rate)} Hz`, `${short(scene.counts, 6)} counts`, scene.controller ? Choices.CONTROLLERS[scene.controller.kind].label : "plain wall"];
    $("one-about").textContent = `${parts.join(", ")}, ${scene.halfQuantum ? "push of half a count's torque" : scene.push > 0 ? `push ${short(1e3 * scene.push, 3)} mN·m` : "no push"}, ${scene.hand ? "held by a hand" : "no hand"}`;
    const { scene: changed } = other;
    $("other-about").textContent = `The same, ${changed.controller ? `under ${Choices.CONTROLLERS[changed.controller.kind].label}` : "under the plain wall"}, ${short(changed.rate)} Hz, ${short(changed.counts, 6)} counts`;
    $("table").replaceChildren(...ROWS.map(([title, say]) => element("tr", {}, element("th", { scope: "row" }, title), element("td", {}, say(one)), element("td", {}, say(other)))));
    for (const name of ["one", "other"]) {
      const result = results[name], buzzes = result.outcome === "cycle", touch = buzzes ? touchOf(result) : null;
      const rest = result.outcome === "rest" ? "0" : "–";
      const tiles = [
        [buzzes ? `${short(1e3 * result.p2p, 3)}` : rest, "mrad peak to peak"],
        [buzzes ? short(result.frequency, 3) : rest, "Hz"],
        [touch ? short(touch.level, 2) : "–", "dB above touch threshold"],
      ];
      $(`${name}-tiles`).replaceChildren(...tiles.map(([value, unit]) => element("li", {}, element("b", {}, value), unit)));
      const said = verdict(result, "");
      $(`${name}-dial`).setAttribute("aria-label", `The knob as it turns, enlarged. ${said}`);
      $(`${name}-angle`).setAttribute("aria-label", `Angle over time with count edges. ${said}`);
      $(`${name}-torque`).setAttribute("aria-label", `Torque over time, held between samples. ${said}`);
      $(`${name}-plane`).setAttribute("aria-label", `Phase plane with count edges. ${said}`);
      $(`${name}-hear`).disabled = !buzzes;
    }
    $("quiet").hidden = one.outcome === "cycle" || other.outcome === "cycle";
    $("quiet").textContent = "Nothing buzzes, so there is nothing to hear. Less friction, less damping or more push may change that.";
    writeSpec();
  };
  const writeSpec = () => { $("spec").textContent = Choices.yaml(results[$("which").value].scene, data.slug); };

  let waiting = 0;
  const later = () => { waiting ||= requestAnimationFrame(compute); };
  const compute = () => {
    waiting = 0;
    const changed = { ...scene, start: { ...scene.start } };
    const other = Choices.REMEDIES[remedy].change(changed, valuesOf(remedy));
    results = { one: solve(changed), other: solve(other) };
    fill();
    toCycle();
    resound();
  };

  // ---- Time: seconds since each first sample. `clock.from` are the times at which the two pictures began.
  const clock = { from: { one: 0, other: 0 }, now: 0, playing: false, last: 0 };
  const swing = () => { // seconds of one swing, by which slow motion and windows go
    const cycle = [results.one, results.other].find((one) => one.outcome === "cycle");
    if (cycle) return 1 / cycle.frequency;
    const c = results.one.cell || results.other.cell;
    return c ? (2 * Math.PI * c.period) / Math.sqrt(Math.max(c.kappa + c.beta, 1e-9)) : 0.05;
  };
  const SWINGS = 5; // in a window
  const windowOf = () => SWINGS * swing();
  const slowness = () => { // in the middle a swing takes two seconds; at the right it is real time
    const place = Number($("speed").value), middle = 2 / swing();
    return Math.max(1, place < 50 ? middle * 10 ** ((50 - place) / 50) : middle ** ((100 - place) / 50));
  };
  const showSpeed = () => { $("speed-said").textContent = slowness() <= 1.005 ? "real time" : `1 : ${short(slowness(), 2)}`; };
  const toCycle = () => { // on to the cycles; where nothing cycles, to the start, so that there is something to see
    const cycles = ["one", "other"].some((name) => results[name].outcome === "cycle");
    for (const name of ["one", "other"]) {
      const result = results[name], settled = result.cell && result.period;
      clock.from[name] = cycles && settled ? result.kept * result.cell.period + 2 * windowOf() : 0;
    }
    clock.now = 0;
    ranges = {};
    showSpeed();
    if (!clock.playing) requestAnimationFrame(() => draw());
  };
  const timeOf = (name) => {
    const result = results[name];
    let t = clock.from[name] + clock.now;
    if (!result.period && result.cell) t %= result.kept * result.cell.period; // what is known, again and again
    return t;
  };
  const frame = (stamp) => {
    if (!clock.playing) return;
    if (clock.last) clock.now += Math.min(0.1, (stamp - clock.last) / 1000) / slowness();
    clock.last = stamp;
    draw();
    requestAnimationFrame(frame);
  };
  const play = (wanted) => {
    clock.playing = wanted;
    clock.last = 0;
    $("play").setAttribute("aria-pressed", String(wanted));
    $("play").textContent = wanted ? "Pause" : "Play";
    if (wanted) requestAnimationFrame(frame);
  };

  // ---- Pictures.
  let colours = {};
  const recolour = () => {
    const style = getComputedStyle(document.documentElement);
    for (const name of ["paper", "ink", "soft", "line", "one", "other", "wall", "edge", "count"]) colours[name] = style.getPropertyValue(`--${name}`).trim();
  };
  const sizes = new Map();
  const canvas = (id) => {
    let known = sizes.get(id);
    if (!known) {
      const node = $(id), scale = Math.min(devicePixelRatio || 1, 2);
      known = { node, context: node.getContext("2d"), width: node.clientWidth, height: node.clientHeight, scale };
      node.width = Math.max(1, Math.round(known.width * scale));
      node.height = Math.max(1, Math.round(known.height * scale));
      sizes.set(id, known);
    }
    const { context, scale, width, height } = known;
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = "11px system-ui, sans-serif";
    context.lineJoin = "round";
    return known;
  };
  const POINTS = 320;
  const trace = { one: null, other: null };
  // Angle, speed and torque over the window that ends now.
  const sample = (name) => {
    const result = results[name];
    const kept = (trace[name] ||= { t: new Float64Array(POINTS), angle: new Float64Array(POINTS), speed: new Float64Array(POINTS), torque: new Float64Array(POINTS) });
    const end = timeOf(name), wide = windowOf(), first = Math.max(0, end - wide);
    kept.first = end - wide;
    kept.end = end;
    for (let i = 0; i < POINTS; i += 1) {
      const t = first + ((end - first) * i) / (POINTS - 1), now = Knob.at(result, t / result.cell.period);
      kept.t[i] = t;
      kept.angle[i] = now.angle;
      kept.speed[i] = now.speed;
      kept.torque[i] = now.torque;
    }
    return kept;
  };
  // What the encoder shows from sample to sample in the window, rad; null where samples are too many to be drawn.
  const readings = (name) => {
    const kept = trace[name], { cell, scene: of } = results[name];
    const begin = Math.max(0, Math.floor(kept.first / cell.period)), finish = Math.floor(kept.end / cell.period), found = [];
    if (finish - begin > 400) return null;
    for (let i = begin; i <= finish; i += 1) {
      const x = Knob.at(results[name], i + 1e-9).angle / cell.quantum - cell.shift;
      found.push(((cell.truncate && x > 0 ? Math.floor(x) : cell.sense * Math.floor(cell.sense * x)) + (of.offset || 0)) * cell.quantum);
    }
    return { begin, shows: found };
  };
  // One range for both knobs, so that they compare; it follows what is seen, smoothly.
  let ranges = {};
  const rangeOf = (what, least) => {
    let low = Infinity, high = -Infinity;
    for (const name of ["one", "other"]) {
      if (!results[name].cell) continue;
      for (const value of trace[name][what] || []) { if (value < low) low = value; if (value > high) high = value; }
    }
    const middle = 0.5 * (low + high), half = Math.max(0.62 * (high - low), least);
    const wanted = [middle - half, middle + half], now = ranges[what];
    if (!now) return (ranges[what] = wanted);
    const part = clock.playing ? 0.12 : 1;
    return (ranges[what] = [now[0] + part * (wanted[0] - now[0]), now[1] + part * (wanted[1] - now[1])]);
  };
  const ticks = (low, high, about) => {
    const raw = (high - low) / about, power = 10 ** Math.floor(Math.log10(raw)), part = raw / power;
    const step = (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10) * power, found = [];
    for (let i = Math.ceil(low / step); i * step <= high && found.length < 12; i += 1) found.push(i * step);
    return found;
  };
  const LEFT = 46, BOTTOM = 16;
  const edgesIn = (cell, low, high) => { // angles of count edges
    const found = [], first = Math.ceil(low / cell.quantum - cell.shift), last = Math.floor(high / cell.quantum - cell.shift);
    if (last - first > 60) return null;
    for (let i = first; i <= last; i += 1) found.push((i + cell.shift) * cell.quantum);
    return found;
  };
  const axes = (at, wide, high, ySay, yTicks, yOf, xTicks, xOf, xSay) => {
    at.fillStyle = colours.soft;
    at.textAlign = "right";
    at.textBaseline = "middle";
    for (const tick of yTicks) {
      const y = yOf(tick); // what stands in the corners is the unit
      if (y > 17 && y < high - BOTTOM - 3) at.fillText(ySay(tick), LEFT - 5, y);
    }
    at.textAlign = "center";
    at.textBaseline = "bottom";
    for (const tick of xTicks) {
      const x = xOf(tick);
      if (x > LEFT + 12 && x < wide - 14) at.fillText(xSay(tick), x, high - 1);
    }
  };
  const line = (at, xs, ys, colour, width) => {
    at.strokeStyle = colour;
    at.lineWidth = width;
    at.beginPath();
    for (let i = 0; i < POINTS; i += 1) { if (i) at.lineTo(xs(i), ys(i)); else at.moveTo(xs(i), ys(i)); }
    at.stroke();
  };
  const drawAngle = (name, low, high) => {
    const { context: at, width: wide, height } = canvas(`${name}-angle`), kept = trace[name], { cell } = results[name];
    const bottom = height - BOTTOM, yOf = (angle) => bottom - ((angle - low) / (high - low)) * bottom;
    const xOf = (t) => LEFT + ((t - kept.first) / (kept.end - kept.first)) * (wide - LEFT - 8);
    const wallTop = Math.max(0, Math.min(bottom, yOf(0)));
    at.fillStyle = colours.wall;
    at.fillRect(LEFT, wallTop, wide - LEFT, bottom - wallTop);
    const edges = edgesIn(cell, low, high);
    at.strokeStyle = colours.edge;
    at.lineWidth = 1;
    at.beginPath();
    for (const edge of edges || []) { at.moveTo(LEFT, yOf(edge)); at.lineTo(wide, yOf(edge)); }
    at.stroke();
    if (low < 0 && high > 0) {
      at.strokeStyle = colours.soft;
      at.beginPath();
      at.moveTo(LEFT, yOf(0));
      at.lineTo(wide, yOf(0));
      at.stroke();
      at.fillStyle = colours.soft;
      at.textAlign = "left";
      at.textBaseline = "bottom";
      at.fillText("inside the wall", LEFT + 4, bottom - 2);
    }
    // What the encoder shows, held from sample to sample.
    at.save();
    at.beginPath();
    at.rect(LEFT, 0, wide - LEFT, bottom);
    at.clip();
    if (kept.seen) {
      at.strokeStyle = colours.count;
      at.lineWidth = 1.25;
      at.beginPath();
      kept.seen.shows.forEach((angle, i) => {
        const from = (kept.seen.begin + i) * cell.period, y = yOf(angle);
        at.lineTo(Math.max(LEFT, xOf(from)), y);
        at.lineTo(xOf(Math.min(from + cell.period, kept.end)), y);
      });
      at.stroke();
    }
    at.restore();
    line(at, (i) => xOf(kept.t[i]), (i) => yOf(kept.angle[i]), colours[name], 2);
    at.fillStyle = colours[name];
    at.beginPath();
    at.arc(xOf(kept.end), yOf(kept.angle[POINTS - 1]), 4, 0, 7);
    at.fill();
    const step = ticks(0, 1e3 * (kept.end - kept.first), 5);
    axes(at, wide, height, (v) => short(v, 3), ticks(1e3 * low, 1e3 * high, 5), (v) => yOf(v / 1e3), step.slice(1), (v) => xOf(kept.end - v / 1e3), (v) => `−${short(v, 3)} ms`);
    at.textAlign = "left";
    at.textBaseline = "top";
    at.fillStyle = colours.soft;
    at.fillText("mrad", 2, 2);
  };
  const drawTorque = (name, low, high) => {
    const { context: at, width: wide, height } = canvas(`${name}-torque`), kept = trace[name];
    const bottom = height - BOTTOM, yOf = (torque) => bottom - 3 - ((torque - low) / (high - low)) * (bottom - 6);
    const xOf = (t) => LEFT + ((t - kept.first) / (kept.end - kept.first)) * (wide - LEFT - 8);
    at.strokeStyle = colours[name];
    at.lineWidth = 1.5;
    at.beginPath();
    for (let i = 0; i < POINTS; i += 1) {
      const x = xOf(kept.t[i]);
      if (i && kept.torque[i] !== kept.torque[i - 1]) at.lineTo(x, yOf(kept.torque[i - 1]));
      at.lineTo(x, yOf(kept.torque[i]));
    }
    at.stroke();
    axes(at, wide, height, (v) => short(v, 3), ticks(1e3 * low, 1e3 * high, 3), (v) => yOf(v / 1e3), [], xOf, () => "");
    at.textAlign = "left";
    at.textBaseline = "top";
    at.fillText("mN·m", 2, 2);
  };
  const drawPlane = (name, [low, high], [slow, fast]) => {
    const { context: at, width: wide, height } = canvas(`${name}-plane`), kept = trace[name], { cell } = results[name];
    const bottom = height - BOTTOM, xOf = (angle) => LEFT + ((angle - low) / (high - low)) * (wide - LEFT);
    const yOf = (speed) => bottom - ((speed - slow) / (fast - slow)) * bottom;
    at.save();
    at.beginPath();
    at.rect(LEFT, 0, wide - LEFT, bottom);
    at.clip();
    if (low < 0) {
      at.fillStyle = colours.wall;
      at.fillRect(LEFT, 0, xOf(Math.min(0, high)) - LEFT, bottom);
    }
    at.strokeStyle = colours.edge;
    at.lineWidth = 1;
    at.beginPath();
    for (const edge of edgesIn(cell, low, high) || []) { at.moveTo(xOf(edge), 0); at.lineTo(xOf(edge), bottom); }
    at.moveTo(LEFT, yOf(0));
    at.lineTo(wide, yOf(0));
    at.stroke();
    line(at, (i) => xOf(kept.angle[i]), (i) => yOf(kept.speed[i]), colours[name], 1.5);
    at.fillStyle = colours[name];
    at.beginPath();
    at.arc(xOf(kept.angle[POINTS - 1]), yOf(kept.speed[POINTS - 1]), 4.5, 0, 7);
    at.fill();
    at.restore();
    axes(at, wide, height, (v) => short(v, 2), ticks(slow, fast, 4), yOf, ticks(1e3 * low, 1e3 * high, 4), (v) => xOf(v / 1e3), (v) => short(v, 3));
    at.textAlign = "left";
    at.textBaseline = "bottom";
    at.fillText("mrad", 2, height - 1);
    at.textBaseline = "top";
    at.fillText("rad/s", 2, 2);
  };
  const drawDial = (name, [low, high]) => {
    const { context: at, width: wide, height } = canvas(`${name}-dial`), kept = trace[name], { cell } = results[name];
    const x = wide / 2, y = height / 2 + 4, radius = Math.min(wide, height) / 2 - 14;
    const times = Math.max(1, 1.1 / Math.max(high - low, 1e-12)), nice = Number(times.toPrecision(1));
    $(`${name}-times`).textContent = short(nice, 1);
    const middle = 0.5 * (low + high), up = (angle) => -Math.PI / 2 - (angle - middle) * nice;
    const sector = (from, to, colour) => {
      at.fillStyle = colour;
      at.beginPath();
      at.moveTo(x, y);
      at.arc(x, y, radius + 11, up(from), up(to));
      at.closePath();
      at.fill();
    };
    if (low < 0) sector(Math.min(0, high + (high - low)), low - 0.3 * (high - low), colours.wall);
    at.strokeStyle = colours.count;
    at.lineWidth = 1;
    at.beginPath();
    for (const edge of edgesIn(cell, low, high) || []) {
      at.moveTo(x + (radius + 3) * Math.cos(up(edge)), y + (radius + 3) * Math.sin(up(edge)));
      at.lineTo(x + (radius + 10) * Math.cos(up(edge)), y + (radius + 10) * Math.sin(up(edge)));
    }
    at.stroke();
    const now = up(kept.angle[POINTS - 1]);
    at.fillStyle = colours.paper;
    at.strokeStyle = colours.soft;
    at.lineWidth = 2;
    at.beginPath();
    at.arc(x, y, radius, 0, 7);
    at.fill();
    at.stroke();
    at.strokeStyle = colours.line;
    at.lineWidth = 2;
    at.beginPath();
    for (let i = 0; i < 36; i += 1) { // the grip turns with it
      const a = now + (i * Math.PI) / 18;
      at.moveTo(x + (radius - 5) * Math.cos(a), y + (radius - 5) * Math.sin(a));
      at.lineTo(x + (radius - 1) * Math.cos(a), y + (radius - 1) * Math.sin(a));
    }
    at.stroke();
    at.strokeStyle = colours[name];
    at.lineWidth = 4;
    at.lineCap = "round";
    at.beginPath();
    at.moveTo(x + 0.25 * radius * Math.cos(now), y + 0.25 * radius * Math.sin(now));
    at.lineTo(x + 0.9 * radius * Math.cos(now), y + 0.9 * radius * Math.sin(now));
    at.stroke();
    at.lineCap = "butt";
  };
  const draw = () => {
    const names = ["one", "other"].filter((name) => results[name].cell);
    if (!names.length) return;
    for (const name of names) {
      const kept = sample(name);
      kept.seen = readings(name);
      kept.both = kept.seen ? [...kept.seen.shows, ...kept.angle] : kept.angle;
    }
    const quantum = Math.max(...names.map((name) => results[name].cell.quantum));
    const angle = rangeOf("angle", 0.6 * quantum), speed = rangeOf("speed", 1e-6);
    const both = rangeOf("both", 0.6 * quantum), torque = rangeOf("torque", 0.6 * Math.max(...names.map((name) => results[name].scene.stiffness * results[name].cell.quantum)));
    for (const name of names) {
      drawAngle(name, ...both);
      drawTorque(name, ...torque);
      drawPlane(name, angle, speed);
      drawDial(name, angle);
    }
  };

  // ---- Sound: the knob's speed over whole periods, both amplified alike, so that the larger one fills half the scale.
  let audio = null, playing = { name: "", source: null, gain: null };
  const clip = (result) => {
    const { cell, period, kept } = result, span = period * cell.period, rate = audio.sampleRate;
    const many = Math.max(1, Math.round(1 / span)), length = Math.max(2, Math.round(many * span * rate)), wave = new Float32Array(length);
    let peak = 0;
    for (let i = 0; i < length; i += 1) {
      wave[i] = Knob.at(result, kept + (period * many * i) / length).speed;
      peak = Math.max(peak, Math.abs(wave[i]));
    }
    return { wave, peak };
  };
  const silence = () => {
    if (playing.source) {
      playing.gain.gain.setTargetAtTime(0, audio.currentTime, 0.02);
      playing.source.stop(audio.currentTime + 0.15);
    }
    playing = { name: "", source: null, gain: null };
    for (const name of ["one", "other"]) {
      $(`${name}-hear`).setAttribute("aria-pressed", "false");
      $(`${name}-hear`).textContent = "Hear it";
    }
  };
  const sound = (name) => {
    silence();
    if (results[name].outcome !== "cycle") return;
    audio ||= new AudioContext();
    audio.resume();
    const clips = Object.fromEntries(["one", "other"].filter((one) => results[one].outcome === "cycle").map((one) => [one, clip(results[one])]));
    const loudest = Math.max(...Object.values(clips).map((one) => one.peak)), { wave } = clips[name];
    const buffer = audio.createBuffer(1, wave.length, audio.sampleRate), channel = buffer.getChannelData(0);
    for (let i = 0; i < wave.length; i += 1) channel[i] = (0.5 * wave[i]) / loudest;
    const source = audio.createBufferSource(), gain = audio.createGain();
    source.buffer = buffer;
    source.loop = true;
    gain.gain.setValueAtTime(0, audio.currentTime);
    gain.gain.setTargetAtTime(1, audio.currentTime, 0.03);
    source.connect(gain).connect(audio.destination);
    source.start();
    playing = { name, source, gain };
    $(`${name}-hear`).setAttribute("aria-pressed", "true");
    $(`${name}-hear`).textContent = "Stop";
  };
  let soundLater = 0;
  const resound = () => {
    if (!playing.name) return;
    clearTimeout(soundLater);
    soundLater = setTimeout(() => playing.name && sound(playing.name), 150);
  };

  // ---- Beginning.
  const begin = (number) => {
    scene = structuredClone(data.cells[number].scene);
    numbers = {};
    sceneSliders();
    controllerSliders();
    if (scene.controller && scene.controller.kind === remedy) remedy = remedy === "bounded_lag" ? "virtual_damping" : "bounded_lag";
    remedySliders();
    compute();
  };
  $("controller").append(element("option", { value: "" }, "plain wall"), ...Object.entries(Choices.CONTROLLERS).map(([value, one]) => element("option", { value }, one.label)));
  $("remedy").append(...Object.entries(Choices.REMEDIES).map(([value, one]) => element("option", { value }, one.label)));
  $("cells").append(...data.cells.map((cell, value) => element("option", { value }, cell.label)));
  $("cells-label").hidden = data.cells.length < 2;
  $("cells").addEventListener("change", () => begin(Number($("cells").value)));
  $("reset").addEventListener("click", () => begin(Number($("cells").value)));
  $("controls").addEventListener("submit", (event) => event.preventDefault());
  $("controller").addEventListener("change", () => {
    const kind = $("controller").value;
    scene.controller = kind ? { kind, ...Choices.CONTROLLERS[kind].from(scene) } : null;
    controllerSliders();
    later();
  });
  $("rounding").addEventListener("change", () => { scene.rounding = $("rounding").value; later(); });
  $("remedy").addEventListener("change", () => { remedy = $("remedy").value; remedySliders(); later(); });
  $("play").addEventListener("click", () => play(!clock.playing));
  $("again").addEventListener("click", () => {
    clock.from = { one: 0, other: 0 };
    clock.now = 0;
    ranges = {};
    play(true);
  });
  $("speed").value = 50;
  $("speed").addEventListener("input", showSpeed);
  for (const name of ["one", "other"]) $(`${name}-hear`).addEventListener("click", () => (playing.name === name ? silence() : sound(name)));
  $("which").addEventListener("change", writeSpec);
  $("copy").addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText($("spec").textContent);
      $("copied").textContent = "Copied.";
    } catch {
      getSelection().selectAllChildren($("spec"));
      $("copied").textContent = "Selected: copy it with the keyboard.";
    }
  });
  new ResizeObserver(() => { sizes.clear(); if (results.one) draw(); }).observe($("show"));
  dark.addEventListener("change", () => { recolour(); draw(); });
  document.addEventListener("visibilitychange", () => { clock.last = 0; if (document.hidden) silence(); });
  recolour();
  begin(0);
  if (!still.matches) play(true);
})();
