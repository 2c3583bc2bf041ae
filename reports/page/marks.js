"use strict";
// Findings, events and stretches that stay unexplained: pointing at one lights up its times and its joint; a click (or
// Enter) keeps it lit and goes there.

function startMarks() {
  const block = document.querySelector("script.marks-data");
  if (!block) return;
  const marks = readBlock(block);
  let kept = null;

  const light = (mark) => {
    for (const track of stage.tracks.values()) {
      const own = mark ? mark.times.filter(([recording]) => recording === "" || recording === track.name) : [];
      if (own.length > 0 || track.stretches.length > 0) track.setStretches(own.map(([, from, to]) => [from, to]));
    }
    stage.setJoint(mark ? mark.joint : null);
  };

  const goTo = (mark) => {
    const known = mark.times.filter(([recording]) => stage.tracks.has(recording));
    const [recording, from, to] = known.find(([name]) => stage.showRecording(name)) || known[0] || [];
    if (recording === undefined) return;
    for (const fold of document.querySelectorAll("details")) {
      const plots = [...fold.querySelectorAll(".plot")];
      if (plots.some((plot) => plot.dataset.recording === recording)) fold.open = true;
    }
    light(mark);
    stage.track(recording).setTime((from + to) / 2);
  };

  marks.forEach((mark, i) => {
    for (const words of document.querySelectorAll(`.mark-${i}`)) {
      const target = words.closest("tr, .card") || words;
      target.classList.add("acts");
      target.tabIndex = 0;
      target.addEventListener("pointerenter", () => light(mark));
      target.addEventListener("pointerleave", () => light(kept));
      target.addEventListener("focus", () => light(mark));
      target.addEventListener("blur", () => light(kept));
      const keep = () => {
        const same = kept === mark;
        document.querySelectorAll(".acts.kept").forEach((other) => other.classList.remove("kept"));
        kept = same ? null : mark;
        if (same) return light(null);
        target.classList.add("kept");
        goTo(mark);
      };
      target.addEventListener("click", () => String(window.getSelection()) === "" && keep());
      target.addEventListener("keydown", (event) => event.key === "Enter" && keep());
    }
  });
}
