"""Style and script of the page. The page loads nothing, and its security policy forbids loading."""

from __future__ import annotations

STYLE = """
:root {
  color-scheme: light dark;
  --ink: #1b2430; --soft: #55606e; --paper: #ffffff; --card: #f6f8fa; --line: #d5dbe2; --link: #0a5cad;
  --bad: #b3261e; --bad-back: #fdecea; --good: #1d6b34; --good-back: #e6f4ea; --warn: #7a4b00; --warn-back: #fff3d6;
  --plain-back: #e9edf2; --a: #2a66ad; --b: #a34f00;
}
@media (prefers-color-scheme: dark) { :root {
  --ink: #e6eaf0; --soft: #a3adba; --paper: #14181d; --card: #1c2229; --line: #38424e; --link: #7db8f5;
  --bad: #ff9d94; --bad-back: #3d1a18; --good: #86d79b; --good-back: #16321f; --warn: #f3c46b; --warn-back: #38290b;
  --plain-back: #2a323c; --a: #6aa4ea; --b: #ff9a3d;
} }
* { box-sizing: border-box; }
body { font: 15px/1.5 system-ui, "Segoe UI", Roboto, sans-serif; margin: 0; color: var(--ink);
  background: var(--paper); }
main, header, footer { max-width: 1120px; margin: 0 auto; padding: 0 24px; }
header { padding-top: 32px; }
.made { color: var(--soft); margin: 0; }
h1 { font-size: 30px; line-height: 1.2; margin: 4px 0; overflow-wrap: anywhere; }
h2 { font-size: 22px; margin: 48px 0 12px; padding-top: 12px; border-top: 2px solid var(--line); }
h3 { font-size: 17px; margin: 28px 0 10px; } h4 { font-size: 15px; margin: 0 0 4px; overflow-wrap: anywhere; }
p { margin: 0 0 10px; } a { color: var(--link); }
a:focus-visible, button:focus-visible, input:focus-visible { outline: 3px solid var(--link); outline-offset: 2px; }
nav { display: flex; flex-wrap: wrap; gap: 4px 18px; margin: 18px 0 0; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(190px, 100%), 1fr)); gap: 12px;
  margin: 22px 0 0; }
.tile { border: 1px solid var(--line); border-radius: 8px; padding: 12px 16px; background: var(--card); color: inherit;
  text-decoration: none; display: block; }
.tile b { display: block; font-size: 26px; line-height: 1.2; } .tile span { color: var(--soft); }
.tile.bad b { color: var(--bad); } .tile.good b { color: var(--good); }
.notice { border-left: 5px solid var(--warn); background: var(--warn-back); padding: 10px 14px; margin: 16px 0 0;
  border-radius: 4px; overflow-wrap: anywhere; }
.notice p:last-child, .notice ul { margin: 0; } .notice ul { padding-left: 20px; }
.notice.bad { border-color: var(--bad); background: var(--bad-back); }
.where { min-width: 200px; } .between { min-width: 140px; } .link { margin: 8px 0 0; }
td p { margin: 0; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 3px 18px; margin: 10px 0; }
dt { color: var(--soft); } dd { margin: 0; overflow-wrap: anywhere; min-width: 0; }
code { font: 13px ui-monospace, Consolas, monospace; overflow-wrap: anywhere; }
.chip { display: inline-block; border-radius: 10px; padding: 0 9px; font-size: 13px; font-weight: 600;
  white-space: nowrap;
  background: var(--plain-back); }
.chip.bad { color: var(--bad); background: var(--bad-back); }
.chip.good { color: var(--good); background: var(--good-back); }
.chip.warn { color: var(--warn); background: var(--warn-back); }
.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(310px, 100%), 1fr)); gap: 16px; }
.card { border: 1px solid var(--line); border-radius: 8px; overflow: hidden; background: var(--card); }
.card img, .film img { display: block; width: 100%; height: auto; background: #eef0f3; }
.card .text { padding: 10px 14px 12px; overflow-wrap: anywhere; } .card .text p { margin: 0 0 4px; }
.wide { padding: 14px 18px 16px; margin: 0 0 18px; }
.wide > p { max-width: 75ch; } .wide h3 { margin-top: 0; }
.part { overflow-wrap: anywhere; } .folder { color: var(--soft); font-size: 13px; }
.a, .b { font-weight: 600; } .a { color: var(--a); } .b { color: var(--b); }
.chip + .chip { margin-left: 6px; }
.soft { color: var(--soft); } .stale { color: var(--warn); }
.film { margin: 10px 0 0; max-width: 640px; }
.frames { display: grid; grid-template-columns: repeat(3, 1fr); gap: 6px; }
.frames.two { grid-template-columns: repeat(2, 1fr); }
.frames img { border: 1px solid var(--line); border-radius: 6px; }
.live .frames { display: block; } .live .frames img { display: none; } .live .frames img.on { display: block; }
.player { display: none; gap: 12px; align-items: center; margin-top: 8px; } .live .player { display: flex; }
.player input { flex: 1; min-width: 0; }
button, input { font: inherit; color: inherit; }
button { border: 1px solid var(--line); background: var(--plain-back); border-radius: 6px; padding: 3px 14px;
  min-width: 76px;
  cursor: pointer; }
input[type=search] { border: 1px solid var(--line); background: var(--paper); border-radius: 6px; padding: 4px 10px;
  width: min(340px, 100%); }
table { border-collapse: collapse; width: 100%; margin: 8px 0 14px; font-size: 14px; }
th, td { padding: 6px 10px; text-align: left; vertical-align: top; border-bottom: 1px solid var(--line); }
bdi { overflow-wrap: anywhere; } .wide thead th { background: var(--card); }
thead th { border-bottom: 2px solid var(--line); background: var(--paper); position: sticky; top: 0; }
tbody th { background: var(--card); font-size: 14px; }
td.number, th.number { text-align: right; }
td.number, .short { white-space: nowrap; } td.at { font-size: 12px; white-space: normal; }
.narrow { width: auto; min-width: 340px; }
.chunk { content-visibility: auto; }
.rows { table-layout: fixed; margin: 0; } .rows tbody td { overflow-wrap: break-word; }
.rows th:nth-child(1) { width: 6%; } .rows th:nth-child(2) { width: 10%; } .rows th:nth-child(3) { width: 12%; }
.rows th:nth-child(4) { width: 28%; } .rows th:nth-child(5) { width: 18%; } .rows th:nth-child(6) { width: 16%; }
.curve { margin: 12px 0 0; max-width: 640px; break-inside: avoid; }
.curve svg { display: block; width: 100%; height: auto; }
.curve path { stroke: var(--line); stroke-width: 1; } .curve polyline { fill: none; stroke: var(--a); stroke-width: 2; }
figcaption { color: var(--soft); font-size: 13px; }
ol.steps { list-style: none; padding: 0; margin: 0; counter-reset: step; }
ol.steps > li { counter-increment: step; display: grid; grid-template-columns: 44px minmax(0, 1fr) minmax(0, 380px);
  gap: 6px 16px; padding: 14px 0; border-bottom: 1px solid var(--line); }
ol.steps > li::before { content: counter(step); font-size: 20px; font-weight: 700; width: 36px; height: 36px;
  border-radius: 18px; background: var(--plain-back); text-align: center; line-height: 36px; }
ol.steps .film { margin: 0; } ol.steps dl { margin: 4px 0 0; }
ul.plain { margin: 0 0 8px; padding-left: 20px; }
footer { color: var(--soft); font-size: 13px; padding-top: 28px; padding-bottom: 40px; }
[hidden] { display: none !important; }
@media (max-width: 760px) {
  ol.steps > li { grid-template-columns: 44px 1fr; } ol.steps .film { grid-column: 2; }
  .scroll { overflow-x: auto; } .rows { min-width: 900px; }
}
@media print {
  :root { color-scheme: light; --ink: #000; --soft: #444; --paper: #fff; --card: #fff; --line: #bbb; --link: #000;
    --bad: #a01010; --bad-back: #fff; --good: #0b5a22; --good-back: #fff; --warn: #6b4200; --warn-back: #fff;
    --plain-back: #fff; --a: #2a62a8; --b: #b85c00; }
  @page { margin: 14mm; }
  body { font-size: 10pt; } main, header, footer { max-width: none; padding: 0; }
  nav, .player, .filter { display: none !important; }
  h1 { font-size: 20pt; } h2 { font-size: 14pt; margin-top: 18pt; } h3 { font-size: 11pt; }
  h2, h3, h4, thead { break-after: avoid; }
  .card, .tile, ol.steps > li, tr, .film { break-inside: avoid; } .wide { break-inside: auto; }
  .cards { grid-template-columns: repeat(2, 1fr); }
  .chip { border: 1px solid currentColor; font-size: inherit; padding: 0 6px; }
  code { font-size: 8pt; }
  .live .frames { display: grid; } .live .frames img { display: block; }
  .tile b { font-size: 16pt; } table { font-size: 8.5pt; } thead th { position: static; } .folder { font-size: 8pt; }
  .chunk { content-visibility: visible; }
}
"""

CHUNK = 256
"""Findings of one table: browsers lay out only the tables that are near the window, in long lists."""

_ROW_PX, _HEAD_PX = 70, 75
"""Usual heights of a row of these tables and of its heads, which browsers reserve for those that are not laid out."""


def chunk_class(rows: int) -> str:
    """The class of a table of so many findings, which says about how high it is."""
    return f"chunk chunk-{(rows - 1).bit_length()}"


STYLE += "".join(
    f".chunk-{power} {{ contain-intrinsic-size: auto {_HEAD_PX + _ROW_PX * (3 << power) // 4}px; }}\n"
    for power in range(CHUNK.bit_length())
)

SCRIPT = """
"use strict";
for (const film of document.querySelectorAll(".film[data-film]")) {
  const frames = [...film.querySelectorAll("img")];
  const [button, slider] = [film.querySelector("button"), film.querySelector("input")];
  let timer = 0;
  const show = (at) => {
    frames.forEach((frame, k) => frame.classList.toggle("on", k === at));
    slider.value = String(at);
    slider.setAttribute("aria-valuetext", "picture " + (at + 1) + " of " + frames.length);
  };
  const stop = () => { clearInterval(timer); timer = 0; button.textContent = "Play"; };
  const next = () => {
    const at = Number(slider.value) + 1;
    if (at >= frames.length) stop(); else show(at);
  };
  film.classList.add("live");
  show(0);
  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
  button.addEventListener("click", () => {
    if (timer) { stop(); return; }
    if (Number(slider.value) >= frames.length - 1) show(0);
    button.textContent = "Pause";
    timer = setInterval(next, 450);
  });
}
const filter = document.getElementById("filter");
if (filter) {
  const rows = [...document.querySelectorAll(".rows tbody tr[id]")];
  const texts = rows.map((row) => row.textContent.toLowerCase());
  const heads = [...document.querySelectorAll(".chunk")];
  const count = document.getElementById("count");
  filter.closest(".filter").hidden = false;
  filter.addEventListener("input", () => {
    const words = filter.value.toLowerCase().split(/\\s+/).filter(Boolean);
    let shown = 0;
    rows.forEach((row, k) => {
      row.hidden = !words.every((word) => texts[k].includes(word));
      if (!row.hidden) shown += 1;
    });
    for (const head of heads) head.hidden = !head.querySelector("tr[id]:not([hidden])");
    count.textContent = words.length ? shown + " of " + rows.length : "";
  });
}
"""
