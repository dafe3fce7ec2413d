/** A brush, which Python has prepared: its tuft on a material (`paint3d/brush/bending.py`). */

import { NDArray, type Records } from "../core/arrays";
import type { Bundle } from "../core/bundle";
import type { Argument, Kernels } from "../core/kernels";
import type { Material } from "../colour/materials";
import { RecordingError } from "../recording/recording";
import { guessed } from "./shape_guess";

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
  hairs?: HairWords; // of a tuft of single hairs
}

/** What is said of hairs beside their arrays. */
export interface HairWords {
  count: number;
  numbers: Record<string, number>;
  // of zeros: so long, and so much longer for each pigment
  shapes: Record<string, { kind: "f4" | "f8"; shape: [number, number][] }>;
}

export class Brush {
  readonly words: BrushWords;
  readonly curves: { [name: string]: NDArray };
  readonly #tables: { [name: string]: NDArray };
  readonly #bristles: { [name: string]: NDArray } = {};

  constructor(
    private readonly kernels: Kernels,
    private readonly bundle: Bundle<BrushWords>,
  ) {
    this.words = bundle.words;
    const read = (prefix: string): { [name: string]: NDArray } =>
      Object.fromEntries(
        bundle.names(prefix).map((name) => [name, bundle.anyArray(kernels, prefix + name)]),
      );
    this.#tables = read("tuft.");
    const [spine, diameters] = [bundle.numbers("tuft.spine", "f4"), bundle.numbers("tuft.diameters", "f8")];
    const apart = { reach: bundle.numbers("apart.reach", "u4"), openness: bundle.numbers("apart.openness", "u4") };
    const [tilts, descents, , stations] = this.#tables.spine.shape;
    for (const [name, table] of Object.entries(guessed({ spine, diameters, lengthMm: this.lengthMm, apart })))
      this.#tables[name] = NDArray.of(kernels, "f4", table, [tilts, descents, stations]);
    this.curves = read("curves.");
  }

  get name(): string {
    return this.words.name;
  }

  get lengthMm(): number {
    return this.words.length_mm;
  }

  get hasHairs(): boolean {
    return this.words.hairs !== undefined;
  }

  get hairs(): HairWords {
    if (this.words.hairs === undefined) throw new Error(`${this.name} has no single hairs`);
    return this.words.hairs;
  }

  /** Arrays for painting with its hairs (`make_hairs`). */
  makeHairs(load: NDArray<"f8">, memory: Records): { [name: string]: Argument } {
    const { kernels, bundle } = this;
    const { numbers, shapes } = this.hairs;
    const made: { [name: string]: Argument } = { bristles: {}, imprint: {} };
    const put = (name: string, value: Argument): void => {
      const [first, second] = name.split(".");
      if (second === undefined) made[first] = value;
      else (made[first] as { [name: string]: Argument })[second] = value;
    };
    for (const [name, value] of Object.entries(numbers)) put(name, value);
    for (const name of bundle.names("hairs."))
      put(name, this.#heldHairs(name) ?? bundle.anyArray(kernels, `hairs.${name}`));
    for (const [name, { kind, shape }] of Object.entries(shapes))
      put(name, kernels.zeros(kind, ...shape.map(([base, each]) => base + each * load.shape[1])));
    const state = "brush_engine.bristles.state";
    const bend = kernels.records("brush_engine.bristles.bend.BEND");
    return { ...made, load, memory, bend, kept: kernels.records(`${state}.KEPT`) };
  }

  /** Arrays of the hairs themselves, which nobody changes: they are read once. */
  #heldHairs(name: string): NDArray | null {
    if (!name.startsWith("bristles.")) return null;
    return (this.#bristles[name] ??= this.bundle.anyArray(this.kernels, `hairs.${name}`));
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
      spread: tuft.spread + (material.friction - 1.0) * this.words.rubbing,
      drag_fraction: Math.min(this.words.farthest_drag, tuft.drag_fraction * material.friction),
    };
  }
}

/** How much ink a dip takes up, relative to the preset's full load. */
export interface DipAmount {
  wetted: number;
  fullness: number;
}

export const FULL_DIP: DipAmount = { wetted: 1.0, fullness: 1.0 };

/** The amount that a score's dip says, where it says one; `line` is where. */
export function readAmount(words: unknown, line: string): DipAmount | null {
  if (words === undefined) return null;
  const amount = { ...FULL_DIP, ...(words as object) };
  const { wetted, fullness } = amount;
  const isIn = (value: unknown, least: number, most: number): boolean =>
    typeof value === "number" && value >= least && value <= most;
  if (Object.keys(amount).length !== 2 || !isIn(wetted, 0.001, 1.0) || !isIn(fullness, 0.05, 3.0))
    throw new RecordingError(
      `${line}: a dip is ${JSON.stringify(words)}; expected wetted, .001 to 1, and fullness, .05 to 3`,
    );
  return amount;
}

/** A tuft with this load when full, and the matching rate of transfer. */
export function amountOfTuft(amount: DipAmount, tuft: Tuft): Tuft {
  return {
    ...tuft,
    load: tuft.load * amount.wetted * amount.fullness,
    transfer_per_mm: tuft.transfer_per_mm / amount.wetted,
  };
}
