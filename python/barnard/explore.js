// The view of `Scene.explore()`. In mode "browser", a frame has the engine, and the kernel hears of the view and of keys that changed.
// In mode "kernel", a canvas shows frames of the kernel, and tells it of drags, wheel and sliders.

/** Time in which a frame answers, or is taken for blocked [ms]. */
const PATIENCE = 20000;

function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

/** Rows of sliders; `moved` receives a slider and its position, and may return the text of its value. */
function sliderRows(model, moved) {
  return model.get("sliders").map((slider) => {
    const input = element("input", { type: "range", min: 0, max: 1, step: 0.001, value: slider.at });
    const value = element("output", { textContent: slider.text });
    input.addEventListener("input", () => { value.textContent = moved(slider, Number(input.value)) ?? value.textContent; });
    model.on("msg:custom", (message) => {
      if (message.type === "slid" && message.place === slider.place) value.textContent = message.text;
    });
    return element("label", {}, slider.place, input, value);
  });
}

/** A view whose engine is in the browser. */
function inBrowser(model, view) {
  const words = element("div", { className: "barnard-words", textContent: "loading the engine" });
  const frame = element("iframe", { title: "Explorer of the scene" });
  Object.assign(frame.style, { width: `${model.get("width")}px`, height: `${model.get("height")}px`, border: 0 });
  let answered = false;
  const first = [...model.get("steps")];
  const act = (...steps) => frame.contentWindow?.postMessage({ barnard: steps }, "*");
  const hear = ({ source, data }) => {
    if (source !== frame.contentWindow || !data?.barnard) return;
    answered = true;
    const { quality, text, problem } = data.barnard;
    if (problem) words.textContent = problem;
    if (quality) {
      frame.dataset.quality = quality;
      words.textContent = quality;
      frame.dataset.pictures = Number(frame.dataset.pictures || 0) + 1;
      if (first.length) act(...first.splice(0));
    }
    if (text) model.send({ type: "view", text });
  };
  window.addEventListener("message", hear);
  const address = URL.createObjectURL(new Blob([model.get("page")], { type: "text/html" }));
  frame.src = `${address}#compact`;
  const late = setTimeout(() => { if (!answered) model.send({ type: "blocked" }); }, PATIENCE);
  const rows = sliderRows(model, ({ place, low, high, byRatio, unit }, at) => {
    const value = Number((byRatio ? low * (high / low) ** at : low + (high - low) * at).toPrecision(5));
    const way = place.replace(/\[(\d+)\]/g, ".$1").split(".");
    const key = way.pop();
    act(["set", way.join("."), key, unit ? `${value} ${unit}` : value]);
    return `${Number(value.toPrecision(4))} ${unit}`.trim();
  });
  view.append(frame, words, ...rows);
  return () => {
    clearTimeout(late);
    window.removeEventListener("message", hear);
    URL.revokeObjectURL(address);
  };
}

/** A view of frames of the kernel. */
function byKernel(model, view) {
  const canvas = element("canvas", { width: model.get("width"), height: model.get("height"), tabIndex: 0, title: "drag to orbit, wheel to come nearer" });
  const words = element("div", { className: "barnard-words" });
  const context = canvas.getContext("2d");

  // One message a frame of the browser: moves add up until the next.
  let orbit = [0, 0], zoom = 0, waiting = false;
  const send = () => {
    waiting = false;
    if (orbit[0] || orbit[1] || zoom) model.send({ type: "move", orbit, zoom });
    orbit = [0, 0];
    zoom = 0;
  };
  const soon = () => {
    if (!waiting) requestAnimationFrame(send);
    waiting = true;
  };
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    orbit = [orbit[0] + event.movementX, orbit[1] + event.movementY];
    soon();
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom += event.deltaY / 500;
    soon();
  }, { passive: false });
  canvas.addEventListener("dblclick", () => model.send({ type: "home" }));

  const received = async (message, buffers) => {
    if (message.type === "words") words.textContent = message.text;
    if (message.type !== "frame") return;
    const picture = await createImageBitmap(new Blob([buffers[0]], { type: "image/png" }));
    context.imageSmoothingEnabled = true;
    context.drawImage(picture, 0, 0, canvas.width, canvas.height);
    canvas.dataset.frames = Number(canvas.dataset.frames || 0) + 1;
    canvas.dataset.quality = message.quality;
    words.textContent = message.text;
    // The kernel sends the next one when this one is seen.
    model.send({ type: "seen", number: message.number });
  };
  model.on("msg:custom", received);
  view.append(canvas, words, ...sliderRows(model, ({ place }, at) => { model.send({ type: "slide", place, at }); }));
  model.send({ type: "ready" });
  return () => model.off("msg:custom", received);
}

function render({ model, el }) {
  let view = null, end = () => {};
  const show = () => {
    end();
    view?.remove();
    view = element("div", { className: "barnard" });
    end = (model.get("mode") === "browser" ? inBrowser : byKernel)(model, view);
    el.append(view);
  };
  model.on("change:mode", show);
  show();
  return () => end();
}
export default { render };
