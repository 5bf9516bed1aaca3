// The view: pointers, wheel and keys move it, the value under the pointer is shown.
"use strict";

/** Motion of an arrow key, as a part of the view's width [1]. */
const KEY_STEP = 0.03;

const pointers = new Map();
const part = (x, y) => [x / canvas.clientWidth, y / canvas.clientHeight];

canvas.onpointerdown = (event) => {
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
};
canvas.onpointerup = canvas.onpointercancel = (event) => pointers.delete(event.pointerId);
canvas.onpointermove = (event) => {
  const last = pointers.get(event.pointerId);
  if (!last) return probe(event);
  const across = canvas.clientWidth;
  const moved = [(event.clientX - last[0]) / across, (event.clientY - last[1]) / across];
  if (pointers.size === 2) {
    const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
    const apart = ([x, y]) => Math.hypot(x - other[0], y - other[1]);
    act(["approach", apart(last) / Math.max(apart([event.clientX, event.clientY]), 1)], ["pan", moved[0] / 2, moved[1] / 2]);
  } else {
    const method = event.shiftKey || event.buttons & 6 ? "pan" : event.ctrlKey ? "look" : "orbit";
    act([method, ...moved]);
  }
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
};
canvas.oncontextmenu = (event) => event.preventDefault();
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  act([event.ctrlKey ? "widen" : "approach", Math.exp(event.deltaY / 600)]);
}, { passive: false });
const KEYS = {
  ArrowLeft: ["orbit", -KEY_STEP, 0], ArrowRight: ["orbit", KEY_STEP, 0], ArrowUp: ["orbit", 0, -KEY_STEP], ArrowDown: ["orbit", 0, KEY_STEP],
  "+": ["approach", 0.9], "=": ["approach", 0.9], "-": ["approach", 1 / 0.9],
  w: ["fly", 0, 0, 0.1], s: ["fly", 0, 0, -0.1], a: ["fly", -0.1, 0, 0], d: ["fly", 0.1, 0, 0], e: ["fly", 0, 0.1, 0], q: ["fly", 0, -0.1, 0], h: ["home"],
};
canvas.onkeydown = (event) => {
  const step = KEYS[event.key];
  if (!step || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  act(step);
};
document.onkeydown = (event) => {
  if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z" || /^(INPUT|TEXTAREA)$/.test(event.target.tagName)) return;
  event.preventDefault();
  act([event.shiftKey ? "redo" : "undo"]);
};
new ResizeObserver(() => { if (state) act(["rest"]); }).observe($("view"));

let isProbing = false;
async function probe(event) {
  if (isProbing || !shown || isRunning || shownBy.isBusy) return;
  isProbing = true;
  const box = canvas.getBoundingClientRect();
  try {
    const found = await shownBy.call([["probe", ...part(event.clientX - box.left, event.clientY - box.top)]]);
    const values = found.bands.map(({ name, value }) => `${name} ${value.toExponential(2)}`).join("   ");
    const depth = found.depth === null ? found.failure || "" : `A(V) ${(1.0857 * found.depth).toPrecision(3)} mag`;
    $("probe").textContent = `${values} ${found.unit}   ${depth}`;
    draw(found);
  } catch (error) {
    $("probe").textContent = error.message;
  }
  isProbing = false;
}

/** Spectrum at the pointer over wavelength. */
function draw({ wavelengths, continuum }) {
  const plot = $("spectrum");
  const pen = plot.getContext("2d");
  plot.hidden = !continuum.some((value) => value > 0);
  pen.clearRect(0, 0, plot.width, plot.height);
  const top = Math.max(...continuum) || 1;
  const [low, high] = [wavelengths[0], wavelengths.at(-1)];
  pen.strokeStyle = "#7fb2ff";
  pen.beginPath();
  wavelengths.forEach((w, i) => pen.lineTo(((w - low) / (high - low)) * plot.width, plot.height - 16 - (continuum[i] / top) * (plot.height - 20)));
  pen.stroke();
  pen.fillStyle = "#9aa0b0";
  pen.font = "11px system-ui";
  pen.fillText(`${low.toFixed(2)} µm`, 2, plot.height - 3);
  pen.textAlign = "right";
  pen.fillText(`${high.toFixed(2)} µm`, plot.width - 2, plot.height - 3);
  pen.textAlign = "left";
}
