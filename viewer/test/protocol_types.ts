// What the generated types refuse. It is never run: `tsc` reads it, and complains of each line below that is right after
// all, so that names and arguments cannot become loose unseen.

import type { Workbench } from "../src/actions/workbench";
import type { Link } from "../src/link/link";
import type { Document } from "../src/link/protocol";

export async function refused(link: Link, wb: Workbench, document: Document): Promise<unknown[]> {
  return [
    link.command("hide", { parts: [1, "*pump*"] }),
    // @ts-expect-error: no command is called so
    link.command("hyde", { parts: [1] }),
    // @ts-expect-error: an argument is missing
    link.command("hide"),
    // @ts-expect-error: an argument is of another type
    link.command("ghost", { parts: [1], is_on: 1 }),
    // @ts-expect-error: the arguments are those of another command
    wb.run("section_switch", { id: 1, normal: [0, 0, 1], offset: 0 }),
    wb.run("undo"),
    // @ts-expect-error: it takes none
    wb.run("undo", { parts: [1] }),
    // @ts-expect-error: no such word
    wb.runOf(() => [["set_mode", { mode: "float" }]]),
    wb.run("measure_edit", { id: 1, name: "gap" }),
    // @ts-expect-error: a point has three numbers
    wb.ask("ray", { origin: [0, 0], direction: [0, 0, 1] }),
    (await wb.ask("ray", { origin: [0, 0, 0], direction: [0, 0, 1] }))?.part,
    // @ts-expect-error: there may be nothing on the ray
    (await wb.ask("ray", { origin: [0, 0, 0], direction: [0, 0, 1] })).part,
    // @ts-expect-error: only `snap` answers with corners
    (await wb.ask("ray", { origin: [0, 0, 0], direction: [0, 0, 1] }))?.corners,
    // @ts-expect-error: a question is no job
    wb.job("snap", {}, "Snap"),
    (await link.job("page", {}).result).left_out,
    // @ts-expect-error: only the page leaves triangles out
    (await link.job("export_csv", {}).result).left_out,
    // @ts-expect-error: the document changes by patches alone
    document.hidden.push(1),
  ];
}
