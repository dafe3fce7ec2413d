/** Colours of a painted surface's vertices: `ColourModel` of `paint3d/colour/vertex_colours.py`. */

import { NDArray } from "../core/arrays";
import type { Argument, Kernels } from "../core/kernels";
import { type Below, GlazeModel } from "./glazing";
import type { OneInk, Pigment } from "./materials";

/** What Python says of colour, for all materials. */
export interface ColourTables {
  codes: NDArray<"u1">;
  noRgb: NDArray<"f4">;
  liveBands: Int32Array;
  liveWeights: Float64Array; // (bands, 3)
  rgbWeights: Float64Array; // (31, 3)
  saunderson: readonly [number, number];
  primaries: Float32Array; // (31, 3) spectra of red, green and blue
}

/** What it says of one. */
export interface Backing {
  bareLinearRgb: Float32Array;
  reflectance: Float32Array; // (31,) as measured
  tables: Record<string, { table: Float32Array; shades: Uint8Array; bend: number }>;
}

export class ColourModel {
  readonly #look: { [name: string]: Argument } = {};
  readonly #glaze: GlazeModel | null = null;
  readonly #bare: Below | null = null; // what is below: the material alone
  readonly #kernel: string = "";

  constructor(
    private readonly kernels: Kernels,
    private readonly tables: ColourTables,
    pigments: readonly Pigment[],
    backing: Backing,
  ) {
    const of = NDArray.of;
    if (pigments.length === 1) {
      const own = backing.tables[pigments[0].name];
      this.#kernel = "colour.kernels.kubelka_munk.single_colours";
      const look: OneInk = {
        table: of(kernels, "f4", own.table, [own.table.length / 3, 3]),
        shades: of(kernels, "u1", own.shades, [own.shades.length / 3, 3]),
        bend: own.bend,
        bare: of(kernels, "f4", backing.bareLinearRgb, [1, 3]),
      };
      this.#look = look;
      return;
    }
    if (pigments.some((pigment) => pigment.saunderson)) {
      this.#glaze = new GlazeModel(kernels, tables, pigments, backing);
      this.#bare = { slots: kernels.zeros("i4", 0), spectra: kernels.zeros("u2", 0, backing.reflectance.length) };
      return;
    }
    this.#kernel = "colour.kernels.kubelka_munk.mixture_colours";
    const live = pigments.every((pigment) => pigment.in_palette);
    const chosen = live ? tables.liveBands : Int32Array.from(backing.reflectance.keys());
    const weights = live ? tables.liveWeights : tables.rgbWeights;
    const paints: number[] = [];
    const bands: number[] = [];
    for (const [k, band] of chosen.entries()) {
      for (const pigment of pigments) paints.push(pigment.K[band], pigment.S[band]);
      bands.push(backing.reflectance[band], ...weights.subarray(3 * k, 3 * k + 3));
    }
    this.#look = {
      paints: of(kernels, "f4", paints, [chosen.length, pigments.length, 2]),
      bands: of(kernels, "f4", bands, [chosen.length, 4]),
      bare: of(kernels, "f4", backing.bareLinearRgb, [1, 3]),
    };
  }

  /** Fill the rows of `out` of some vertices. */
  srgb(
    amounts: NDArray<"f4">, coverage: NDArray<"f4">, out: NDArray<"u1">, vertexIds: NDArray<"i4">,
  ): void {
    if (this.#glaze) {
      this.#glaze.srgb(amounts, coverage, this.#bare!, out, vertexIds);
      return;
    }
    const wet = { vertex_ids: vertexIds, amounts, coverage };
    const shown = { codes: this.tables.codes, linear_rgb: this.tables.noRgb, srgb: out };
    this.kernels.call(this.#kernel, wet, this.#look, shown);
  }

  /** Let its tables go. */
  free(): void {
    this.#glaze?.free();
    this.#bare?.slots.free();
    this.#bare?.spectra.free();
    for (const value of Object.values(this.#look)) if (value instanceof NDArray) value.free();
  }
}
