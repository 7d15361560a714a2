// Which fasteners a tool reaches: a row each, unreached first; a click seats the tool there.

import { useSignal } from "@preact/signals";
import { seatTool } from "../actions/cards";
import type { CardAnswer } from "../link/protocol";
import { useWorkbench } from "./context";

const FIRST = 50;

export function ReachList({ answer }: { answer: CardAnswer }) {
  const wb = useWorkbench();
  const { store } = wb;
  const shown = useSignal(FIRST);
  const rows = answer.reaches;
  const isOne = rows.every((row) => row.tool === rows[0]?.tool);
  return (
    <>
      <ul class="reaches" aria-label="Fasteners">
        {rows.slice(0, shown.value).map((row) => (
          <li
            key={`${row.part} ${row.point.join()}`}
            class={row.is_reachable ? "is-good" : "is-bad"}
            aria-current={store.reach.value === row}
          >
            <button
              type="button"
              class="link"
              disabled={store.is_read_only.value && !row.is_catalogue}
              title={seatText(row)}
              onClick={() => seatTool(wb, row)}
            >
              {row.name.split("/").at(-1)}
            </button>
            <span class="note">{reachText(row, isOne)}</span>
            {row.blockers.length > 0 && (
              <span class="note">{`${row.is_reachable ? "limited by" : "in the way"}: ${row.blockers
                .slice(0, 2)
                .map((part) => store.nameOf(part))
                .join(", ")}`}</span>
            )}
          </li>
        ))}
      </ul>
      {rows.length > shown.value && (
        <button
          type="button"
          class="button"
          onClick={() => {
            shown.value += 4 * FIRST;
          }}
        >
          {`${rows.length - shown.value} more`}
        </button>
      )}
    </>
  );
}

type Row = CardAnswer["reaches"][number];

/** What a click on a row does. */
function seatText(row: Row): string {
  if (row.is_catalogue && row.tool !== "") return `Draws the ${row.tool} in its seat there`;
  return row.is_reachable ? `Puts the ${row.tool} into its seat there` : "Looks at it";
}

/**
 * "swings 300°", or with several tools "hand swings 300°, also torque"; of the catalogue "hexagon 13 mm: ring 13 swings
 * 60°, 6 strokes a turn".
 */
function reachText(row: Row, isOne: boolean): string {
  const head = row.is_catalogue && row.head !== "" ? `${row.head}: ` : "";
  if (!row.is_reachable) return `${head}${row.because}`;
  const swing = `swings ${Math.round(row.swing_deg)}°`;
  if (row.is_catalogue) {
    const strokes = row.strokes === null ? "" : `, ${row.strokes} ${row.strokes === 1 ? "stroke" : "strokes"} a turn`;
    return `${head}${row.tool} ${swing}${strokes}${row.has_hand === false ? "; no room for a hand at its grip" : ""}`;
  }
  if (isOne && row.tools.length === 1) return swing;
  const others = row.tools.filter((name) => name !== row.tool);
  return `${row.tool} ${swing}${others.length > 0 ? `, also ${others.join(", ")}` : ""}`;
}
