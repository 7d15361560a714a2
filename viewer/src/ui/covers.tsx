// Overlays on the picture: loading, failure, a broken link, notices.

import { formatCount, formatShare } from "../math/units";
import { useWorkbench } from "./context";
import { CommandButton, IconButton } from "./fields";
import { Icon } from "./icons";

/** Why no mock-up is available, and what to do; null if there is one. */
function failure(
  store: ReturnType<typeof useWorkbench>["store"],
): { title: string; text: string; advice: string } | null {
  const { connection } = store;
  if (connection.value === "refused") {
    return {
      title: "This page is not allowed here",
      text: "The engine did not accept the token of this page, or too many pages are open.",
      advice: "Open the complete address that feeler view printed, including the part after the #.",
    };
  }
  if (connection.value === "outdated") {
    return {
      title: "This page is older than the engine",
      text: "Their protocol versions differ.",
      advice: "Reload the page.",
    };
  }
  const failed = store.document.value?.failed;
  if (failed)
    return {
      title: "The mock-up could not be opened",
      text: failed,
      advice: "Repair the file or choose another, and start feeler view again.",
    };
  const lost = store.geometry_failed.value;
  if (lost)
    return {
      title: "The geometry could not be loaded",
      text: lost,
      advice: "Reload the page; if it happens again, start feeler view again.",
    };
  return null;
}

export function Covers() {
  const wb = useWorkbench();
  const { store } = wb;
  const wrong = failure(store);
  if (wrong) {
    return (
      <div class="cover">
        <div class="cover-card failed" role="alert">
          <Icon name="alert" size={32} />
          <h2>{wrong.title}</h2>
          <p class="failure-text">{wrong.text}</p>
          <p class="note">{wrong.advice}</p>
          {store.connection.value === "outdated" && (
            <button type="button" class="button main" onClick={() => location.reload()}>
              Reload
            </button>
          )}
        </div>
      </div>
    );
  }
  return <Loading />;
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
      <span>The connection to the engine is lost. The tool stays where it is; the page reconnects by itself.</span>
      <button type="button" class="button" onClick={() => wb.link?.retryNow()}>
        Try now
      </button>
    </div>
  );
}

/** An empty picture says why, and how it ends. */
export function AllHidden() {
  const { store } = useWorkbench();
  const count = store.part_count.value;
  if (!store.manifest.value || count === 0 || store.hidden.value.size < count) return null;
  return (
    <div class="banner quiet" role="status">
      <Icon name="eyeOff" size={16} />
      <span>{count === 1 ? "The only part is hidden." : `All ${formatCount(count)} parts are hidden.`}</span>
      <CommandButton id="show-all" icon="eye" text="Show all" />
    </div>
  );
}

/** A record that the workbench was opened with: replayed by a button, and what came of it. */
export function RecordBar() {
  const { store } = useWorkbench();
  const record = store.document.value?.record;
  if (!record || store.connection.value !== "open") return null;
  const state = record.is_playing ? "playing" : record.is_same === null ? "" : record.is_same ? "same" : "parted";
  return (
    <section class={`record-bar ${state}`} aria-label="Record">
      <p role="status">
        <strong>{record.name}</strong>
        {record.is_playing ? " is being replayed." : (record.verdict && ` ${record.verdict}`) || " can be replayed."}
      </p>
      <CommandButton id="replay" icon="play" text={record.verdict ? "Replay again" : "Replay"} />
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
