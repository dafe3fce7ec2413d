/** State of a painter's single hairs: `HairTuft` of `paint3d/painter/bristle_state.py`. */

import { NDArray, type Records } from "../core/arrays";
import type { Argument, Kernels } from "../core/kernels";
import type { Brush } from "../brush/brush";
import type { InkField } from "../surface/painted_surface";

/** The arrays that the kernels take, by name; `bristles` and `imprint` are tuples of their own. */
type Hairs = { [name: string]: Argument };

/** Hairs between strokes. */
export interface KeptHairs {
  load: Float64Array;
  columns: number;
  memory: Uint8Array;
}

export class HairTuft {
  readonly #count: number;
  readonly #memory: Records;
  #load: NDArray<"f8">; // (B, P) ink in each hair, coats x mm2
  #work: Hairs | null = null;

  constructor(
    private readonly kernels: Kernels,
    private readonly brush: Brush,
  ) {
    this.#count = brush.hairs.count;
    this.#load = kernels.zeros("f8", this.#count, 0);
    this.#memory = kernels.records("brush_engine.bristles.state.MEMORY");
  }

  /** Bring the tuft to a point: straighten it and join its clumps. */
  shape(): void {
    for (const name of ["set_x", "set_y", "parted", "split"]) this.#memory.field(name)[0] = 0.0;
  }

  /** Distribute the load over the hairs after a whole dip. */
  dip(held: Float64Array): void {
    this.#addPigments(held.length);
    for (const name of ["way", "unlevelled", "split"]) this.#memory.field(name)[0] = 0.0;
    const load = this.#load.data;
    const shares = held.map((part) => part / this.#count);
    for (let k = 0; k < load.length; k++) load[k] = shares[k % held.length];
  }

  /** The ink of all hairs. */
  total(): Float64Array {
    const out = this.kernels.zeros("f8", this.#load.shape[1]);
    this.kernels.call("brush_engine.bristles.ink_transfer.sum_hairs", this.#load, out);
    const held = out.data.slice();
    out.free();
    return held;
  }

  /** Rescale the hairs' ink to a total, each keeping its fraction of it. */
  rescale(total: Float64Array): void {
    this.#addPigments(total.length);
    const held = this.total();
    const load = this.#load.data;
    const count = held.length;
    for (let p = 0; p < count; p++) {
      if (held[p] === total[p]) continue;
      for (let k = p; k < load.length; k += count)
        load[k] = held[p] > 0.0 ? load[k] * (total[p] / held[p]) : total[p] / this.#count;
    }
  }

  /** Grow the load to at least this many columns. */
  #addPigments(count: number): void {
    const before = this.#load.shape[1];
    if (count <= before) return;
    const wider = this.kernels.zeros("f8", this.#count, count);
    const [from, to] = [this.#load.data, wider.data];
    for (let k = 0; k < from.length; k++)
      to[Math.floor(k / before) * count + (k % before)] = from[k];
    this.#load.free();
    this.#load = wider;
    this.#drop();
  }

  keep(): KeptHairs {
    const columns = this.#load.shape[1];
    return { load: this.#load.data.slice(), columns, memory: this.#memory.bytes.slice() };
  }

  restore(kept: KeptHairs): void {
    this.#load.free();
    this.#load = NDArray.of(this.kernels, "f8", kept.load, [this.#count, kept.columns]);
    this.#memory.bytes.set(kept.memory);
    this.#drop();
  }

  /** The arrays for the kernels, whose load is first matched to the brush's. */
  work(ink: InkField): Hairs {
    const total = ink.load.data.slice();
    const held = this.total();
    if (held.length !== total.length || held.some((part, p) => part !== total[p])) {
      this.rescale(total);
      ink.load.data.set(this.total());
    }
    this.#work ??= this.brush.makeHairs(this.#load, this.#memory);
    return this.#work;
  }

  /** Let the work go: its arrays are of another load. */
  #drop(): void {
    const work = this.#work;
    this.#work = null;
    if (work === null) return;
    for (const [name, value] of Object.entries(work))
      if (value instanceof NDArray && name !== "load") value.free();
    for (const value of Object.values(work.imprint as Hairs)) (value as NDArray).free();
  }
}
