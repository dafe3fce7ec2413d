/** What surfaces are made of, and the inks that are painted with, as Python has prepared them. */

import type { NDArray } from "../core/arrays";

export interface Material {
  name: string;
  chinese: string;
  grain: number;
  tooth_mm: number;
  uptake: number;
  friction: number;
  seen_roughness: number;
  paper: [number, number]; // how much of its clouds and fibres is seen where it is bare, and of its grain in ink
  pores_mm: number;
  residual: number;
  advance: number;
  spread_mm2_s: number;
  passing: number;
  drying_mm_s: number;
  sieve: number; // potential above which the pores let all pigment pass, by their strength
  mobility: Record<string, number>; // of the pigments' grains
}

/** A pigment: a column of the ink's arrays. */
export interface Pigment {
  name: string;
  chinese: string;
  saunderson: boolean;
  lasting: boolean; // not water
  in_palette: boolean;
  fine: number; // the part that goes with the water
  K: Float64Array;
  S: Float64Array;
}

/** Tables of a single pigment on a material. */
export interface OneInk {
  [name: string]: NDArray | number;
  table: NDArray<"f4">;
  shades: NDArray<"u1">;
  bend: number;
  bare: NDArray<"f4">;
}
