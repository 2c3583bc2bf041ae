// The reports' style sheet: light and dark by the reader's preference, one column, good on paper.
#pragma once

namespace lacuna {

inline constexpr char kStyleSheet[] = R"css(
:root { color-scheme: light dark;
  --ground: #f7f7f5; --surface: #ffffff; --ink: #1a1d22; --muted: #5b626d; --line: #e2e4e8; --soft: #f1f2f4;
  --measured: #1a1d22; --before: #d4571e; --after: #1f62c9; --other: #7a5bb5;
  --good: #1b7f46; --found: #1f62c9; --open: #a86400; }
@media (prefers-color-scheme: dark) { :root {
  --ground: #121418; --surface: #1a1d22; --ink: #e7e9ec; --muted: #9aa2ad; --line: #30353d; --soft: #23272e;
  --measured: #e7e9ec; --before: #f0834d; --after: #6aa5f8; --other: #b79bea;
  --good: #4cc07f; --found: #6aa5f8; --open: #e0a040; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--ground); color: var(--ink);
  font: 15px/1.55 system-ui, -apple-system, "Segoe UI", "Helvetica Neue", Arial, sans-serif; }
main { max-width: 1060px; margin: 0 auto; padding: 40px 28px 80px; }
h1 { font-size: 30px; line-height: 1.2; margin: 0 0 18px; letter-spacing: -.01em; overflow-wrap: anywhere; }
h2 { font-size: 20px; line-height: 1.3; margin: 0 0 14px; letter-spacing: -.005em; }
h3 { font-size: 15.5px; margin: 26px 0 6px; overflow-wrap: anywhere; }
p { margin: 0 0 12px; max-width: 78ch; overflow-wrap: anywhere; }
ul { margin: 0 0 12px; padding-left: 20px; } li { margin: 3px 0; max-width: 78ch; overflow-wrap: anywhere; }
.kicker { color: var(--muted); font-size: 13px; letter-spacing: .06em; text-transform: uppercase; margin: 0 0 4px; }
.muted { color: var(--muted); } .small { font-size: 13px; }
.lead { font-size: 20px; line-height: 1.45; max-width: none; margin: 0 0 22px; padding: 16px 20px;
  background: var(--surface); border: 1px solid var(--line); border-left: 5px solid var(--muted); border-radius: 8px; }
.lead.good { border-left-color: var(--good); } .lead.found { border-left-color: var(--found); }
.lead.open { border-left-color: var(--open); }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(190px, 1fr)); gap: 12px; margin: 0 0 26px; }
.tile { background: var(--surface); border: 1px solid var(--line); border-radius: 8px; padding: 12px 16px; }
.tile dt { color: var(--muted); font-size: 13px; }
.tile dd { margin: 2px 0 0; font-size: 22px; font-weight: 600; line-height: 1.25; font-variant-numeric: tabular-nums;
  overflow-wrap: anywhere; }
.tile dd.hint { font-size: 13px; font-weight: 400; color: var(--muted); }
nav { display: flex; flex-wrap: wrap; gap: 4px 18px; padding: 10px 0; margin: 0 0 22px; font-size: 13.5px;
  border-top: 1px solid var(--line); border-bottom: 1px solid var(--line); }
a { color: var(--found); text-decoration: none; } a:hover, a:focus { text-decoration: underline; }
section { background: var(--surface); border: 1px solid var(--line); border-radius: 10px; padding: 22px 24px;
  margin: 0 0 20px; }
.scroll { overflow-x: auto; margin: 0 0 14px; /* a shadow at the side where there is more */
  background: linear-gradient(90deg, var(--surface) 30%, transparent) 0 0 / 40px 100% no-repeat local,
    linear-gradient(270deg, var(--surface) 30%, transparent) 100% 0 / 40px 100% no-repeat local,
    linear-gradient(90deg, rgb(0 0 0 / .22), transparent) 0 0 / 12px 100% no-repeat scroll,
    linear-gradient(270deg, rgb(0 0 0 / .22), transparent) 100% 0 / 12px 100% no-repeat scroll; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: 6px 12px 6px 0; border-bottom: 1px solid var(--line); }
th { color: var(--muted); font-weight: 500; font-size: 12.5px; vertical-align: bottom; }
td { overflow-wrap: break-word; } td.num, th.num { text-align: right; } td.num { white-space: nowrap; }
td.num + td:not(.num), th.num + th:not(.num) { padding-left: 12px; }
th:last-child, td:last-child { padding-right: 0; }
tr.emphasised td { background: color-mix(in srgb, var(--found) 10%, transparent); font-weight: 600; }
.tag { display: inline-block; padding: 0 7px; border-radius: 9px; font-size: 12px; background: var(--soft);
  color: var(--muted); white-space: nowrap; }
.tag.warn { color: var(--open); } .tag.fine { color: var(--good); }
.card { border-top: 1px solid var(--line); padding-top: 14px; margin-top: 16px; }
.card h3 { margin-top: 0; }
.facts { display: grid; grid-template-columns: max-content 1fr; gap: 4px 18px; margin: 0 0 10px; font-size: 13.5px; }
.facts dt { color: var(--muted); } .facts dd { margin: 0; overflow-wrap: anywhere; }
code { font: 12.5px/1.5 ui-monospace, "SF Mono", Menlo, Consolas, monospace; overflow-wrap: anywhere; }
td:first-child code { white-space: nowrap; }
figure { margin: 0 0 16px; break-inside: avoid; } figcaption { font-size: 13px; color: var(--muted); }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(440px, 1fr)); gap: 8px 24px; }
svg { display: block; width: 100%; height: auto; font-family: inherit; color: var(--ink); }
svg.chart { max-width: 960px; }
.gallery { display: grid; grid-template-columns: repeat(auto-fill, minmax(300px, 1fr)); gap: 16px; }
img { display: block; width: 100%; height: auto; border-radius: 6px; border: 1px solid var(--line); background: #fff; }
details { margin: 0 0 12px; } summary { cursor: pointer; color: var(--found); font-size: 13.5px; margin: 0 0 8px; }
.plot.drawn > svg, .plot.drawn > .drawing { display: none; }
.live-head { display: flex; flex-wrap: wrap; align-items: baseline; gap: 2px 14px; font-size: 12.5px; min-height: 24px;
  padding: 2px 0 2px 62px; color: var(--muted); }
.live-title { color: var(--ink); overflow-wrap: anywhere; }
.live-key { display: inline-flex; align-items: baseline; gap: 6px; font: inherit; color: inherit; background: none;
  border: 0; padding: 0; text-align: left; overflow-wrap: anywhere; }
button.live-key { cursor: pointer; } button.live-key:hover { color: var(--ink); } .live-key.off { opacity: .4; }
.live-value { color: var(--ink); font-variant-numeric: tabular-nums; min-width: 7ch; } .live-value:empty { display: none; }
.swatch { flex: none; width: 18px; height: 0; border-top: 2.5px solid var(--muted); align-self: center; }
.swatch.dashed { border-top-style: dashed; } .swatch.measured { border-color: var(--measured); }
.swatch.before { border-color: var(--before); } .swatch.after { border-color: var(--after); }
.swatch.other { border-color: var(--other); }
.swatch.band, .swatch.shade, .swatch.ghost { height: 10px; border: 0; background: var(--good); opacity: .35; }
.swatch.shade { background: var(--open); } .swatch.ghost { background: #78808c; opacity: .7; border-radius: 2px; }
.live-area { position: relative; width: 100%; cursor: crosshair; touch-action: pan-y; }
.live-area:focus-visible, .replay canvas:focus-visible, .acts:focus-visible { outline: 2px solid var(--found);
  outline-offset: 2px; border-radius: 3px; }
.live-cursor { position: absolute; top: 0; bottom: 20px; left: 0; width: 1px; background: var(--ink); opacity: .55;
  pointer-events: none; }
.live-foot { display: flex; justify-content: space-between; gap: 12px; font-size: 12.5px; color: var(--muted);
  padding: 0 8px 0 62px; } .live-instant { color: var(--ink); font-variant-numeric: tabular-nums; }
.dygraph-axis-label { color: var(--muted); font-size: 12px; }
.acts { cursor: pointer; } tr.acts:hover td, tr.acts.kept td { background: color-mix(in srgb, var(--found) 12%, transparent); }
.card.acts:hover h3, .card.acts.kept h3 { color: var(--found); }
.replay-stage { background: var(--surface); }
.replay-views { display: grid; grid-template-columns: repeat(auto-fit, minmax(300px, 1fr)); gap: 14px; }
.replay-view { margin: 0; min-width: 0; } .replay-view figcaption { display: flex; flex-wrap: wrap; gap: 2px 16px;
  font-size: 13px; margin: 0 0 4px; } .replay-off { margin-left: auto; color: var(--open); }
.replay-view canvas { display: block; width: 100%; aspect-ratio: 4 / 3; border: 1px solid var(--line); border-radius: 8px;
  background: linear-gradient(var(--soft), var(--surface)); cursor: grab; touch-action: none; }
.replay-view canvas:active { cursor: grabbing; }
.replay-view:only-child canvas { aspect-ratio: 2 / 1; }
.replay-bar { display: flex; align-items: center; gap: 12px; margin: 10px 0 8px; }
.replay-play { width: 42px; height: 32px; font-size: 13px; color: var(--surface); background: var(--found); border: 0;
  border-radius: 6px; cursor: pointer; }
.replay-slider { flex: 1; min-width: 60px; accent-color: var(--found); }
.replay-clock { font-variant-numeric: tabular-nums; font-size: 13.5px; min-width: 7ch; text-align: right; }
.replay-options { display: flex; flex-wrap: wrap; align-items: center; gap: 6px 20px; font-size: 13px; color: var(--muted);
  margin: 0 0 14px; }
.replay-options select { font: inherit; color: var(--ink); background: var(--surface); border: 1px solid var(--line);
  border-radius: 5px; padding: 2px 4px; max-width: 260px; }
.replay-glow { display: inline-flex; align-items: center; gap: 6px; }
.glow-scale { width: 70px; height: 10px; border-radius: 3px;
  background: linear-gradient(90deg, var(--soft), #e23c1e); border: 1px solid var(--line); }
.replay-table th { white-space: normal; min-width: 76px; }
.replay-table td { padding-top: 3px; padding-bottom: 3px;
  background: color-mix(in srgb, #e23c1e var(--glow, 0%), transparent); }
.replay-table tr.lit td:first-child { box-shadow: inset 3px 0 var(--found); padding-left: 8px; }
.floating { position: fixed; right: 16px; bottom: 16px; width: min(450px, calc(100vw - 32px)); z-index: 30; padding: 10px 12px 4px;
  border: 1px solid var(--line); border-radius: 10px; box-shadow: 0 6px 28px rgb(0 0 0 / .25); }
.floating .replay-views { grid-template-columns: 1fr 1fr; } .floating figcaption { font-size: 12px; }
.floating .replay-view:only-child { grid-column: span 2; } .floating .replay-off { margin: 0; }
footer pre { white-space: pre-wrap; overflow-wrap: anywhere; }
@media (max-width: 640px) { main { padding: 24px 14px 48px; } section { padding: 16px 14px; }
  .pair { grid-template-columns: 1fr; } .lead { font-size: 17px; } .facts { grid-template-columns: 1fr; } }
@media print { :root { --ground: #fff; --surface: #fff; --ink: #000; --muted: #444; --line: #ccc; --soft: #eee;
    --measured: #000; --before: #c24a12; --after: #1550ad; --good: #1b7f46; --found: #1550ad; --open: #8a5200; }
  body { font-size: 10.5pt; } main { max-width: none; padding: 0; } nav { display: none; }
  .plot.drawn > svg { display: block; } .live { display: none; } .floating { position: static; width: auto; }
  .scroll { overflow: visible; background: none; } .replay-options, .replay-bar { display: none; }
  section { border: 0; padding: 8px 0; } tr, .card, .tile { break-inside: avoid; } h2, h3 { break-after: avoid; } }
)css";

}  // namespace lacuna
