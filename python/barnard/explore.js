// The view of `Scene.explore()`: a canvas that shows frames of the kernel, and tells it of drags, wheel and sliders.
function render({ model, el }) {
  const view = document.createElement("div");
  view.className = "barnard";
  const canvas = document.createElement("canvas");
  canvas.width = model.get("width");
  canvas.height = model.get("height");
  canvas.tabIndex = 0;
  canvas.title = "drag to orbit, wheel to come nearer";
  const words = document.createElement("div");
  words.className = "barnard-words";
  view.append(canvas, words);
  const context = canvas.getContext("2d");

  // One message a frame of the browser: moves add up until the next.
  let orbit = [0, 0], zoom = 0, waiting = false;
  const tell = () => {
    waiting = false;
    if (orbit[0] || orbit[1] || zoom) model.send({ type: "move", orbit, zoom });
    orbit = [0, 0];
    zoom = 0;
  };
  const soon = () => {
    if (!waiting) requestAnimationFrame(tell);
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

  for (const slider of model.get("sliders")) {
    const row = document.createElement("label");
    const input = document.createElement("input");
    const value = document.createElement("output");
    Object.assign(input, { type: "range", min: 0, max: 1, step: 0.001, value: slider.at });
    value.textContent = slider.text;
    input.addEventListener("input", () => model.send({ type: "slide", place: slider.place, at: Number(input.value) }));
    model.on("msg:custom", (message) => {
      if (message.type === "slid" && message.place === slider.place) value.textContent = message.text;
    });
    row.append(slider.place, input, value);
    view.append(row);
  }

  model.on("msg:custom", async (message, buffers) => {
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
  });
  model.send({ type: "ready" });
  el.append(view);
}
export default { render };
