// SPDX-License-Identifier: Apache-2.0
// The style sheet of the report: light and dark screens, paper.
#include "fit/report_parts.h"

namespace dermap {

std::string_view ReportStyle() {
  return R"css(
:root { color-scheme: light dark;
  --page: #f4f3f0; --card: #ffffff; --ink: #1f2328; --soft: #5b626b; --line: #dcdad5; --accent: #8a3b2e;
  --good: #1d7a46; --warn: #a15c00; --grid: #e9e7e2;
  --s1: #0072b2; --s2: #d55e00; --s3: #009e73; --s4: #b0579a; --s5: #8a6d00; }
@media (prefers-color-scheme: dark) { :root {
  --page: #15171a; --card: #1e2125; --ink: #e8e6e3; --soft: #a2a8b0; --line: #363b41; --accent: #e39a86;
  --good: #5cc98a; --warn: #f0b04f; --grid: #2b2f34;
  --s1: #56b4e9; --s2: #ff9351; --s3: #3fd0a4; --s4: #e08cc8; --s5: #e6c84a; } }
* { box-sizing: border-box; }
html { scroll-behavior: smooth; }
body { margin: 0; background: var(--page); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
main, header.top { max-width: 1240px; margin: 0 auto; padding: 0 24px; }
header.top { padding-top: 36px; }
h1 { font-size: 28px; line-height: 1.2; margin: 0 0 4px; font-weight: 650; letter-spacing: -0.01em; overflow-wrap: anywhere; }
h2 { font-size: 19px; margin: 0 0 4px; font-weight: 650; }
h3 { font-size: 15px; margin: 26px 0 8px; font-weight: 650; }
.kicker { color: var(--accent); font-size: 12.5px; font-weight: 650; letter-spacing: 0.08em; text-transform: uppercase; margin: 0 0 6px; }
.verdict { font-size: 16px; max-width: 78ch; margin: 8px 0 18px; }
.badge { display: inline-block; border: 1px solid; border-radius: 999px; padding: 1px 11px; font-size: 13px; font-weight: 650; margin-right: 8px; }
.badge.good { color: var(--good); } .badge.warn { color: var(--warn); }
nav { display: flex; flex-wrap: wrap; gap: 4px 16px; margin: 16px 0 4px; font-size: 13.5px; }
a { color: var(--accent); text-decoration: none; } a:hover { text-decoration: underline; }
section { background: var(--card); border: 1px solid var(--line); border-radius: 12px; padding: 22px 24px 24px; margin: 18px 0; }
.lead { color: var(--soft); max-width: 88ch; margin: 0 0 16px; }
.tiles { display: grid; grid-template-columns: repeat(4, minmax(0, 1fr)); gap: 12px; margin: 18px 0 0; }
@media (max-width: 760px) { .tiles { grid-template-columns: repeat(2, minmax(0, 1fr)); } }
.tile { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 12px 16px; }
.tile .k { color: var(--soft); font-size: 12.5px; display: block; }
.tile .v { font-size: 23px; font-weight: 650; line-height: 1.25; font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }
.tile .v.text { font-size: 16px; }
.tile .d { color: var(--soft); font-size: 12.5px; display: block; }
.grid { display: grid; gap: 22px 20px; align-items: start; }
.grid.c2 { grid-template-columns: repeat(2, minmax(0, 1fr)); }
.grid.c3 { grid-template-columns: repeat(3, minmax(0, 1fr)); }
.split { display: grid; gap: 20px 32px; grid-template-columns: minmax(0, 2.1fr) minmax(0, 1fr); align-items: start; }
.split.even { grid-template-columns: minmax(0, 1fr) minmax(0, 1.25fr); }
#pixel-stage { cursor: crosshair; } #pixel-stage:focus-visible { outline: 3px solid var(--accent); outline-offset: 2px; }
#pixel-mark { pointer-events: none; }
@media (max-width: 760px) { .split, .split.even { grid-template-columns: 1fr; } }
.grid.c4 { grid-template-columns: repeat(4, minmax(0, 1fr)); }
@media (max-width: 900px) { .grid.c2, .grid.c3, .grid.c4 { grid-template-columns: repeat(2, minmax(0, 1fr)); } }
@media (max-width: 520px) { .grid.c2, .grid.c3, .grid.c4 { grid-template-columns: 1fr; } main, header.top { padding: 0 12px; } section { padding: 16px; } }
figure { margin: 0; min-width: 0; }
figcaption { font-size: 13.5px; margin-bottom: 6px; }
.unit, .note { color: var(--soft); font-size: 12.5px; }
.note { margin: 4px 0 0; }
img { display: block; max-width: 100%; }
img.pixels { width: 100%; height: auto; image-rendering: pixelated; border-radius: 4px; }
img.photo { width: 100%; height: auto; border-radius: 4px; }
.bar { position: relative; margin: 8px 12px 20px; height: 10px; }
img.ramp { width: 100%; height: 10px; max-width: none; border-radius: 2px; outline: 1px solid var(--line); }
.bar .tick { position: absolute; top: 11px; transform: translateX(-50%); font-size: 11.5px; line-height: 1.3; color: var(--soft); font-variant-numeric: tabular-nums; white-space: nowrap; }
.bar .tick::before { content: ""; position: absolute; left: 50%; top: -3px; height: 4px; border-left: 1px solid var(--soft); }
.beyond { position: absolute; top: -3px; font-size: 9px; line-height: 16px; color: var(--soft); }
.beyond.low { left: -11px; } .beyond.high { right: -11px; }
.key { display: inline-block; width: 11px; height: 11px; border-radius: 2px; margin-right: 6px; vertical-align: -1px; }
.swatch { display: inline-block; width: 13px; height: 13px; border-radius: 50%; margin-right: 7px; vertical-align: -2px; border: 1px solid rgba(128,128,128,.5); }
.key.missing { background: #ec40c8; }
.stage { position: relative; }
.point { position: absolute; width: 13px; height: 13px; margin: -6.5px 0 0 -6.5px; border: 1.6px solid #fff; border-radius: 50%; box-shadow: 0 0 0 1px rgba(0,0,0,.65), inset 0 0 0 1px rgba(0,0,0,.65); }
.point i { position: absolute; left: 13px; top: -8px; font: 650 13px/1 system-ui, "DejaVu Sans", sans-serif; color: #fff; text-shadow: 0 0 3px #000, 0 0 2px #000, 0 0 1px #000; }
.length { position: absolute; left: 10px; bottom: 8px; border-top: 3px solid #fff; color: #fff; font-size: 12px; line-height: 1.3; text-shadow: 0 0 3px #000, 0 0 2px #000; filter: drop-shadow(0 0 1px #000); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; font-variant-numeric: tabular-nums; }
th { text-align: left; font-weight: 650; color: var(--soft); font-size: 12.5px; vertical-align: bottom; }
th, td { padding: 6px 14px 6px 0; border-bottom: 1px solid var(--line); }
td { vertical-align: top; } .nowrap { white-space: nowrap; }
tbody tr:last-child td { border-bottom: 0; }
.flag img.pixels { width: 84px; max-width: none; }
.triples { display: grid; grid-template-columns: 118px repeat(3, minmax(0, 1fr)); gap: 14px 18px; align-items: start; max-width: 1060px; }
.triples .band { font-weight: 650; padding-top: 24px; } .triples .band .row { display: block; font-weight: 400; color: var(--soft); font-size: 12.5px; }
@media (max-width: 700px) { .triples { grid-template-columns: repeat(3, minmax(0, 1fr)); } .triples .band { grid-column: 1 / -1; padding-top: 0; } }
svg.chart { width: 100%; height: auto; display: block; font: 12px system-ui, "DejaVu Sans", sans-serif; }
svg .axis { stroke: var(--soft); } svg .grid { stroke: var(--grid); }
svg text { fill: var(--soft); } svg text.label { fill: var(--ink); font-size: 12.5px; } svg text.legend { fill: var(--ink); font-size: 12.5px; }
svg .mid { text-anchor: middle; } svg .end { text-anchor: end; }
svg .reference { stroke: var(--soft); stroke-dasharray: 3 4; }
svg .curve { fill: none; stroke-width: 2; stroke-linejoin: round; } svg .curve.dashed { stroke-dasharray: 6 4; }
svg .dot { stroke: var(--card); stroke-width: 1; } svg .whisker { stroke-width: 1.5; }
svg .s0 { stroke: var(--ink); } svg .dot.s0 { fill: var(--ink); stroke: var(--card); }
svg .s1 { stroke: var(--s1); } svg .dot.s1 { fill: var(--s1); stroke: var(--card); }
svg .s2 { stroke: var(--s2); } svg .dot.s2 { fill: var(--s2); stroke: var(--card); }
svg .s3 { stroke: var(--s3); } svg .dot.s3 { fill: var(--s3); stroke: var(--card); }
svg .s4 { stroke: var(--s4); } svg .dot.s4 { fill: var(--s4); stroke: var(--card); }
svg .s5 { stroke: var(--s5); } svg .dot.s5 { fill: var(--s5); stroke: var(--card); }
ul.sentences { margin: 0; padding-left: 20px; } ul.sentences li { margin: 4px 0; max-width: 100ch; }
dl { display: grid; grid-template-columns: minmax(120px, 190px) 1fr; gap: 8px 20px; margin: 0; } dt { font-weight: 650; } dd { margin: 0; max-width: 88ch; }
footer { color: var(--soft); font-size: 12.5px; padding: 4px 2px 40px; }
@media print {
  :root { --page: #fff; --card: #fff; --ink: #000; --soft: #444; --line: #bbb; --grid: #ddd; --accent: #000;
    --s1: #0072b2; --s2: #d55e00; --s3: #009e73; --s4: #b0579a; --s5: #8a6d00; }
  body { font-size: 11px; } figcaption, .unit, .note { font-size: 8.5px; } table, th { font-size: 9px; } .tiles { grid-template-columns: repeat(4, minmax(0, 1fr)); gap: 6px; } .tile { padding: 6px 9px; } .tile .v { font-size: 15px; } .tile .v.text { font-size: 11px; } .tile .k, .tile .d { font-size: 8.5px; } h3 { margin: 14px 0 5px; }
  .bar .tick { font-size: 7px; } nav { display: none; }
  main, header.top { max-width: none; padding: 0; } section, .tile { border-radius: 0; }
  section { border-width: 1px 0 0; padding: 12px 0; margin: 0 0 6px; }
  .grid.c2 { grid-template-columns: repeat(2, minmax(0, 1fr)); } .grid.c3 { grid-template-columns: repeat(3, minmax(0, 1fr)); } .grid.c4 { grid-template-columns: repeat(4, minmax(0, 1fr)); }
  .triples { grid-template-columns: 90px repeat(3, minmax(0, 1fr)); }
  figure, .tile, tr, svg.chart { break-inside: avoid; } h2, h3 { break-after: avoid; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; } }
)css";
}

}  // namespace dermap
