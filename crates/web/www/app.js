// The page of the explorer: pictures, settings, timeline. All pictures, checks and numbers come from two workers (worker.js): `quick`
// while things move, `fine` for the picture that `barnard render` makes.
"use strict";

const canvas = $("canvas");
const context = canvas.getContext("2d");

/** Time without change after which the final picture is begun [ms]. */
const REST = 350;

let module, quick, fine, fineName = null;
/** Requested device: "cpu", "webgpu" (also in software), or null for a graphics processor if there is one. */
let device = null;
let state = null;
/** Files that scenes may name, as steps of a worker. */
const files = [];
/** Source of the scene: [method, arguments] of the worker. */
let opened = null;
/** Number of the latest change: answers to earlier ones are dropped. */
let change = 0;
let shown = null;
let shownBy = null;

// Pictures.

/** Width and height of pictures: the scene's own frame, as large as fits. */
function size() {
  const scale = Math.min(window.devicePixelRatio || 1, 2);
  const [width, height] = state?.size || [16, 9];
  $("view").style.setProperty("--aspect", width / height);
  const box = $("view").getBoundingClientRect();
  const fitted = Math.min(box.width / width, box.height / height);
  const edges = [width, height].map((edge) => Math.max(24, Math.round(edge * fitted)));
  [canvas.style.width, canvas.style.height] = edges.map((edge) => `${edge}px`);
  return edges.map((edge) => Math.round(edge * scale));
}

function paint(picture, by) {
  const [width, height] = size();
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const layer = (w, h, pixels) => {
    const own = new OffscreenCanvas(w, h);
    own.getContext("2d").putImageData(new ImageData(pixels, w, h), 0, 0);
    return own;
  };
  context.imageSmoothingEnabled = true;
  context.imageSmoothingQuality = "high";
  context.drawImage(layer(picture.width, picture.height, picture.pixels), 0, 0, width, height);
  if (picture.sparks) context.drawImage(layer(...picture.sparks), 0, 0, width, height);
  if (picture.quality === "final") $("preview")?.remove();
  shown = picture;
  shownBy = by;
  canvas.dataset.quality = picture.quality;
  canvas.dataset.pictures = Number(canvas.dataset.pictures || 0) + 1;
  tell({ quality: picture.quality });
  status(`${picture.quality}, ${picture.width} × ${picture.height}, ${picture.seconds.toFixed(2)} s, ${picture.backend}`);
}

const status = (words) => { $("status").textContent = words; };

function progress(stage, share) {
  $("bar").hidden = false;
  $("bar-done").style.width = `${100 * share}%`;
  status(`${stage} ${Math.round(100 * share)} %`);
}

let pending = [];
let isRunning = false;
let rest = 0;

/** Has steps done by the quick worker, and its picture shown. Steps add up while it is busy. */
function act(...steps) {
  // A packed scene shows its preview until the first change, or the final picture.
  if (steps.some(([method]) => method !== "state" && method !== "rest")) $("preview")?.remove();
  pending.push(...steps);
  change += 1;
  clearTimeout(rest);
  stopFine();
  run();
}

async function run() {
  if (isRunning) return;
  isRunning = true;
  while (pending.length) {
    const steps = pending;
    pending = [];
    const [width, height] = size();
    try {
      await quick.call(steps);
      fail("");
    } catch (error) {
      fail(error.message);
      if (error.fatal) break;
    }
    try {
      if (!pending.length) take(await quick.call([["render", width, height, true], ["state"]], (picture) => paint(picture, quick)));
    } catch (error) {
      fail(error.message);
      if (error.fatal) break;
    }
  }
  isRunning = false;
  clearTimeout(rest);
  rest = setTimeout(finish, REST);
}

function stopFine() {
  if (fine?.isBusy) {
    fine.end();
    fine = null;
  }
  $("bar").hidden = true;
}

/** Begins the final picture of what is shown. */
async function finish() {
  const asked = change;
  const current = () => asked === change;
  try {
    const text = await quick.call([["text_with_view"]]);
    if (!current()) return;
    tell({ text });
    if (!fine) {
      fine = new Engine(module, device);
      if (files.length) await fine.call(files);
      fineName = null;
    }
    const [width, height] = size();
    // A bundle has results that its text alone lacks.
    const first = opened[0] === "bundle" ? [opened, ["replace", text]] : [["open", state.name, text]];
    const open = fineName === opened ? [["replace", text]] : first;
    fineName = opened;
    const engine = fine;
    const seen = (picture) => current() && paint(picture, engine);
    const heard = (stage, share) => current() && progress(stage, share);
    // Both workers show pictures by the levels of the first final one.
    const levels = ["take_levels", await quick.call([["levels"]])];
    const render = ["render", width, height, false];
    await engine.call([...open, ...(state.duration ? [["moment", moment]] : []), ["home"], levels, render], seen, heard);
    // Gas that is known roughly is shown in all pixels before it is computed exactly.
    if (state.rough && current()) {
      const voxels = await engine.call([["refine"]], seen, heard);
      if (!current()) return;
      await engine.call([render], seen, heard);
      if (voxels && current()) status(`${$("status").textContent}, gas on ${voxels} voxels: a browser lacks the memory for more`);
    }
    if (current()) await quick.call([["take_levels", await engine.call([["levels"]])]]);
  } catch (error) {
    if (current()) fail(error.message);
  }
  if (current()) $("bar").hidden = true;
}

// Settings.

function options(select, rows, value, first) {
  select.replaceChildren(...(first ? [new Option(first, "")] : []), ...rows.map(({ name, summary }) => Object.assign(new Option(name, name), { title: summary })));
  select.value = value || "";
}

const GAS_KEYS = ["density", "voxels", "temperature"];
let catalogue = null;
let dustHome = null;
let moment = 0;

function take(next) {
  const isNew = !state || state.name !== next.name;
  state = next;
  $("description").textContent = state.description || "";
  document.title = `${state.name} – Barnard`;
  $("undo").disabled = !state.undo;
  $("redo").disabled = !state.redo;
  $("filters").value = state.filters || "";
  $("palette").value = state.palette || "";
  $("stretch").value = state.stretch;
  $("strength").value = Math.log10(Math.max(state.strength, 1));
  $("strength-text").textContent = state.strength.toPrecision(3);
  $("dust-set").hidden = !state.dust;
  if (isNew) dustHome = state.dust;
  $("star-set").hidden = state.stars.length === 0;
  const star = Math.min(Number($("star").value) || 0, Math.max(state.stars.length - 1, 0));
  $("star").replaceChildren(...state.stars.map((row, number) => new Option(row.name || `star ${number}`, number)));
  $("star").value = star;
  for (const key of ["temperature", "luminosity", "position"]) {
    $(key).value = state.stars[star]?.[key] || "";
    $(key).disabled = !state.stars[star]?.[key];
  }
  $("gas-set").hidden = !state.gas;
  for (const key of GAS_KEYS) $(`gas-${key}`).value = state.gas?.[key] || "";
  $("bookmarks").replaceChildren(...state.bookmarks.map((name) => {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: name, title: `Go to bookmark ${name}` });
    button.onclick = () => act(["bookmark", name]);
    return button;
  }));
  $("timeline").hidden = !state.duration;
  $("time").max = state.duration || 0;
}

/** An amount with its unit, times a factor. */
function times(amount, factor) {
  const [, number, unit] = /^\s*([-+.\deE]+)\s*(.*)$/.exec(amount) || [];
  const value = Number((Number(number) * factor).toPrecision(4));
  return unit ? `${value} ${unit}` : value;
}

const edit = (place, key, value) => act(["set", place, key, value]);

$("filters").onchange = () => act(["filters", $("filters").value]);
$("palette").onchange = () => edit("display", "palette", $("palette").value || null);
$("stretch").onchange = () => edit("display", "stretch", $("stretch").value);
$("strength").oninput = () => edit("display", "strength", Number((10 ** $("strength").value).toPrecision(3)));
$("darker").onclick = () => act(["brighten", -0.5]);
$("brighter").onclick = () => act(["brighten", 0.5]);
$("expose").onclick = () => act(["expose"]);
$("dust").oninput = () => {
  const factor = 10 ** $("dust").value;
  $("dust-text").textContent = `× ${factor.toPrecision(2)}`;
  edit("dust", "scale", times(dustHome, factor));
};
$("star").onchange = () => take(state);
for (const key of ["temperature", "luminosity", "position"]) {
  $(key).onchange = () => edit(`star.${$("star").value}`, key, $(key).value);
}
for (const key of GAS_KEYS) {
  $(`gas-${key}`).onchange = ({ target: { value } }) => edit("gas", key, key === "voxels" && value ? Number(value) : value || null);
}
for (const slider of ["strength", "dust"]) $(slider).addEventListener("change", () => act(["rest"]));
$("home").onclick = () => act(["home"]);
$("undo").onclick = () => act(["undo"]);
$("redo").onclick = () => act(["redo"]);
$("panel").onsubmit = (event) => event.preventDefault();

// Timeline.

let playing = 0;
function show(seconds) {
  moment = seconds;
  $("time").value = seconds;
  $("time-text").textContent = `${seconds.toFixed(2)} s`;
  act(["moment", seconds]);
}
$("time").oninput = () => show(Number($("time").value));
$("play").onclick = () => {
  if (playing) return stop();
  const from = performance.now() - 1000 * (moment >= state.duration ? 0 : moment);
  $("play").textContent = "Pause";
  const step = () => {
    const now = (performance.now() - from) / 1000;
    show(Math.min(now, state.duration));
    if (now >= state.duration) return stop();
    const next = () => { playing = isRunning ? requestAnimationFrame(next) : requestAnimationFrame(step); };
    next();
  };
  step();
};
function stop() {
  cancelAnimationFrame(playing);
  playing = 0;
  $("play").textContent = "Play";
}
