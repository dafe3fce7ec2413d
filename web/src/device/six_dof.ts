/**
 * 6-DOF mice: reports to axes and buttons by the device's own descriptor, which WebHID has parsed:
 * `paint3d/device/six_dof.py`.
 */

const [DESKTOP, BUTTONS] = [0x01, 0x09];
const FIRST_AXIS = 0x30;
export const MULTI_AXIS = { usagePage: DESKTOP, usage: 0x08 };
const JOYSTICKS = [0x04, 0x05]; // usages of the desktop's page
const AXES = ["x", "y", "z", "rx", "ry", "rz"];
const MOST_BUTTONS = 31;

/** What is used of WebHID's `HIDReportItem`. */
export interface ReportItem {
  isArray?: boolean;
  isConstant?: boolean;
  isRange?: boolean;
  usages?: readonly number[]; // with their page: page << 16 | usage
  usageMinimum?: number;
  usageMaximum?: number;
  reportSize?: number; // bits
  reportCount?: number;
  logicalMinimum?: number;
  logicalMaximum?: number;
}

/** And of its `HIDCollectionInfo`. */
export interface Collection {
  usagePage?: number;
  usage?: number;
  children?: readonly Collection[];
  inputReports?: readonly { reportId?: number; items?: readonly ReportItem[] }[];
}

/** One number in a report. */
interface Field {
  reportId: number;
  bit: number; // from the report's beginning, its id not counted
  size: number;
  usage: number; // with its page
  low: number;
  high: number;
  isArray: boolean;
}

/** Where axes and buttons are in a device's reports. */
export interface MouseLayout {
  axes: Field[];
  buttons: Field[];
  bits: Map<number, number>; // length of each report
}

/** Last known state: +x right, +y towards the user, +z down, and the turns about them, as sent. */
export interface MouseReading {
  axes: readonly number[];
  buttons: number;
}

export const MOUSE_AT_REST: MouseReading = { axes: [0, 0, 0, 0, 0, 0], buttons: 0 };

/** A device that is none, or a report that is not of it. */
export class DeviceError extends Error {
  override name = "DeviceError";
}

/** Find the six axes of a 6-DOF mouse. */
export function findMouseLayout(collections: readonly Collection[]): MouseLayout {
  const bits = new Map<number, number>();
  const fields: Field[] = [];
  for (const top of collections) {
    const isJoystick = top.usagePage === DESKTOP && JOYSTICKS.includes(top.usage ?? 0);
    for (const [reportId, items] of itemsOf(top))
      for (const item of items) {
        const [start, size, count] = [bits.get(reportId) ?? 0, item.reportSize ?? 0, item.reportCount ?? 0];
        bits.set(reportId, start + size * count);
        if (item.isConstant === true || isJoystick || size === 0) continue;
        const [low, high] = [item.logicalMinimum ?? 0, item.logicalMaximum ?? 0];
        for (let k = 0; k < count; k++) {
          const usage = usageAt(item, item.isArray === true ? 0 : k);
          fields.push({ reportId, bit: start + k * size, size, usage, low, high, isArray: item.isArray === true });
        }
      }
  }
  const axes = AXES.map((_, k) => fields.find((field) => !field.isArray && field.usage === (DESKTOP << 16) + FIRST_AXIS + k));
  const missing = AXES.filter((_, k) => axes[k] === undefined).join(" ");
  if (missing !== "") throw new DeviceError(`not a 6-DOF mouse: its descriptor has no axis ${missing}`);
  return { axes: axes as Field[], buttons: fields.filter(({ usage }) => usage >> 16 === BUTTONS), bits };
}

/** Update a reading by one report, without its id; what the report lacks keeps its value. */
export function decodeReport(layout: MouseLayout, reportId: number, data: DataView, before: MouseReading): MouseReading {
  const size = Math.ceil((layout.bits.get(reportId) ?? 0) / 8);
  if (size === 0) return before; // a battery's, or another that says nothing of axes
  if (data.byteLength < size)
    throw new DeviceError(`report ${reportId} has ${data.byteLength} bytes; expected ${size}`);
  const axes = layout.axes.map((field, k) => (field.reportId === reportId ? numberAt(field, data) : before.axes[k]));
  const fields = layout.buttons.filter((field) => field.reportId === reportId);
  return { axes, buttons: fields.length > 0 ? pressed(fields, data) : before.buttons };
}

/** The items of each report in a collection: its own, or those of the collections in it. */
function itemsOf(collection: Collection): Map<number, ReportItem[]> {
  const all = new Map((collection.inputReports ?? []).map(({ reportId, items }) => [reportId ?? 0, [...(items ?? [])]]));
  if (all.size > 0) return all;
  for (const child of collection.children ?? [])
    for (const [reportId, items] of itemsOf(child)) all.set(reportId, [...(all.get(reportId) ?? []), ...items]);
  return all;
}

/** The usage of the k-th number of an item; the last one stands for those that follow. */
function usageAt({ isRange, usages, usageMinimum, usageMaximum }: ReportItem, k: number): number {
  if (isRange === true) return Math.min((usageMinimum ?? 0) + k, usageMaximum ?? 0);
  return usages === undefined || usages.length === 0 ? 0 : usages[Math.min(k, usages.length - 1)];
}

/** A field's number; it may start at any bit and cross bytes, the lowest bit comes first. */
function numberAt({ bit, size, low }: Field, data: DataView): number {
  let value = 0;
  for (let k = 0; k < size; k++) if ((data.getUint8((bit + k) >> 3) >> ((bit + k) & 7)) & 1) value += 2 ** k;
  return low < 0 && value >= 2 ** (size - 1) ? value - 2 ** size : value;
}

/** The buttons that are down, as bits; bit 0 is the first. */
function pressed(fields: readonly Field[], data: DataView): number {
  let buttons = 0;
  for (const field of fields) {
    const value = numberAt(field, data);
    const isIn = value >= field.low && value <= field.high;
    const usage = (field.usage & 0xffff) + (field.isArray ? value - field.low : 0);
    const isDown = field.isArray ? isIn && usage > 0 : value !== 0;
    if (isDown && usage >= 1 && usage <= MOST_BUTTONS) buttons |= 1 << (usage - 1);
  }
  return buttons;
}
