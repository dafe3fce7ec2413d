/** Arrays in the memory of the kernels' module: what NumPy's arrays are to the desktop. */

/** What a number of each type is read and written by; `b1` is NumPy's bool. */
export interface Views {
  f4: Float32Array;
  f8: Float64Array;
  i1: Int8Array;
  u1: Uint8Array;
  b1: Uint8Array;
  i2: Int16Array;
  u2: Uint16Array;
  i4: Int32Array;
  u4: Uint32Array;
  i8: BigInt64Array;
  u8: BigUint64Array;
}
export type Kind = keyof Views;

const VIEWS = {
  f4: Float32Array,
  f8: Float64Array,
  i1: Int8Array,
  u1: Uint8Array,
  b1: Uint8Array,
  i2: Int16Array,
  u2: Uint16Array,
  i4: Int32Array,
  u4: Uint32Array,
  i8: BigInt64Array,
  u8: BigUint64Array,
};

/** A record type: where its fields (numbers f8, or rows of them) begin, in bytes. */
export interface RecordType {
  itemsize: number;
  fields: Record<string, { offset: number; count: number }>;
}

/** The kernels' memory, as far as arrays need it. */
export interface Memory {
  readonly buffer: ArrayBufferLike;
  allocate(bytes: number): number;
  release(address: number): void;
}

/** The elements in a shape. */
export function count(shape: readonly number[]): number {
  return shape.reduce((product, n) => product * n, 1);
}

/** A C-contiguous array of numbers; its view is made anew when the memory has grown. */
export class NDArray<K extends Kind = Kind> {
  readonly address: number;
  readonly size: number;
  #view: Views[K] | null = null;

  constructor(
    readonly memory: Memory,
    readonly kind: K,
    readonly shape: readonly number[],
    address?: number,
  ) {
    this.size = count(shape);
    this.address = address ?? memory.allocate(this.nbytes);
  }

  /** Zeros. */
  static zeros<K extends Kind>(memory: Memory, kind: K, shape: readonly number[]): NDArray<K> {
    const array = new NDArray(memory, kind, shape);
    array.bytes.fill(0);
    return array;
  }

  /** A copy of numbers. */
  static of<K extends Kind>(
    memory: Memory,
    kind: K,
    values: Views[K] | readonly number[],
    shape: readonly number[] = [values.length],
  ): NDArray<K> {
    const array = new NDArray(memory, kind, shape);
    if (values.length !== array.size)
      throw new RangeError(`${values.length} numbers for an array of ${shape.join(" x ")}`);
    (array.data as Float64Array).set(values as Float64Array);
    return array;
  }

  get nbytes(): number {
    return this.size * VIEWS[this.kind].BYTES_PER_ELEMENT;
  }

  get length(): number {
    return this.shape[0] ?? 1;
  }

  /** Its numbers; not to be kept over a call that may allocate. */
  get data(): Views[K] {
    if (this.#view === null || this.#view.buffer !== this.memory.buffer)
      this.#view = new VIEWS[this.kind](
        this.memory.buffer as ArrayBuffer,
        this.address,
        this.size,
      ) as Views[K];
    return this.#view;
  }

  get bytes(): Uint8Array {
    return new Uint8Array(this.memory.buffer as ArrayBuffer, this.address, this.nbytes);
  }

  /** Copy the first `used` rows to a new array of `room` rows, the rest 0; this one is let go. */
  grown(used: number, room: number): NDArray<K> {
    const larger = NDArray.zeros(this.memory, this.kind, [room, ...this.shape.slice(1)]);
    larger.bytes.set(this.bytes.subarray(0, (this.nbytes / Math.max(1, this.length)) * used));
    this.free();
    return larger;
  }

  /** The same memory as numbers of another type, in one row. */
  seenAs<L extends Kind>(kind: L): NDArray<L> {
    const size = this.nbytes / VIEWS[kind].BYTES_PER_ELEMENT;
    return new NDArray(this.memory, kind, [size], this.address);
  }

  /** Give its memory back; it must not be used any more. */
  free(): void {
    this.memory.release(this.address);
  }
}

/** An array of records. */
export class Records {
  readonly address: number;

  constructor(
    readonly memory: Memory,
    readonly kind: string,
    readonly type: RecordType,
    readonly shape: readonly number[] = [1],
  ) {
    this.address = memory.allocate(this.nbytes);
    new Uint8Array(memory.buffer as ArrayBuffer, this.address, this.nbytes).fill(0);
  }

  get nbytes(): number {
    return count(this.shape) * this.type.itemsize;
  }

  get bytes(): Uint8Array {
    return new Uint8Array(this.memory.buffer as ArrayBuffer, this.address, this.nbytes);
  }

  /** The numbers of a field of the first record. */
  field(name: string): Float64Array {
    const found = this.type.fields[name];
    if (found === undefined) throw new RangeError(`${this.kind} has no field ${name}`);
    const at = this.address + found.offset;
    return new Float64Array(this.memory.buffer as ArrayBuffer, at, found.count);
  }
}
