"""Style and script of the HTML page. The page loads nothing, and its security policy forbids loading."""

from __future__ import annotations

POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; base-uri 'none'"

STYLE = """
:root { color-scheme: light dark; --line: #8885; --soft: #8882; }
body { font: 14px/1.45 system-ui, sans-serif; margin: 0 auto; max-width: 1200px; padding: 1.5em; }
h1, p { overflow-wrap: anywhere; }
h1 { font-size: 1.5em; margin: 0 0 .2em; } h2 { font-size: 1.15em; margin: 2em 0 .6em; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .15em 1em; margin: 1em 0; }
dt { opacity: .7; } dd { margin: 0; overflow-wrap: anywhere; }
.partial { border-left: 4px solid #d33; padding: .4em .8em; background: #d331; }
.advice { border-left: 4px solid #38f; padding: .4em .8em; background: #38f1; }
.groups { display: grid; grid-template-columns: repeat(auto-fill, minmax(270px, 1fr)); gap: 1em;
  max-height: 75vh; overflow-y: auto; padding: 4px; }
.group { border: 1px solid var(--line); border-radius: 6px; overflow: hidden; background: none; color: inherit;
  font: inherit; text-align: left; padding: 0; cursor: pointer; display: flex; flex-direction: column; }
.group[aria-pressed=true] { outline: 3px solid #38f; }
.group img { display: block; width: 100%; aspect-ratio: 8 / 5; background: #fff; }
.group span { display: block; padding: .5em .8em; overflow-wrap: anywhere; } .group b { display: block; }
.filters { display: flex; flex-wrap: wrap; gap: .6em 1em; align-items: center; margin: 0 0 .8em; }
.filters input[type=search] { min-width: 16em; } select, input, button { font: inherit; }
table { border-collapse: collapse; width: 100%; }
th, td { padding: .35em .6em; text-align: left; vertical-align: top; }
th { border-bottom: 2px solid var(--line); position: sticky; top: 0; background: Canvas; }
td { border-bottom: 1px solid var(--soft); overflow-wrap: break-word; }
.path, .words { overflow-wrap: anywhere; min-width: 16em; } .words { min-width: 8em; }
.number { text-align: right; white-space: nowrap; }
.clash { color: #c22; } .contained, .duplicate { color: #a3c; } .contact { color: #291; } .clearance { color: #27c; }
@media (max-width: 800px) { table { display: block; overflow-x: auto; } .path, .words { overflow-wrap: break-word; } }
@media print { .filters, #more { display: none; } }
"""

SCRIPT = """
"use strict";
const rows = JSON.parse(document.getElementById("data").textContent);
const STEP = 200;
const filters = ["verdict", "status", "severity", "rule"].map((name) => document.getElementById(name));
const text = document.getElementById("text");
const groups = [...document.querySelectorAll(".group")];
const body = document.getElementById("rows");
const more = document.getElementById("more");
let group = null, shown = STEP;

function matching() {
  const words = text.value.toLowerCase().split(/\\s+/).filter(Boolean);
  return rows.filter((row) =>
    filters.every((filter) => !filter.value || row[filter.id] === filter.value) &&
    (group === null || row.group === group) &&
    words.every((word) => row.text.includes(word)));
}

function cell(line, content, name) {
  const made = line.insertCell();
  made.textContent = content;
  if (name) made.className = name;
}

function draw() {
  const found = matching();
  body.replaceChildren();
  for (const row of found.slice(0, shown)) {
    const line = body.insertRow();
    line.id = row.id;
    cell(line, row.verdict, row.verdict);
    cell(line, row.extent, "number");
    if (row.volume) cell(line, row.volume, "number");
    cell(line, row.a, "path");
    cell(line, row.b, "path");
    cell(line, row.place, "number");
    cell(line, row.rule + (row.severity === "major" ? "" : ", " + row.severity), "words");
    cell(line, row.status + (row.by ? " by " + row.by : "") + (row.note ? ": " + row.note : ""), "words");
  }
  const left = found.length - Math.min(found.length, shown);
  more.hidden = left === 0;
  more.textContent = "Show " + Math.min(left, STEP) + " more";
  document.getElementById("count").textContent = found.length + " of " + rows.length + " findings";
}

function again() { shown = STEP; draw(); }
for (const row of rows) row.text = [row.a, row.b, row.rule, row.note, row.id, row.group].join("\\n").toLowerCase();
for (const filter of filters) filter.addEventListener("change", again);
text.addEventListener("input", again);
more.addEventListener("click", () => { shown += STEP; draw(); });
groups.forEach((each) => each.addEventListener("click", () => {
  group = group === each.dataset.group ? null : each.dataset.group;
  for (const other of groups) other.setAttribute("aria-pressed", String(other.dataset.group === group));
  again();
}));
document.getElementById("clear").addEventListener("click", () => {
  for (const filter of filters) filter.value = "";
  text.value = "";
  group = null;
  for (const each of groups) each.setAttribute("aria-pressed", "false");
  again();
});
draw();
"""
