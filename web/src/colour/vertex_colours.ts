/** Colours of a painted surface's vertices: `ColourModel` of `paint3d/colour/vertex_colours.py`. */

import { NDArray } from "../core/arrays";
import type { Argument, Kernels } from "../core/kernels";
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
  ground: Float64Array; // (31,) behind a matt film
  glossyGround: Float64Array; // and behind a glossy one
  tables: Record<string, { table: Float32Array; shades: Uint8Array; bend: number }>;
}

export class ColourModel {
  readonly #look: { [name: string]: Argument };
  readonly #kernel: string;

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
    this.#kernel = "colour.kernels.kubelka_munk.mixture_colours";
    const glossy = pigments.some((pigment) => pigment.saunderson);
    const [outer, inner] = glossy ? tables.saunderson : [0.0, 0.0];
    const ground = glossy ? backing.glossyGround : backing.ground;
    const live = pigments.every((pigment) => pigment.in_palette);
    const chosen = live ? tables.liveBands : Int32Array.from(ground.keys());
    const weights = live ? tables.liveWeights : tables.rgbWeights;
    const scale = (1.0 - outer) * (1.0 - inner);
    const paints: number[] = [];
    const bands: number[] = [];
    const offset = [0.0, 0.0, 0.0];
    for (const [k, band] of chosen.entries()) {
      for (const pigment of pigments) paints.push(pigment.K[band], pigment.S[band]);
      bands.push(ground[band]);
      for (let c = 0; c < 3; c++) {
        bands.push(weights[3 * k + c] * scale);
        offset[c] += weights[3 * k + c];
      }
    }
    this.#look = {
      paints: of(kernels, "f4", paints, [chosen.length, pigments.length, 2]),
      bands: of(kernels, "f4", bands, [chosen.length, 4]),
      bare: of(kernels, "f4", [...backing.bareLinearRgb, ...offset.map((w) => outer * w)], [2, 3]),
      inner_loss: Math.fround(inner),
    };
  }

  /** Fill the rows of `out` of some vertices. */
  srgb(
    amounts: NDArray<"f4">, coverage: NDArray<"f4">, out: NDArray<"u1">, vertexIds: NDArray<"i4">,
  ): void {
    const wet = { vertex_ids: vertexIds, amounts, coverage };
    const shown = { codes: this.tables.codes, linear_rgb: this.tables.noRgb, srgb: out };
    this.kernels.call(this.#kernel, wet, this.#look, shown);
  }

  /** Let its tables go. */
  free(): void {
    for (const value of Object.values(this.#look)) if (value instanceof NDArray) value.free();
  }
}
