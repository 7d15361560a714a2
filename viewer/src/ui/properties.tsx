// What is selected: the facts of a part, or the distance of two.

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Measured, PartFacts } from "../link/protocol";
import { areaText, formatCount, formatLength, volumeText } from "../math/units";
import { isEmpty } from "../math/vectors";
import { useWorkbench } from "./context";
import { IconButton } from "./fields";
import { Icon } from "./icons";
import { Name } from "./names";
import { partsText } from "./words";

/** Answers are asked for once the selection rests. */
const REST_MS = 120;

export function Properties() {
  const wb = useWorkbench();
  const { store } = wb;
  const parts = [...store.selection.value];
  const [first, second] = parts;
  if (first === undefined || !store.manifest.value) return null;
  // The engine measures: a file without a server has boxes only.
  const hasDistance = parts.length === 2 && wb.link !== null;
  return (
    <section class="properties" aria-label="Selection">
      <header>
        <h2>
          {parts.length === 1 ? (
            <Name text={store.nameOf(first)} title={wb.path(first)} />
          ) : (
            partsText(parts.length, formatCount)
          )}
        </h2>
        <IconButton icon="fit" label="Frame the selection" run={() => wb.fit()} />
        <IconButton icon="close" label="Clear the selection" run={() => wb.select([])} />
      </header>
      {parts.length === 1 && <PartProperties part={first} />}
      {hasDistance && second !== undefined && <Distance one={first} other={second} />}
      {parts.length > 1 && !hasDistance && <Box parts={parts} />}
    </section>
  );
}

function PartProperties({ part }: { part: number }) {
  const wb = useWorkbench();
  const { store } = wb;
  const facts = useAnswer<PartFacts>(`${part}`, () => wb.ask("part", { part }));
  const unit = store.unit.value;
  const triangles = store.manifest.value?.parts.triangles[part];
  return (
    <dl class="facts">
      <dt>Path</dt>
      <dd>
        <Name text={wb.path(part)} />
      </dd>
      <BoxFacts parts={[part]} />
      <dt>Triangles</dt>
      <dd>{formatCount(facts?.triangles ?? triangles ?? 0)}</dd>
      {facts && (
        <>
          <dt>Surface</dt>
          <dd>{facts.is_closed ? "closed" : "open"}</dd>
          {facts.volume !== null && (
            <>
              <dt>Volume</dt>
              <dd>{volumeText(facts.volume, unit)}</dd>
            </>
          )}
          <dt>Area</dt>
          <dd>{areaText(facts.area, unit)}</dd>
          {facts.state !== "in place" && (
            <>
              <dt>Place</dt>
              <dd>{facts.state}</dd>
            </>
          )}
          {Object.entries(facts.attributes).map(([name, value]) => (
            <Attribute key={name} name={name} value={value} />
          ))}
        </>
      )}
    </dl>
  );
}

/** Of the file: its texts may be of any script, and long. */
const Attribute = ({ name, value }: { name: string; value: string }) => (
  <>
    <dt>
      <Name text={name} />
    </dt>
    <dd>
      <Name text={value} />
    </dd>
  </>
);

/** Exact, on the triangles, where the parts are now. */
function Distance({ one, other }: { one: number; other: number }) {
  const wb = useWorkbench();
  const { store } = wb;
  const moved = store.document.value?.moved ?? {};
  const key = JSON.stringify([one, other, moved[one], moved[other]]);
  const found = useAnswer<Measured>(key, () => wb.ask("measure", { type: "parts", parts: [one, other] }));
  return (
    <>
      <ul class="part-list">
        {[one, other].map((part) => (
          <li key={part}>
            <Name text={store.nameOf(part)} title={wb.path(part)} />
          </li>
        ))}
      </ul>
      <p class="distance" role="status">
        <span>Distance</span>
        <strong>
          {found ? (found.value > 0 ? formatLength(found.value, store.unit.value) : "0, they touch or overlap") : "…"}
        </strong>
      </p>
      <button
        type="button"
        class="button"
        disabled={!found || store.is_read_only.value}
        onClick={() => void wb.run("measure_add", { type: "parts", parts: [one, other] })}
      >
        <Icon name="measure" size={14} />
        <span>Add as a measure</span>
      </button>
    </>
  );
}

function Box({ parts }: { parts: readonly number[] }) {
  const { store } = useWorkbench();
  const counts = store.manifest.value?.parts.triangles ?? [];
  return (
    <dl class="facts">
      <BoxFacts parts={parts} />
      <dt>Triangles</dt>
      <dd>{formatCount(parts.reduce((sum, part) => sum + (counts[part] ?? 0), 0))}</dd>
    </dl>
  );
}

function BoxFacts({ parts }: { parts: readonly number[] }) {
  const wb = useWorkbench();
  const { store } = wb;
  // Parts that were moved have their box elsewhere.
  void store.document.value?.moved;
  const { lower, upper } = wb.boxOf(parts);
  if (isEmpty({ lower, upper })) return null;
  const unit = store.unit.value;
  const sizes = ([0, 1, 2] as const).map((k) => formatLength(upper[k] - lower[k], unit).replace(/\s\S+$/, ""));
  return (
    <>
      <dt>Size</dt>
      <dd>{`${sizes.join(" × ")} ${unit}`}</dd>
    </>
  );
}

/** The answer to a question, asked again when `key` changes; null until it comes, and without a server. */
function useAnswer<Answer>(key: string, ask: () => Promise<Answer>): Answer | null {
  const answer = useSignal<Answer | null>(null);
  useEffect(() => {
    let isWanted = true;
    answer.value = null;
    const rest = setTimeout(() => {
      ask().then(
        (found) => {
          if (isWanted) answer.value = found;
        },
        () => null,
      );
    }, REST_MS);
    return () => {
      isWanted = false;
      clearTimeout(rest);
    };
  }, [key]);
  return answer.value;
}
