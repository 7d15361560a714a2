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
              disabled={store.is_read_only.value}
              title={row.is_reachable ? `Puts the ${row.tool} into its seat there` : "Looks at it"}
              onClick={() => seatTool(wb, row)}
            >
              {row.name.split("/").at(-1)}
            </button>
            <span class="note">{reachText(row, isOne)}</span>
            {row.blockers.length > 0 && (
              <span class="note">{`in the way: ${row.blockers
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

/** "swings 300°", or with several tools "hand swings 300°, torque too". */
function reachText(row: CardAnswer["reaches"][number], isOne: boolean): string {
  if (!row.is_reachable) return row.because;
  const swing = `swings ${Math.round(row.swing_deg)}°`;
  if (isOne && row.tools.length === 1) return swing;
  const others = row.tools.filter((name) => name !== row.tool);
  return `${row.tool} ${swing}${others.length > 0 ? `, also ${others.join(", ")}` : ""}`;
}
