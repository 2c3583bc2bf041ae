"use strict";
// Plots that zoom and share a cursor: each takes the place of the drawing beside its data once it comes into view.

const GRAPH_LEFT = 62;     // px, room of the y axis: one for all plots, so that they align
const TICK_EXPONENT = 3;   // beyond 10^-3..10^4 the axis title carries a power of ten
const DRAWING_TEXT = 40;   // px of a drawing's height that its words take

class Plot {
  constructor(holder) {
    this.holder = holder;
    this.data = readBlock(holder.querySelector("script.plot-data"));
    this.track = stage.track(this.data.recording);
    this.readCurves();
  }

  readCurves() {
    this.curves = [];
    const blocks = this.data.blocks.map((block) => ({ x: unpack(block.x), curves: block.curves }));
    for (const block of blocks) {
      const falls = block.x[0] > block.x[block.x.length - 1];
      if (falls) block.x.reverse();
      for (const curve of block.curves) {
        const y = unpack(curve.y);
        this.curves.push({ ...curve, x: block.x, y: falls ? y.reverse() : y, shown: true });
      }
    }
    const rows = [];
    let first = 0;
    for (const block of blocks) {
      const ys = this.curves.slice(first, first + block.curves.length).map((curve) => curve.y);
      block.x.forEach((x, i) => {
        if (!Number.isFinite(x) || (this.data.x.log && x <= 0)) return;
        const row = new Array(this.curves.length + 1).fill(null);
        row[0] = x;
        ys.forEach((y, k) => (row[first + k + 1] = this.drawable(y[i])));
        rows.push(row);
      });
      first += block.curves.length;
    }
    this.rows = rows.sort((a, b) => a[0] - b[0]);
  }

  // null joins its neighbours, NaN breaks the line; beyond the limit the line runs along it.
  drawable(value) {
    if (!Number.isFinite(value) || (this.data.y.log && value <= 0)) return NaN;
    const limit = this.data.y.limit;
    return limit ? clamp(value, limit[0], limit[1]) : value;
  }

  build() {
    const root = makeElement("div", "live");
    this.head = makeElement("div", "live-head");
    this.title = makeElement("span", "live-title");
    this.head.append(this.title);
    this.curves.forEach((curve, i) => this.addKey(curve, i));
    if (this.data.band && this.data.band_label) this.head.append(this.patch("band", this.data.band_label));
    if (this.data.shaded_label) this.head.append(this.patch("shade", this.data.shaded_label));
    this.area = makeElement("div", "live-area");
    this.area.style.height = `${Math.max(this.data.height - DRAWING_TEXT, 90)}px`;
    this.area.tabIndex = 0;
    this.area.setAttribute("role", "img");
    this.area.setAttribute("aria-label", `${this.data.title}. Drag to zoom, double click for all, arrow keys move the cursor.`);
    this.line = makeElement("div", "live-cursor");
    this.line.hidden = true;
    root.append(this.head, this.area);
    if (this.data.labels) {
      this.foot = makeElement("div", "live-foot");
      this.instant = makeElement("span", "live-instant");
      this.below = makeElement("span", "", axisTitle(this.data.x.label, this.data.x.unit, 0));
      this.foot.append(this.instant, this.below);
      root.append(this.foot);
    }
    root.style.maxWidth = `${this.data.width}px`;
    this.holder.append(root);
    this.holder.classList.add("drawn");
    this.draw();
    this.area.append(this.line);
    this.listen();
    if (this.track.time !== null) this.showTime(this.track.time);
  }

  addKey(curve, i) {
    if (!curve.label) return;
    const key = makeElement("button", "live-key");
    key.type = "button";
    key.title = "Shows or hides this line";
    const swatch = makeElement("span", `swatch ${curve.ink}${curve.dashed ? " dashed" : ""}`);
    curve.value = makeElement("span", "live-value");
    key.append(swatch, makeElement("span", "", curve.label), curve.value);
    key.addEventListener("click", () => {
      curve.shown = !curve.shown;
      key.classList.toggle("off", !curve.shown);
      this.graph.setVisibility(i, curve.shown);
    });
    this.head.append(key);
  }

  patch(kind, label) {
    const key = makeElement("span", "live-key");
    key.append(makeElement("span", `swatch ${kind}`), makeElement("span", "", label));
    return key;
  }

  draw() {
    const xs = this.rows.map((row) => row[0]);
    this.full = this.data.x.range || [xs[0], xs[xs.length - 1]];
    const series = {};
    this.curves.forEach((curve, i) => {
      series[`s${i}`] = {
        strokeWidth: curve.points ? 0 : curve.width,
        strokePattern: curve.dashed ? [6, 4] : null,
        drawPoints: curve.points,
        pointSize: curve.width / 2,
      };
    });
    this.graph = new Dygraph(this.area, this.rows, {
      labels: ["x", ...Object.keys(series)],
      series,
      ...this.colors(),
      legend: "never",
      showLabelsOnHighlight: false,
      highlightCircleSize: 0,
      connectSeparatedPoints: true,
      dateWindow: this.track.range || this.full,
      logscale: this.data.y.log,
      rightGap: 8,
      axes: {
        x: { logscale: this.data.x.log, axisLabelFormatter: (v) => this.tick(v, 0), pixelsPerLabel: 70, drawGrid: false },
        y: { axisLabelFormatter: (v) => this.tick(v, this.exponent()), axisLabelWidth: GRAPH_LEFT - 8, pixelsPerLabel: 28 },
      },
      underlayCallback: (context, area, graph) => this.shade(context, area, graph),
      drawCallback: () => this.drawn(),
    });
    this.drawn();
  }

  colors() {
    const muted = themeColor("line");
    return { colors: this.curves.map((curve) => themeColor(curve.ink)), gridLineColor: muted, axisLineColor: muted };
  }

  // Of the y axis as it is shown now.
  exponent() {
    if (this.data.y.log || !this.graph || !this.graph.yAxisRange) return this.lastExponent || 0;
    const range = this.graph.yAxisRange();
    const decade = Math.floor(Math.log10(Math.max(Math.abs(range[0]), Math.abs(range[1]), 1e-300)));
    this.lastExponent = decade > -TICK_EXPONENT && decade < TICK_EXPONENT + 2 ? 0 : decade;
    return this.lastExponent;
  }

  tick(value, exponent) {
    if (exponent === 0) return formatted(value, 6);
    return formatted(Number((value / 10 ** exponent).toPrecision(6)), 6);
  }

  shade(context, area, graph) {
    const stretch = ([from, to], color, alpha) => {
      const left = clamp(graph.toDomXCoord(from), area.x, area.x + area.w);
      const right = clamp(graph.toDomXCoord(to), area.x, area.x + area.w);
      if (!(right >= left) || from > graph.xAxisRange()[1] || to < graph.xAxisRange()[0]) return;
      context.globalAlpha = alpha;
      context.fillStyle = themeColor(color);
      context.fillRect(left, area.y, Math.max(right - left, 1.5), area.h);
    };
    (this.data.shaded || []).forEach((of) => stretch(of, "open", 0.16));
    this.track.stretches.forEach((of) => stretch(of, "found", 0.24));
    if (this.data.band && this.data.band.every(Number.isFinite)) {
      const [low, high] = this.data.band.map((v) => clamp(graph.toDomYCoord(v), area.y, area.y + area.h));
      context.globalAlpha = 0.2;
      context.fillStyle = themeColor("good");
      context.fillRect(area.x, high, area.w, Math.max(low - high, 1));
    }
    context.globalAlpha = 1;
    if (!this.data.zero) return;
    const zero = graph.toDomYCoord(0);
    if (!(zero > area.y && zero < area.y + area.h)) return;
    context.fillStyle = themeColor("muted");
    context.fillRect(area.x, Math.round(zero), area.w, 1);
  }

  // After every drawing: the title's power of ten, the cursor's place, and what the others must follow.
  drawn() {
    const graph = this.graph;
    if (!graph || this.quiet) return;
    const range = graph.xAxisRange();
    this.area.dataset.from = range[0];
    this.area.dataset.to = range[1];
    if (this.drawnExponent !== this.exponent()) {
      // Labels were made with the axis as it was before.
      this.drawnExponent = this.exponent();
      this.quietly(() => graph.updateOptions({}));
    }
    this.title.textContent = axisTitle(this.data.y.label, this.data.y.unit, this.exponent());
    this.placeLine();
    const known = this.track.range || this.full;
    const moved = Math.abs(range[0] - known[0]) + Math.abs(range[1] - known[1]);
    if (moved > 1e-9 * Math.abs(this.full[1] - this.full[0])) this.track.setRange(range, this);
  }

  quietly(action) {
    this.quiet = true;
    try {
      action();
    } finally {
      this.quiet = false;
    }
  }

  follow(range) {
    this.quietly(() => this.graph.updateOptions({ dateWindow: range || this.full }));
    this.drawn();
  }

  placeLine() {
    const time = this.track.time;
    const range = this.graph.xAxisRange();
    this.line.hidden = time === null || time < range[0] || time > range[1];
    if (!this.line.hidden) this.line.style.transform = `translateX(${this.graph.toDomXCoord(time)}px)`;
  }

  showTime(time) {
    this.placeLine();
    if (this.instant) this.instant.textContent = axisTitle(`${this.data.x.label} ${formatted(time)}`, this.data.x.unit, 0).replace(",", "");
    for (const curve of this.curves)
      if (curve.value && !curve.points) curve.value.textContent = formatted(valueAt(curve.x, curve.y, time), 4);
  }

  listen() {
    this.track.timeListeners.add((time) => this.showTime(time));
    this.track.rangeListeners.add((range, source) => source !== this && this.follow(range));
    this.track.markListeners.add(() => this.quietly(() => this.graph.updateOptions({})));
    onThemeChange(() => this.quietly(() => this.graph.updateOptions(this.colors())));
    const look = (event) => {
      if (this.track.held) return;
      const x = event.clientX - this.area.getBoundingClientRect().left;
      this.track.setTime(clamp(this.graph.toDataXCoord(x), ...this.graph.xAxisRange()), this);
    };
    this.area.addEventListener("pointermove", look);
    this.area.addEventListener("pointerdown", look);
    this.area.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    const [from, to] = this.graph.xAxisRange();
    const time = this.track.time === null ? (from + to) / 2 : this.track.time;
    const step = (to - from) * (event.shiftKey ? 0.05 : 0.005);
    const zoom = (factor) => {
      const range = [time - (time - from) * factor, time + (to - time) * factor];
      this.track.setRange([Math.max(range[0], this.full[0]), Math.min(range[1], this.full[1])]);
    };
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "ArrowLeft") this.track.setTime(clamp(time - step, ...this.full), this);
    else if (event.key === "ArrowRight") this.track.setTime(clamp(time + step, ...this.full), this);
    else if (event.key === "+" || event.key === "=") zoom(0.6);
    else if (event.key === "-") zoom(1 / 0.6);
    else if (event.key === "0" || event.key === "Home") this.track.setRange(null);
    else return;
    event.preventDefault();
  }
}

// Drawings far below are left alone until they come near.
function startPlots() {
  if (typeof Dygraph === "undefined") return;
  const observer = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      observer.unobserve(entry.target);
      new Plot(entry.target).build();
    }
  }, { rootMargin: "600px 0px" });
  document.querySelectorAll(".plot").forEach((holder) => observer.observe(holder));
}
