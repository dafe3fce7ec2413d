/** Two tables of a tuft's bent shapes, from its spine: `paint3d/page/shape_guess.py`. */

const LEAST_COSINE = 1e-3;
const TERMS = 12;

/** What the tables are made of: a spine (T, D, 3, S) and what they differ from a guess by. */
export interface GuessedFrom {
  spine: Float32Array;
  diameters: Float64Array; // (S,) mm
  lengthMm: number;
  apart: Record<"reach" | "openness", Uint32Array>;
}

/** Reach and openness (T, D, S). */
export function guessed({ spine, diameters, lengthMm, apart }: GuessedFrom): Record<"reach" | "openness", Float32Array> {
  const stations = diameters.length;
  const size = spine.length / 3;
  const [reach, openness] = [new Float32Array(size), new Float32Array(size)];
  const wide = diameters.map((diameter) => diameter / lengthMm);
  for (let row = 0; row < size; row += stations)
    for (let k = 0; k < stations; k++) {
      const at = 3 * row + k;
      const [along, up, angle] = [spine[at], spine[at + stations], spine[at + 2 * stations]];
      const square = angle * angle;
      const cosine = Math.max(series(square, 0), LEAST_COSINE);
      reach[row + k] = along - (up * (angle * series(square, 1))) / cosine;
      const gap = Math.fround((2.0 * up) / cosine) / wide[k];
      openness[row + k] = gap / (1.0 + gap);
      if (k === 1) openness[row] = openness[row + 1]; // at the tip, 0 over 0
    }
  corrected(reach, apart.reach);
  corrected(openness, apart.openness);
  return { reach, openness };
}

/** 1 - x^2 / (1 + first)(2 + first) + .., of a cosine (0) or a sine over x (1). */
function series(square: number, first: number): number {
  let result = 1.0;
  for (let k = TERMS; k > 0; k--) result = 1.0 - result * (square / ((2 * k + first - 1) * (2 * k + first)));
  return result;
}

/** Add differences, counted in the order of bits, to numbers. */
function corrected(numbers: Float32Array, apart: Uint32Array): void {
  const bits = new Int32Array(numbers.buffer);
  for (let k = 0; k < bits.length; k++) bits[k] += apart[k] & 1 ? -((apart[k] + 1) / 2) : apart[k] / 2;
}
