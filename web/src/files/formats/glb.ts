/** Binary glTF 2.0: the default scene as one mesh, with its nodes' transforms: `paint3d/files/formats/gltf.py`. */

import { MeshoptDecoder } from "meshoptimizer/decoder";
import { joined, roundHalfToEven } from "../../core/numbers";
import { colourShares, srgbFromLinear } from "../colours";
import { damaged, MeshError, noted, type Note } from "../mesh_error";
import { checkCount, leftOut, rawMesh, threes, type RawMesh } from "../raw_mesh";

type Row = Record<string, unknown>;
type Matrix = number[][]; // 4 x 4

const [JSON_CHUNK, BIN_CHUNK] = [0x4e4f534a, 0x004e4942];
interface Component {
  kind: "i1" | "u1" | "i2" | "u2" | "u4" | "f4";
  bytes: number;
  most: number;
}

const COMPONENTS = new Map<unknown, Component>([
  [5120, { kind: "i1", bytes: 1, most: 127 }],
  [5121, { kind: "u1", bytes: 1, most: 255 }],
  [5122, { kind: "i2", bytes: 2, most: 32767 }],
  [5123, { kind: "u2", bytes: 2, most: 65535 }],
  [5125, { kind: "u4", bytes: 4, most: 4294967295 }],
  [5126, { kind: "f4", bytes: 4, most: 1 }],
]);
const WIDTHS = new Map<unknown, number>([["SCALAR", 1], ["VEC2", 2], ["VEC3", 3], ["VEC4", 4], ["MAT4", 16]]);
const MOST_ZEROS = 1 << 26;
const METRE_MM = 1000.0;
const STEPS = "_POSITION_STEPS"; // what metres in float32 lose of millimetres, in the desktop's own files
const [TRIANGLES, STRIP, FAN] = [4, 5, 6];
const THIN = new Map<unknown, Note>([[0, noted("points")], [1, noted("lines")], [2, noted("lines")], [3, noted("lines")]]);
const [DRACO, MESHOPT] = ["KHR_draco_mesh_compression", "EXT_meshopt_compression"];
const FILTERS = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"];
const MODES = ["ATTRIBUTES", "TRIANGLES", "INDICES"];
const MOST_UNPACKED = 1 << 28; // bytes
const [HIDDEN, INSTANCES] = ["KHR_node_visibility", "EXT_mesh_gpu_instancing"];
const [LIGHTS, GLOSSY] = ["KHR_lights_punctual", "KHR_materials_pbrSpecularGlossiness"];
const MOST_INSTANCES = 1 << 17;
const MATERIALS = "KHR_materials_";
const SRGB_WRITERS = ["trimesh", "Open3D", "VTK"]; // write colours of vertices as they have them
const KNOWN = [
  DRACO, MESHOPT, "KHR_mesh_quantization", HIDDEN, INSTANCES, LIGHTS, "KHR_texture_transform", "EXT_texture_webp",
  "KHR_texture_basisu", "EXT_texture_avif", "KHR_animation_pointer", "KHR_xmp_json_ld",
]; // prettier-ignore

/** Values of an accessor, (count, width). */
interface Values {
  rows: Float64Array;
  width: number;
  kind: "i1" | "u1" | "i2" | "u2" | "u4" | "f4" | "f8";
}

/** Let what unpacks files by meshopt be compiled, which has to be before one is read. */
export function readyForGlb(): Promise<void> {
  return MeshoptDecoder.ready;
}

/** Read a .glb file; points, lines, skins and animations are passed over, and noted. */
export function readGlb(data: Uint8Array): RawMesh {
  const file = new File(data);
  for (const name of listed(file.document.extensionsRequired))
    if (!KNOWN.includes(String(name)) && !String(name).startsWith(MATERIALS))
      throw new MeshError(
        "it requires the extension {name!r:.60}, which is not read; expected a file that does without (Blender saves " +
          "one)",
        { name: String(name) },
      );
  const parts: RawMesh[] = [];
  const told: Note[] = [];
  const dropped = new Set<Note>();
  for (const [matrix, mesh] of placedMeshes(file))
    for (const one of listed(mesh.primitives) as Row[]) {
      const part = primitive(file, one, told, dropped);
      if (part !== null) parts.push(transformed(part, matrix));
    }
  if (parts.length === 0) throw new MeshError("its scene has no triangles; expected a surface");
  for (const { corners, vertices } of parts) {
    const most = corners.reduce((a, b) => Math.max(a, b), -1);
    if (most >= vertices.length / 3)
      throw new MeshError("a face refers to vertex {most}; expected 0 to {last}", { most, last: vertices.length / 3 - 1 });
  }
  for (const one of leftBeside(file)) dropped.add(one);
  const notes = [...new Map(told.map((one) => [JSON.stringify(one), one])).values(), ...leftOut(dropped)];
  return { ...asOne(parts), unitMm: METRE_MM, up: "y", notes };
}

function listed(value: unknown): unknown[] {
  return Array.isArray(value) ? (value as unknown[]) : [];
}

// ---- Kinds ------------------------------------------------------------------------------------

/** A part that must be there. */
function required(row: Row, name: string): unknown {
  if (!(name in row)) throw damaged(noted("it lacks {part}", { part: `'${name}'` }));
  return row[name];
}

/** An integer, which must be there unless there is one for a row without it. */
function integer(row: Row, name: string, usual?: number): number {
  const value = usual !== undefined && !(name in row) ? usual : required(row, name);
  if (!Number.isSafeInteger(value)) throw damaged(noted("a part of it is of another kind than is expected there"));
  return value as number;
}

/** What a part stands for. */
function known<T>(all: Map<unknown, T>, row: Row, name: string): T {
  const value = required(row, name);
  const meant = all.get(value);
  if (meant === undefined)
    throw damaged(noted("it lacks {part}", { part: (typeof value === "string" ? `'${value}'` : String(value)).slice(0, 60) }));
  return meant;
}

type PartKind = "object" | "list" | "string";
const KINDS: Record<string, Note | string> = {
  object: noted("an object"), list: noted("a list"), string: noted("a text"), null: "null",
  boolean: noted("true or false"), number: noted("a number"),
}; // prettier-ignore
const PARTS: Record<string, Record<string, PartKind>> = { // what is read of the entries of each list
  accessors: { sparse: "object" },
  buffers: { uri: "string" },
  bufferViews: { extensions: "object" },
  images: { uri: "string" },
  materials: { pbrMetallicRoughness: "object", extensions: "object" },
  meshes: { primitives: "list" },
  nodes: { extensions: "object", children: "list", matrix: "list", rotation: "list", scale: "list", translation: "list" },
  samplers: {},
  scenes: { nodes: "list" },
  textures: { extensions: "object" },
}; // prettier-ignore

function kindOf(value: unknown): string {
  return value === null ? "null" : Array.isArray(value) ? "list" : typeof value;
}

/** Refuse a document that is of another version, or whose parts are of another kind. */
function checkKinds(document: Row): void {
  const expect = (value: unknown, kind: PartKind, place: string): void => {
    if (kindOf(value) !== kind)
      throw new MeshError("its {place} is {found}; expected {kinds}", { place, found: KINDS[kindOf(value)], kinds: KINDS[kind] });
  };
  const check = (entry: Row, kinds: Record<string, PartKind>, place: string): void => {
    for (const [name, kind] of Object.entries(kinds)) if (name in entry) expect(entry[name], kind, `${place}${name}`);
  };
  check(document, { asset: "object", extensionsRequired: "list", extensionsUsed: "list" }, "");
  const version = String((document.asset as Row | undefined)?.version ?? "2.0");
  if (!version.startsWith("2.")) throw new MeshError("it is glTF version {version:.20}; expected 2", { version });
  if (kindOf(document.scenes) === "object")
    throw new MeshError("its scenes are named, as in glTF version 1; expected 2"); // not counted
  check(document, Object.fromEntries(Object.keys(PARTS).map((name) => [name, "list"])), "");
  for (const [name, kinds] of Object.entries(PARTS))
    for (const [k, entry] of (listed(document[name]) as Row[]).entries()) {
      const place = `${name}[${k}]`;
      expect(entry, "object", place);
      check(entry, kinds, `${place}.`);
      if (name === "meshes")
        for (const [j, part] of (listed(entry.primitives) as Row[]).entries()) {
          expect(part, "object", `${place}.primitives[${j}]`);
          check(part, { attributes: "object", extensions: "object" }, `${place}.primitives[${j}].`);
        }
      else if (name === "materials")
        check((entry.pbrMetallicRoughness as Row | undefined) ?? {}, { baseColorTexture: "object", baseColorFactor: "list" },
          `${place}.pbrMetallicRoughness.`); // prettier-ignore
    }
}

// ---- The file ---------------------------------------------------------------------------------

class File {
  readonly document: Row;
  #binary: Uint8Array | null = null;
  readonly #views = new Map<unknown, Uint8Array>(); // unpacked, by their numbers

  constructor(data: Uint8Array) {
    const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
    if (data.length < 12 || view.getUint32(0, true) !== 0x46546c67)
      throw new MeshError(
        "it is no text that glTF could be: its byte {start} is {data}; expected a glTF document, or a .glb that begins " +
          "with 'glTF'",
        { start: 0, data: data[0] },
      );
    const [version, length] = [view.getUint32(4, true), view.getUint32(8, true)];
    if (version !== 2) throw new MeshError("it is glTF version {version}; expected 2", { version });
    if (length > data.length)
      throw new MeshError("it has {n} of {length} bytes; the file is cut short", { n: data.length, length });
    let text: Uint8Array | null = null;
    for (let at = 12; at + 8 <= length; ) {
      const [size, kind] = [view.getUint32(at, true), view.getUint32(at + 4, true)];
      if (at + 8 + size > length) throw new MeshError("a chunk reaches beyond the end; the file is cut short");
      const chunk = data.subarray(at + 8, at + 8 + size);
      if (kind === JSON_CHUNK) text ??= chunk;
      if (kind === BIN_CHUNK) this.#binary ??= chunk;
      at += 8 + size;
    }
    if (text === null)
      throw new MeshError(
        "it has no JSON chunk within the {length} bytes that its header speaks of, of {n}; expected one after the header",
        { length, n: data.length },
      );
    let document: unknown;
    try {
      document = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(text));
    } catch (cause) {
      throw new MeshError("its JSON cannot be read: {cause}", { cause: cause instanceof Error ? cause.message : cause });
    }
    if (typeof document !== "object" || document === null || Array.isArray(document))
      throw new MeshError("its JSON is not an object; expected a glTF document");
    this.document = document as Row;
    checkKinds(this.document);
  }

  /** What wrote the file, as it says. */
  get generator(): string {
    return String((this.document.asset as Row | undefined)?.generator ?? "");
  }

  /** One entry of a top-level list such as "nodes". */
  item(kind: string, index: unknown): Row {
    const entries = listed(this.document[kind]);
    if (!Number.isInteger(index) || (index as number) < 0 || (index as number) >= entries.length)
      throw new MeshError("it refers to {kind}[{index}], of which there are {n}", { kind, index, n: entries.length });
    const entry = entries[index as number];
    if (typeof entry !== "object" || entry === null)
      throw new MeshError("{kind}[{index}] is not an object", { kind, index });
    return entry as Row;
  }

  /** An accessor's values, as floats where they are normalised. */
  numbers(index: unknown): Values {
    const accessor = this.item("accessors", index);
    const component = known(COMPONENTS, accessor, "componentType");
    const width = known(WIDTHS, accessor, "type");
    const count = integer(accessor, "count");
    let rows: Float64Array;
    if (accessor.bufferView === undefined) {
      checkCount(count, 1, MOST_ZEROS, noted("elements in an accessor"));
      rows = new Float64Array(count * width);
    } else rows = this.#view(accessor, component, width, count);
    const sparse = accessor.sparse as Row | undefined;
    if (sparse !== undefined) {
      const [where, what] = [required(sparse, "indices") as Row, required(sparse, "values") as Row];
      const n = integer(sparse, "count");
      const ids = this.#view(where, known(COMPONENTS, where, "componentType"), 1, n);
      if (!ids.every((id) => Number.isInteger(id) && id >= 0)) throw damaged(noted("it refers to something that it does not have"));
      const most = ids.reduce((a, b) => Math.max(a, b), -1);
      if (most >= count) throw new MeshError("a sparse accessor replaces element {most} of {n}", { most, n: count });
      const values = this.#view(what, component, width, n);
      ids.forEach((id, k) => rows.set(values.subarray(width * k, width * (k + 1)), width * id));
    }
    if (accessor.normalized === true && component.kind !== "f4")
      return { rows: rows.map((x) => Math.max(x / component.most, -1.0)), width, kind: "f8" };
    return { rows, width, kind: component.kind };
  }

  /** Values (count, width) of the buffer view that an accessor, or a part of a sparse one, refers to. */
  #view(accessor: Row, { kind, bytes }: Component, width: number, count: number): Float64Array {
    const index = required(accessor, "bufferView");
    const start = integer(accessor, "byteOffset", 0);
    const view = this.item("bufferViews", index);
    const packed = (view.extensions as Row | undefined)?.[MESHOPT] as Row | undefined;
    const size = bytes * width;
    const stride = integer(view, "byteStride", 0) || size;
    const length = integer(view, "byteLength");
    const begin = packed === undefined ? integer(view, "byteOffset", 0) : 0;
    const data = packed === undefined ? this.#buffer(required(view, "buffer")) : this.#unpacked(index, packed);
    if (Math.min(begin, start, length, count) < 0 || stride < size || begin + length > data.length)
      throw new MeshError("bufferViews[{index}] does not fit into its buffer", { index });
    if (count > 0 && start + (count - 1) * stride + size > length)
      throw new MeshError("an accessor reads beyond the end of bufferViews[{index}]", { index });
    const from = new DataView(data.buffer, data.byteOffset, data.byteLength);
    const read = {
      i1: (at: number) => from.getInt8(at),
      u1: (at: number) => from.getUint8(at),
      i2: (at: number) => from.getInt16(at, true),
      u2: (at: number) => from.getUint16(at, true),
      u4: (at: number) => from.getUint32(at, true),
      f4: (at: number) => from.getFloat32(at, true),
    }[kind];
    const rows = new Float64Array(count * width);
    for (let row = 0; row < count; row++)
      for (let c = 0; c < width; c++) rows[width * row + c] = read(begin + start + row * stride + c * bytes);
    return rows;
  }

  /** The bytes of a buffer view that is packed by meshopt: `unpack_meshopt` of Python. */
  #unpacked(index: unknown, packed: Row): Uint8Array {
    const known = this.#views.get(index);
    if (known !== undefined) return known;
    const [begin, length] = [integer(packed, "byteOffset", 0), integer(packed, "byteLength")];
    const data = this.#buffer(required(packed, "buffer"));
    if (Math.min(begin, length) < 0 || begin + length > data.length)
      throw new MeshError("the packed bufferViews[{index}] does not fit into its buffer", { index });
    const { count, byteStride: size } = packed as Record<string, number>;
    const { mode, filter = "NONE" } = packed as Record<string, string>;
    if (!(Number.isInteger(count) && Number.isInteger(size) && count >= 0 && 0 < size && size <= 256))
      throw new MeshError("its meshopt data is {count} elements of {size} bytes; expected numbers", {
        count: count ?? "None", size: size ?? "None",
      }); // prettier-ignore
    checkCount(count * size, 1, MOST_UNPACKED, noted("bytes in a packed view"));
    if (!FILTERS.includes(filter))
      throw new MeshError("its meshopt filter is {name!r:.30}; expected one of {filters}", { name: filter, filters: FILTERS.join(", ") });
    if (!MODES.includes(mode))
      throw new MeshError("its meshopt mode is {mode!r:.30}; expected ATTRIBUTES, TRIANGLES or INDICES", { mode: mode ?? "None" });
    const unpacked = new Uint8Array(count * size);
    try {
      const applied = mode === "ATTRIBUTES" ? filter : "NONE"; // indices have none
      const isOctahedral = applied === "OCTAHEDRAL"; // which the library undoes in other last bits
      MeshoptDecoder.decodeGltfBuffer(
        unpacked, count, size, data.subarray(begin, begin + length), mode, isOctahedral ? "NONE" : applied,
      ); // prettier-ignore
      if (isOctahedral) undoOctahedra(unpacked, size);
    } catch (cause) {
      throw new MeshError("its meshopt data cannot be unpacked: {cause}", { cause: cause instanceof Error ? cause.message : String(cause) });
    }
    this.#views.set(index, unpacked);
    return unpacked;
  }

  #buffer(index: unknown): Uint8Array {
    const buffer = this.item("buffers", index);
    const uri = buffer.uri as string | undefined;
    let data = this.#binary;
    if (uri !== undefined && !uri.startsWith("data:"))
      throw new MeshError("it refers to {shown}, which is missing", { shown: `'${uri.slice(0, 80)}'` });
    if (uri !== undefined) {
      try {
        data = Uint8Array.from(atob(uri.slice(uri.indexOf(",") + 1)), (letter) => letter.charCodeAt(0));
      } catch {
        throw new MeshError("a data URI is not base64");
      }
    }
    if (data === null) throw new MeshError("a buffer has no data");
    const bytelength = integer(buffer, "byteLength");
    if (data.length < bytelength)
      throw new MeshError("buffers[{index}] has {n} of {bytelength} bytes; the file is cut short", {
        index, n: data.length, bytelength,
      }); // prettier-ignore
    return data;
  }
}

/** Unit vectors of codes on an octahedron, in place: `_undo_octahedra` of Python. */
function undoOctahedra(bytes: Uint8Array, size: number): void {
  if (size !== 4 && size !== 8) throw new Error(`octahedra of ${size} bytes`);
  const codes = size === 4 ? new Int8Array(bytes.buffer) : new Int16Array(bytes.buffer);
  const f = Math.fround;
  for (let k = 0; k < codes.length; k += 4) {
    const [x, y, one] = codes.subarray(k, k + 3);
    const z = f(f(one - Math.abs(x)) - Math.abs(y));
    const fold = Math.min(z, 0.0);
    const vector = [f(x + (x >= 0 ? fold : -fold)), f(y + (y >= 0 ? fold : -fold)), z];
    const [xx, yy, zz] = vector.map((part) => f(part * part));
    const length = f(Math.sqrt(f(f(xx + yy) + zz)));
    if (length === 0.0) continue;
    const scale = f((size === 4 ? 127 : 32767) / length);
    vector.forEach((part, c) => (codes[k + c] = roundHalfToEven(f(part * scale))));
  }
}

/** What a document says besides its meshes. */
function leftBeside(file: File): Note[] {
  const { document } = file;
  const dropped = ["animations", "skins", "cameras"].filter((kind) => listed(document[kind]).length > 0).map((kind) => noted(kind));
  if ((document.extensions as Row | undefined)?.[LIGHTS] !== undefined) dropped.push(noted("lights"));
  const others = [...new Set(listed(document.extensionsUsed).map(String))].sort()
    .filter((name) => !KNOWN.includes(name) && !name.startsWith(MATERIALS)); // prettier-ignore
  if (others.length > 0) dropped.push(noted("what the extensions {names} say", { names: others.join(", ").slice(0, 60) }));
  if ((listed(document.nodes) as Row[]).some(isHidden)) dropped.push(noted("hidden parts"));
  for (const mesh of listed(document.meshes) as Row[])
    for (const one of listed(mesh.primitives) as Row[]) {
      if ("targets" in one) dropped.push(noted("morph targets"));
      const thin = THIN.get(one.mode);
      if (thin !== undefined) dropped.push(thin);
    }
  return dropped;
}

function isHidden(node: Row): boolean {
  return ((node.extensions as Row | undefined)?.[HIDDEN] as Row | undefined)?.visible === false;
}

const IDENTITY: Matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]];

function times(a: Matrix, b: Matrix): Matrix {
  return a.map((row) => [0, 1, 2, 3].map((k) => row[0] * b[0][k] + row[1] * b[1][k] + row[2] * b[2][k] + row[3] * b[3][k]));
}

/** Each mesh of the scene with where it stands. */
function* placedMeshes(file: File): Generator<[Matrix, Row]> {
  if (listed(file.document.scenes).length === 0)
    throw new MeshError("it has no scene, so no triangles; expected a surface");
  const scene = file.item("scenes", file.document.scene ?? 0);
  const stack = listed(scene.nodes).reverse().map((index): [unknown, Matrix] => [index, IDENTITY]);
  const seen = new Set<unknown>();
  while (stack.length > 0) {
    const [index, parent] = stack.pop() as [unknown, Matrix];
    const node = file.item("nodes", index);
    if (seen.has(index)) throw new MeshError("node {index} is reached twice; expected a tree of nodes", { index });
    seen.add(index);
    if (isHidden(node)) continue;
    const here = times(parent, local(node));
    if ("mesh" in node) {
      const mesh = file.item("meshes", node.mesh);
      for (const instance of instances(file, node)) yield [times(here, instance), mesh];
    }
    for (const child of [...listed(node.children)].reverse()) stack.push([child, here]);
  }
}

function instances(file: File, node: Row): Matrix[] {
  const repeated = (node.extensions as Row | undefined)?.[INSTANCES] as Row | undefined;
  if (repeated === undefined) return [IDENTITY];
  const parts = Object.entries(repeated.attributes as Row)
    .filter(([key]) => ["TRANSLATION", "ROTATION", "SCALE"].includes(key))
    .map(([key, index]) => [key.toLowerCase(), file.numbers(index)] as const);
  const n = Math.min(...parts.map(([, { rows, width }]) => rows.length / width));
  if (!Number.isFinite(n)) return [];
  if (n > MOST_INSTANCES)
    throw new MeshError("a mesh is repeated {n:,} times; expected {most:,} at most", { n, most: MOST_INSTANCES });
  return Array.from({ length: n }, (_, k) =>
    local(Object.fromEntries(parts.map(([key, { rows, width }]) => [key, [...rows.subarray(width * k, width * (k + 1))]]))));
}

function local(node: Row): Matrix {
  const own = node.matrix as number[] | undefined;
  if (own !== undefined) return [0, 1, 2, 3].map((r) => [0, 1, 2, 3].map((c) => own[4 * c + r]));
  const [x, y, z, w] = (node.rotation as number[] | undefined) ?? [0, 0, 0, 1];
  const scale = (node.scale as number[] | undefined) ?? [1, 1, 1];
  const move = (node.translation as number[] | undefined) ?? [0, 0, 0];
  const turn = [
    [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
  ];
  return [...turn.map((row, r) => [...row.map((value, c) => value * scale[c]), move[r]]), [0, 0, 0, 1]];
}

/** One primitive in its own frame; null for points and lines. */
function primitive(file: File, one: Row, told: Note[], dropped: Set<Note>): RawMesh | null {
  const mode = (one.mode as number | undefined) ?? TRIANGLES;
  if (![TRIANGLES, STRIP, FAN].includes(mode)) return null;
  if ((one.extensions as Row | undefined)?.[DRACO] !== undefined)
    throw new MeshError("it is compressed with Draco, which needs DracoPy; expected an uncompressed file");
  const attributes = (one.attributes as Row | undefined) ?? {};
  if (!("POSITION" in attributes))
    throw new MeshError("a primitive has no positions, so no triangles; expected a surface");
  let vertices = file.numbers(attributes.POSITION).rows;
  const n = vertices.length / 3;
  const indices = "indices" in one ? file.numbers(one.indices).rows : Float64Array.from({ length: n }, (_, k) => k);
  const others: Record<string, Values> = {};
  for (const name of ["NORMAL", "COLOR_0", STEPS]) {
    if (!(name in attributes)) continue;
    const values = file.numbers(attributes[name]);
    const nOthers = values.rows.length / values.width;
    if (nOthers !== n)
      throw new MeshError("a primitive has {n} positions but {name_others} of {name}", { n, name_others: nOthers, name });
    others[name] = values;
  }
  if (STEPS in others) vertices = takeSteps(vertices, others[STEPS]);
  let colours: Uint8Array | null = null;
  if ("COLOR_0" in others) {
    const { rows, width } = others.COLOR_0;
    const { shares, notes } = colourShares(rows.filter((_, k) => k % width < 3), "f8");
    told.push(...notes);
    const writer = SRGB_WRITERS.find((name) => file.generator.includes(name));
    if (shares !== null && writer !== undefined) {
      told.push(noted("its vertex colours are taken as sRGB, as {writer} writes them", { writer }));
      colours = Uint8Array.from(shares, (share) => Math.floor(255 * share + 0.5));
    } else if (shares !== null) colours = srgbFromLinear(shares);
  }
  if (one.material !== undefined) {
    const surface = file.item("materials", one.material);
    const pbr = (surface.pbrMetallicRoughness as Row | undefined) ?? {};
    const glossy = (surface.extensions as Row | undefined)?.[GLOSSY] as Row | undefined;
    const [factor, texture] = glossy === undefined
      ? [pbr.baseColorFactor, pbr.baseColorTexture] : [glossy.diffuseFactor, glossy.diffuseTexture]; // prettier-ignore
    if (texture !== undefined || (listed(factor) as number[]).slice(0, 3).some((part) => part < 1.0))
      dropped.add(noted("its colours and pictures"));
  }
  const corners = triangles(indices, mode);
  return rawMesh({ vertices, corners, sizes: threes(corners.length / 3), colours, normals: others.NORMAL?.rows ?? null });
}

function triangles(indices: Float64Array, mode: number): Float64Array {
  if (mode === TRIANGLES) {
    if (indices.length % 3 !== 0)
      throw new MeshError("a primitive has {n} indices; expected a multiple of 3", { n: indices.length });
    return indices;
  }
  const n = Math.max(indices.length - 2, 0);
  return Float64Array.from({ length: 3 * n }, (_, c) => {
    const k = Math.floor(c / 3);
    if (mode === FAN) return indices[[0, k + 1, k + 2][c % 3]];
    return indices[[k, k + 1 + (k % 2), k + 2 - (k % 2)][c % 3]];
  });
}

/** Metres that give back, in float32, the millimetres that the desktop wrote. */
function takeSteps(metres: Float64Array, codes: Values): Float64Array {
  const mm = new Float32Array(1);
  const bits = new Int32Array(mm.buffer);
  return metres.map((metre, k) => {
    const code = codes.rows[codes.width * Math.floor(k / 3)] || 0.0;
    const whole = Math.round(Math.min(Math.max(code, -13), 13)) + 13;
    const step = (Math.floor(whole / [9, 3, 1][k % 3]) % 3) - 1;
    if (step === 0) return metre;
    mm[0] = metre * METRE_MM;
    bits[0] += step;
    return mm[0] / METRE_MM;
  });
}

function transformed(part: RawMesh, matrix: Matrix): RawMesh {
  const turn = matrix.slice(0, 3).map((row) => row.slice(0, 3));
  const turned = (rows: Float64Array, by: number[][], move: number[]): Float64Array =>
    rows.map((_, k) => {
      const [r, at] = [k % 3, k - (k % 3)];
      return by[r][0] * rows[at] + by[r][1] * rows[at + 1] + by[r][2] * rows[at + 2] + move[r];
    });
  const cross = (a: number[], b: number[]): number[] =>
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]; // prettier-ignore
  const cofactor = [0, 1, 2].map((k) => cross(turn[(k + 1) % 3], turn[(k + 2) % 3]));
  const determinant = turn[0].reduce((sum, x, k) => sum + x * cofactor[0][k], 0.0);
  const isMirrored = determinant < 0.0;
  const { corners } = part;
  return {
    ...part,
    vertices: turned(part.vertices, turn, matrix.slice(0, 3).map((row) => row[3])),
    corners: isMirrored ? corners.map((_, k) => corners[k - (k % 3) + 2 - (k % 3)]) : corners,
    normals: part.normals === null ? null
      : turned(part.normals, cofactor.map((row) => row.map((x) => (isMirrored ? -x : x))), [0, 0, 0]),
  }; // prettier-ignore
}

/** Several meshes as one: where some have colours the others are white, normals are kept where all have them. */
function asOne(parts: RawMesh[]): RawMesh {
  let before = 0;
  const corners = parts.map((part) => {
    const first = before;
    before += part.vertices.length / 3;
    return part.corners.map((c) => c + first);
  });
  const normals = parts.map((part) => part.normals).filter((rows) => rows !== null);
  const isColoured = parts.some((part) => part.colours !== null);
  return rawMesh({
    vertices: joined(parts.map((part) => part.vertices), Float64Array),
    corners: joined(corners, Float64Array),
    sizes: threes(corners.reduce((n, row) => n + row.length, 0) / 3),
    colours: isColoured
      ? joined(parts.map((part) => part.colours ?? new Uint8Array(part.vertices.length).fill(255)), Uint8Array) : null,
    normals: normals.length === parts.length ? joined(normals, Float64Array) : null,
  }); // prettier-ignore
}
