// Which fasteners a tool reaches: a row each, unreached first; a click seats the tool there.

import { useSignal } from "@preact/signals";
import { seatTool } from "../actions/cards";
import type { Card, CardAnswer } from "../link/protocol";
import { useWorkbench } from "./context";

const FIRST = 50;

export function ReachList({ card, answer }: { card: Card; answer: CardAnswer }) {
  const wb = useWorkbench();
  const { store } = wb;
  const shown = useSignal(FIRST);
  const rows = answer.reaches;
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
              title={row.is_reachable ? "Puts the tool into its seat there" : "Looks at it"}
              onClick={() => seatTool(wb, card.id, row)}
            >
              {row.name.split("/").at(-1)}
            </button>
            <span class="note">{row.is_reachable ? `swings ${Math.round(row.swing_deg)}°` : row.because}</span>
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
