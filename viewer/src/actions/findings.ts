// Commands for findings: open a file, step to the next, show one.

import type { Finding } from "../link/protocol";
import { add, centre, diagonal, isEmpty, scale, type Vec3 } from "../math/vectors";
import { depthOf, neighbour, partsOf, shownGroups } from "../model/findings";
import type { Workbench } from "./workbench";

/** A message to the server holds 1 MiB, and some of it is not the file's. */
const MOST_BYTES = 1_000_000;

/** Asks for a file that `feeler clash --json` wrote, and opens it. */
export function openFindings(wb: Workbench): void {
  const input = document.createElement("input");
  input.type = "file";
  input.accept = ".json,application/json";
  input.addEventListener("change", () => {
    const file = input.files?.[0];
    if (file) void takeFindings(wb, file);
  });
  input.click();
}

async function takeFindings(wb: Workbench, file: File): Promise<void> {
  try {
    if (file.size > MOST_BYTES) {
      throw new RangeError(`${file.name} is too large to open here: start by feeler view MOCKUP --findings FILE`);
    }
    const findings: unknown = parsed(await file.text(), file.name);
    if (await wb.run("findings_open", { findings })) wb.store.panel.value = "findings";
  } catch (error) {
    wb.tell(error);
  }
}

function parsed(text: string, name: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    throw new SyntaxError(`${name} is no JSON: choose what feeler clash --json wrote`);
  }
}

/** N and P. */
export async function stepFinding(wb: Workbench, step: 1 | -1): Promise<void> {
  const findings = wb.document?.findings;
  if (!findings) return;
  const { finding, finding_query, finding_order } = wb.store;
  const next = neighbour(shownGroups(findings, finding_query.peek(), finding_order.peek()), finding.peek(), step);
  if (next) await lookAtFinding(wb, next);
}

/** The rest becomes ghost; camera and pivot go to the contact, not to the middle of both parts. */
export async function lookAtFinding(wb: Workbench, finding: Finding): Promise<void> {
  wb.store.panel.value = "findings";
  wb.store.finding.value = finding.id;
  const parts = partsOf(finding);
  wb.select(parts);
  const point = placeOf(wb, finding);
  if (point) {
    const reach = reachOf(wb, parts, depthOf(finding));
    wb.look((camera) => {
      const away = scale(camera.forward, -reach);
      camera.target = point;
      camera.position = add(point, away);
      camera.moved = true;
    });
  } else wb.fit(parts);
  wb.redraw();
  wb.say(finding.sentence);
  if (wb.store.can_look.peek() && parts.length > 0) await wb.run("single_out", { parts });
}

/** The contact: the middle of both points if they are known. */
function placeOf(wb: Workbench, finding: Finding): Vec3 | null {
  const { point_a, point_b } = finding;
  if (point_a && point_b) return scale(add(point_a, point_b), 0.5);
  if (point_a ?? point_b) return point_a ?? point_b;
  const box = wb.boxOf(partsOf(finding));
  return isEmpty(box) ? null : centre(box);
}

/** Distance of the eye: far enough to show the surroundings, near enough to show the contact. */
function reachOf(wb: Workbench, parts: readonly number[], depth: number): number {
  const sizes = parts.map((part) => diagonal(wb.boxOf([part])));
  const smallest = Math.min(...sizes.filter((size) => size > 0), 0.5);
  return Math.max(2.5 * smallest, 20 * depth, 1e-3);
}
