"use strict";
// The recording against both models: two pictures side by side, the measured robot a ghost in each, at the instant that
// the plots' cursor stands at; the effort that a model lacks as colour.

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
const ENLARGEMENTS = [1, 2, 5, 10, 20, 50, 100, 200, 500];
const VISIBLE = 0.15;          // rad, or of the robot's size: how far a model stands off, enlarged, at its worst
const GHOST = [120, 128, 140];
const GLOW = [226, 60, 30];
const FLOOR_LINES = 6;         // each way from the middle
const MOST_PIXELS = 1400;      // a side of a picture

class Replay {
  constructor(holder) {
    this.holder = holder;
    this.data = readBlock(holder.querySelector("script.replay-data"));
    this.figure = new Figure(this.data.solids);
    this.view = new View(this.data.camera);
    this.speed = 1;
    this.recordings = this.data.recordings.map((recording) => this.unpacked(recording));
    this.recordings.forEach((recording) => stage.track(recording.name));
    this.build();
    this.choose(0);
  }

  unpacked(recording) {
    const part = (of) => ({ ...of, before: unpack(of.before), after: unpack(of.after) });
    const time = unpack(recording.time);
    const out = {
      ...recording,
      time,
      joints: recording.joints.map((of) => ({ ...part(of), measured: unpack(of.measured) })),
      missing: recording.missing.map((of) => ({ ...part(of), time: unpack(of.time) })),
    };
    out.most = Math.max(1, ...out.missing.map((of) => largest(of.before) / of.noise));
    return out;
  }

  // What there is to see: measured beside `before`, and where there are two models beside `after`.
  sides() {
    const { joints } = this.recordings[0];
    return ["before", "after"].filter((side) => joints.some((of) => of[side] && of[side].length > 0));
  }

  build() {
    this.stageElement = makeElement("div", "replay-stage");
    const views = makeElement("div", "replay-views");
    const words = { before: this.data.words[0], after: this.data.words[1] };
    this.pictures = this.sides().map((side) => {
      const figure = makeElement("figure", "replay-view");
      const canvas = makeElement("canvas");
      canvas.tabIndex = 0;
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", `The robot as measured, a ghost, and as the ${words[side]} moves it. Arrow keys turn the view.`);
      const caption = makeElement("figcaption");
      const key = makeElement("span", "live-key"), ghost = makeElement("span", "live-key");
      key.append(makeElement("span", `swatch ${side}`), makeElement("span", "", words[side]));
      ghost.append(makeElement("span", "swatch ghost"), makeElement("span", "", "measured"));
      const off = makeElement("span", "replay-off");
      caption.append(key, ghost, off);
      figure.append(caption, canvas);
      views.append(figure);
      this.listenTo(canvas);
      return { side, canvas, off, raster: new Raster(), ghost: new Raster(), ground: new Raster() };
    });
    this.stageElement.append(views, this.controls());
    this.place = makeElement("div", "replay-place");
    this.place.append(this.stageElement);
    this.holder.append(this.place, this.options(), this.table());
    this.holder.classList.add("drawn");
    new ResizeObserver(() => this.request()).observe(this.stageElement);
    onThemeChange(() => this.request());
    stage.jointListeners.add(() => this.request());
    stage.showRecording = (name) => this.show(name);
    this.float();
  }

  controls() {
    const bar = makeElement("div", "replay-bar");
    this.button = makeElement("button", "replay-play");
    this.button.type = "button";
    this.button.addEventListener("click", () => this.play(!this.playing));
    this.slider = makeElement("input", "replay-slider");
    this.slider.type = "range";
    this.slider.setAttribute("aria-label", "Time in the recording");
    this.slider.addEventListener("input", () => this.track.setTime(Number(this.slider.value), this));
    this.clock = makeElement("output", "replay-clock");
    bar.append(this.button, this.slider, this.clock);
    this.stageElement.addEventListener("keydown", (event) => {
      if (event.key !== " " || event.target === this.button) return;
      event.preventDefault();
      this.play(!this.playing);
    });
    this.showPlaying();
    return bar;
  }

  options() {
    const bar = makeElement("div", "replay-options");
    const choice = (words, entries, selected, action) => {
      const label = makeElement("label", "", `${words} `), select = makeElement("select");
      entries.forEach(([value, name]) => {
        const option = makeElement("option", "", name);
        option.value = String(value);
        select.append(option);
      });
      select.value = String(selected);
      select.addEventListener("change", () => action(Number(select.value)));
      label.append(select);
      bar.append(label);
      return select;
    };
    this.recordingSelect = choice("Recording", this.recordings.map((of, i) => [i, `${of.name} (${of.role})`]), 0, (i) => this.choose(i));
    choice("Speed", SPEEDS.map((v) => [v, `\u00d7 ${v}`]), this.speed, (v) => (this.speed = v));
    this.enlargeSelect = choice("Deviations drawn", ENLARGEMENTS.map((v) => [v, `\u00d7 ${v}`]), 1, (v) => {
      this.enlarged = v;
      this.request();
    });
    this.keep = makeElement("input");
    this.keep.type = "checkbox";
    this.keep.checked = true;
    const label = makeElement("label", "");
    label.append(this.keep, " stays in view beside the plots");
    bar.append(label);
    if (this.recordings.some((of) => of.missing.length > 0)) {
      const legend = makeElement("span", "replay-glow");
      this.glowWords = makeElement("span");
      legend.append("missing effort: noise ", makeElement("span", "glow-scale"), this.glowWords);
      bar.append(legend);
    }
    return bar;
  }

  // Numbers at the cursor, joint by joint.
  table() {
    const scroll = makeElement("div", "scroll"), table = makeElement("table", "replay-table");
    const head = makeElement("thead"), body = makeElement("tbody"), row = makeElement("tr");
    const names = { before: this.data.words[0], after: this.data.words[1] };
    const missing = this.recordings.some((of) => of.missing.length > 0);
    const titles = ["joint", "measured", ...this.pictures.map(({ side }) => `${names[side]} \u2212 measured`), "unit",
                    ...(missing ? this.pictures.map(({ side }) => `effort missing, ${names[side]} / noise`) : [])];
    titles.forEach((title) => {
      const cell = makeElement("th", title === "joint" || title === "unit" ? "" : "num", title);
      cell.scope = "col";
      row.append(cell);
    });
    head.append(row);
    this.rows = this.data.joints.map((joint) => {
      const line = makeElement("tr"), cells = titles.map((title) => makeElement("td", title === "joint" || title === "unit" ? "" : "num"));
      cells[0].append(makeElement("code", "", joint.name));
      line.append(...cells);
      body.append(line);
      return { line, cells };
    });
    table.append(head, body);
    scroll.append(table);
    return scroll;
  }

  choose(index) {
    const recording = this.recordings[index];
    if (this.track) {
      this.play(false);
      this.track.timeListeners.delete(this.listener);
    }
    this.recording = recording;
    this.recordingSelect.value = String(index);
    this.track = stage.track(recording.name);
    this.listener = () => this.request();
    this.track.timeListeners.add(this.listener);
    const { time } = recording;
    this.slider.min = time[0];
    this.slider.max = time[time.length - 1];
    this.slider.step = (time[time.length - 1] - time[0]) / 5000;
    this.enlarged = this.fittingEnlargement();
    this.enlargeSelect.value = String(this.enlarged);
    if (this.glowWords) this.glowWords.textContent = ` ${formatted(recording.most, 2)} times it`;
    if (this.track.time === null) this.track.setTime(this.worstTime(), this);
    this.request();
  }

  show(name) {
    const index = this.recordings.findIndex((of) => of.name === name);
    if (index < 0) return false;
    if (this.recordings[index] !== this.recording) this.choose(index);
    return true;
  }

  // So that the plain model's worst deviation can be seen, and no larger.
  fittingEnlargement() {
    const sizes = this.recording.joints.map((of) => {
      const slides = this.data.joints[of.joint].slides;
      const deviations = (of.before || of.after).map(Math.abs).filter(Number.isFinite).sort((a, b) => a - b);
      const usual = deviations[Math.floor(0.98 * (deviations.length - 1))] || 0;
      return slides ? usual / this.data.camera.radius : usual;
    });
    const worst = Math.max(...sizes, 1e-12);
    return ENLARGEMENTS.filter((v) => v * worst <= VISIBLE).pop() || 1;
  }

  // Of all joints together.
  worstTime() {
    const { time, joints } = this.recording;
    let best = 0, most = -1;
    time.forEach((t, i) => {
      const total = joints.reduce((sum, of) => sum + Math.abs((of.before || of.after)[i] || 0), 0);
      if (total > most) [most, best] = [total, i];
    });
    return time[best];
  }

  play(on) {
    this.playing = on;
    this.track.held = on;
    this.showPlaying();
    if (!on) return;
    const { time } = this.recording, end = time[time.length - 1];
    if (this.track.time >= end) this.track.setTime(time[0], this);
    let last = null;
    const step = (now) => {
      if (!this.playing) return;
      if (last !== null) {
        const next = this.track.time + (this.speed * (now - last)) / 1000;
        this.track.setTime(Math.min(next, end), this);
        if (next >= end) return this.play(false);
      }
      last = now;
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  showPlaying() {
    this.button.textContent = this.playing ? "\u275a\u275a" : "\u25b6";
    this.button.setAttribute("aria-label", this.playing ? "Pause" : "Play");
    this.button.title = this.playing ? "Pause (space)" : "Play (space)";
  }

  request() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.draw();
    });
  }

  // Positions of all joints: as measured (side null), or a model's with its deviations enlarged.
  positions(t, side) {
    const q = this.data.joints.map(() => 0);
    for (const of of this.recording.joints) {
      const measured = valueAt(this.recording.time, of.measured, t);
      const off = side && of[side] && of[side].length > 0 ? valueAt(this.recording.time, of[side], t) : 0;
      q[of.joint] = (Number.isFinite(measured) ? measured : 0) + this.enlarged * (Number.isFinite(off) ? off : 0);
    }
    return q;
  }

  // The effort that a model lacks, times the noise, by joint; NaN where it is not known.
  missing(t, side) {
    const out = this.data.joints.map(() => NaN);
    for (const of of this.recording.missing) {
      const known = of[side] && t >= of.time[0] && t <= of.time[of.time.length - 1];
      if (known) out[of.joint] = valueAt(of.time, of[side], t) / of.noise;
    }
    return out;
  }

  draw() {
    const t = this.track.time;
    if (t === null) return;
    this.slider.value = String(t);
    this.clock.textContent = `${t.toFixed(2)} s`;
    for (const picture of this.pictures) {
      const missing = this.missing(t, picture.side);
      this.paint(picture, this.positions(t, picture.side), missing);
      picture.off.textContent = this.enlarged === 1 ? "" : `deviations \u00d7 ${this.enlarged}`;
    }
    this.fillTable(t);
    this.stageElement.dataset.time = String(t);
  }

  paint(picture, q, missing) {
    const { canvas, raster, ghost, ground } = picture;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (width === 0 || height === 0) return;
    // Twice as fine as the screen: what is drawn gets smooth edges when it is scaled down.
    const fine = Math.min(Math.max(2, window.devicePixelRatio), MOST_PIXELS / Math.max(width, height));
    const w = Math.round(width * fine), h = Math.round(height * fine);
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    this.view.resize(w, h);
    for (const each of [raster, ghost, ground]) {
      each.resize(w, h);
      each.clear();
    }
    const poses = bodyPoses(this.data.joints, q), seen = bodyPoses(this.data.joints, this.positions(this.track.time, null));
    const base = this.inkOf(picture.side);
    this.figure.shadow(ground, this.view, poses, this.data.camera.ground);
    this.figure.draw(ghost, this.view, seen, () => GHOST);
    this.figure.draw(raster, this.view, poses, (solid) => this.colorOf(solid, base, missing));
    ghost.outline([40, 44, 52], 0.8);
    raster.outline([10, 12, 16], 0.55);
    const context = canvas.getContext("2d");
    context.clearRect(0, 0, w, h);
    this.floor(context);
    ground.put(context, 0.16);
    raster.put(context, 1);
    ghost.put(context, 0.42);
    this.rings(context, poses, fine);
  }

  inkOf(side) {
    return side === "after" ? [96, 148, 224] : [228, 160, 122];
  }

  // The plain colour of the model, its pins darker; what lacks effort glows, joint and link together.
  colorOf(solid, base, missing) {
    const own = solid.color.map((c) => 255 * c);
    const plain = base.map((c, k) => 0.72 * c + 0.28 * own[k]);
    if (solid.body < 0) return own.map((c) => 0.6 * c + 70);
    const glow = this.glow(missing[solid.body]);
    return plain.map((c, k) => (1 - glow) * c + glow * GLOW[k]);
  }

  // 0 within the noise, 1 at the recording's most, by its square root so that half as much still shows.
  glow(ratio) {
    if (!Number.isFinite(ratio) || this.recording.most <= 3) return 0;
    return Math.sqrt(clamp((Math.abs(ratio) - 3) / (this.recording.most - 3), 0, 1));
  }

  floor(context) {
    const { target, radius, ground } = this.data.camera;
    const step = radius / 2.5;
    const middle = [Math.round(target[0] / step) * step, Math.round(target[1] / step) * step];
    context.strokeStyle = themeColor("line");
    context.lineWidth = 2;
    context.beginPath();
    const segment = (x0, y0, x1, y1) => {
      const a = this.view.project(x0, y0, ground), b = this.view.project(x1, y1, ground);
      if (Math.min(a[2], b[2]) < NEAREST * this.view.distance) return;
      context.moveTo(a[0], a[1]);
      context.lineTo(b[0], b[1]);
    };
    for (let k = -FLOOR_LINES; k <= FLOOR_LINES; ++k) {
      for (let i = -FLOOR_LINES; i < FLOOR_LINES; ++i) {
        segment(middle[0] + k * step, middle[1] + i * step, middle[0] + k * step, middle[1] + (i + 1) * step);
        segment(middle[0] + i * step, middle[1] + k * step, middle[0] + (i + 1) * step, middle[1] + k * step);
      }
    }
    context.stroke();
  }

  // About the joint that lights up, with its name.
  rings(context, poses, fine) {
    const index = this.data.joints.findIndex((joint) => joint.name === stage.joint);
    if (index < 0) return;
    const [x, y] = this.view.project(poses[index][9], poses[index][10], poses[index][11]);
    context.strokeStyle = context.fillStyle = themeColor("found");
    context.lineWidth = 3 * fine;
    context.beginPath();
    context.arc(x, y, 20 * fine, 0, 2 * Math.PI);
    context.stroke();
    context.font = `600 ${13 * fine}px system-ui, sans-serif`;
    const left = x + 26 * fine;
    context.fillText(this.data.joints[index].name, left, y - 12 * fine, Math.max(context.canvas.width - left, 1));
  }

  fillTable(t) {
    const missing = this.pictures.map(({ side }) => this.missing(t, side));
    this.rows.forEach(({ line, cells }, joint) => {
      const of = this.recording.joints.find((each) => each.joint === joint);
      line.classList.toggle("lit", stage.joint === this.data.joints[joint].name);
      const at = (values) => (values && values.length > 0 ? formatted(valueAt(this.recording.time, values, t)) : "\u2013");
      const words = [of ? at(of.measured) : "\u2013", ...this.pictures.map(({ side }) => (of ? at(of[side]) : "\u2013")), of ? of.unit : ""];
      if (cells.length > words.length + 1) words.push(...missing.map((by) => formatted(by[joint], 3)));
      words.forEach((word, k) => (cells[k + 1].textContent = word));
      missing.forEach((by, k) => {
        const cell = cells[cells.length - missing.length + k];
        if (cells.length > 4 + this.pictures.length - 1) cell.style.setProperty("--glow", `${Math.round(60 * this.glow(by[joint]))}%`);
      });
    });
  }

  listenTo(canvas) {
    let last = null;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      last = [event.clientX, event.clientY];
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      this.turn((event.clientX - last[0]) * -0.008, (event.clientY - last[1]) * -0.008);
      last = [event.clientX, event.clientY];
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => (last = null));
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== canvas) return;  // the page scrolls
      event.preventDefault();
      this.approach(Math.exp(event.deltaY * 0.001));
    }, { passive: false });
    canvas.addEventListener("dblclick", () => {
      this.view.reset();
      this.request();
    });
    const keys = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
    canvas.addEventListener("keydown", (event) => {
      if (keys[event.key]) this.turn(...keys[event.key]);
      else if (event.key === "+") this.approach(0.9);
      else if (event.key === "-") this.approach(1 / 0.9);
      else return;
      event.preventDefault();
    });
  }

  turn(about, up) {
    this.view.azimuth += about;
    this.view.elevation = clamp(this.view.elevation + up, -1.5, 1.2);
    this.request();
  }

  approach(factor) {
    this.view.distance = clamp(this.view.distance * factor, 0.25 * this.data.camera.distance, 4 * this.data.camera.distance);
    this.request();
  }

  // While plots of its recording are looked at and the replay is out of sight, it floats in the corner.
  float() {
    const plots = new Set();
    let visible = true;
    const update = () => {
      const floats = !visible && plots.size > 0 && this.keep.checked;
      if (floats) this.place.style.height = `${this.place.offsetHeight}px`;
      else this.place.style.height = "";
      this.stageElement.classList.toggle("floating", floats);
      this.request();
    };
    new IntersectionObserver((entries) => {
      visible = entries[entries.length - 1].isIntersecting;
      update();
    }).observe(this.place);
    const observer = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        const own = entry.isIntersecting && entry.target.dataset.recording === this.recording.name;
        plots[own ? "add" : "delete"](entry.target);
      }
      update();
    });
    document.querySelectorAll(".plot").forEach((plot) => {
      if (plot.dataset.recording) observer.observe(plot);
    });
    this.keep.addEventListener("change", update);
  }
}

function startReplay() {
  const holder = document.querySelector(".replay");
  if (holder) new Replay(holder);
}
