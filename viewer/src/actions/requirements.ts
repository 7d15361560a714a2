// Actions of clearances that must hold: add, check, look at what is wrong.

import type { KeptClear } from "../link/protocol";
import { isSame } from "../math/same";
import { middleOf } from "../math/vectors";
import type { Finding } from "../model/findings";
import { downloaded, lookAt, showPanel } from "./findings";
import type { Workbench } from "./workbench";

/** The least distance of a new one. */
const GAP_M = 0.005;

/** Adds one: between the two selected parts, else with patterns to fill in. */
export async function addRequirement(wb: Workbench): Promise<void> {
  showPanel(wb);
  wb.store.findings.are_requirements_open.value = true;
  const [one, other] = wb.store.selection.peek();
  const [a, b] = [one, other].map((part) => (part === undefined ? "*" : wb.path(part)));
  const number = (wb.document?.requirements.length ?? 0) + 1;
  await wb.run("requirement_add", { name: `Requirement ${number}`, a: a ?? "*", b: b ?? "*", gap: GAP_M });
}

/** Checks all in the scene as it is now. */
export async function checkRequirements(wb: Workbench): Promise<void> {
  showPanel(wb);
  wb.store.findings.are_requirements_open.value = true;
  const job = wb.job("verify", {}, "Checking clearances");
  if (!job) return;
  await wb.told(job.result.then((results) => wb.send("requirements_checked", { results })));
}

export const exportRequirements = (wb: Workbench): Promise<void> =>
  downloaded(wb, wb.job("export_requirements", {}, "Export: requirements"));

/** Whether parts were moved since it was checked. */
export function isStale(wb: Workbench, { verdict }: KeptClear): boolean {
  const now = wb.store.document.value;
  if (!verdict || !now) return false;
  const before = [Object.entries(verdict.moved), verdict.out, verdict.gripped];
  return !isSame(before, [Object.entries(now.moved), now.out, now.gripped]);
}

/** Shows the worst pair of a violated one. */
export async function lookAtRequirement(wb: Workbench, { verdict, name }: KeptClear): Promise<void> {
  const [part_a = null, part_b = null] = verdict?.parts ?? [];
  if (!verdict || part_a === null || part_b === null) return;
  const [point_a = null, point_b = null] = verdict.points;
  const finding: Finding = {
    row: -1,
    id: name,
    path_a: wb.path(part_a),
    path_b: wb.path(part_b),
    part_a,
    part_b,
    verdict: verdict.depth ? "clash" : "clearance",
    rule: name,
    severity: "major",
    kind: "measured",
    depth: verdict.depth || null,
    depth_error: null,
    gap: verdict.gap,
    volume: null,
    point_a,
    point_b,
    translation: null,
    is_touching: false,
  };
  await lookAt(wb, finding, () => wb.ask("pair_side", { parts: [part_a, part_b], point: middleOf(point_a, point_b) }));
}
