// The drawings: angle and torque over time, speed over angle, the knob itself.
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
