/** Sums and orders as NumPy has them, to the last bit. */

const PAIRED = 128; // numbers up to which eight sums run side by side

/** The sum of numbers in NumPy's order: halves of halves, and in the smallest eight sums at once. */
export function pairwiseSum(values: Float64Array, first = 0, n = values.length): number {
  if (n > PAIRED) {
    const half = (n >> 1) - ((n >> 1) % 8);
    return pairwiseSum(values, first, half) + pairwiseSum(values, first + half, n - half);
  }
  let sum = 0.0;
  let k = 0;
  if (n >= 8) {
    const r = values.slice(first, first + 8);
    for (k = 8; k < n - (n % 8); k += 8) for (let j = 0; j < 8; j++) r[j] += values[first + k + j];
    sum = r[0] + r[1] + (r[2] + r[3]) + (r[4] + r[5] + (r[6] + r[7]));
  }
  for (; k < n; k++) sum += values[first + k];
  return sum;
}

/** Round to the nearest whole number, halves to the even one. */
export function roundHalfToEven(x: number): number {
  const floor = Math.floor(x);
  const over = x - floor;
  if (over !== 0.5) return over < 0.5 ? floor : floor + 1.0;
  return floor % 2.0 === 0.0 ? floor : floor + 1.0;
}

/** The order that sorts keys of whole numbers, 0 to 2^62, given as high and low 31 bits; equal ones stay in order. */
export function stableOrder(low: Uint32Array, high: Uint32Array | null = null): Int32Array {
  const n = low.length;
  let order = Int32Array.from({ length: n }, (_, k) => k);
  let other = new Int32Array(n);
  for (const keys of high === null ? [low] : [low, high])
    for (const shift of [0, 16]) {
      const starts = new Uint32Array(65537);
      for (let k = 0; k < n; k++) starts[((keys[k] >>> shift) & 65535) + 1]++;
      if (starts[(n > 0 ? (keys[0] >>> shift) & 65535 : 0) + 1] === n) continue; // all alike
      for (let k = 0; k < 65536; k++) starts[k + 1] += starts[k];
      for (let k = 0; k < n; k++) other[starts[(keys[order[k]] >>> shift) & 65535]++] = order[k];
      [order, other] = [other, order];
    }
  return order;
}

/** Interleave the low `bits` of three whole numbers; the first has the lowest. */
export function interleaved(x: number, y: number, z: number, bits: number): number {
  let code = 0;
  for (let k = 0; k < bits; k++)
    code |= (((x >> k) & 1) | (((y >> k) & 1) << 1) | (((z >> k) & 1) << 2)) << (3 * k);
  return code >>> 0;
}

/** Lists one after the other. */
export function joined<T extends Float64Array | Int32Array | Uint8Array>(
  lists: readonly T[], Type: new (n: number) => T,
): T {
  const all = new Type(lists.reduce((n, list) => n + list.length, 0));
  let n = 0;
  for (const list of lists) {
    all.set(list, n);
    n += list.length;
  }
  return all;
}
