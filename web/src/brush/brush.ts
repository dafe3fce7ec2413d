/** A brush, which Python has prepared: its tuft on a material (`paint3d/brush/bending.py`). */

import type { NDArray } from "../core/arrays";
import type { Bundle } from "../core/bundle";
import type { Kernels } from "../core/kernels";
import type { Material } from "../colour/materials";

export interface Tuft {
  [name: string]: NDArray | number;
  length: number;
  full_press: number;
  load: number;
  lowest_tilt: number;
  transfer_per_mm: number;
  spread: number;
  drag_fraction: number;
}

export interface BrushWords {
  name: string;
  chinese: string;
  length_mm: number;
  rubbing: number;
  farthest_drag: number;
  tuft: Record<string, number>;
}

export class Brush {
  readonly words: BrushWords;
  readonly curves: { [name: string]: NDArray };
  readonly #tables: { [name: string]: NDArray };

  constructor(kernels: Kernels, bundle: Bundle<BrushWords>) {
    this.words = bundle.words;
    const read = (prefix: string): { [name: string]: NDArray } =>
      Object.fromEntries(
        bundle.names(prefix).map((name) => [name, bundle.anyArray(kernels, prefix + name)]),
      );
    this.#tables = read("tuft.");
    this.curves = read("curves.");
  }

  get name(): string {
    return this.words.name;
  }

  get lengthMm(): number {
    return this.words.length_mm;
  }

  /** Its tuft as it is, before a material draws at it. */
  get tuft(): Tuft {
    return { ...this.words.tuft, ...this.#tables } as Tuft;
  }

  /** Its tuft on a material, which may draw more or less ink out of it. */
  tuftOn(material: Material): Tuft {
    const tuft = this.tuft;
    return {
      ...tuft,
      transfer_per_mm: tuft.transfer_per_mm * material.uptake,
      spread: tuft.spread + (material.slip - 1.0) * this.words.rubbing,
      drag_fraction: Math.min(this.words.farthest_drag, tuft.drag_fraction * material.slip),
    };
  }
}

/** How much ink a dip takes up, relative to the preset's full load. */
export interface DipAmount {
  wetted: number;
  fullness: number;
}

export const FULL_DIP: DipAmount = { wetted: 1.0, fullness: 1.0 };

/** A tuft with this load when full, and the matching rate of transfer. */
export function amountOfTuft(amount: DipAmount, tuft: Tuft): Tuft {
  return {
    ...tuft,
    load: tuft.load * amount.wetted * amount.fullness,
    transfer_per_mm: tuft.transfer_per_mm / amount.wetted,
  };
}
