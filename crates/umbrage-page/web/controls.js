// Mouse, keyboard, touch and the panel; and the view as part of the address, so that it survives and can be shared.

const element = (id) => document.getElementById(id);
const aspect = () => canvas.clientWidth / canvas.clientHeight;
const around = () => document.querySelector("[name=mode]:checked").value === "orbit";
const STEP = 5 * DEGREE;

// Units of irradiance: name, and how many of it are 1 in the file.
const UNITS = { w: ["W/m\u00b2", 1], lx: ["lx", about.lumensPerWatt], photometric: ["lx", 1] };
const unit = () => UNITS[element("unit").value];
// What is photometric has no other unit.
if (about.photometric) {
  element("unit").value = "photometric";
  for (const option of [...element("unit").options]) if (option.value !== "photometric") option.remove();
}
const short = (x) => String(Number(x.toPrecision(3)));

// --- pointers ---

const pointers = new Map();
let moved = 0;

canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  if (pointers.size === 1) moved = 0;
});
canvas.addEventListener("pointermove", (event) => {
  const last = pointers.get(event.pointerId);
  if (!last) return;
  const next = [event.clientX, event.clientY];
  const [dx, dy] = add(next, last, -1);
  moved += Math.abs(dx) + Math.abs(dy);
  if (pointers.size === 1) {
    if (event.shiftKey || event.buttons & 6) slide(dx, dy);
    else {
      // The scene follows the hand: around it, the eye goes the other way; in it, the view does.
      const angle = (around() ? 0.4 : -0.2) * DEGREE;
      turn(angle * dx, -angle * dy, around());
    }
  } else if (pointers.size === 2) {
    const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    const [before, after] = [last, next].map((at) => span(add(at, other, -1)));
    if (before > 0 && after > 0) approach(before / after);
    slide(dx / 2, dy / 2);
  }
  pointers.set(event.pointerId, next);
  redraw();
});
function release(event) {
  if (!pointers.delete(event.pointerId)) return;
  if (event.type === "pointerup" && pointers.size === 0 && moved < 5) tell(event);
  remember();
}
canvas.addEventListener("pointerup", release);
canvas.addEventListener("pointercancel", release);
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  const lines = event.deltaY * (event.deltaMode === 1 ? 16 : 1);
  approach(Math.exp(Math.max(-200, Math.min(200, lines)) * 0.0015));
  remember();
  redraw();
}, { passive: false });

// Moves what is in the middle along with the pointer.
function slide(dx, dy) {
  const metres = (2 * camera.distance * Math.tan((camera.fov * DEGREE) / 2)) / canvas.clientHeight;
  move(-dx * metres, dy * metres, 0);
}

function picked(event) {
  const x = (2 * event.clientX) / canvas.clientWidth - 1;
  return pick(x, 1 - (2 * event.clientY) / canvas.clientHeight, aspect());
}

function tell(event) {
  const hit = picked(event);
  const [name, factor] = unit();
  element("status").textContent = hit ? `Irradiance here: ${short(hit.irradiance * factor)} ${name}` : "";
}

canvas.addEventListener("dblclick", (event) => {
  const hit = picked(event);
  if (!hit) return;
  look(camera.eye, hit.point, [0, 0, -1]);
  remember();
  redraw();
});

// --- keys ---

const WALK = { w: [0, 0, 1], s: [0, 0, -1], a: [-1, 0, 0], d: [1, 0, 0], q: [0, -1, 0], e: [0, 1, 0] };
const held = new Set();
let lastTime = null;
let fast = false;

const STEPS = {
  left: () => turn(-STEP, 0, around()),
  right: () => turn(STEP, 0, around()),
  up: () => turn(0, STEP, around()),
  down: () => turn(0, -STEP, around()),
  nearer: () => approach(0.9),
  farther: () => approach(1 / 0.9),
  fit: () => start(Number(element("camera").value || 0), aspect()),
};
const KEYS = {
  ArrowLeft: "left", ArrowRight: "right", ArrowUp: "up", ArrowDown: "down",
  "+": "nearer", "=": "nearer", "-": "farther", Home: "fit", f: "fit",
};

function step(name) {
  STEPS[name]();
  remember();
  redraw();
}

window.addEventListener("keydown", (event) => {
  // Keys belong to the view unless a control has the focus.
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (document.activeElement !== canvas && document.activeElement !== document.body) return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  fast = event.shiftKey;
  if (WALK[key]) held.add(key);
  else if (KEYS[key]) step(KEYS[key]);
  else return;
  event.preventDefault();
  redraw();
});
window.addEventListener("keyup", (event) => {
  fast = event.shiftKey;
  if (held.delete(event.key.toLowerCase()) && held.size === 0) remember();
});
window.addEventListener("blur", () => held.clear());

// Walks as long as keys are held: through the scene in about eight seconds. Tells whether it goes on.
function walk(now) {
  if (held.size === 0) {
    lastTime = null;
    return false;
  }
  const seconds = lastTime === null ? 0 : Math.min((now - lastTime) / 1000, 0.1);
  lastTime = now;
  const metres = (seconds * diagonal * (fast ? 3 : 1)) / 8;
  for (const key of held) move(...WALK[key].map((x) => x * metres));
  return true;
}

// --- panel ---

for (const button of document.querySelectorAll("[data-step]")) {
  button.addEventListener("click", () => step(button.dataset.step));
}
element("form").addEventListener("submit", (event) => event.preventDefault());
element("camera").addEventListener("change", () => step("fit"));
for (const id of ["show", "exposure", "filmic", "wire", "unit", "scale-end"]) {
  element(id).addEventListener("input", (event) => {
    if (id === "unit") element("scale-end").value = short(shown.scaleEnd * unit()[1]);
    update();
    if (event.isTrusted) remember();
  });
}

const SHOWN = ["picture", "light", "irradiance"];

// From the controls to what is drawn.
function update() {
  shown.show = SHOWN.indexOf(element("show").value);
  shown.exposure = 2 ** Number(element("exposure").value);
  shown.filmic = element("filmic").checked;
  shown.wire = element("wire").checked;
  const [name, factor] = unit();
  const end = Number(element("scale-end").value);
  if (end > 0) shown.scaleEnd = end / factor;
  element("exposure-value").textContent = `\u00d7${shown.exposure.toPrecision(2)}`;
  element("exposure").setAttribute("aria-valuetext", `${shown.exposure.toPrecision(2)} times`);
  element("legend").hidden = shown.show !== 2;
  element("exposure").disabled = element("filmic").disabled = shown.show === 2;
  const ticks = [0, 0.25, 0.5, 0.75, 1].map((share) => short(share * shown.scaleEnd * factor));
  element("ticks").replaceChildren(...ticks.map((text, i) => {
    const tick = document.createElement("span");
    tick.textContent = i === 4 ? `${text} ${name}` : text;
    return tick;
  }));
  redraw();
}

// --- the view in the address ---

const list = (numbers) => numbers.map((x) => Number(x.toPrecision(7))).join(",");

function remember() {
  const words = new URLSearchParams();
  words.set("eye", list(add(camera.eye, about.origin)));
  words.set("target", list(add(target(), about.origin)));
  words.set("fov", camera.fov.toPrecision(6));
  if (shown.exposure !== 1) words.set("exposure", shown.exposure.toPrecision(6));
  if (shown.filmic) words.set("tone", "filmic");
  if (shown.show) words.set("show", SHOWN[shown.show]);
  if (shown.wire) words.set("wire", "1");
  if (shown.show === 2) {
    words.set("end", String(Number((shown.scaleEnd * unit()[1]).toPrecision(6))));
    words.set("unit", element("unit").value);
  }
  // Some browsers forbid it where pages lie on a disk.
  try { history.replaceState(null, "", "#" + words.toString().replaceAll("%2C", ",")); } catch { /* not remembered */ }
}

function recall() {
  const words = new URLSearchParams(location.hash.slice(1));
  const point = (name) => {
    const numbers = (words.get(name) ?? "").split(",").map(Number);
    return numbers.length === 3 && numbers.every(Number.isFinite) ? numbers : null;
  };
  const number = (name) => {
    const value = Number(words.get(name) ?? NaN);
    return value > 0 && Number.isFinite(value) ? value : null;
  };
  const [eye, at] = [point("eye"), point("target")];
  if (eye && at) look(add(eye, about.origin, -1), add(at, about.origin, -1), point("up") ?? [0, 0, -1]);
  camera.fov = Math.min(number("fov") ?? camera.fov, 179);
  element("exposure").value = Math.log2(number("exposure") ?? 1);
  element("filmic").checked = words.get("tone") === "filmic";
  element("wire").checked = words.get("wire") === "1";
  if (SHOWN.includes(words.get("show"))) element("show").value = words.get("show");
  if (UNITS[words.get("unit")] && !about.photometric) element("unit").value = words.get("unit");
  element("scale-end").value = number("end") ?? short(shown.scaleEnd * unit()[1]);
  update();
}

// --- begin ---

element("bar").style.background =
  `linear-gradient(to right, ${about.scale.map((code) => `rgb(${code.join(" ")})`).join(", ")})`;
element("facts").replaceChildren(...about.facts.flatMap(([name, value]) => {
  const [term, told] = [document.createElement("dt"), document.createElement("dd")];
  term.textContent = name;
  told.textContent = value;
  return [term, told];
}));
element("camera").replaceChildren(...about.cameras.map(({ name }, number) => new Option(name, number)));
element("camera-row").hidden = about.cameras.length < 2;
// Where there is little room, the panel would hide the scene.
if (window.innerWidth < 1000) element("controls").open = false;

if (!gl) {
  fail("This page needs WebGL 2, which this browser or its graphics driver does not offer.");
} else {
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => { prepare(); redraw(); });
  prepare();
  start(0, aspect());
  recall();
  window.addEventListener("hashchange", recall);
  new ResizeObserver(resize).observe(canvas);
  resize();
}
