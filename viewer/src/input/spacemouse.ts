// The SpaceMouse over WebHID: a cap with six degrees of freedom and buttons.
//
// A device is opened after a user's gesture (`connect`), and by itself on later visits (`reconnect`). Its reports are
// read by its own descriptor, so that wired, wireless and future ones need no table of layouts.

import type { Vec3 } from "../math/vectors";
import { deflection, fieldsOf, type HidCollection, type HidField, readField } from "./hid";
import { curved, RateDriver, type RateSpeeds, type RateTarget, REST, type SixRates } from "./rate";

export interface HidInputReport {
  readonly device: HidDevice;
  readonly reportId: number;
  readonly data: DataView;
}

/** The used members of WebHID's `HIDDevice`. */
export interface HidDevice {
  readonly productName: string;
  readonly vendorId: number;
  readonly productId: number;
  readonly opened: boolean;
  readonly collections: readonly HidCollection[];
  open(): Promise<void>;
  close(): Promise<void>;
  addEventListener(kind: "inputreport", listener: (report: HidInputReport) => void): void;
  removeEventListener(kind: "inputreport", listener: (report: HidInputReport) => void): void;
}

export interface HidFilter {
  readonly vendorId: number;
  readonly usagePage?: number;
  readonly usage?: number;
}

/** The used members of `navigator.hid`. */
export interface Hid {
  getDevices(): Promise<HidDevice[]>;
  requestDevice(options: { filters: HidFilter[] }): Promise<HidDevice[]>;
  addEventListener(kind: "connect" | "disconnect", listener: (event: { device: HidDevice }) => void): void;
  removeEventListener(kind: "connect" | "disconnect", listener: (event: { device: HidDevice }) => void): void;
}

const VENDOR_3DCONNEXION = 0x256f;
/** Caps made before 2013 bear Logitech's number, as its mice and keyboards do. */
const VENDOR_LOGITECH = 0x046d;
const PAGE_DESKTOP = 0x01;
const MULTI_AXIS_CONTROLLER = 0x08;
const FILTERS: readonly HidFilter[] = [
  { vendorId: VENDOR_3DCONNEXION, usagePage: PAGE_DESKTOP, usage: MULTI_AXIS_CONTROLLER },
  { vendorId: VENDOR_LOGITECH, usagePage: PAGE_DESKTOP, usage: MULTI_AXIS_CONTROLLER },
];

/** Usages X, Y, Z, Rx, Ry, Rz of the desktop page. */
const FIRST_AXIS = 0x0001_0030;
const PAGE_BUTTON = 0x0009;

/**
 * A cap that is silent for this long counts as at rest: one that is held at its stop may say nothing new, but one that
 * was unplugged says nothing either.
 */
const SILENCE_MS = 5000;

/** The state of a cap. */
export class Cap {
  /** From -1 to 1, the device's axes: x right, y towards the user, z down; rotations about them. */
  readonly axes: number[] = [0, 0, 0, 0, 0, 0];
  /** Numbers of the pressed buttons, from 1. */
  buttons: ReadonlySet<number> = new Set();
  private readonly fields: Map<number, HidField[]>;

  constructor(collections: readonly HidCollection[]) {
    this.fields = fieldsOf(collections);
  }

  /** How many of the six freedoms the device has. */
  get freedoms(): number {
    const found = new Set<number>();
    for (const field of [...this.fields.values()].flat()) {
      const axis = field.usage - FIRST_AXIS;
      if (axis >= 0 && axis < 6) found.add(axis);
    }
    return found.size;
  }

  /** Takes a report: axes and buttons that it does not contain stay. */
  report(id: number, data: DataView): void {
    let buttons: Set<number> | null = null;
    for (const field of this.fields.get(id) ?? []) {
      const value = readField(field, data);
      const axis = field.usage - FIRST_AXIS;
      const isButton = field.usage >>> 16 === PAGE_BUTTON;
      if (isButton) buttons ??= new Set();
      if (value === null) continue;
      if (axis >= 0 && axis < 6) this.axes[axis] = deflection(field, value);
      if (!isButton) continue;
      const first = field.usage & 0xffff;
      const number = field.isArray ? first + value - field.minimum : first;
      const isOn = field.isArray ? value >= field.minimum && value <= field.maximum : value !== 0;
      if (isOn && number > 0) buttons?.add(number);
    }
    if (buttons) this.buttons = buttons;
  }
}

/** The cap's axes as deflections along and about the view's: right, up, towards the viewer. */
export function ratesOfCap(axes: readonly number[], dead_zone: number, bend: number): SixRates {
  const rate = (index: number) => curved(axes[index] ?? 0, dead_zone, bend);
  const view = (first: number): Vec3 => [rate(first), -rate(first + 2) || 0, rate(first + 1)];
  return { translation: view(0), rotation: view(3) };
}

export type CapStatus =
  | { readonly kind: "absent"; readonly text: string }
  | { readonly kind: "none" }
  | { readonly kind: "open"; readonly name: string }
  | { readonly kind: "failed"; readonly text: string };

export interface CapHost {
  readonly target: () => RateTarget;
  readonly speeds: () => RateSpeeds;
  /** A button was pressed; numbers from 1. */
  button(number: number): void;
  /** The device came, went or failed. */
  status(status: CapStatus): void;
  /** The cap has moved: a frame is due. */
  moved(): void;
}

export interface CapSettings {
  isOn: boolean;
  dead_zone: number;
  bend: number;
}

interface OpenDevice {
  readonly device: HidDevice;
  readonly cap: Cap;
}

export const browserHid = (): Hid | null =>
  typeof navigator === "undefined" ? null : ((navigator as Navigator & { hid?: Hid }).hid ?? null);

export class SpaceMouse {
  readonly settings: CapSettings = { isOn: true, dead_zone: 0.04, bend: 0.5 };

  private current: OpenDevice | null = null;
  private heard_ms = Number.NEGATIVE_INFINITY;
  private readonly driver: RateDriver;

  constructor(
    private readonly host: CapHost,
    private readonly hid: Hid | null = browserHid(),
    private readonly now: () => number = () => performance.now(),
  ) {
    this.driver = new RateDriver(host.target, "spacemouse", host.speeds);
    if (!hid) {
      host.status({
        kind: "absent",
        text: "This browser has no WebHID: use Chrome or Edge, or give the device to the server (--device spacemouse).",
      });
      return;
    }
    hid.addEventListener("connect", this.onConnect);
    hid.addEventListener("disconnect", this.onDisconnect);
  }

  /** The device's name; null where none is open. */
  get name(): string | null {
    return this.current?.device.productName ?? null;
  }

  /** Lets the user choose a device; to be called in a user's gesture. Whether one is open. */
  async connect(): Promise<boolean> {
    if (!this.hid) return false;
    try {
      return await this.openFirst(await this.hid.requestDevice({ filters: [...FILTERS] }));
    } catch (error) {
      return this.fail(error);
    }
  }

  /** Opens a device that was allowed before; on load. Whether one is open. */
  async reconnect(): Promise<boolean> {
    if (!this.hid) return false;
    try {
      return await this.openFirst(await this.hid.getDevices());
    } catch (error) {
      return this.fail(error);
    }
  }

  /** Moves the target; once a frame. Whether another frame is wanted. */
  frame(now_ms: number): boolean {
    const isHeard = this.settings.isOn && this.current && now_ms - this.heard_ms < SILENCE_MS;
    const rates =
      isHeard && this.current ? ratesOfCap(this.current.cap.axes, this.settings.dead_zone, this.settings.bend) : REST;
    return this.driver.drive(rates, now_ms);
  }

  async close(): Promise<void> {
    this.hid?.removeEventListener("connect", this.onConnect);
    this.hid?.removeEventListener("disconnect", this.onDisconnect);
    await this.leave()?.close();
  }

  private async openFirst(devices: readonly HidDevice[]): Promise<boolean> {
    for (const device of devices) if (await this.open(device)) return true;
    return this.current !== null;
  }

  private async open(device: HidDevice): Promise<boolean> {
    if (this.current?.device === device) return true;
    const isMaker = device.vendorId === VENDOR_3DCONNEXION || device.vendorId === VENDOR_LOGITECH;
    const cap = new Cap(device.collections);
    // A receiver shows itself as several devices; those without the six freedoms are its mouse and keyboard.
    if (!isMaker || cap.freedoms < 6) return false;
    if (!device.opened) await device.open();
    await this.leave()?.close();
    this.current = { device, cap };
    device.addEventListener("inputreport", this.onReport);
    this.host.status({ kind: "open", name: device.productName });
    return true;
  }

  /** Forgets the open device. */
  private leave(): HidDevice | null {
    const device = this.current?.device ?? null;
    device?.removeEventListener("inputreport", this.onReport);
    this.current = null;
    return device;
  }

  private fail(error: unknown): false {
    const text = error instanceof Error ? error.message : String(error);
    this.host.status({ kind: "failed", text: `The SpaceMouse cannot be opened: ${text}` });
    return false;
  }

  private readonly onConnect = (event: { device: HidDevice }): void => {
    if (!this.current) void this.open(event.device).catch((error: unknown) => this.fail(error));
  };

  private readonly onDisconnect = (event: { device: HidDevice }): void => {
    if (this.current?.device !== event.device) return;
    this.leave();
    this.host.status({ kind: "none" });
    this.host.moved();
  };

  private readonly onReport = (report: HidInputReport): void => {
    const cap = this.current?.cap;
    if (!cap || !this.settings.isOn) return;
    const before = cap.buttons;
    cap.report(report.reportId, report.data);
    this.heard_ms = this.now();
    for (const button of cap.buttons) if (!before.has(button)) this.host.button(button);
    this.host.moved();
  };
}
