// The page of a running server: the link, the stage, the hand and the devices, joined.

import { pictureFor } from "../actions/exports";
import { lookAtFinding } from "../actions/findings";
import { WHILE_LOADING } from "../actions/opening";
import { Workbench } from "../actions/workbench";
import { listenToDrops } from "../input/drop";
import { listenToKeys } from "../input/keys";
import { Pointer } from "../input/mouse";
import { Geometry } from "../link/geometry";
import { Link, LinkError } from "../link/link";
import type { OfflinePage } from "../link/offline-file";
import type {
  Camera,
  Document,
  HeldManifest,
  Joints,
  People,
  Seen,
  ServerEvent,
  State,
  Welcome,
} from "../link/protocol";
import { fromAxes } from "../math/matrix";
import { isSame } from "../math/same";
import { formatCount } from "../math/units";
import { corners, emptyBox, include, scale, transform, union, type Vec3 } from "../math/vectors";
import { patched, shownMockup } from "../model/document";
import { FindingList } from "../model/findings";
import { Hand } from "../model/hand";
import { OfflineReplay } from "../model/offline-replay";
import { Store } from "../model/store";
import { Stage } from "../scene/stage";
import type { PictureElements } from "../ui/app";
import { createApi, type FeelerApi } from "./api";
import { createDevices, type Devices } from "./devices";
import { followStore } from "./effects";
import { followFilm } from "./film";
import { followFindings, takeRows } from "./follow-findings";
import { followJoints } from "./follow-joints";
import { followReach } from "./follow-reach";
import { followRecord } from "./follow-record";
import { followTask } from "./follow-task";
import { Loop } from "./loop";
import { followOutlines } from "./outlines";
import { followPeople } from "./people";

/** The state of the hand before the first message. */
const NO_VERSION = -1;

/** A link that is down for longer is not coming back. */
const ENDED_MS = 8000;
/** So long the hand waits at most for the first picture of the mock-up: its programs are compiled when it is first drawn. */
const PICTURED_MS = 2000;
const NO_ANSWER = "feeler does not answer. It is busy, or it was stopped; what you asked for is done once it goes on.";

/** The page of a running server. */
export class Page {
  readonly store = new Store();
  readonly wb: Workbench;
  readonly loop: Loop;
  private readonly devices: Devices;
  private readonly geometry: Geometry | null;
  private readonly state_listeners = new Set<(state: State) => void>();
  private come_triangles = 0;
  private drawn_triangles = 0;
  private is_whole = false;
  private is_ready = false;
  private readonly when_ready: (() => void)[] = [];
  private tellPictured = (): void => undefined;
  private readonly pictured = new Promise<void>((resolve) => {
    this.tellPictured = resolve;
  });
  private first_picture_ms: number | null = null;
  private whole_picture_ms: number | null = null;
  private loaded_hash: string | null = null;
  private last_hash: string | null = null;
  private held_version = NO_VERSION;
  private held_facts: HeldManifest | null = null;
  /** The view that the page chose; null: none yet. */
  private start_camera: Camera | null = null;
  private end_watch: ReturnType<typeof setTimeout> | null = null;

  constructor(picture: PictureElements, token: string | null) {
    const { store } = this;
    const base = new URL("./", location.href);
    this.geometry = token ? new Geometry(base.href, token) : null;
    const stage = new Stage(picture.canvas, {
      pixelRatio: 2,
      labels: picture.labels,
      fieldOf: (...mesh) => this.geometry?.fieldOf(...mesh) ?? new Promise(() => undefined),
    });
    const listener = {
      onStatus: (status: Link["status"]) => this.onStatus(status),
      onWelcome: (welcome: Welcome) => this.onWelcome(welcome),
      onState: (state: State) => this.onState(state),
      onEvent: (event: ServerEvent) => this.onEvent(event),
      onSilence: (is_silent: boolean) => this.onSilence(is_silent),
      onPeople: (people: People) => {
        const said = store.people.take(people);
        if (said) store.notify("info", said);
      },
      onSeen: (seen: Seen) => store.people.takeSeen(seen),
      onJoints: ({ poses, values }: Joints) => {
        store.joints_shown.value = poses && { poses, values };
      },
    };
    const url = `${base.protocol === "https:" ? "wss:" : "ws:"}//${base.host}${base.pathname}`;
    const link = token ? new Link({ url, token, listener }) : null;
    const hand = new Hand({
      moved: () => this.loop.wished(),
      placed: (pose) => void this.wb.place(pose),
      ended: () => this.wb.goOn(),
    });
    hand.viewAxes = () => {
      const { right, top, forward } = stage.camera;
      return fromAxes(right, top, scale(forward, -1), [0, 0, 0]);
    };
    const redraw = (): void => this.loop.request();
    this.wb = new Workbench({
      store,
      stage,
      hand,
      link,
      redraw,
      fetchFile: (name) => fetchFile(base, token, name),
    });
    if (token) this.wb.fetchRoom = (card) => fetchBytes(base, token, `cards/${card}`);
    this.wb.canvas = picture.canvas;
    const pointer = new Pointer(this.wb, picture.canvas);
    this.loop = new Loop(this.wb, pointer, picture);
    this.devices = createDevices(this.wb, this.loop);
    followStore(this.wb, this.loop);
    followOutlines(this.wb, this.loop);
    followFilm(this.wb, this.loop);
    followJoints(this.wb, this.loop);
    followReach(this.wb, this.loop);
    followTask(this.wb, this.loop);
    followRecord(this.wb);
    followPeople(this.wb, this.loop);
    followFindings(this.wb, token ? (version) => fetchBytes(base, token, `findings/${version}`) : null);
    listenToKeys(this.wb);
    listenToDrops(this.wb);
    stage.onRestored(redraw);
    stage.onStale = redraw;
    new ResizeObserver(redraw).observe(picture.canvas);
    document.addEventListener("visibilitychange", redraw);
    window.addEventListener("pagehide", () => keepCamera(store.manifest.peek()?.hash, stage.camera.toJSON()));
    this.loop.after_frame.add(() => this.watchReady());
    if (!link) store.connection.value = "refused";
    link?.connect();
  }

  /** Shows the content of one file, without a server. */
  showOffline({ document, manifest, pieces, camera, left_out, findings }: OfflinePage): void {
    const { store, wb } = this;
    store.connection.value = "offline";
    const replay = new OfflineReplay(store);
    this.loop.each_frame.add((now) => replay.frame(now));
    // The hand and its load stayed with the engine.
    store.document.value = { ...document, tool: null, gripped: [], held_version: 0 };
    if (findings) takeRows(wb, FindingList.decoded(findings));
    wb.stage.setManifest(manifest);
    store.manifest.value = manifest;
    if (camera) {
      wb.stage.camera.fromJSON(camera);
      store.set({ is_parallel: camera.is_parallel ?? false });
    }
    for (const [k, piece] of pieces.entries()) wb.stage.addPiece(k, piece);
    this.come_triangles = manifest.triangles;
    this.is_whole = true;
    if (left_out > 0) {
      store.notify("warning", `${formatCount(left_out)} triangles of small parts had no room in this file`);
    }
    // A report links to its findings.
    const wanted = new URLSearchParams(location.hash.slice(1)).get("finding");
    const row = wanted === null ? -1 : (store.findings.list.peek()?.rowOf(wanted) ?? -1);
    if (row >= 0) void lookAtFinding(wb, row);
    this.loop.request();
  }

  api(): FeelerApi {
    return createApi({
      wb: this.wb,
      loop: this.loop,
      isReady: () => this.is_ready,
      whenReady: () => (this.is_ready ? Promise.resolve() : new Promise((resolve) => this.when_ready.push(resolve))),
      drawn: () => ({ first_picture_ms: this.first_picture_ms, whole_picture_ms: this.whole_picture_ms }),
      countTriangles: () => this.drawn_triangles,
      onState: (listener) => {
        this.state_listeners.add(listener);
        return () => this.state_listeners.delete(listener);
      },
    });
  }

  private onStatus(status: Link["status"]): void {
    this.store.connection.value = status;
    this.watchEnd(status);
    if (status === "open") return;
    this.store.people.forget();
    this.devices.reset();
    this.wb.hand.drop();
    this.store.jobs.value = [];
  }

  /** The link is open all the same: what was asked is answered once the program goes on. */
  private onSilence(is_silent: boolean): void {
    const { store } = this;
    if (is_silent === store.is_silent.peek()) return;
    store.is_silent.value = is_silent;
    if (is_silent) store.notify("warning", NO_ANSWER);
    else if (store.connection.peek() === "open") {
      store.dismissText(NO_ANSWER);
      store.notify("info", "feeler answers again.");
    } else store.dismissText(NO_ANSWER);
  }

  /** A link that stays down for some seconds has no server any more: a new start has another address. */
  private watchEnd(status: Link["status"]): void {
    const { is_ended } = this.store;
    if (status !== "lost") {
      if (this.end_watch !== null) clearTimeout(this.end_watch);
      this.end_watch = null;
      is_ended.value = false;
    }
    if (status !== "lost" || this.end_watch !== null) return;
    this.end_watch = setTimeout(() => {
      is_ended.value = true;
    }, ENDED_MS);
  }

  private onWelcome(welcome: Welcome): void {
    const { store } = this;
    store.is_recording.value = welcome.recording;
    store.has_device.value = welcome.device;
    store.opens.value = welcome.opens;
    store.undo_depth.value = null;
    store.redo_depth.value = null;
    store.joints_shown.value = null;
    this.loop.forget();
    this.takeDocument(welcome.document);
    void this.takeHeld(welcome.document.held_version, welcome.held);
  }

  private onState(state: State): void {
    this.loop.answered(state);
    this.devices.state(state);
    for (const listener of [...this.state_listeners]) listener(state);
  }

  private onEvent(event: ServerEvent): void {
    const { store } = this;
    switch (event.type) {
      case "patch": {
        const before = store.document.peek();
        store.undo_depth.value = event.undo_depth;
        store.redo_depth.value = event.redo_depth;
        // Undo, a grip or another page put the hand elsewhere: an old wish no longer means anything.
        if (event.fields.pose && event.command !== "place") this.wb.hand.drop();
        if (event.fields.mechanism !== undefined) store.joints_shown.value = null;
        if (before) this.takeDocument(patched(before, event.fields));
        break;
      }
      case "impact":
        this.devices.impact(event);
        this.loop.request();
        break;
      case "notice":
        store.notify(event.level, event.text);
        break;
      case "shot":
        pictureFor(this.wb, event.width, event.height, event.camera)
          .then((png) => this.wb.link?.shot(event.id, `shot-${event.id}`, png))
          .catch((error: unknown) => this.wb.tell(error));
        break;
      case "benchmark":
        this.api()
          .benchmark()
          .then((figures) => this.wb.link?.benchmarked(event.id, { ...figures }))
          .catch((error: unknown) => this.wb.tell(error));
        break;
      case "held":
        void this.takeHeld(event.version, event.manifest);
        break;
    }
  }

  private takeDocument(document: Document): void {
    this.store.document.value = document;
    if (!document.loading) this.store.dismissOf(WHILE_LOADING);
    const hash = shownMockup(document)?.hash ?? null;
    if (hash !== this.loaded_hash) this.loadGeometry(hash);
  }

  private loadGeometry(hash: string | null): void {
    const { store, wb } = this;
    this.loaded_hash = hash;
    this.is_whole = false;
    store.geometry_failed.value = null;
    if (hash === null) {
      this.geometry?.abort();
      wb.stage.clear();
      store.manifest.value = null;
      store.geometry_share.value = null;
      return;
    }
    store.geometry_share.value = 0;
    this.geometry?.load({
      onManifest: (manifest) => {
        const before = wb.stage.camera.toJSON();
        wb.stage.setManifest(manifest);
        this.come_triangles = 0;
        const camera = recallCamera(manifest.hash);
        if (camera) wb.stage.camera.fromJSON(camera);
        else if (!isSame(before, wb.stage.camera.toJSON())) this.start_camera = wb.stage.camera.toJSON();
        store.selection.value = new Set();
        // What was looked for and measured was in another one.
        if (this.last_hash !== null && this.last_hash !== manifest.hash) {
          store.search.value = "";
          store.findings.current.value = null;
          store.measuring.value = null;
        }
        this.last_hash = manifest.hash;
        store.manifest.value = manifest;
        setTimeout(() => this.tellPictured(), PICTURED_MS);
        this.frameStart();
        this.loop.request();
      },
      onPiece: (k, data, share) => {
        wb.stage.addPiece(k, data);
        this.come_triangles += store.manifest.peek()?.pieces[k]?.triangles ?? 0;
        store.geometry_share.value = share;
        this.loop.request();
      },
      onDone: () => {
        store.geometry_share.value = 1;
        this.is_whole = true;
        this.loop.request();
      },
      onFailed: (what) => {
        store.geometry_share.value = null;
        store.geometry_failed.value = what;
      },
    });
  }

  private async takeHeld(version: number, manifest: HeldManifest | null): Promise<void> {
    const { wb } = this;
    if (version === this.held_version) return;
    this.held_version = version;
    this.held_facts = manifest;
    this.frameStart();
    try {
      const piece = manifest && this.geometry ? await this.geometry.loadHeld(version) : null;
      if (this.first_picture_ms === null) await this.pictured;
      if (version !== this.held_version) return;
      wb.stage.setHeld(piece && manifest ? { piece, manifest } : null);
      wb.hand.pivot = manifest ? pivotOf(manifest) : [0, 0, 0];
      this.loop.remark();
    } catch (error) {
      this.held_version = NO_VERSION;
      wb.tell(error);
    }
  }

  /** The page's first view holds the mock-up and the hand; one that somebody changed stays. */
  private frameStart(): void {
    const { store, wb } = this;
    const { camera } = wb.stage;
    const manifest = store.manifest.peek();
    const pose = store.document.peek()?.pose;
    if (!manifest || !pose || !this.held_facts || !isSame(this.start_camera, camera.toJSON())) return;
    const held = emptyBox();
    for (const corner of corners(this.held_facts)) include(held, transform(pose, corner));
    camera.view(7, union({ lower: manifest.lower, upper: manifest.upper }, held), manifest.up);
    this.start_camera = camera.toJSON();
  }

  /** Ready once the first picture with every piece in it is drawn, by the device as well. */
  private watchReady(): boolean {
    this.drawn_triangles = this.come_triangles;
    const { isShown, isPictured } = this.wb.stage.stats;
    if (isPictured) this.geometry?.firstDrawn();
    if (this.is_ready) return false;
    if (isPictured && this.first_picture_ms === null) {
      this.first_picture_ms = epochMs();
      this.tellPictured();
    }
    this.is_ready = this.is_whole && isShown;
    if (this.is_ready) {
      this.whole_picture_ms = epochMs();
      for (const tell of this.when_ready.splice(0)) tell();
      if (!this.store.settings.peek().has_seen_tour) this.greet();
    }
    return this.is_whole && !this.is_ready;
  }

  private greet(): void {
    // The sample has a card of its own.
    const isSample = this.store.paths.peek().includes("gearbox/starter/body");
    const where = this.store.is_coarse.peek() ? "“More” in the bar has it." : "Ctrl+K, tour. Press ? for all keys.";
    if (!isSample) this.store.notify("info", `New here? The tour takes two minutes: ${where}`);
    this.store.set({ has_seen_tour: true });
  }
}

/** Milliseconds since 1970, to fractions of one. */
const epochMs = (): number => performance.timeOrigin + performance.now();

/** The hand turns about its own origin if that lies in the held mesh, else about the middle of the mesh. */
function pivotOf(manifest: HeldManifest): Vec3 {
  const { lower, upper } = manifest;
  const isInside = [0, 1, 2].every((k) => (lower[k] ?? 0) <= 0 && 0 <= (upper[k] ?? 0));
  if (isInside) return [0, 0, 0];
  return [(lower[0] + upper[0]) / 2, (lower[1] + upper[1]) / 2, (lower[2] + upper[2]) / 2];
}

const CAMERA_KEY = "feeler.camera";

/** A reload of the tab looks from where one looked. */
function keepCamera(hash: string | undefined, camera: Camera): void {
  if (hash) sessionStorage.setItem(CAMERA_KEY, JSON.stringify({ hash, camera }));
}

function recallCamera(hash: string): Camera | null {
  const kept = JSON.parse(sessionStorage.getItem(CAMERA_KEY) ?? "null") as { hash: string; camera: Camera } | null;
  return kept?.hash === hash ? kept.camera : null;
}

async function fetchFile(base: URL, token: string | null, name: string): Promise<Blob> {
  return new Blob([await fetchBytes(base, token, `exports/${encodeURIComponent(name)}`)]);
}

async function fetchBytes(base: URL, token: string | null, path: string): Promise<ArrayBuffer> {
  const response = await fetch(new URL(path, base), { headers: { Authorization: `Bearer ${token ?? ""}` } });
  if (!response.ok) throw new LinkError(`the server answered ${response.status}`, path, "Try it again");
  return response.arrayBuffer();
}
