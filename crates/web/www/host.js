// A page in a frame, as notebooks show it: the host sends steps for the engine, and receives qualities of pictures and the text.
"use strict";

const host = window.parent === window ? null : window.parent;

/** Sends a message to the host, if there is one. */
const tell = (message) => host?.postMessage({ barnard: message }, "*");

window.addEventListener("message", ({ source, data }) => {
  if (host && source === host && Array.isArray(data?.barnard)) act(...data.barnard);
});
if (location.hash === "#compact") document.body.classList.add("compact");
tell({ ready: true });
