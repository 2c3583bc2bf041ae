"use strict";
// What plots and replay share: of each recording the instant looked at, the stretch zoomed into, and what lights up.

class Track {
  constructor(name) {
    this.name = name;
    this.time = null;   // s; null: nobody has looked yet
    this.range = null;  // [from, to] in s; null: all
    this.held = false;  // a replay runs: pointers over plots do not move the instant
    this.timeListeners = new Set();
    this.rangeListeners = new Set();
    this.markListeners = new Set();
    this.stretches = [];  // [from, to] that light up
  }
  setTime(time, source = null) {
    if (!Number.isFinite(time)) return;
    this.time = time;
    this.timeListeners.forEach((listen) => listen(time, source));
  }
  setRange(range, source = null) {
    this.range = range;
    this.rangeListeners.forEach((listen) => listen(range, source));
  }
  setStretches(stretches) {
    this.stretches = stretches;
    this.markListeners.forEach((listen) => listen());
  }
}

const stage = {
  tracks: new Map(),
  joint: null,  // that lights up
  jointListeners: new Set(),
  showRecording: () => false,  // set by the replay

  // The recording's track; a track of its own for what belongs to no recording.
  track(name) {
    if (!name) return new Track("");
    if (!this.tracks.has(name)) this.tracks.set(name, new Track(name));
    return this.tracks.get(name);
  },
  // Before anything is drawn: what is plotted of which recording.
  know(plots) {
    plots.forEach((plot) => {
      plot.dataset.recording = readBlock(plot.querySelector("script.plot-data")).recording;
      this.track(plot.dataset.recording);
    });
  },
  setJoint(joint) {
    this.joint = joint;
    this.jointListeners.forEach((listen) => listen(joint));
  },
};
