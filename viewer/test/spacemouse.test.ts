import assert from "node:assert/strict";
import { test } from "node:test";
import { deflection, fieldsOf, type HidCollection, type HidReportItem, readField } from "../src/input/hid";
import {
  Cap,
  type CapStatus,
  type Hid,
  type HidDevice,
  type HidInputReport,
  ratesOfCap,
  SpaceMouse,
} from "../src/input/spacemouse";

const axes = (first: number, count: number, range = 350): HidReportItem => ({
  reportSize: 16,
  reportCount: count,
  isRange: true,
  usageMinimum: 0x10030 + first,
  usageMaximum: 0x10030 + first + count - 1,
  logicalMinimum: -range,
  logicalMaximum: range,
});
const buttons = (count: number): HidReportItem[] => [
  {
    ...{ reportSize: 1, reportCount: count, isRange: true, usageMinimum: 0x90001, usageMaximum: 0x90000 + count },
    ...{ logicalMinimum: 0, logicalMaximum: 1 },
  },
  { reportSize: 1, reportCount: (8 - (count % 8)) % 8, isConstant: true },
];

/** A newer device: all six axes in one report of 12 bytes. */
const COMBINED: HidCollection[] = [
  {
    usagePage: 1,
    usage: 8,
    inputReports: [
      { reportId: 1, items: [axes(0, 6)] },
      { reportId: 3, items: buttons(15) },
    ],
  },
];
/** An older one: two reports of 6 bytes, each in a collection of its own, and usages listed one by one. */
const SPLIT: HidCollection[] = [
  {
    usagePage: 1,
    usage: 8,
    inputReports: [{ reportId: 3, items: buttons(2) }],
    children: [
      {
        inputReports: [
          {
            reportId: 1,
            items: [
              { ...axes(0, 3, 500), isRange: false, usages: [0x10030, 0x10031, 0x10032] },
              { reportSize: 8, reportCount: 1, isConstant: true },
            ],
          },
        ],
      },
      { inputReports: [{ reportId: 2, items: [axes(3, 3, 500)] }] },
    ],
  },
];

const int16 = (...values: number[]) => new DataView(Int16Array.from(values).buffer);
const bytes = (...values: number[]) => new DataView(Uint8Array.from(values).buffer);

class FakeDevice implements HidDevice {
  readonly vendorId: number = 0x256f;
  readonly productId = 0xc635;
  opened = false;
  readonly listeners = new Set<(report: HidInputReport) => void>();
  constructor(
    readonly productName: string,
    readonly collections: HidCollection[],
    private readonly refusal: string | null = null,
  ) {}
  open(): Promise<void> {
    if (this.refusal) return Promise.reject(new Error(this.refusal));
    this.opened = true;
    return Promise.resolve();
  }
  close(): Promise<void> {
    this.opened = false;
    return Promise.resolve();
  }
  addEventListener(_kind: string, listener: (report: HidInputReport) => void): void {
    this.listeners.add(listener);
  }
  removeEventListener(_kind: string, listener: (report: HidInputReport) => void): void {
    this.listeners.delete(listener);
  }
  report(reportId: number, data: DataView): void {
    for (const listener of this.listeners) listener({ device: this, reportId, data });
  }
}

class FakeHid implements Hid {
  known: HidDevice[] = [];
  chosen: HidDevice[] = [];
  asked: unknown = null;
  readonly listeners = new Map<string, (event: { device: HidDevice }) => void>();
  getDevices = () => Promise.resolve(this.known);
  requestDevice = (options: unknown) => {
    this.asked = options;
    return Promise.resolve(this.chosen);
  };
  addEventListener(kind: string, listener: (event: { device: HidDevice }) => void): void {
    this.listeners.set(kind, listener);
  }
  removeEventListener(kind: string): void {
    this.listeners.delete(kind);
  }
}

function bench(hid: FakeHid | null = new FakeHid()) {
  const seen = { x: 0, turn: 0, nudges: 0, puts: 0, moved: 0 };
  const statuses: CapStatus[] = [];
  const pressed: number[] = [];
  const clock = { now: 1000 };
  const mouse = new SpaceMouse(
    {
      target: () => ({
        nudge: (increment) => {
          seen.nudges++;
          seen.x += increment.translation[0];
          seen.turn += increment.rotation[1];
        },
        put: () => {
          seen.puts++;
        },
      }),
      speeds: () => ({ translation_m_per_s: 0.1, rotation_rad_per_s: 1 }),
      button: (number) => pressed.push(number),
      status: (status) => statuses.push(status),
      moved: () => {
        seen.moved++;
      },
    },
    hid,
    () => clock.now,
  );
  return { hid: hid as FakeHid, mouse, seen, statuses, pressed, clock };
}

test("both layouts say the same of the same cap", () => {
  const combined = new Cap(COMBINED);
  combined.report(1, int16(350, -175, 35, -350, 0, 70));
  const split = new Cap(SPLIT);
  split.report(1, new DataView(Uint8Array.of(0xf4, 0x01, 0x06, 0xff, 0x32, 0x00, 0x77).buffer));
  split.report(2, int16(-500, 0, 100));
  for (const cap of [combined, split]) {
    assert.equal(cap.freedoms, 6);
    assert.deepEqual(
      cap.axes.map((axis) => Math.round(axis * 1000) / 1000),
      [1, -0.5, 0.1, -1, 0, 0.2],
    );
  }
});

test("a report tells its own axes and leaves the others, unknown ones and short ones tell nothing", () => {
  const cap = new Cap(SPLIT);
  cap.report(2, int16(250, 0, 0));
  cap.report(1, int16(500, 0, 0));
  cap.report(23, int16(1, 2, 3));
  cap.report(1, bytes(0));
  assert.deepEqual(cap.axes, [1, 0, 0, 0.5, 0, 0]);
});

test("a button report is the whole state of the buttons, and axis reports leave it", () => {
  const cap = new Cap(COMBINED);
  cap.report(3, bytes(0b101, 0b0100_0000));
  assert.deepEqual([...cap.buttons], [1, 3, 15]);
  cap.report(1, int16(0, 0, 0, 0, 0, 0));
  assert.equal(cap.buttons.size, 3);
  cap.report(3, bytes(0, 0b1000_0000));
  assert.equal(cap.buttons.size, 0, "padding is no button");
});

test("buttons told as an array of usages", () => {
  const array: HidReportItem = {
    ...{ reportSize: 16, reportCount: 3, isArray: true, isRange: true, usageMinimum: 0x90001, usageMaximum: 0x90100 },
    ...{ logicalMinimum: 1, logicalMaximum: 0x100 },
  };
  const cap = new Cap([{ inputReports: [{ reportId: 28, items: [array] }] }]);
  cap.report(28, int16(12, 0, 2));
  assert.deepEqual([...cap.buttons], [12, 2]);
});

test("fields follow each other bit by bit, ids apart", () => {
  const fields = fieldsOf([
    {
      inputReports: [
        { reportId: 1, items: [{ reportSize: 3, reportCount: 1, isConstant: true }, ...buttons(2), axes(0, 2)] },
        { items: [axes(2, 1)] },
      ],
    },
  ]);
  assert.deepEqual(
    (fields.get(1) ?? []).map((field) => [field.usage, field.bit, field.bits]),
    [
      [0x90001, 3, 1],
      [0x90002, 4, 1],
      [0x10030, 11, 16],
      [0x10031, 27, 16],
    ],
  );
  assert.equal(fields.get(0)?.length, 1);
  const second = fields.get(1)?.[3];
  assert.ok(second);
  const data = new DataView(new ArrayBuffer(6));
  data.setUint16(3, (0x10000 - 100) << 3, true);
  data.setUint8(5, 0b111);
  assert.equal(readField(second, data), -100);
});

test("constants are no fields whatever usage they bear, and the last usage stands for all that follow", () => {
  const pair = { reportSize: 8, reportCount: 2, logicalMinimum: 0, logicalMaximum: 9 };
  const items = [
    { ...pair, usages: [0x10030], isConstant: true },
    { ...pair, usages: [0x10031] },
  ];
  assert.deepEqual(
    (fieldsOf([{ inputReports: [{ items }] }]).get(0) ?? []).map((field) => [field.usage, field.bit]),
    [
      [0x10031, 16],
      [0x10031, 24],
    ],
  );
});

test("an unsigned range is centred, and one that the descriptor leaves out is taken from the bits", () => {
  const item = { reportSize: 8, reportCount: 1, usages: [0x10030] };
  const [wide] =
    fieldsOf([{ inputReports: [{ items: [{ ...item, logicalMinimum: 0, logicalMaximum: -1 }] }] }]).get(0) ?? [];
  assert.ok(wide);
  assert.equal(deflection(wide, 255), 1);
  assert.equal(deflection(wide, 0), -1);
  assert.equal(readField(wide, bytes(200)), 200);
});

test("the cap's axes are the view's: right, up, towards the viewer", () => {
  const move = (axis: number) => {
    const values = [0, 0, 0, 0, 0, 0];
    values[axis] = 1;
    const { translation, rotation } = ratesOfCap(values, 0, 0);
    return [...translation, ...rotation];
  };
  assert.deepEqual(move(0), [1, 0, 0, 0, 0, 0]);
  assert.deepEqual(move(1), [0, 0, 1, 0, 0, 0], "pulled towards the user");
  assert.deepEqual(move(2), [0, -1, 0, 0, 0, 0], "pressed down");
  assert.deepEqual(move(3), [0, 0, 0, 1, 0, 0]);
  assert.deepEqual(move(4), [0, 0, 0, 0, 0, 1]);
  assert.deepEqual(move(5), [0, 0, 0, 0, -1, 0]);
});

test("a gesture opens a device, which moves the hand until it is let go", async () => {
  const { hid, mouse, seen, statuses, pressed, clock } = bench();
  const device = new FakeDevice("SpaceMouse Pro", COMBINED);
  hid.chosen = [device];
  assert.equal(await mouse.connect(), true);
  assert.deepEqual(hid.asked, {
    filters: [
      { vendorId: 0x256f, usagePage: 1, usage: 8 },
      { vendorId: 0x046d, usagePage: 1, usage: 8 },
    ],
  });
  assert.deepEqual(statuses, [{ kind: "open", name: "SpaceMouse Pro" }]);
  device.report(1, int16(350, 0, 0, 0, 0, 0));
  assert.equal(seen.moved, 1);
  for (let k = 0; k <= 10; k++) assert.equal(mouse.frame(clock.now + 10 * k), true);
  assert.ok(Math.abs(seen.x - 0.1 * (0.1 + 1 / 60)) < 1e-12);
  device.report(1, int16(0, 0, 0, 0, 0, 0));
  assert.equal(mouse.frame(1110), false);
  assert.equal(seen.puts, 1);
  device.report(3, bytes(1, 0));
  device.report(3, bytes(3, 0));
  assert.deepEqual(pressed, [1, 2]);
});

test("a known device is opened on load, its mouse and keyboard sides and other makers' are left", async () => {
  const { hid, mouse } = bench();
  const keyboard = new FakeDevice("Receiver", [{ usagePage: 1, usage: 6, inputReports: [] }]);
  const other = Object.assign(new FakeDevice("Joystick", COMBINED), { vendorId: 0x1234 });
  const cap = new FakeDevice("SpaceNavigator", SPLIT);
  hid.known = [keyboard, other, cap];
  assert.equal(await mouse.reconnect(), true);
  assert.deepEqual([keyboard.opened, other.opened, cap.opened], [false, false, true]);
  assert.equal(mouse.name, "SpaceNavigator");
});

test("an unplugged device is at rest at once, and opened again when it is back", async () => {
  const { hid, mouse, seen, statuses } = bench();
  const device = new FakeDevice("SpaceMouse", COMBINED);
  hid.known = [device];
  await mouse.reconnect();
  device.report(1, int16(350, 0, 0, 0, 0, 0));
  mouse.frame(1000);
  hid.listeners.get("disconnect")?.({ device });
  assert.equal(mouse.frame(1010), false);
  assert.equal(seen.puts, 1);
  assert.equal(mouse.name, null);
  device.opened = false;
  hid.listeners.get("connect")?.({ device });
  await new Promise((resolve) => setImmediate(resolve));
  assert.equal(mouse.name, "SpaceMouse");
  assert.deepEqual(
    statuses.map((status) => status.kind),
    ["open", "none", "open"],
  );
  assert.equal(mouse.frame(1020), false, "what the cap said before it went is forgotten");
});

test("a cap that is silent while deflected counts as at rest after five seconds", async () => {
  const { hid, mouse } = bench();
  const device = new FakeDevice("SpaceMouse", COMBINED);
  hid.known = [device];
  await mouse.reconnect();
  device.report(1, int16(350, 0, 0, 0, 0, 0));
  assert.equal(mouse.frame(1000 + 4900), true);
  assert.equal(mouse.frame(1000 + 5100), false);
});

test("an absent API and a refusal are told", async () => {
  const absent = bench(null);
  assert.equal(absent.statuses[0]?.kind, "absent");
  assert.equal(await absent.mouse.connect(), false);
  assert.equal(await absent.mouse.reconnect(), false);
  const { hid, mouse, statuses } = bench();
  hid.chosen = [new FakeDevice("SpaceMouse", COMBINED, "Failed to open the device.")];
  assert.equal(await mouse.connect(), false);
  assert.deepEqual(statuses, [{ kind: "failed", text: "The SpaceMouse cannot be opened: Failed to open the device." }]);
});

test("who chooses nothing keeps what is open, and closing lets go of everything", async () => {
  const { hid, mouse } = bench();
  const device = new FakeDevice("SpaceMouse", COMBINED);
  hid.known = [device];
  await mouse.reconnect();
  assert.equal(await mouse.connect(), true);
  await mouse.close();
  assert.deepEqual([device.opened, device.listeners.size, hid.listeners.size], [false, 0, 0]);
});
