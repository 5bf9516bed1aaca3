// Scenes: built-in ones, files, addresses, the text editor, and the start of the page.
"use strict";

/** Names of packed scenes. */
const BUNDLE = /\.barnard$/i;

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
  if (host) tell({ text: await quick.call([["text_with_view"]]) });
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
    const bundle = list.find((file) => BUNDLE.test(file.name));
    if (bundle) return open("bundle", bundle.name, new Uint8Array(await bundle.arrayBuffer()));
    const scene = list.find((file) => /\.toml$/i.test(file.name));
    const others = list.filter((file) => file !== scene);
    for (const file of others) await give(file.name, new Uint8Array(await file.arrayBuffer()));
    if (scene) return open("open", scene.name.replace(/\.toml$/i, ""), await scene.text());
    const volume = others.find((file) => /\.(npy|npz|fits|vdb)$/i.test(file.name));
    if (volume) return open("open", volume.name.replace(/\.\w+$/, ""), sceneOf(volume.name));
    fail("Drop a packed scene (.barnard), a scene (.toml), alone or with its files, or a volume (.npy, .npz, .fits, .vdb).");
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
    // A page in one file has no volumes beside it.
    if (window.barnardModule && (await quick.call([["needs", name]])).length) continue;
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
  const bytes = window.barnardModule ? await window.barnardModule() : await (await fetch("barnard_bg.wasm")).arrayBuffer();
  try {
    module = await WebAssembly.compile(bytes);
  } catch (error) {
    throw new Error("this browser is too old: it lacks vector instructions of WebAssembly (" + error.message + ")");
  }
  const query = new URLSearchParams(location.search);
  device = query.get("device");
  quick = new Engine(module, device);
  await quick.ready;
  catalogue = await quick.call([["catalogue"]]);
  options($("filters"), catalogue.filters, "", "of the scene");
  options($("palette"), catalogue.palettes, "", "of the filters");
  options($("stretch"), catalogue.stretches, "");
  if (window.barnardScene) open("bundle", window.barnardScene.name, window.barnardScene.bytes());
  else if (query.has("scene")) {
    const address = query.get("scene");
    const name = address.split("/").pop();
    const answer = await fetch(address);
    if (!answer.ok) throw new Error(`${address} could not be read: ${answer.status} ${answer.statusText}`);
    if (BUNDLE.test(name)) open("bundle", name, new Uint8Array(await answer.arrayBuffer()));
    else open("open", name.replace(/\.toml$/, ""), await answer.text());
  } else open("builtin", query.get("builtin") || "six_stars");
  fillGallery();
}

start().catch((error) => {
  status("");
  fail(`Barnard cannot start: ${error.message}.`);
});
