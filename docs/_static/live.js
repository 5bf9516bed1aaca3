// The picture of the front page becomes the explorer with the same scene.
"use strict";

document.addEventListener("DOMContentLoaded", () => {
  const button = document.getElementById("live");
  if (!button) return;
  const picture = document.querySelector("article img");
  button.addEventListener("click", () => {
    const frame = Object.assign(document.createElement("iframe"), { src: button.dataset.page, title: "Explorer of the Pleiades" });
    frame.className = "live";
    picture.replaceWith(frame);
    button.remove();
  });
});
