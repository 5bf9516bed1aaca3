// An explorer in a worker. A message is { id, steps: [[method, ...arguments], ...] }; the answer has the result of the last step.
// Pictures and progress are messages of their own, with the number of the message that asked for them.
"use strict";
if (typeof wasm_bindgen === "undefined") importScripts("barnard.js");

let explorer = null;
let current = 0;
let memory = null;

const show = (picture) => {
  const buffers = [picture.pixels.buffer];
  if (picture.sparks) buffers.push(picture.sparks[2].buffer);
  postMessage({ id: current, picture }, buffers);
};
let told = 0;
const hear = (stage, share) => {
  const now = performance.now();
  if (now - told < 100 && share < 1) return;
  told = now;
  postMessage({ id: current, stage, share });
};

const own = {
  start: async (module, device) => {
    ({ memory } = wasm_bindgen.initSync({ module }));
    return device === "cpu" ? "" : wasm_bindgen.open_device(device === "webgpu");
  },
  catalogue: () => JSON.parse(wasm_bindgen.catalogue()),
  give: (name, bytes) => wasm_bindgen.give(name, bytes),
  needs: (name) => wasm_bindgen.needs(name).split("\n").filter(Boolean),
  thumbnail: (name) => wasm_bindgen.thumbnail(name),
  builtin: (name) => take(wasm_bindgen.Explorer.builtin(name)),
  bundle: (name, bytes) => take(wasm_bindgen.Explorer.bundle(name, bytes)),
  open: (name, text) => take(new wasm_bindgen.Explorer(name, text)),
  /** Memory of the engine [bytes]. */
  memory: () => memory.buffer.byteLength,
  state: () => JSON.parse(explorer.state()),
  probe: (x, y) => JSON.parse(explorer.probe(x, y)),
  refine: () => explorer.refine(hear),
  render: (width, height, moving) => explorer.render(width, height, moving, show, hear),
};

function take(opened) {
  if (explorer) explorer.free();
  explorer = opened;
}

const answer = async ({ id, steps }) => {
  current = id;
  try {
    let result;
    for (const [method, ...args] of steps) result = await (own[method] ? own[method](...args) : explorer[method](...args));
    postMessage({ id, result });
  } catch (error) {
    // A trap leaves the engine in no state to go on.
    const fatal = error instanceof WebAssembly.RuntimeError;
    const words = (fatal && wasm_bindgen.last_panic()) || error.message || String(error);
    postMessage({ id, error: words, fatal });
  }
};

// A device has pictures done later: messages wait for each other.
let queue = Promise.resolve();
onmessage = ({ data }) => { queue = queue.then(() => answer(data)); };
