/** Pores of a surface: grain, fibres, and the glue that has dried in them; `paint3d/surface/pores.py`. */

import { NDArray } from "../core/arrays";
import type { Kernels } from "../core/kernels";
import type { Material } from "../colour/materials";

const LN2_HIGH = 6.93147180369123816490e-1;
const LN2_LOW = 1.90821492927058770002e-10;
const TERMS = 14;
const POWERS = powersOfTwo();

const DIRECTIONS = 12;
const LONG = 8.0;
const [BENDS_MM, BENT] = [4.0, 0.6];
const [USUAL, SPAN] = [0.74, 0.12];
const GRAIN_MM = 1.2;
const GRAIN_OF_PORES = 1.5;
const GRAIN_OF_WAYS = 2.0;
const FIBRES_OF_WAYS = 1.4;
const FLOCS = [[1.2, 0.3], [2.4, 0.8], [4.8, 1.0]] as const; // prettier-ignore
const FLOCS_MEAN = 0.07;
const FLOCS_OF_WAYS = 1.0;
const ELSEWHERE = 13.1;
const UNDER_FIBRES = 0.35;
const FIBRE_MM = 0.3;
const SHEET_MM = 0.12;
const SHOWN = [0.7, 1.2] as const;
const FIBRES_OF_SIEVE = 0.5;
const RAW_MM = 0.06;
const CATCH_MM = 0.4;
const [FIBRES_OF_CATCH, FLOCS_OF_CATCH] = [0.6, 1.0];
const GLUE = 0.25;
const GLUE_OF_WAYS = 0.9;
const GLUE_OF_ENTRY = 0.85;
const FULL = 0.98;
const LEAST_MM = 0.012;
const FILM_MM2_S = 0.3;
const ENTRY_RATIO = 0.3; // entry potential of a cell's widest pores over that of its narrowest
const POOL_MM = 0.25;
const SHEDS = [0.6, 0.9] as const;

function powersOfTwo(): Float64Array {
  const powers = new Float64Array(2048); // of -1024 to 1023
  powers[1024] = 1.0;
  for (let k = 1; k < 1024; k++) {
    powers[1024 + k] = 2.0 * powers[1023 + k];
    powers[1024 - k] = 0.5 * powers[1025 - k];
  }
  return powers;
}

/** e to the power of x, to the same bit as `even_exp` of Python. */
export function evenExp(x: number): number {
  const k = Math.floor(x * (1.0 / (LN2_HIGH + LN2_LOW)) + 0.5);
  const r = x - k * LN2_HIGH - k * LN2_LOW;
  let series = 1.0;
  for (let n = TERMS; n > 0; n--) series = 1.0 + (series * r) / n;
  return series * POWERS[1024 + k];
}

export function clip(x: number, low: number, high: number): number {
  return Math.min(Math.max(x, low), high);
}

/** The depth of water that the pores hold, mm, above 0. */
export function capacityOf(material: Material): number {
  return Math.max(material.pores_mm, LEAST_MM);
}

/** The diffusivity of a film of water on full pores, mm2/s. */
export function filmOf(material: Material): number {
  return Math.max(material.spread_mm2_s, FILM_MM2_S);
}

/** How far a surface repels water, 0 to 1. */
function repellenceOf(material: Material): number {
  const [low, high] = SHEDS;
  return material.pores_mm !== 0.0 ? clip((material.advance - low) / (high - low), 0.0, 1.0) : 1.0;
}

/** The entry potential of a cell's widest pores over that of its narrowest, 0 to 1. */
export function entryRatioOf(material: Material): number {
  return ENTRY_RATIO + (1.0 - ENTRY_RATIO) * repellenceOf(material);
}

/** Pore properties at N points. */
export interface Pores {
  residual: Float64Array;
  strength: Float64Array;
  sieve: Float64Array;
  catch: Float64Array;
  entryDepth: Float64Array;
  conductance: Float64Array;
}

/** Finds the pores of a material without glue. */
export class PoreFinder {
  constructor(
    private readonly kernels: Kernels,
    private readonly material: Material,
    private readonly frames: Float64Array, // (12, 3, 3)
    private readonly spacing: number,
  ) {}

  /** The pores at points (N, 3), mm. */
  find(points: Float64Array): Pores {
    const { material } = this;
    const n = points.length / 3;
    const height = this.#grain(points, GRAIN_MM);
    const fibres = this.#fibresShown(points);
    const flocs = fibres === null ? null : this.#flocs(points);
    const capacity = capacityOf(material);
    const pores: Pores = {
      residual: new Float64Array(n), strength: new Float64Array(n), sieve: new Float64Array(n),
      catch: new Float64Array(n), entryDepth: new Float64Array(n), conductance: new Float64Array(n),
    }; // prettier-ignore
    const tight = material.pores_mm !== 0.0 ? Math.min(1.0, material.pores_mm / RAW_MM) : 1.0;
    for (let i = 0; i < n; i++) {
      let bump = material.grain * (2.0 * height[i] - 1.0);
      let relief = GRAIN_OF_PORES * bump;
      if (flocs !== null) {
        bump *= UNDER_FIBRES;
        relief = material.grain * flocs[i];
      }
      const residual = clip(material.residual * (1.0 + relief), 0.0, 0.95);
      const strength = (capacity * material.spread_mm2_s * (1.0 - residual)) / 3.0;
      pores.residual[i] = residual;
      pores.strength[i] = strength;
      pores.entryDepth[i] = capacity * Math.max(residual, material.advance * (1.0 + relief));
      pores.sieve[i] = strength * material.sieve;
      pores.conductance[i] = Math.max(0.05, 1.0 + GRAIN_OF_WAYS * bump);
      pores.catch[i] = CATCH_MM * tight;
      if (fibres !== null) {
        const along = fibres[i];
        pores.sieve[i] *= evenExp(-FIBRES_OF_SIEVE * material.grain * along);
        pores.conductance[i] *= evenExp(FIBRES_OF_WAYS * material.grain * along - FLOCS_OF_WAYS * relief);
        pores.catch[i] *= evenExp(FIBRES_OF_CATCH * material.grain * along - FLOCS_OF_CATCH * relief);
      }
    }
    return pores;
  }

  #grain(points: Float64Array, length: number): Float64Array {
    const { kernels } = this;
    const given = NDArray.of(kernels, "f8", points, [points.length / 3, 3]);
    const out = kernels.zeros("f8", points.length / 3);
    kernels.call("surface.kernels.grain.fill_grain", given, length, out);
    const height = out.data.slice();
    given.free();
    out.free();
    return height;
  }

  #flocs(points: Float64Array): Float64Array {
    const denser = new Float64Array(points.length / 3).fill(FLOCS_MEAN);
    for (const [k, [apart, strength]] of FLOCS.entries()) {
      const height = this.#grain(points.map((x) => x + ELSEWHERE * k), apart);
      for (let i = 0; i < denser.length; i++) denser[i] += strength * (2.0 * height[i] - 1.0);
    }
    return denser;
  }

  #fibresShown(points: Float64Array): Float64Array | null {
    const [fade, gone] = SHOWN;
    const { pores_mm: pores } = this.material;
    if (!(pores > 0.0 && pores <= SHEET_MM)) return null;
    if (this.spacing >= gone) return new Float64Array(points.length / 3);
    const shown = Math.min(1.0, (gone - this.spacing) / (gone - fade));
    return this.#relief(points, Math.max(FIBRE_MM, this.spacing)).map((height) => height * shown);
  }

  #relief(points: Float64Array, width: number): Float64Array {
    const n = points.length / 3;
    const bent = points.slice();
    for (let axis = 0; axis < 3; axis++) {
      const height = this.#grain(points.map((x) => x + 31.7 * axis), BENDS_MM);
      for (let i = 0; i < n; i++) bent[3 * i + axis] += BENT * BENDS_MM * (height[i] - 0.5);
    }
    const strongest = new Float64Array(n);
    const turned = new Float64Array(3 * n);
    for (let k = 0; k < DIRECTIONS; k++) {
      for (let axis = 0; axis < 3; axis++) {
        const [a, b, c] = this.frames.subarray(9 * k + 3 * axis, 9 * k + 3 * axis + 3);
        const size = axis > 0 ? width : LONG * width;
        for (let i = 0; i < n; i++)
          turned[3 * i + axis] =
            (bent[3 * i] * a + bent[3 * i + 1] * b + bent[3 * i + 2] * c) / size + 7.7 * k;
      }
      const height = this.#grain(turned, 1.0);
      for (let i = 0; i < n; i++) strongest[i] = Math.max(strongest[i], height[i]);
    }
    return strongest.map((height) => clip((height - USUAL) / SPAN, -1.0, 1.0));
  }
}

/** Entry depth, its potential and factor on the conductance of a pore, as some glue leaves it. */
export function closePore(
  material: Material, residual: number, strength: number, entryDepth: number, conductance: number, glue: number,
): [number, number, number] {
  const clogged = glue / (glue + GLUE);
  const depth = capacityOf(material);
  const full = FULL * depth;
  const kept = entryDepth + GLUE_OF_ENTRY * clogged * Math.max(0.0, full - entryDepth);
  let s = clip(kept / depth - residual, 0.0, 1.0);
  s = Math.min(1.0, s / (1.0 - residual));
  const poolEntry = filmOf(material) * POOL_MM * repellenceOf(material);
  return [kept, strength * (s * s * s) + poolEntry, conductance * (1.0 - GLUE_OF_WAYS * clogged)];
}
