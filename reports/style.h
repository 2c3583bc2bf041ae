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
.scroll { overflow-x: auto; margin: 0 0 14px; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: 6px 12px 6px 0; border-bottom: 1px solid var(--line); }
th { color: var(--muted); font-weight: 500; font-size: 12.5px; white-space: nowrap; vertical-align: bottom; }
td { overflow-wrap: break-word; } td.num, th.num { text-align: right; white-space: nowrap; }
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
@media (max-width: 640px) { main { padding: 24px 14px 48px; } section { padding: 16px 14px; }
  .pair { grid-template-columns: 1fr; } .lead { font-size: 17px; } .facts { grid-template-columns: 1fr; } }
@media print { :root { --ground: #fff; --surface: #fff; --ink: #000; --muted: #444; --line: #ccc; --soft: #eee;
    --measured: #000; --before: #c24a12; --after: #1550ad; --good: #1b7f46; --found: #1550ad; --open: #8a5200; }
  body { font-size: 10.5pt; } main { max-width: none; padding: 0; } nav { display: none; }
  section { border: 0; padding: 8px 0; } tr, .card, .tile { break-inside: avoid; } h2, h3 { break-after: avoid; } }
)css";

}  // namespace lacuna
