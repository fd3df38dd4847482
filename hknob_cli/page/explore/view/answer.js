// From the scene to both results, and to words.
const solve = (what, samples) => {
  try { return Knob.solve(what, { samples }); } catch (error) {
    if (error instanceof RangeError) return { outcome: "wrong", why: error.message, scene: what };
    throw error;
  }
};
const isHeavy = (result) => result.outcome === "cycle" && data.touch.high * result.period * result.cell.period * result.pieces.length > HEAVY;
const touchOf = (result) => {
  if (result.touch === undefined && hurried && isHeavy(result)) return null;
  if (result.touch === undefined) result.touch = result.outcome === "cycle" ? Knob.touchLevel(result, data.touch) : null;
  return result.touch;
};
const feltWords = (result) => {
  const touch = touchOf(result);
  if (!touch && result.touch === undefined) return "";
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
  if (hurried) return `${n} has not settled yet: looking further.`;
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

let waiting = 0, rest = 0;
const later = () => { waiting ||= requestAnimationFrame(() => compute()); };
const compute = () => {
  waiting = 0;
  clearTimeout(rest);
  followScene();
  const changed = { ...scene, start: { ...scene.start } };
  const other = Choices.REMEDIES[remedy].change(changed, valuesOf(remedy));
  results = { one: solve(changed, AT_ONCE), other: solve(other, AT_ONCE) };
  hurried = Object.values(results).some((one) => one.outcome === "undecided" || isHeavy(one));
  fill();
  rest = setTimeout(finish, MOMENT_MS);
  toCycle();
  resound();
};

// A moment after the last change: what takes longer, and a word to those who listen to the page.
const finish = () => {
  if (hurried) {
    hurried = false;
    for (const [name, one] of Object.entries(results)) if (one.outcome === "undecided") results[name] = solve(one.scene, MOST);
    fill();
    toCycle();
  }
  $("told").textContent = `${$("said").textContent} ${$("said-other").textContent}`;
};
