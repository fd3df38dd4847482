// Sound: the knob's speed over whole periods, both amplified alike, so that the larger one fills half the scale.
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
const HEAR = { one: $("one-hear").textContent, other: $("other-hear").textContent };
const silence = () => {
  if (playing.source) {
    playing.gain.gain.setTargetAtTime(0, audio.currentTime, 0.02);
    playing.source.stop(audio.currentTime + 0.15);
  }
  playing = { name: "", source: null, gain: null };
  for (const name of ["one", "other"]) {
    $(`${name}-hear`).setAttribute("aria-pressed", "false");
    $(`${name}-hear`).textContent = HEAR[name];
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
