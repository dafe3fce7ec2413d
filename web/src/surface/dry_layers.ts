/** Dried paint: a row for each vertex that something has dried on; `paint3d/surface/dry_layers.py`. */

import { NDArray } from "../core/arrays";
import type { Kernels } from "../core/kernels";
import { roundHalfToEven } from "../core/numbers";

const FIRST_ROWS = 1024;
const BANDS = 31;
/** Of a reflectance of 1. */
export const SPECTRUM_STEPS = 65535;
/** Reflectances of the grey grounds over which a dried row says what it shows. */
export const GROUNDS = [0.04, 0.52, 1.0];

/** Dried paint at an instant, for undo. */
export interface KeptRows {
  ids: Int32Array;
  spectra: Uint16Array;
  over: Uint16Array[]; // the same over grey grounds
  amounts: Float32Array;
  share: Float32Array;
  nPigments: number;
}

export class DryLayers {
  count = 0;
  changes = 0;
  slots: NDArray<"i4">; // of each vertex, -1 where nothing has dried; (0,) before anything has
  spectra: NDArray<"u2">;
  ids: Int32Array = new Int32Array(0);
  amounts: Float32Array = new Float32Array(0); // (D, P)
  share: Float32Array = new Float32Array(0);
  #nPigments = 0;

  over: NDArray<"u2">[]; // shown over `GROUNDS`; none where nothing below can change

  constructor(kernels: Kernels, hasFilters = false) {
    this.over = hasFilters ? GROUNDS.map(() => kernels.zeros("u2", 0, BANDS)) : [];
    this.slots = kernels.zeros("i4", 0);
    this.spectra = kernels.zeros("u2", 0, BANDS);
  }

  /** The row of a vertex, -1 where nothing has dried. */
  rowOf(id: number): number {
    return id < this.slots.length ? this.slots.data[id] : -1;
  }

  /** The glue that has dried on a vertex, coats. */
  glueOf(id: number): number {
    const row = this.rowOf(id);
    if (row < 0) return 0.0;
    const own = this.amounts.subarray(row * this.#nPigments, (row + 1) * this.#nPigments);
    return rowSum(own, Math.fround);
  }

  /** Fit to so many vertices and pigments. */
  fit(capacity: number, nPigments: number): void {
    if (this.count > 0) this.#fitSlots(capacity);
    if (nPigments > this.#nPigments) {
      this.amounts = widened(this.amounts, this.#nPigments, nPigments);
      this.#nPigments = nPigments;
    }
  }

  #fitSlots(capacity: number): void {
    const n = this.slots.length;
    if (n >= capacity) return;
    this.slots = this.slots.grown(n, capacity);
    this.slots.data.fill(-1, n);
  }

  /** Rows of `spectra` for distinct vertices; `settle` gives them to them. */
  reserveRows(ids: Int32Array, capacity: number): Int32Array {
    this.#fitSlots(capacity);
    let n = this.count;
    const rows = ids.map((id) => {
      const row = this.rowOf(id);
      return row >= 0 ? row : n++;
    });
    this.#reserve(n);
    return rows;
  }

  #reserve(wanted: number): void {
    if (wanted <= this.ids.length) return;
    const room = Math.max(FIRST_ROWS, wanted + Math.floor(wanted / 2));
    this.spectra = this.spectra.grown(this.count, room);
    this.over = this.over.map((array) => array.grown(this.count, room));
    const longer = <T extends Int32Array | Float32Array>(array: T, to: T): T => {
      to.set(array);
      return to;
    };
    this.ids = longer(this.ids, new Int32Array(room));
    this.amounts = longer(this.amounts, new Float32Array(room * this.#nPigments));
    this.share = longer(this.share, new Float32Array(room));
  }

  /** Give rows to vertices on which amounts (N, P) have dried, which cover shares of them. */
  settle(ids: Int32Array, rows: Int32Array, amounts: Float32Array, share: Float32Array): void {
    this.changes++;
    const slots = this.slots.data;
    const p = this.#nPigments;
    for (const [k, row] of rows.entries()) {
      slots[ids[k]] = row;
      this.ids[row] = ids[k];
      for (let c = 0; c < p; c++) this.amounts[row * p + c] += amounts[k * p + c];
      this.share[row] = Math.max(this.share[row], share[k]);
      this.count = Math.max(this.count, row + 1);
    }
  }

  /** Leave of a row this share, nearer to the bare ground; how much ink goes. */
  fade(row: number, stays: number, bare: Float64Array): number {
    const n = this.#nPigments;
    const lost: number[] = [];
    for (let k = row * n; k < (row + 1) * n; k++) {
      const before = this.amounts[k];
      this.amounts[k] = before * stays;
      lost.push(Math.fround(before - this.amounts[k]));
    }
    this.share[row] *= stays;
    const fade = (spectra: Uint16Array, ground: (band: number) => number): void => {
      for (let k = 0; k < BANDS; k++) {
        const shown = ground(k) + stays * (spectra[BANDS * row + k] - ground(k));
        spectra[BANDS * row + k] = roundHalfToEven(Math.min(Math.max(shown, 0.0), SPECTRUM_STEPS));
      }
    };
    fade(this.spectra.data, (band) => bare[band]);
    for (const [k, over] of this.over.entries()) fade(over.data, () => GROUNDS[k] * SPECTRUM_STEPS);
    return rowSum(lost);
  }

  keep(): KeptRows {
    const n = this.count;
    return {
      ids: this.ids.slice(0, n),
      spectra: this.spectra.data.slice(0, BANDS * n),
      over: this.over.map((array) => array.data.slice(0, BANDS * n)),
      amounts: this.amounts.slice(0, n * this.#nPigments),
      share: this.share.slice(0, n),
      nPigments: this.#nPigments,
    };
  }

  restore(kept: KeptRows, capacity: number): void {
    const n = kept.ids.length;
    this.slots.data.fill(-1);
    if (n > 0) this.#fitSlots(capacity);
    this.#reserve(n);
    this.amounts.fill(0.0);
    this.share.fill(0.0);
    this.ids.set(kept.ids);
    this.spectra.data.set(kept.spectra);
    for (const [k, array] of this.over.entries()) array.data.set(kept.over[k]);
    this.amounts.set(widened(kept.amounts, kept.nPigments, this.#nPigments));
    this.share.set(kept.share);
    const slots = this.slots.data;
    for (const [row, id] of kept.ids.entries()) slots[id] = row;
    this.count = n;
    this.changes++;
  }
}

/** Rows of `before` columns with zeros to make them `after` columns. */
export function widened(rows: Float32Array, before: number, after: number): Float32Array {
  if (before === after) return rows;
  const wider = new Float32Array(before === 0 ? 0 : (rows.length / before) * after);
  for (let k = 0; k < rows.length; k++) wider[Math.floor(k / before) * after + (k % before)] = rows[k];
  return wider;
}

/** The sum of a row, in NumPy's order; `round` to its type. */
export function rowSum(row: ArrayLike<number>, round: (x: number) => number = (x) => x): number {
  const n = row.length;
  let [sum, k] = [0.0, 0];
  if (n >= 8) {
    const lanes = Array.from({ length: 8 }, (_, j) => row[j]);
    for (k = 8; k + 8 <= n; k += 8)
      for (let j = 0; j < 8; j++) lanes[j] = round(lanes[j] + row[k + j]);
    const [a, b, c, d, e, f, g, h] = lanes;
    sum = round(
      round(round(a + b) + round(c + d)) + round(round(e + f) + round(g + h)),
    );
  }
  for (; k < n; k++) sum = round(sum + row[k]);
  return sum;
}
