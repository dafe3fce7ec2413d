/** What Python has made for the page: numbers and texts by name, and arrays (`paint3d/page/bundle.py`). */

import { count, NDArray, type Kind, type Memory, type Views } from "./arrays";

const MAGIC = "P3DPAGE1";

/** An array by its kind and shape, whole in its buffer. */
export interface Table {
  kind: Kind;
  shape: readonly number[];
  values: Views[Kind];
}

interface Place {
  kind: Kind;
  shape: readonly number[];
  at: number;
  lags: number[];
}

/** A file that is not what `paint3d page build` wrote. */
export class BundleError extends Error {
  override name = "BundleError";
}

export class Bundle<Words = Record<string, unknown>> {
  private constructor(
    readonly words: Words,
    private readonly places: Record<string, Pick<Place, "kind" | "shape">>,
    private readonly read: (name: string) => ArrayBufferLike,
    private readonly name: string,
  ) {}

  /** What was made here, as if it came in a file. */
  static of<Words>(words: Words, tables: Record<string, Table>, name: string): Bundle<Words> {
    return new Bundle(words, tables, (array) => tables[array].values.buffer, name);
  }

  /** Read a file, gzipped or unpacked by whoever sent it. */
  static async read<Words>(bytes: ArrayBuffer, name: string): Promise<Bundle<Words>> {
    const data = await unpacked(bytes);
    const head = new DataView(data);
    if (data.byteLength < 16 || text(data, 0, 8) !== MAGIC)
      throw new BundleError(`${name} is not what "paint3d page build" writes`);
    const length = head.getUint32(8, true);
    const { words, arrays } = JSON.parse(text(data, 16, length)) as {
      words: Words;
      arrays: Record<string, Place>;
    };
    const read = (array: string): ArrayBuffer => {
      const { kind, shape, at, lags } = arrays[array];
      return unpackedNumbers(new Uint8Array(data, at), count(shape), Number(kind[1]), lags);
    };
    return new Bundle(words, arrays, read, name);
  }

  has(name: string): boolean {
    return name in this.places;
  }

  /** Names of arrays that begin with a prefix, without it. */
  names(prefix: string): string[] {
    return Object.keys(this.places)
      .filter((name) => name.startsWith(prefix))
      .map((name) => name.slice(prefix.length));
  }

  /** An array's numbers, outside the kernels' memory. */
  numbers<K extends Kind>(name: string, kind: K): Views[K] {
    const place = this.#place(name);
    if (place.kind !== kind)
      throw new BundleError(`${this.name}: ${name} is ${place.kind}; expected ${kind}`);
    const types = {
      f4: Float32Array, f8: Float64Array, i1: Int8Array, u1: Uint8Array, b1: Uint8Array,
      i2: Int16Array, u2: Uint16Array, i4: Int32Array, u4: Uint32Array, i8: BigInt64Array,
      u8: BigUint64Array,
    }; // prettier-ignore
    return new types[kind](this.read(name) as ArrayBuffer) as Views[K];
  }

  /** An array, copied into the kernels' memory. */
  array<K extends Kind>(memory: Memory, name: string, kind: K): NDArray<K> {
    return NDArray.of(memory, kind, this.numbers(name, kind), this.#place(name).shape);
  }

  /** The same of whatever type it has. */
  anyArray(memory: Memory, name: string): NDArray {
    return this.array(memory, name, this.#place(name).kind) as NDArray;
  }

  #place(name: string): Pick<Place, "kind" | "shape"> {
    const place = this.places[name];
    if (place === undefined) throw new BundleError(`${this.name} has no ${name}`);
    return place;
  }
}

/** Numbers of `width` bytes, of which first bytes stand first, added up over their lags. */
function unpackedNumbers(
  planes: Uint8Array, size: number, width: number, lags: readonly number[],
): ArrayBuffer {
  const result = new ArrayBuffer(size * width);
  const types = { 1: Uint8Array, 2: Uint16Array, 4: Uint32Array };
  const plane = (k: number): Uint8Array => planes.subarray(k * size, (k + 1) * size);
  if (width === 1) new Uint8Array(result).set(plane(0));
  else if (width === 2) {
    const [words, a, b] = [new Uint16Array(result), plane(0), plane(1)];
    for (let i = 0; i < size; i++) words[i] = a[i] | (b[i] << 8);
  } else {
    const words = new Uint32Array(result);
    const each = width / 4; // words to a number
    for (let part = 0; part < each; part++) {
      const [a, b, c, d] = [0, 1, 2, 3].map((k) => plane(4 * part + k));
      for (let i = 0, at = part; i < size; i++, at += each) words[at] = a[i] | (b[i] << 8) | (c[i] << 16) | (d[i] << 24);
    }
  }
  if (lags.length > 0) {
    const numbers = new types[width as 1 | 2 | 4](result);
    for (const lag of lags) for (let i = lag; i < size; i++) numbers[i] += numbers[i - lag];
  }
  return result;
}

function text(data: ArrayBuffer, at: number, length: number): string {
  return new TextDecoder().decode(new Uint8Array(data, at, length));
}

async function unpacked(bytes: ArrayBuffer): Promise<ArrayBuffer> {
  const start = new Uint8Array(bytes, 0, Math.min(2, bytes.byteLength));
  if (start[0] !== 0x1f || start[1] !== 0x8b) return bytes;
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}
