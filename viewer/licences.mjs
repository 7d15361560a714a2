// The licences of what others wrote and the page carries: a file beside it, and a comment at the head of each script, so
// that they are in every copy, the file to send too.
//
// Which packages that is, esbuild says of what it built; none is listed by hand.

import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";

const NAME = "THIRD_PARTY.txt";
/** Licences that ask for no more than their text. */
const ALLOWED = new Set(["MIT", "ISC", "BSD-2-Clause", "BSD-3-Clause"]);

/** The names of the packages among paths of sources, in order. */
export const packagesOf = (paths) =>
  [...new Set(paths.map((path) => path.match(/.*node_modules\/((?:@[^/]+\/)?[^/]+)\//)?.[1]).filter(Boolean))].sort();

/** What has to be said of packages: name, version, licence and its text. An error for one that may not be carried. */
export async function licencesOf(names, folder) {
  const texts = [];
  for (const name of names) {
    const facts = JSON.parse(await readFile(join(folder, "node_modules", name, "package.json"), "utf8"));
    if (!ALLOWED.has(facts.license)) throw new Error(`${name}: may its licence, ${facts.license}, go into the page?`);
    const text = await readFile(join(folder, "node_modules", name, "LICENSE"), "utf8");
    texts.push(`${name} ${facts.version}, ${facts.license}\n\n${text.trim()}\n`);
  }
  return texts.join("\n");
}

/** A plugin of esbuild that writes them after each build. folder: that of package.json. */
export const licences = (folder) => ({
  name: "licences",
  setup(build) {
    build.onEnd(async ({ metafile, errors }) => {
      if (errors.length > 0) return;
      const all = packagesOf(Object.keys(metafile.inputs));
      const head = "What others wrote and the page of feeler's workbench carries, under these licences.";
      await writeFile(join(build.initialOptions.outdir, NAME), `${head}\n\n${await licencesOf(all, folder)}`);
      for (const [output, { inputs }] of Object.entries(metafile.outputs)) {
        const names = packagesOf(Object.keys(inputs));
        if (names.length === 0) continue;
        const path = join(folder, output);
        const script = await readFile(path, "utf8");
        await writeFile(path, `/*!\n${await licencesOf(names, folder)}*/\n${script}`);
      }
    });
  },
});
