/** A 6-DOF mouse by WebHID: deflections of its cap, and buttons: `paint3d/device/space_mouse.py`. */

import catalogue from "../../../paint3d/device/catalogue.json";
import { decodeReport, findMouseLayout, MOUSE_AT_REST, MULTI_AXIS, type Collection, type MouseLayout, type MouseReading } from "./six_dof";

const SILENCE_MS = 150; // without a report, after which the deflection is zero
const DEAD_ZONE = 0.05; // fraction of the full deflection that counts as rest
const CURVE = 1.6; // exponent of the response

/** What is used of WebHID's `HIDDevice`. */
export interface HidDevice extends EventTarget {
  readonly vendorId: number;
  readonly productId: number;
  readonly productName: string;
  readonly collections: readonly Collection[];
  readonly opened: boolean;
  open(): Promise<void>;
  close(): Promise<void>;
}

/** And of `navigator.hid`. */
export interface Hid extends EventTarget {
  getDevices(): Promise<HidDevice[]>;
  requestDevice(options: { filters: { usagePage: number; usage: number }[] }): Promise<HidDevice[]>;
}

interface Quirks {
  fullDeflection: number;
  signs: readonly number[];
}

/** WebHID, where the browser has it. */
export function hidOf(): Hid | null {
  return (navigator as unknown as { hid?: Hid }).hid ?? null;
}

export function quirksOf(vendor: number, product: number): Quirks {
  const hex = (id: number): string => id.toString(16).padStart(4, "0");
  const own = catalogue.six_dof_mice.find((row) => row.vendor === hex(vendor) && row.products.includes(hex(product)));
  const { full_deflection: fullDeflection, axes_signs: signs } = { ...catalogue.six_dof_defaults, ...own };
  return { fullDeflection, signs };
}

/** Deflection, each -1 to 1: x right, y away, z up, and the turns about them. */
export function deflection(axes: readonly number[], { fullDeflection, signs }: Quirks): number[] {
  return axes.map((count, k) => {
    const linear = Math.min(Math.max(count / fullDeflection, -1.0), 1.0);
    const beyond = Math.max(Math.abs(linear) - DEAD_ZONE, 0.0) / (1.0 - DEAD_ZONE);
    return Math.sign(linear) * beyond ** CURVE * signs[k];
  });
}

export class SpaceMouse {
  #reading: MouseReading = MOUSE_AT_REST;
  #deflection = [0, 0, 0, 0, 0, 0];
  #heardMs = -Infinity;
  readonly #layout: MouseLayout;
  readonly #quirks: Quirks;
  readonly #heard = (event: Event): void => this.#hear(event as Event & { reportId: number; data: DataView });

  /** `moved` is told of every report, `pressed` of buttons that went down, as bits. */
  constructor(
    readonly device: HidDevice,
    private readonly moved: () => void,
    private readonly pressed: (buttons: number) => void,
  ) {
    this.#layout = findMouseLayout(device.collections);
    this.#quirks = quirksOf(device.vendorId, device.productId);
  }

  /** Open one that the user chooses; null where none was chosen. */
  static async choose(hid: Hid): Promise<HidDevice | null> {
    const [device] = await hid.requestDevice({ filters: [MULTI_AXIS] });
    return device ?? null;
  }

  async start(): Promise<void> {
    if (!this.device.opened) await this.device.open();
    this.device.addEventListener("inputreport", this.#heard);
  }

  async stop(): Promise<void> {
    this.device.removeEventListener("inputreport", this.#heard);
    this.#heardMs = -Infinity;
    await this.device.close();
  }

  /** The deflection now: a mouse stops sending at rest, and its last report need not have been zero. */
  deflectionAt(nowMs: number): readonly number[] | null {
    return nowMs - this.#heardMs < SILENCE_MS && this.#deflection.some((x) => x !== 0.0) ? this.#deflection : null;
  }

  #hear({ reportId, data, timeStamp }: Event & { reportId: number; data: DataView }): void {
    const before = this.#reading.buttons;
    this.#reading = decodeReport(this.#layout, reportId, data, this.#reading);
    this.#deflection = deflection(this.#reading.axes, this.#quirks);
    this.#heardMs = timeStamp;
    const fresh = this.#reading.buttons & ~before;
    if (fresh !== 0) this.pressed(fresh);
    this.moved();
  }
}
