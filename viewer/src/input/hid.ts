// Input reports of HID devices, read by the device's own descriptor: the place, size and range of each usage.

/** One item of a report, as WebHID gives it; offsets follow from the order. */
export interface HidReportItem {
  readonly reportSize?: number;
  readonly reportCount?: number;
  readonly isConstant?: boolean;
  readonly isArray?: boolean;
  readonly isRange?: boolean;
  readonly usages?: readonly number[];
  readonly usageMinimum?: number;
  readonly usageMaximum?: number;
  readonly logicalMinimum?: number;
  readonly logicalMaximum?: number;
}

export interface HidReport {
  readonly reportId?: number;
  readonly items?: readonly HidReportItem[];
}

export interface HidCollection {
  readonly usagePage?: number;
  readonly usage?: number;
  readonly inputReports?: readonly HidReport[];
  readonly children?: readonly HidCollection[];
}

/** A number in a report. */
export interface HidField {
  /** Usage page in the upper 16 bits, usage in the lower; for an array, that of its logical minimum. */
  readonly usage: number;
  readonly bit: number;
  readonly bits: number;
  readonly minimum: number;
  readonly maximum: number;
  /** The number selects the active usage, instead of an amount. */
  readonly isArray: boolean;
}

/** The fields of each input report, by report id, without padding. */
export function fieldsOf(collections: readonly HidCollection[]): Map<number, HidField[]> {
  const fields = new Map<number, HidField[]>();
  const seen = new Set<HidReport>();
  const visit = (collection: HidCollection): void => {
    for (const report of collection.inputReports ?? []) {
      // Chromium lists a report in each collection that has a part of it, whole each time.
      const id = report.reportId ?? 0;
      if (seen.has(report) || fields.has(id)) continue;
      seen.add(report);
      fields.set(id, fieldsOfReport(report));
    }
    for (const child of collection.children ?? []) visit(child);
  };
  for (const collection of collections) visit(collection);
  return fields;
}

function fieldsOfReport(report: HidReport): HidField[] {
  const fields: HidField[] = [];
  let bit = 0;
  for (const item of report.items ?? []) {
    const bits = item.reportSize ?? 0;
    const count = item.reportCount ?? 0;
    const [minimum, maximum] = rangeOf(item, bits);
    for (let k = 0; k < count; k++, bit += bits) {
      const usage = usageOf(item, k);
      if (item.isConstant || usage === null || bits === 0 || bits > 32) continue;
      fields.push({ usage, bit, bits, minimum, maximum, isArray: item.isArray ?? false });
    }
  }
  return fields;
}

/** Some descriptors state an upper limit of -1 where all bits of an unsigned number are meant. */
function rangeOf(item: HidReportItem, bits: number): [number, number] {
  const minimum = item.logicalMinimum ?? 0;
  const maximum = item.logicalMaximum ?? 0;
  return maximum > minimum ? [minimum, maximum] : [minimum, minimum + 2 ** bits - 1];
}

function usageOf(item: HidReportItem, k: number): number | null {
  if (item.isRange) {
    if (item.usageMinimum === undefined) return null;
    return item.isArray
      ? item.usageMinimum
      : Math.min(item.usageMinimum + k, item.usageMaximum ?? item.usageMinimum + k);
  }
  const usages = item.usages ?? [];
  // The last usage stands for all further numbers of the item.
  return usages[item.isArray ? 0 : Math.min(k, usages.length - 1)] ?? null;
}

/** The number of a field, signed where its range is; null where the report ends before it. */
export function readField(field: HidField, data: DataView): number | null {
  if (field.bit + field.bits > 8 * data.byteLength) return null;
  let value = 0;
  for (let k = 0; k < field.bits; k++) {
    const bit = field.bit + k;
    if ((data.getUint8(bit >> 3) >> (bit & 7)) & 1) value += 2 ** k;
  }
  return field.minimum < 0 && value >= 2 ** (field.bits - 1) ? value - 2 ** field.bits : value;
}

/** From -1 to 1 about the middle of the field's range. */
export function deflection(field: HidField, value: number): number {
  const middle = (field.minimum + field.maximum) / 2;
  const half = (field.maximum - field.minimum) / 2;
  return Math.min(1, Math.max(-1, (value - middle) / half));
}
