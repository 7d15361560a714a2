// Names of files, which may be long and of any script: cut in the middle, the whole on hover, and each on its own in the
// order of reading.

/** The last letters are always seen: `bolt_012` and `bolt_013` differ there. */
const TAIL = 9;
/** Shorter names are not worth a cut. */
const LEAST_CUT = 2 * TAIL;

/** A name in two pieces, of which the first may be cut; the second is empty for short names. */
export function pieces(text: string): [head: string, tail: string] {
  // By code points: half of one is no letter.
  const letters = Array.from(text);
  if (letters.length <= LEAST_CUT) return [text, ""];
  return [letters.slice(0, -TAIL).join(""), letters.slice(-TAIL).join("")];
}

/** A name that takes the room that there is. */
export function Name({ text, title = text }: { text: string; title?: string | undefined }) {
  const [head, tail] = pieces(text);
  return (
    <span class="name" title={title}>
      <bdi class="name-head">{head}</bdi>
      {tail && <bdi class="name-tail">{tail}</bdi>}
    </span>
  );
}
