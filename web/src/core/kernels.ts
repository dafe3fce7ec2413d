/**
 * The compiled kernels, called by name: `kernels.call("mesh.kernels.refine.activate_cell", field, 3)`.
 *
 * A kernel is a function of C, `int kernel(const int64 *takes, int64 *gives)`: what it takes and
 * gives stands in rows of eight bytes, an array as its address and its shape (`tools/kernels`).
 */

import { NDArray, Records, type Kind, type Memory, type RecordType, type Views } from "./arrays";

/** What a kernel takes: the type of a number, "f8[:,:]" for an array, or parts by name. */
type Expected = string | { [name: string]: Expected };

interface Code {
  symbol: string;
  gives: string;
  n_takes: number;
  n_gives: number;
  expected: { [name: string]: Expected };
}

/** What `kernels.json` says. */
export interface KernelIndex {
  kernels: Record<string, Code[]>;
  records: Record<string, RecordType>;
}

/** What may be handed to a kernel. */
export type Argument =
  | number
  | bigint
  | boolean
  | NDArray
  | Records
  | readonly Argument[]
  | { readonly [name: string]: Argument };

/** What a kernel gives; arrays are copies outside the module's memory. */
export type Given = number | boolean | null | Views[Kind] | Given[];

/** A kernel that cannot be called so, or that failed. */
export class KernelError extends Error {
  override name = "KernelError";
}

const NO_VALUE = -2; // numba's way to say None
const SLOTS = 1024; // more than any kernel takes
const TYPES = ["b1", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "", "", "f4", "f8"]; // NumPy's

export class Kernels implements Memory {
  #exports: Record<string, CallableFunction>;
  #memory: WebAssembly.Memory;
  #takes: number;
  #gives: number;
  #ints = new Int32Array();
  #floats = new Float64Array();
  #at = 0;

  private constructor(
    instance: WebAssembly.Instance,
    readonly index: KernelIndex,
  ) {
    this.#exports = instance.exports as Record<string, CallableFunction>;
    this.#memory = instance.exports.memory as WebAssembly.Memory;
    (this.#exports._initialize as (() => void) | undefined)?.();
    this.#takes = this.allocate(8 * SLOTS);
    this.#gives = this.allocate(8 * SLOTS);
  }

  /** Compile the module; `source` is what `kernels.wasm` holds. */
  static async load(source: BufferSource, index: KernelIndex): Promise<Kernels> {
    const { instance } = await WebAssembly.instantiate(source, {});
    return new Kernels(instance, index);
  }

  get buffer(): ArrayBufferLike {
    return this.#memory.buffer;
  }

  allocate(bytes: number): number {
    const address = (this.#exports.malloc as (n: number) => number)(Math.max(bytes, 16)) >>> 0;
    if (address === 0)
      throw new KernelError(`out of memory: ${bytes} bytes more; try a smaller object or a page anew`);
    return address;
  }

  release(address: number): void {
    (this.#exports.free as (at: number) => void)(address);
  }

  /** Zeros in the kernels' memory. */
  zeros<K extends Kind>(kind: K, ...shape: number[]): NDArray<K> {
    return NDArray.zeros(this, kind, shape);
  }

  /** Records of a type by its name, such as "brush_engine.footprint.GEOMETRY". */
  records(kind: string): Records {
    const type = this.index.records[kind];
    if (type === undefined) throw new KernelError(`there are no records ${kind}`);
    return new Records(this, kind, type);
  }

  /** Call a kernel. */
  call(name: string, ...args: Argument[]): Given {
    const codes = this.index.kernels[`paint3d.${name}`];
    if (codes === undefined) throw new KernelError(`there is no kernel ${name}`);
    let unfit = "";
    for (const code of codes) {
      unfit = this.#pack(code, args);
      if (unfit === "") return this.#run(name, code);
    }
    throw new KernelError(`${name}: ${unfit}`);
  }

  #run(name: string, code: Code): Given {
    const run = this.#exports[code.symbol] as (takes: number, gives: number) => number;
    let status: number;
    try {
      status = run(this.#takes, this.#gives);
    } catch (cause) {
      throw new KernelError(`${name} ended early: ${cause instanceof Error ? cause.message : cause}`);
    }
    if (status === NO_VALUE) return null;
    if (status !== 0)
      throw new KernelError(status < 0 ? `${name} has no memory (${status})` : `${name} has failed`);
    this.#look();
    this.#at = this.#gives >> 2;
    return this.#unpack(code.gives, { at: 0 });
  }

  /** See the memory as it is now. */
  #look(): void {
    if (this.#ints.buffer === this.buffer) return;
    this.#ints = new Int32Array(this.buffer as ArrayBuffer);
    this.#floats = new Float64Array(this.buffer as ArrayBuffer);
  }

  /** Write arguments into the row; "", or what does not fit. */
  #pack(code: Code, args: Argument[]): string {
    const names = Object.keys(code.expected);
    if (args.length !== names.length)
      return `takes ${names.join(", ")} in this order, got ${args.length}`;
    this.#look();
    this.#at = this.#takes >> 2;
    for (const [k, name] of names.entries()) {
      const unfit = this.#packOne(name, code.expected[name], args[k]);
      if (unfit !== "") return unfit;
    }
    return "";
  }

  #packOne(name: string, expected: Expected, value: Argument): string {
    if (typeof expected === "object") {
      if (typeof value !== "object" || value instanceof NDArray || value instanceof Records)
        return `${name}: expected (${Object.keys(expected).join(", ")})`;
      const parts = value as { readonly [name: string]: Argument };
      for (const key in expected) {
        const part = parts[key];
        if (part === undefined) return `${name}: ${key} is missing`;
        const unfit = this.#packOne(`${name}.${key}`, expected[key], part);
        if (unfit !== "") return unfit;
      }
      return "";
    }
    const bracket = expected.indexOf("[");
    if (bracket >= 0) {
      if (!(value instanceof NDArray || value instanceof Records))
        return `${name}: expected an array ${expected}, got ${typeof value}`;
      const axes = (expected.length - bracket) >> 1;
      if (value.kind !== expected.slice(0, bracket) || value.shape.length !== axes)
        return `${name}: expected ${expected}, got ${value.kind} (${value.shape.join(", ")})`;
      this.#putInt(value.address);
      for (const n of value.shape) this.#putInt(n);
      return "";
    }
    if (expected === "b1") {
      if (typeof value !== "boolean") return `${name}: expected a bool, got ${typeof value}`;
      this.#putInt(Number(value));
      return "";
    }
    if (expected === "i8" && typeof value === "bigint") {
      this.#ints[this.#at] = Number(BigInt.asIntN(32, value));
      this.#ints[this.#at + 1] = Number(value >> 32n);
      this.#at += 2;
      return "";
    }
    if (typeof value !== "number") return `${name}: expected ${expected}, got ${typeof value}`;
    if (expected === "i8") {
      if (!Number.isSafeInteger(value)) return `${name}: expected an integer, got ${value}`;
      this.#putInt(value);
    } else {
      this.#floats[this.#at >> 1] = value;
      this.#at += 2;
    }
    return "";
  }

  #putInt(value: number): void {
    this.#ints[this.#at] = value;
    this.#ints[this.#at + 1] = Math.floor(value / 4294967296);
    this.#at += 2;
  }

  #takeInt(): number {
    const low = this.#ints[this.#at] >>> 0;
    const value = this.#ints[this.#at + 1] * 4294967296 + low;
    this.#at += 2;
    return value;
  }

  /** Read a value by its specification (`tools/kernels/caller.c`). */
  #unpack(spec: string, place: { at: number }): Given {
    const sign = spec[place.at++];
    if (sign === "n") return null;
    if (sign === "i" || sign === "u") return this.#takeInt();
    if (sign === "b") return (this.#takeInt() & 1) === 1;
    if (sign === "d") {
      this.#at += 2;
      return this.#floats[(this.#at >> 1) - 1];
    }
    if (sign === "(") {
      const parts: Given[] = [];
      while (spec[place.at] !== ")") parts.push(this.#unpack(spec, place));
      place.at++;
      return parts;
    }
    if (sign !== "[") throw new KernelError(`a specification of no known kind: ${spec}`);
    const kind = TYPES[spec.charCodeAt(place.at) - 65] as Kind;
    const axes = Number(spec[place.at + 1]);
    place.at += 2;
    const address = this.#takeInt();
    let size = 1;
    for (let k = 0; k < axes; k++) size *= this.#takeInt();
    const block = this.#takeInt();
    const view = viewOf(this.buffer as ArrayBuffer, kind, address, size);
    (this.#exports.paint3d_release as (at: number) => void)(block);
    return view;
  }
}

/** A copy of numbers at an address. */
function viewOf(buffer: ArrayBuffer, kind: Kind, address: number, size: number): Views[Kind] {
  const bytes = Number(kind[1]);
  const copy = buffer.slice(address, address + bytes * size);
  switch (kind) {
    case "f4":
      return new Float32Array(copy);
    case "f8":
      return new Float64Array(copy);
    case "i1":
      return new Int8Array(copy);
    case "i2":
      return new Int16Array(copy);
    case "u2":
      return new Uint16Array(copy);
    case "i4":
      return new Int32Array(copy);
    case "u4":
      return new Uint32Array(copy);
    case "i8":
      return new BigInt64Array(copy);
    case "u8":
      return new BigUint64Array(copy);
    default:
      return new Uint8Array(copy);
  }
}
