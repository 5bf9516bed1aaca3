// A worker with an explorer, and messages to the reader.
"use strict";

const $ = (id) => document.getElementById(id);

function fail(words) {
  $("problem").textContent = words;
  $("problem").hidden = !words;
  if (words) tell({ problem: words });
}

/** A worker with an explorer, which answers calls in order. */
class Engine {
  constructor(module, device) {
    this.worker = new Worker(window.barnardWorker || "worker.js");
    this.waiting = new Map();
    this.number = 0;
    this.worker.onmessage = ({ data }) => this.hear(data);
    this.worker.onerror = (event) => fail("The engine stopped: " + (event.message || "it could not be loaded") + ". Reload the page.");
    this.ready = this.call([["start", module, device]]);
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
