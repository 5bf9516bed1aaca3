// Parts of a page in one file: the module, the worker, and the scene.
"use strict";

/** Bytes of an element's Base64 text. */
function bytesOf(id) {
  const text = atob(document.getElementById(id).textContent.trim());
  return Uint8Array.from(text, (character) => character.charCodeAt(0));
}

window.barnardWorker = URL.createObjectURL(new Blob([document.getElementById("barnard-worker").textContent], { type: "text/javascript" }));
window.barnardModule = async () => {
  if (typeof DecompressionStream === "undefined") throw new Error("this browser is too old: it lacks DecompressionStream");
  const stream = new Blob([bytesOf("barnard-module")]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
};
const bundle = document.getElementById("barnard-bundle");
if (bundle) window.barnardScene = { name: bundle.dataset.name, bytes: () => bytesOf("barnard-bundle") };
