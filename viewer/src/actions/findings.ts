// Actions of findings: check, open and export, step and look, mark, ignore.

import type { Job } from "../link/link";
import type { Commands, FindingFormat, FindingSide, FindingStatus, Taken, Written } from "../link/protocol";
import { add, type Box, centre, diagonal, include, isEmpty, normalize, scale, type Vec3 } from "../math/vectors";
import type { Focus } from "../model/finding-state";
import { type Finding, neighbour, partsOf, sentence } from "../model/findings";
import { chooseFile } from "./choosing";
import { download } from "./exports";
import { sendFiles } from "./sending";
import type { Workbench } from "./workbench";

/** From the right, the front and above: where the server says nothing. */
const USUAL: Vec3 = [0.62, -0.66, 0.42];
/** A mark of nothing smaller is seen. */
const LEAST_REACH_M = 1e-4;

// ---- the list ----

/** Checks all pairs of parts, or those with the given ones, and shows what was found. */
export async function checkClashes(wb: Workbench, parts: readonly number[] = []): Promise<void> {
  showPanel(wb);
  const title = parts.length > 0 ? `Clashes of ${partText(wb, parts)}` : "Clash check";
  const job = wb.job("clash", parts.length > 0 ? { parts } : {}, title);
  if (!job) return;
  await wb.told(job.result.then((taken) => take(wb, taken)));
}

const partText = (wb: Workbench, parts: readonly number[]): string =>
  parts.length === 1 ? wb.store.nameOf(parts[0] ?? -1) : `${parts.length} parts`;

/** The parts under the menu, or the selected ones. Where all pairs were checked as they are now, the list is filtered. */
export async function clashesOf(wb: Workbench, parts: readonly number[]): Promise<void> {
  const { findings } = wb.store;
  const check = findings.facts.peek()?.check;
  const [part] = parts;
  if (check && check.of === null && !findings.is_stale.peek() && parts.length === 1 && part !== undefined) {
    showPanel(wb);
    findings.set({ part });
    wb.say(`${findings.shown.peek().rows.length} findings of ${wb.store.nameOf(part)}`);
    return;
  }
  await checkClashes(wb, parts);
}

async function take(wb: Workbench, taken: Taken): Promise<void> {
  await wb.send("findings_take", { key: taken.key });
  showPanel(wb);
  wb.store.findings.set({ part: -1 });
  for (const note of taken.notes.slice(0, 2)) wb.store.notify("warning", note);
  const gone =
    taken.gone > 0
      ? `; ${taken.gone} of the last check ${taken.gone === 1 ? "is" : "are"} resolved, and in the report`
      : "";
  wb.store.notify("info", `${taken.count} ${taken.count === 1 ? "finding" : "findings"}${gone}`);
}

/** The panel of findings is seen. */
export function showPanel(wb: Workbench): void {
  wb.store.panel.value = "findings";
  wb.store.set({ are_panels_open: true });
}

/** Asks for a file that `feeler clash --json` or --save wrote, of any size, and opens it. */
export function openFindings(wb: Workbench): void {
  chooseFile(".json,application/json", (file) => takeFindings(wb, file));
}

/** Opens a file of findings. */
export async function takeFindings(wb: Workbench, file: File): Promise<void> {
  await wb.told(
    (async () => {
      const files = await sendFiles(wb, [file], "job");
      const job = files === null ? null : wb.job("findings_file", { files, name: file.name }, `Opening ${file.name}`);
      if (job) await take(wb, await job.result);
    })(),
  );
}

/** Asks for a BCF file, whose statuses and comments go to the findings. */
export function openBcf(wb: Workbench): void {
  chooseFile(".bcf,.bcfzip", async (file) =>
    wb.told(
      (async () => {
        const files = await sendFiles(wb, [file], "job");
        const job = files === null ? null : wb.job("findings_bcf", { files, name: file.name }, `Opening ${file.name}`);
        if (!job) return;
        const { key, count, notes } = await job.result;
        if (count > 0) await wb.send("findings_take", { key });
        for (const note of notes) wb.store.notify("warning", note);
        wb.store.notify("info", `${count} ${count === 1 ? "finding has" : "findings have"} changed`);
      })(),
    ),
  );
}

export const FORMATS: Readonly<Record<FindingFormat, string>> = {
  json: "JSON (feeler clash --previous)",
  csv: "CSV table",
  xlsx: "Excel workbook with pictures",
  html: "Page with pictures",
  bcf: "BCF topics",
  rules: "Rules (feeler clash --rules)",
};

/** Lets the server write the findings, and downloads the file. */
export async function exportFindings(wb: Workbench, format: FindingFormat): Promise<void> {
  const job = wb.job("export_findings", { format }, `Export: ${FORMATS[format]}`);
  await downloaded(wb, job);
  // `downloaded` has told why it failed.
  const notes = (await job?.result.catch(() => null))?.notes ?? [];
  for (const note of notes) wb.store.notify("warning", note);
}

/** Downloads the file that a job writes. */
export async function downloaded(wb: Workbench, job: Job<Written> | null): Promise<void> {
  if (!job) return;
  await wb.told(
    job.result.then(async ({ name }) => {
      download(await wb.fetchFile(name), name);
      wb.store.notify("info", `${name} was written`);
    }),
  );
}

// ---- looking ----

/** N and P. */
export async function stepFinding(wb: Workbench, step: 1 | -1): Promise<void> {
  const { findings } = wb.store;
  const row = neighbour(findings.shown.peek().rows, findings.row.peek(), step);
  if (row >= 0) await lookAtFinding(wb, row);
}

/** Shows a finding: its parts in two colours, all else faint, from the side on which it is seen. */
export async function lookAtFinding(wb: Workbench, row: number): Promise<void> {
  const { findings, unit } = wb.store;
  const list = findings.list.peek();
  if (!list) return;
  const finding = list.finding(row);
  findings.current.value = finding.id;
  findings.chosen.value = new Set([row]);
  findings.ignoring.value = null;
  wb.say(sentence(finding, unit.peek()));
  await lookAt(wb, finding, () => wb.ask("finding_side", { version: list.version, row }));
}

/** Shows two parts in two colours and all else faint, from where the server says. */
export async function lookAt(wb: Workbench, finding: Finding, ask: () => Promise<FindingSide | null>): Promise<void> {
  const { findings } = wb.store;
  wb.store.panel.value = "findings";
  const look = findings.beginLook();
  const side = await sideOf(wb, ask);
  if (!findings.isLook(look)) return; // another one was chosen meanwhile, or it was left
  if (wb.store.selection.peek().size > 0) wb.select([]);
  findings.focus.value = focusOf(finding, side);
  aim(wb, finding, side?.direction ?? USUAL);
}

async function sideOf(wb: Workbench, ask: () => Promise<FindingSide | null>): Promise<FindingSide | null> {
  if (!wb.link) return null;
  try {
    return await ask();
  } catch {
    return null; // the link is down, or the findings have changed: any side will do
  }
}

function focusOf(finding: Finding, side: FindingSide | null): Focus {
  const { point_a, point_b, translation } = finding;
  const points = [point_a, point_b].filter((point) => point !== null);
  const from = point_a ?? point_b;
  const arrow: Focus["arrow"] =
    from && translation && Math.hypot(...translation) > 0 ? [from, add(from, translation)] : null;
  return { finding, parts: partsOf(finding), cover: side?.cover ?? null, points, arrow };
}

/** The camera looks at the contact, and at as much of the smaller part as shows where it is. */
function aim(wb: Workbench, finding: Finding, direction: Vec3): void {
  const parts = partsOf(finding);
  const point = placeOf(wb, finding);
  if (!point) {
    wb.fit(parts);
    return;
  }
  const reach = reachOf(wb, parts, finding);
  wb.look((camera) => {
    camera.up = [...upOf(wb)];
    camera.target = point;
    camera.position = add(point, scale(normalize(direction, USUAL), reach));
    camera.moved = true;
  });
}

const UPS = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] } as const;
const upOf = (wb: Workbench): Readonly<Vec3> => UPS[wb.store.manifest.peek()?.up ?? "z"];

/** The contact: the middle of both points if they are known. */
function placeOf(wb: Workbench, finding: Finding): Vec3 | null {
  const { point_a, point_b } = finding;
  if (point_a && point_b) return scale(add(point_a, point_b), 0.5);
  if (point_a ?? point_b) return point_a ?? point_b;
  const box = wb.boxOf(partsOf(finding));
  return isEmpty(box) ? null : centre(box);
}

/** Distance of the eye: far enough to show the smaller part, near enough to show the contact. */
function reachOf(wb: Workbench, parts: readonly number[], finding: Finding): number {
  const boxes = parts.map((part) => wb.boxOf([part])).filter((box) => !isEmpty(box));
  const smallest = boxes.reduce<Box | null>(
    (best, box) => (best && diagonal(best) <= diagonal(box) ? best : box),
    null,
  );
  const size = smallest ? diagonal(withPoints(smallest, finding)) : 0.5;
  return Math.max(2 * size, 20 * (finding.depth ?? 0), LEAST_REACH_M);
}

function withPoints(box: Box, { point_a, point_b }: Finding): Box {
  const found: Box = { lower: [...box.lower], upper: [...box.upper] };
  for (const point of [point_a, point_b]) if (point) include(found, point);
  return found;
}

/** Everything looks as before the finding was shown. */
export function leaveFinding(wb: Workbench): void {
  wb.store.findings.endLook();
  wb.redraw();
}

/** Selects both parts of the current finding. */
export function selectParts(wb: Workbench, finding: Finding): void {
  leaveFinding(wb);
  wb.select(partsOf(finding));
}

// ---- marks ----

export type MarkChanges = { status?: FindingStatus; note?: string; group?: number };

/** Sets status, note or group of the chosen findings, or of one. */
export function mark(wb: Workbench, changes: MarkChanges, rows = chosenRows(wb)): Promise<boolean> {
  const version = wb.store.findings.list.peek()?.version;
  if (!version || rows.length === 0) return Promise.resolve(false);
  return wb.run("finding_mark", { version, rows, ...changes });
}

export const chosenRows = (wb: Workbench): number[] => [...wb.store.findings.chosen.peek()].sort((a, b) => a - b);

/** Makes a group of the chosen findings. */
export async function makeGroup(wb: Workbench, name: string): Promise<void> {
  const version = wb.store.findings.list.peek()?.version;
  if (!version) return;
  wb.store.findings.set({ grouping: "group" });
  await wb.run("finding_group_add", { version, rows: chosenRows(wb), name });
}

// ---- rules ----

/** Opens the form "ignore like this" for a finding, with the count that it hides. */
export async function beginIgnoring(wb: Workbench, finding: Finding): Promise<void> {
  const version = wb.store.findings.list.peek()?.version;
  if (!version) return;
  await wb.told(
    wb.ask("finding_alike", { version, row: finding.row }).then(({ a, b, count }) => {
      const name = `${lastOf(finding.path_a)} on ${lastOf(finding.path_b)}`;
      wb.store.findings.ignoring.value = { name, a, b, count, trouble: null };
    }),
  );
}

const lastOf = (path: string): string => path.split("/").at(-1) ?? path;

/** Counts what other patterns hide. */
export async function changeIgnoring(wb: Workbench, changes: { name?: string; a?: string; b?: string }): Promise<void> {
  const { ignoring } = wb.store.findings;
  const before = ignoring.peek();
  if (!before) return;
  const is_new = changes.a !== undefined || changes.b !== undefined;
  ignoring.value = { ...before, ...changes, ...(is_new ? { count: null } : {}) };
  if (!is_new) return;
  const { a, b } = ignoring.value;
  if (a.trim() === "" || b.trim() === "") {
    ignoring.value = { ...ignoring.value, count: 0, trouble: "a pattern is missing" };
    return;
  }
  try {
    const { count, trouble } = await wb.ask("finding_hides", { a, b });
    const now = ignoring.peek();
    if (now?.a === a && now.b === b) ignoring.value = { ...now, count, trouble };
  } catch (error) {
    wb.tell(error);
  }
}

/** Hides the findings, and adds the exclusion to the rules. */
export async function confirmIgnoring(wb: Workbench): Promise<void> {
  const { ignoring } = wb.store.findings;
  const given = ignoring.peek();
  if (!given) return;
  const { name, a, b } = given;
  if (await wb.run("finding_ignore", { name, a, b })) {
    ignoring.value = null;
    leaveFinding(wb);
  }
}

/** Sets how the next check is made. */
export const setCheck = (wb: Workbench, changes: Commands["clash_settings"]): Promise<boolean> =>
  wb.run("clash_settings", changes);

/** Opens a file of rules (TOML). */
export function openRules(wb: Workbench): void {
  chooseFile(".toml,text/plain", async (file) => wb.run("clash_settings", { rules: await file.text() }));
}
