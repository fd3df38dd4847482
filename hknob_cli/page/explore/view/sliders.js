// The scene that the sliders show, and the numbers of remedies that were moved, by name; others follow from the scene.
let scene = null, remedy = "bounded_lag", numbers = {}, results = {}, hurried = false;
const get = (from, key) => key.split(".").reduce((part, name) => (part ? part[name] : 0), from);
const set = (into, key, value) => {
  const names = key.split("."), last = names.pop();
  let part = into;
  for (const name of names) part = part[name] = { ...part[name] };
  part[last] = value;
};
const valuesOf = (kind) => (numbers[kind] || Choices.REMEDIES[kind].from(scene));

// Sliders: a range and a number, both of the same value.
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
    number.value = text;
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
  number.addEventListener("change", () => { number.removeAttribute("aria-invalid"); show(); });
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
let remedyShown = [];
const remedySliders = () => {
  $("remedy").value = remedy;
  $("remedy-sliders").replaceChildren();
  remedyShown = Choices.REMEDIES[remedy].sliders.map((one) => addSlider(
    $("remedy-sliders"), one, () => valuesOf(remedy)[one.key], (value) => {
      numbers[remedy] = { ...valuesOf(remedy), [one.key]: value };
    },
  ));
};
const followScene = () => { if (!numbers[remedy]) for (const show of remedyShown) show(); };
