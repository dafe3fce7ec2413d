/** Colours as strangers' files have them, as sRGB codes: `paint3d/files/colours.py`. */

import type { Kind } from "../core/arrays";
import { noted, type Note } from "./mesh_error";

const ROUNDING = 1e-6; // above 1
const [BYTE, WORD, LONG] = [255, 65_535, 4_294_967_295];
const OVERSHOOT = 2; // times the range: codes up to there are a bit too bright, not of the next range
const BRIGHT = 16; // fractions up to here are too bright: as codes they would all be nearly black
const LARGEST: Partial<Record<Kind, number>> = {
  i1: 127, u1: BYTE, i2: 32_767, u2: WORD, i4: 2_147_483_647, u4: LONG,
}; // prettier-ignore
export const VERTEX_COLOURS = noted("vertex colours");

/** Colours (V, 3) of any type as sRGB codes, and what was done to them. */
export function colourCodes(values: Float64Array, kind: Kind): { codes: Uint8Array | null; notes: Note[] } {
  if (kind === "u1" || values.length === 0) return { codes: Uint8Array.from(values), notes: [] };
  const { shares, notes } = colourShares(values, kind);
  return { codes: shares === null ? null : Uint8Array.from(shares, (x) => Math.floor(BYTE * x + 0.5)), notes };
}

/** Colours of any type from 0 to 1; their range is told by the numbers themselves. */
export function colourShares(values: Float64Array, kind: Kind): { shares: Float64Array | null; notes: Note[] } {
  const isInteger = kind[0] === "i" || kind[0] === "u";
  const expected = isInteger ? (LARGEST[kind] as number) : 1;
  const whose = VERTEX_COLOURS;
  if (kind === "i1" && values.some((x) => x < 0.0)) values = values.map((x) => (x < 0.0 ? x + 256.0 : x));
  if (values.length === 0) return { shares: values, notes: [] };
  const all = values.length / 3;
  const known = Array.from({ length: all }, (_, v) => [0, 1, 2].every((c) => Number.isFinite(values[3 * v + c])));
  const nKnown = known.filter(Boolean).length;
  if (nKnown === 0)
    return { shares: null, notes: [noted("left out: its {whose}, none of which is a number", { whose })] };
  const notes: Note[] = [];
  if (nKnown < all)
    notes.push(noted("{n:,} of {n_all:,} {whose} are no numbers: made white", { n: all - nKnown, n_all: all, whose }));
  const good = values.filter((_, k) => known[Math.floor(k / 3)]);
  const end = endOfRange(good, isInteger, expected);
  let outside = 0;
  for (let v = 0; v < good.length; v += 3)
    if ([0, 1, 2].some((c) => good[v + c] < 0.0 || good[v + c] > end + ROUNDING)) outside++;
  if (2 * outside > nKnown)
    return {
      shares: null,
      notes: [...notes, noted("left out: its {whose}, most of which are not within 0 to {end:,}", { whose, end })],
    };
  if (end !== expected && good.some((x) => x !== 0.0))
    notes.push(noted("its {whose} are taken as 0 to {end:,}", { whose, end }));
  if (outside > 0)
    notes.push(
      noted("{n:,} of {n_all:,} {whose} are not within 0 to {end:,}: brought to the nearest that is", {
        n: outside, n_all: all, whose, end,
      }), // prettier-ignore
    );
  const shares = values.map((x, k) => (known[Math.floor(k / 3)] ? Math.min(Math.max(x / end, 0.0), 1.0) : 1.0));
  return { shares, notes };
}

/** Where the range of finite colours ends. */
function endOfRange(good: Float64Array, isInteger: boolean, expected: number): number {
  const highest = good.reduce((a, b) => Math.max(a, b), -Infinity);
  if (!isInteger) {
    let areCodes = highest > 1.0 + ROUNDING;
    if (good.some((x) => x !== Math.floor(x))) areCodes = highest > BRIGHT && medianOf(good.filter((x) => x > 0.0)) > 1.0;
    if (!areCodes) return 1;
  }
  if (highest <= OVERSHOOT * BYTE) return BYTE;
  return highest <= OVERSHOOT * WORD || expected !== LONG ? WORD : LONG;
}

function medianOf(values: Float64Array): number {
  const sorted = values.slice().sort();
  const half = sorted.length >> 1;
  return sorted.length % 2 === 1 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
}

/** sRGB codes of linear light, 0 to 1. */
export function srgbFromLinear(shares: Float64Array): Uint8Array {
  return Uint8Array.from(shares, (x) => {
    const encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1.0 / 2.4) - 0.055;
    return Math.floor(BYTE * Math.min(Math.max(encoded, 0.0), 1.0) + 0.5);
  });
}
