"use strict";
// Runs at the page's end. What fails leaves the page as it is without scripts.

for (const start of [() => stage.know(document.querySelectorAll(".plot")), startReplay, startMarks, startPlots]) {
  try {
    start();
  } catch (error) {
    console.error(error);
  }
}
document.documentElement.dataset.page = "started";
