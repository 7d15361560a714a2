// Overlays on the picture: loading, failure, a broken link, notices.

import { showPart } from "../actions/cards";
import { canPause, recordAt, seekRecord, toggleRecord } from "../actions/record";
import type { Workbench } from "../actions/workbench";
import { formatCount, formatShare, formatTime } from "../math/units";
import { useWorkbench } from "./context";
import { CommandButton, IconButton } from "./fields";
import { Icon } from "./icons";
import { Timeline } from "./timeline";

interface Failure {
  readonly title: string;
  readonly text: string;
  readonly advice: string;
  /** What can be done here. */
  readonly action?: "reload" | "retry" | "open";
}

/** Why no mock-up is available, and what to do; null if there is one. */
function failure({ store }: Workbench): Failure | null {
  const { connection } = store;
  if (connection.value === "refused") {
    return {
      title: "This page has no access",
      text: "The address has no token, or that of another start of feeler view.",
      advice: "Open the complete address that feeler view printed, including the part after the #.",
    };
  }
  if (connection.value === "full") {
    return {
      title: "Too many pages are open",
      text: "feeler view serves four pages at a time.",
      advice: "Close another page of this workbench, then try again here.",
      action: "retry",
    };
  }
  if (connection.value === "outdated") {
    return {
      title: "This page is older than the engine",
      text: "Their protocol versions differ.",
      advice: "Reload the page.",
      action: "reload",
    };
  }
  const failed = store.document.value?.failed;
  if (failed) {
    const advice = "Repair the file or choose another, and start feeler view again.";
    return {
      title: "The mock-up could not be opened",
      text: failed,
      ...(store.opens.value
        ? { advice: "Open another file here, or a sample to look around.", action: "open" as const }
        : { advice }),
    };
  }
  const lost = store.geometry_failed.value;
  if (lost)
    return {
      title: "The geometry could not be loaded",
      text: lost,
      advice: "Reload the page; if it happens again, start feeler view again.",
      action: "reload",
    };
  return null;
}

export function Covers() {
  const wb = useWorkbench();
  const wrong = failure(wb);
  if (!wrong) return <Loading />;
  return (
    <div class="cover">
      <div class="cover-card failed" role="alert">
        <Icon name="alert" size={32} />
        <h2>{wrong.title}</h2>
        <p class="failure-text">{wrong.text}</p>
        <p class="note">{wrong.advice}</p>
        <div class="button-row">
          {wrong.action === "reload" && (
            <button type="button" class="button main" onClick={() => location.reload()}>
              Reload
            </button>
          )}
          {wrong.action === "retry" && (
            <button type="button" class="button main" onClick={() => wb.link?.retryNow()}>
              Try again
            </button>
          )}
          {wrong.action === "open" && (
            <>
              <CommandButton id="open-file" icon="folder" text="Open a file" />
              <CommandButton id="open-sample" icon="list" text="Open a sample" />
            </>
          )}
        </div>
      </div>
    </div>
  );
}

function Loading() {
  const { store } = useWorkbench();
  const loading = store.document.value?.loading;
  const share = store.geometry_share.value;
  if (store.connection.value === "connecting" || (!store.document.value && store.connection.value !== "lost")) {
    return <Progress title="Connecting to the engine" share={null} />;
  }
  if (loading) return <Progress title={loading.stage} share={loading.share} />;
  // Once there is something to look at, the rest of the geometry comes in the corner.
  if (share !== null && share < 1)
    return <Progress title="Geometry" share={share} isSmall={store.manifest.value !== null} />;
  return null;
}

function Progress({ title, share, isSmall }: { title: string; share: number | null; isSmall?: boolean }) {
  return (
    <div class={isSmall ? "cover small" : "cover"}>
      <div class="cover-card" role="status">
        <p>{title}</p>
        <progress max={1} value={share ?? undefined} aria-label={title} />
        <p class="note">{share === null ? "" : formatShare(share)}</p>
      </div>
    </div>
  );
}

export function Banner() {
  const wb = useWorkbench();
  if (wb.store.connection.value !== "lost") return null;
  return (
    <div class="banner" role="alert">
      <Icon name="alert" size={16} />
      <span>
        {wb.store.is_ended.value ? (
          <>
            <strong>feeler view has ended.</strong> Start it again: it prints a new address. What was not saved or
            exported is lost; the picture here can still be looked at.
          </>
        ) : (
          "The connection to the engine is lost. The tool stays where it is; the page reconnects by itself."
        )}
      </span>
      <button type="button" class="button" onClick={() => wb.link?.retryNow()}>
        Try now
      </button>
    </div>
  );
}

/** While files are held over the page. */
export function DropCover() {
  const { store } = useWorkbench();
  if (!store.is_dropping.value) return null;
  return (
    <div class="drop-cover" aria-hidden="true">
      <p>
        {store.opens.value ? "Drop to open: a mock-up, or findings as JSON" : "Drop findings of feeler clash --json"}
      </p>
    </div>
  );
}

/** An empty picture says why, and how it ends. */
export function AllHidden() {
  const { store } = useWorkbench();
  const count = store.part_count.value;
  if (!store.manifest.value || count === 0 || store.hidden.value.size < count || !store.can_look.value) return null;
  return (
    <div class="banner quiet" role="status">
      <Icon name="eyeOff" size={16} />
      <span>{count === 1 ? "The only part is hidden." : `All ${formatCount(count)} parts are hidden.`}</span>
      <CommandButton id="show-all" icon="eye" text="Show all" />
    </div>
  );
}

/** A record that the workbench was opened with: replayed by a button, scrubbed, and what came of it. */
export function RecordBar() {
  const wb = useWorkbench();
  const { store } = wb;
  const timeline = store.timeline.value;
  const record = store.document.value?.record;
  if (!record || store.connection.value !== "open") return null;
  const state = record.is_playing ? "playing" : record.is_same === null ? "" : record.is_same ? "same" : "parted";
  return (
    <section class={`record-bar ${state}`} aria-label="Record">
      <div class="record-line">
        <p role="status">
          <strong>{record.name}</strong>
          {record.is_playing ? " is being replayed." : (record.verdict && ` ${record.verdict}`) || " can be replayed."}
        </p>
        <CommandButton id="replay" icon="play" text={record.verdict ? "Replay again" : "Replay"} />
      </div>
      {timeline && (
        <Timeline
          name="the record"
          seconds={timeline.seconds}
          at={recordAt(wb)}
          gaps={timeline.gaps}
          stops={timeline.steps.map(({ at, time, title }) => ({ at, title, note: formatTime(time) }))}
          is_playing={record.is_playing}
          is_compact
          disabled={record.is_playing && !canPause()}
          toggle={() => toggleRecord(wb)}
          go={(at) => seekRecord(wb, at)}
          show={(part) => showPart(wb, part)}
        />
      )}
    </section>
  );
}

export function Notices() {
  const { store } = useWorkbench();
  return (
    <div class="notices" aria-live="polite">
      {store.notices.value.map((notice) => (
        <div key={notice.id} class={`notice ${notice.level}`} role={notice.level === "error" ? "alert" : undefined}>
          <Icon name={notice.level === "info" ? "info" : "alert"} size={16} />
          <span>{notice.text}</span>
          <IconButton icon="close" label="Dismiss" run={() => store.dismiss(notice.id)} />
        </div>
      ))}
    </div>
  );
}
