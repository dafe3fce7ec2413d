/** sRGB of every vertex before anything was painted: `_MeshColours` of `paint3d/surface/ink_store.py`. */

import { NDArray } from "../core/arrays";
import type { Kernels } from "../core/kernels";
import { roundHalfToEven } from "../core/numbers";

export class MeshColours {
  #known: number;
  #encoded: NDArray<"f4">; // (cap, 3), 0 to 1
  linear: NDArray<"f4">; // (cap, 3)

  /** Colours (B, 3) of the base vertices; `decoded` has the linear light of every code. */
  constructor(
    private readonly kernels: Kernels,
    srgb: Uint8Array,
    decoded: Float32Array,
    capacity: number,
  ) {
    this.#known = srgb.length / 3;
    this.#encoded = kernels.zeros("f4", capacity, 3);
    this.linear = kernels.zeros("f4", capacity, 3);
    this.#encoded.data.set(Float32Array.from(srgb, (code) => code / 255.0));
    this.linear.data.set(Float32Array.from(srgb, (code) => decoded[code]));
  }

  fit(capacity: number): void {
    if (this.#encoded.length >= capacity) return;
    this.#encoded = this.#encoded.grown(this.#known, capacity);
    this.linear = this.linear.grown(this.#known, capacity);
  }

  /** Interpolate at vertices that were added since, and write their codes to `srgb` (cap, 3). */
  know(parents: NDArray<"i4">, nVertices: number, srgb: NDArray<"u1">): void {
    const first = this.#known;
    if (first === nVertices) return;
    this.kernels.call("colour.kernels.glazing.add_between", parents, first, nVertices, this.#encoded);
    const [encoded, linear, codes] = [this.#encoded.data, this.linear.data, srgb.data];
    for (let k = 3 * first; k < 3 * nVertices; k++) {
      const c = encoded[k];
      linear[k] = c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
      codes[k] = roundHalfToEven(Math.fround(c * 255.0));
    }
    this.#known = nVertices;
  }

  /** Codes of vertices `first` to n. */
  codes(first: number, n: number): Uint8Array {
    return Uint8Array.from(this.#encoded.data.subarray(3 * first, 3 * n), (c) => roundHalfToEven(Math.fround(c * 255.0)));
  }

  /** What a vertex reflects: bands, of the spectra (bands, 3) of red, green and blue, in steps of 1/65535. */
  steps(id: number, primaries: Float32Array): Float64Array {
    const f = Math.fround;
    const [r, g, b] = this.linear.data.subarray(3 * id, 3 * id + 3);
    return Float64Array.from({ length: primaries.length / 3 }, (_, k) => {
      const [p, q, s] = primaries.subarray(3 * k, 3 * k + 3);
      const shown = f(f(f(r * p) + g * q) + b * s); // fused, as NumPy's product of matrices has it
      return Math.trunc(f(f(Math.min(Math.max(shown, 0.0), 1.0) * 65535.0) + 0.5));
    });
  }
}
