// The status line: the link, the contact, the part under the pointer, and the engine's rate.

import { formatCount, formatForce, formatLength, formatShare } from "../math/units";
import { length } from "../math/vectors";
import { touchedParts } from "../model/contact";
import type { Connection } from "../model/page-state";
import { useWorkbench } from "./context";
import { IconButton } from "./fields";
import { Name } from "./names";
import { ProjectStatus } from "./project";
import { poseHint } from "./typing-hint";
import { depthText, isolated, isTouching, touchedText, trianglesText } from "./words";

const CONNECTIONS: Readonly<Record<Connection, string>> = {
  connecting: "Connecting",
  open: "Connected",
  lost: "Reconnecting",
  refused: "Not allowed",
  full: "Too many pages",
  outdated: "Reload the page",
  offline: "Read only",
};

export function StatusLine() {
  const wb = useWorkbench();
  const { store } = wb;
  const connection = store.connection.value;
  const hint = poseHint(store);
  return (
    <footer class="status">
      <span class={`link-state ${store.is_ended.value ? "refused" : store.is_silent.value ? "lost" : connection}`}>
        <span class="dot" aria-hidden="true" />
        {store.is_ended.value ? "Ended" : store.is_silent.value ? "feeler does not answer" : CONNECTIONS[connection]}
      </span>
      {store.is_recording.value && (
        <span class="recording">
          <span class="dot" aria-hidden="true" />
          Recording
        </span>
      )}
      <ProjectStatus />
      <ContactFacts />
      <span class="status-path" title={hint || wb.path(store.hover.value)}>
        {hint || (store.hover.value >= 0 && <Name text={wb.path(store.hover.value)} />)}
      </span>
      {store.jobs.value.map((job) => (
        <span class="job" key={job.id}>
          {`${job.title} ${formatShare(job.share)}`}
          <progress value={job.share} max={1} aria-label={job.title} />
          <IconButton icon="close" label={`Cancel: ${job.title}`} run={job.cancel} />
        </span>
      ))}
      <Rates />
      <span class="visually-hidden" role="status" aria-live="polite">
        {store.spoken.value}
      </span>
    </footer>
  );
}

function ContactFacts() {
  const { store } = useWorkbench();
  const state = store.state.value;
  const unit = store.unit.value;
  if (!state || !store.has_hand.value) return null;
  const nearest = state.distance;
  const depth = depthText(state, unit);
  return (
    <span class="contact-facts">
      <span class={`mode-tag ${state.mode}`}>{state.mode}</span>
      {isTouching(state) ? (
        <>
          <span class="hit-count">
            <span class="swatch hit" aria-hidden="true" />
            {touchedText(touchedParts(state).map((part) => store.nameOf(part)))}
          </span>
          {state.hit_count > 0 && <span>{trianglesText(state.hit_count, formatCount)}</span>}
          {depth && <span>{depth}</span>}
          {length(state.force) > 0 && <span>{formatForce(length(state.force))}</span>}
        </>
      ) : (
        <span>
          {nearest && <span class="swatch near" aria-hidden="true" />}
          {nearest ? `${formatLength(nearest.value, unit)} to ${isolated(store.nameOf(nearest.part))}` : "free"}
        </span>
      )}
    </span>
  );
}

/** The hand rests when it has wished nothing for so long. */
const REST_MS = 1000;

/** The engine's rate and how old the state is: small, for those who ask. */
function Rates() {
  const { store } = useWorkbench();
  const state = store.state.value;
  if (!state || !store.settings.value.has_figures) return null;
  // The age counts from the hand's last wish: before the first, and while the hand rests, it says nothing.
  const is_at_rest = state.pose_seq === 0 || state.age_ms > REST_MS;
  const age = is_at_rest ? "" : ` · ${state.age_ms.toFixed(1)} ms old`;
  return (
    <span class="rates" title="Answers of the engine per second, the time of one, and the age of the picture">
      {`${Math.round(state.rate_hz)} Hz · ${formatTime(state.engine_us)}${age}`}
    </span>
  );
}

const formatTime = (us: number): string => (us < 1000 ? `${Math.round(us)} µs` : `${(us / 1000).toFixed(1)} ms`);
