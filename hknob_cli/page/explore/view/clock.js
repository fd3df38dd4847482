// Time: seconds since each first sample. `clock.from` are the times at which the two pictures began.
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
