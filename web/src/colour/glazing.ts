/** Wet paint over dried paint: `GlazeModel` of `paint3d/colour/glazing.py`. */

import { NDArray } from "../core/arrays";
import type { Argument, Kernels } from "../core/kernels";
import { GROUNDS } from "../surface/dry_layers";
import type { Backing, ColourTables } from "./vertex_colours";
import type { Pigment } from "./materials";

/** What is below: rows of spectra, and the colours that the object came with, or the material. */
export interface Below {
  slots: NDArray<"i4">;
  spectra: NDArray<"u2">;
  linearRgb?: NDArray<"f4">;
}

export class GlazeModel {
  readonly #glaze: { [name: string]: NDArray };
  readonly #ground: { [name: string]: NDArray };
  readonly #greys: NDArray<"f4">[];

  constructor(
    private readonly kernels: Kernels,
    private readonly tables: ColourTables,
    pigments: readonly Pigment[],
    backing: Backing,
  ) {
    const of = NDArray.of;
    const bands = backing.reflectance.length;
    const paints: number[] = [];
    for (let band = 0; band < bands; band++)
      for (const pigment of pigments) paints.push(pigment.K[band], pigment.S[band]);
    const films = pigments.flatMap((p) => [p.lasting ? 1 : 0, p.saunderson ? 1 : 0]);
    this.#glaze = {
      paints: of(kernels, "f4", paints, [bands, pigments.length, 2]),
      weights: of(kernels, "f4", Float32Array.from(tables.rgbWeights), [bands, 3]),
      saunderson: of(kernels, "f4", [...tables.saunderson]),
      films: of(kernels, "f4", films, [pigments.length, 2]),
    };
    this.#ground = {
      primaries: of(kernels, "f4", tables.primaries, [bands, 3]),
      material: of(kernels, "f4", backing.reflectance),
    };
    this.#greys = GROUNDS.map((grey) => of(kernels, "f4", new Float32Array(bands).fill(grey)));
  }

  /** Fill the rows of `out` of some vertices. */
  srgb(
    amounts: NDArray<"f4">, coverage: NDArray<"f4">, below: Below, out: NDArray<"u1">,
    vertexIds: NDArray<"i4">,
  ): void {
    const wet = { vertex_ids: vertexIds, amounts, coverage };
    const shown = { codes: this.tables.codes, linear_rgb: this.tables.noRgb, srgb: out };
    this.kernels.call("colour.kernels.glazing.glazed_colours", wet, this.#glaze, this.#on(below), shown);
  }

  /**
   * Put what some vertices reflect now into rows of the spectra below; `grey`: over which of the
   * grey grounds in place of the material.
   */
  dry(
    amounts: NDArray<"f4">, coverage: NDArray<"f4">, below: Below, vertexIds: NDArray<"i4">,
    rows: NDArray<"i4">, grey: number | null = null,
  ): void {
    const wet = { vertex_ids: vertexIds, amounts, coverage };
    const material = grey === null ? {} : { material: this.#greys[grey] };
    const ground = { ...(this.#on(below) as object), ...material } as Argument;
    this.kernels.call("colour.kernels.glazing.dry_vertices", wet, this.#glaze, ground, rows);
  }

  #on(below: Below): Argument {
    const linear_rgb = below.linearRgb ?? this.tables.noRgb;
    return { ...this.#ground, slots: below.slots, spectra: below.spectra, linear_rgb };
  }

  /** Let its tables go. */
  free(): void {
    for (const array of [...Object.values(this.#glaze), ...Object.values(this.#ground), ...this.#greys])
      array.free();
  }
}
