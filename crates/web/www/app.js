// The page of the explorer. All pictures, checks and numbers come from two workers (worker.js): `quick` while things move, `fine` for the
// picture that `barnard render` makes.
"use strict";

const $ = (id) => document.getElementById(id);
const canvas = $("canvas");
const context = canvas.getContext("2d");

/** Time without change after which the final picture is begun [ms]. */
const REST = 350;
/** Motion of an arrow key, as a part of the view's width [1]. */
const KEY_STEP = 0.03;

function fail(words) {
  $("problem").textContent = words;
  $("problem").hidden = !words;
}

/** A worker with an explorer, which answers calls in order. */
class Engine {
  constructor(module) {
    this.worker = new Worker(window.barnardWorker || "worker.js");
    this.waiting = new Map();
    this.number = 0;
    this.worker.onmessage = ({ data }) => this.hear(data);
    this.worker.onerror = (event) => fail("The engine stopped: " + (event.message || "it could not be loaded") + ". Reload the page.");
    this.ready = this.call([["start", module]]);
  }

  get isBusy() { return this.waiting.size > 0; }

  /** Result of the last of some steps; `seen` receives pictures, `heard` progress. */
  call(steps, seen, heard) {
    const id = ++this.number;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject, seen, heard });
      this.worker.postMessage({ id, steps });
    });
  }

  hear({ id, result, error, fatal, picture, stage, share }) {
    const call = this.waiting.get(id);
    if (!call) return;
    if (picture) return call.seen?.(picture);
    if (stage) return call.heard?.(stage, share);
    this.waiting.delete(id);
    if (error === undefined) return call.resolve(result);
    call.reject(Object.assign(new Error(fatal ? "The engine failed: " + error + ". Reload the page." : error), { fatal }));
  }

  end() {
    this.worker.terminate();
    this.waiting.clear();
  }
}

let module, quick, fine, fineName = null;
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
  shown = picture;
  shownBy = by;
  canvas.dataset.quality = picture.quality;
  canvas.dataset.pictures = Number(canvas.dataset.pictures || 0) + 1;
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
    if (!fine) {
      fine = new Engine(module);
      if (files.length) await fine.call(files);
      fineName = null;
    }
    const [width, height] = size();
    const open = fineName === opened ? ["replace", text] : ["open", state.name, text];
    fineName = opened;
    const engine = fine;
    const seen = (picture) => current() && paint(picture, engine);
    const heard = (stage, share) => current() && progress(stage, share);
    const render = ["render", width, height, false];
    await engine.call([open, ...(moment ? [["moment", moment]] : []), ["home"], render], seen, heard);
    // Gas that is known roughly is shown in all pixels before it is computed exactly.
    if (state.rough && current()) {
      const voxels = await engine.call([["refine"]], seen, heard);
      if (!current()) return;
      await engine.call([render], seen, heard);
      if (voxels && current()) status(`${$("status").textContent}, gas on ${voxels} voxels: a browser lacks the memory for more`);
    }
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

// View.

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

// Scenes.

async function open(method, ...args) {
  status("Opening");
  stop();
  stopFine();
  fine?.end();
  fine = null;
  try {
    if (method === "builtin") for (const name of await quick.call([["needs", args[0]]])) await give(name, await volume(name));
    await quick.call([[method, ...args]]);
  } catch (error) {
    return fail(error.message);
  }
  fail("");
  opened = [method, ...args];
  state = null;
  moment = 0;
  $("dust").value = 0;
  $("dust-text").textContent = "";
  act(["state"]);
}

$("gallery-button").onclick = () => $("gallery").showModal();
$("open-button").onclick = () => $("file").click();
/** Gives a file to scenes that name it. */
async function give(name, bytes) {
  const step = ["give", name, bytes];
  await quick.call([step]);
  files.push(step);
}

/** Volume of a built-in scene, packed. */
async function volume(name) {
  const answer = await fetch(name.replace(/\.npz$/, ".packed.npz"));
  if (!answer.ok) throw new Error(`${name} could not be read: ${answer.status} ${answer.statusText}`);
  return new Uint8Array(await answer.arrayBuffer());
}

/** Opens a scene with the files beside it; files alone are for the scene that is open next. */
async function takeFiles(list) {
  try {
    const scene = list.find((file) => /\.toml$/i.test(file.name));
    const others = list.filter((file) => file !== scene);
    for (const file of others) await give(file.name, new Uint8Array(await file.arrayBuffer()));
    if (scene) return open("open", scene.name.replace(/\.toml$/i, ""), await scene.text());
    const volume = others.find((file) => /\.(npy|npz|fits|vdb)$/i.test(file.name));
    if (volume) return open("open", volume.name.replace(/\.\w+$/, ""), sceneOf(volume.name));
    fail("Drop a scene (.toml), alone or with its files, or a volume (.npy, .npz, .fits, .vdb).");
  } catch (error) {
    fail(error.message);
  }
}

/** A scene that shows a volume as dust, lit by a star beside it. */
const sceneOf = (file) => `# ${file} as dust: adapt size, amount and stars.
bands = "johnson"

[camera]
kind = "perspective"
position = "0 0 -6 pc"
target = "0 0 0 pc"
field_of_view = "30 deg"
size = [1280, 720]

[field.cloud]
kind = "grid"
file = "${file}"
low = "-1 -1 -1 pc"
high = "1 1 1 pc"

[dust]
density = "cloud"
scale = "2 mag/pc"

[[star]]
kind = "blackbody"
position = "-1.2 1 -1.2 pc"
temperature = "12000 K"
luminosity = "500 Lsun"
`;

$("file").onchange = async () => {
  await takeFiles([...$("file").files]);
  $("file").value = "";
};
document.ondragover = (event) => event.preventDefault();
document.ondrop = async (event) => {
  event.preventDefault();
  if (event.dataTransfer.files.length) await takeFiles([...event.dataTransfer.files]);
};

$("text-button").onclick = async () => {
  $("text").value = await quick.call([["text"]]);
  $("text-problem").textContent = "";
  $("editor").showModal();
};
$("apply").onclick = async () => {
  try {
    await quick.call([["replace", $("text").value]]);
    $("text-problem").textContent = "";
    act(["state"]);
  } catch (error) {
    $("text-problem").textContent = error.message;
  }
};
$("close-editor").onclick = () => $("editor").close();

for (const button of document.querySelectorAll("[data-save]")) {
  button.onclick = async () => {
    const format = button.dataset.save;
    const name = (state?.name || "nebula").replace(/[^\p{L}\p{N}]+/gu, "_");
    try {
      const bytes = format === "toml" ? await quick.call([["text_with_view"]]) : await (shownBy || quick).call([["encoded", format]]);
      const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(new Blob([bytes])), download: `${name}.${format}` });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    } catch (error) {
      fail(error.message);
    }
  };
}

async function fillGallery() {
  for (const { name, summary } of catalogue.scenes) {
    const button = Object.assign(document.createElement("button"), { type: "button", title: summary });
    const picture = Object.assign(document.createElement("img"), { alt: "" });
    const bytes = await quick.call([["thumbnail", name]]);
    if (bytes.length) picture.src = URL.createObjectURL(new Blob([bytes], { type: "image/jpeg" }));
    button.append(picture, name, Object.assign(document.createElement("small"), { textContent: summary }));
    button.onclick = () => {
      $("gallery").close();
      history.replaceState(null, "", `?builtin=${name}`);
      open("builtin", name);
    };
    $("scenes").append(button);
  }
}

async function start() {
  if (typeof WebAssembly === "undefined" || typeof OffscreenCanvas === "undefined") throw new Error("this browser is too old: it lacks WebAssembly or OffscreenCanvas");
  const bytes = window.barnardModule ? window.barnardModule() : await (await fetch("barnard_bg.wasm")).arrayBuffer();
  try {
    module = await WebAssembly.compile(bytes);
  } catch (error) {
    throw new Error("this browser is too old: it lacks vector instructions of WebAssembly (" + error.message + ")");
  }
  quick = new Engine(module);
  await quick.ready;
  catalogue = await quick.call([["catalogue"]]);
  options($("filters"), catalogue.filters, "", "of the scene");
  options($("palette"), catalogue.palettes, "", "of the filters");
  options($("stretch"), catalogue.stretches, "");
  const query = new URLSearchParams(location.search);
  if (window.barnardScene) open("open", window.barnardScene.name, window.barnardScene.text);
  else if (query.has("scene")) {
    const address = query.get("scene");
    const answer = await fetch(address);
    if (!answer.ok) throw new Error(`${address} could not be read: ${answer.status} ${answer.statusText}`);
    open("open", address.split("/").pop().replace(/\.toml$/, ""), await answer.text());
  } else open("builtin", query.get("builtin") || "six_stars");
  fillGallery();
}

start().catch((error) => {
  status("");
  fail(`Barnard cannot start: ${error.message}.`);
});
