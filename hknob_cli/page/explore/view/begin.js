// Beginning.
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
