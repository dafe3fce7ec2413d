/** A mesh to paint on, which Python has prepared: `paint3d/mesh/refined_mesh.py`. */

import type { NDArray } from "../core/arrays";
import type { Bundle } from "../core/bundle";
import type { Kernels } from "../core/kernels";

/** The arrays of the kernels (`SurfaceField`), replaced as they grow. */
export interface SurfaceField {
  [name: string]: NDArray | number;
  counts: NDArray<"i8">;
  resolution: number;
  paper: number;
  px: NDArray<"f4">;
  py: NDArray<"f4">;
  pz: NDArray<"f4">;
  nx: NDArray<"f4">;
  ny: NDArray<"f4">;
  nz: NDArray<"f4">;
  area_units: NDArray<"i8">;
  area_unit: number;
  node_vertices: NDArray<"i4">;
  child: NDArray<"i4">;
  block_balls: NDArray<"f4">;
}

/** What is said of an object beside its arrays. */
export interface ObjectWords {
  name: string;
  resolution: number;
  refines: boolean;
  n_base_vertices: number;
  usual_material: string;
  apex?: readonly [number, number, number] | null; // where the ribs of a folding fan meet, mm
  most_around_edge: number;
  most_aside_mm: number;
  leaf_sizes: { contact: number; closest: number };
  field: Record<string, number>;
  mesh: string;
}

/** Trees of boxes over the object's triangles. */
export interface ContactTree {
  [name: string]: NDArray;
  order: NDArray<"i4">;
  boxes: NDArray<"f4">;
  triangles: NDArray<"i4">;
  points: NDArray<"f4">;
  normals: NDArray<"f4">;
}

const PER_VERTEX = [
  "px", "py", "pz", "nx", "ny", "nz", "mx", "my", "mz", "take", "key", "parents",
  "vertex_sheet", "area_units", "area", "next_in_cell",
]; // prettier-ignore
const PER_NODE = ["node_vertices", "node_root", "child", "longest", "node_area"];
const GROWTH = 1 << 15; // least number of vertices to reserve

export class PaintMesh {
  readonly arrays: SurfaceField;
  readonly refines: boolean;
  readonly nBaseVertices: number;
  readonly baseFaces: Int32Array;
  readonly #words: ObjectWords;

  constructor(
    private readonly kernels: Kernels,
    object: Bundle<ObjectWords>,
  ) {
    const words = (this.#words = object.words);
    this.refines = words.refines;
    this.nBaseVertices = words.n_base_vertices;
    this.baseFaces = object.numbers("base_faces", "i4").slice();
    const arrays: Record<string, NDArray | number> = { ...words.field };
    for (const name of object.names("field."))
      arrays[name] = object.anyArray(kernels, `field.${name}`);
    this.arrays = arrays as SurfaceField;
    this.#measureSheets(object);
    if (this.refines) this.reserve();
  }

  /** Area, normal and centre of every sheet. */
  #measureSheets(object: Bundle<ObjectWords>): void {
    const { kernels, arrays: field } = this;
    const n = this.nSheets;
    const [area, normal, centre] = [
      kernels.zeros("f8", n), kernels.zeros("f8", n, 3), kernels.zeros("f8", n, 3),
    ]; // prettier-ignore
    const given = [
      object.array(kernels, "contact.points", "f4"),
      object.array(kernels, "contact.normals", "f4"),
      object.array(kernels, "base_faces", "i4"),
    ];
    kernels.call(
      "mesh.kernels.cell_components.measure_sheets", ...given, field, area, normal, centre,
    ); // prettier-ignore
    for (const array of given) array.free();
    const pack = kernels.zeros("f4", n, 8);
    const [rows, a, v, c] = [pack.data, area.data, normal.data, centre.data];
    for (let i = 0; i < n; i++) {
      for (let k = 0; k < 3; k++) {
        rows[8 * i + k] = v[3 * i + k];
        rows[8 * i + 4 + k] = c[3 * i + k];
      }
      rows[8 * i + 3] = a[i];
    }
    Object.assign(field, {
      sheet_area: area, sheet_normal: normal, sheet_centre: centre, sheet_pack: pack,
    }); // prettier-ignore
  }

  /** Make edge and film of the ink uneven, as fibres do; before anything is refined. */
  layPaper(amount: number): void {
    const balls = this.arrays.block_balls.data;
    const aside = Math.fround(this.#words.most_aside_mm * amount);
    for (let k = 3 * this.nBlocks; k < balls.length; k++) balls[k] += aside;
    this.arrays.paper = amount;
    this.kernels.call("mesh.kernels.paper.lay_paper", this.arrays, 0, this.nBaseVertices);
  }

  /** Reserve space for more vertices: about half as many again. */
  reserve(): void {
    const field = this.arrays;
    const [n, nodes] = [this.nVertices, Number(field.counts.data[1])];
    const extra = Math.max(GROWTH, Math.floor((n - this.nBaseVertices) / 2));
    const around = this.#words.most_around_edge;
    // a vertex on an edge halves two triangles: four nodes
    const capacity = nodes + 4 * extra + 4 * around;
    for (const name of PER_VERTEX)
      field[name] = (field[name] as NDArray).grown(n, n + extra + around);
    for (const name of PER_NODE) field[name] = (field[name] as NDArray).grown(nodes, capacity);
    field.radial = (field.radial as NDArray).grown(3 * nodes, 3 * capacity);
  }

  get nVertices(): number {
    return Number(this.arrays.counts.data[0]);
  }

  get capacity(): number {
    return this.arrays.px.length;
  }

  get nCells(): number {
    return (this.arrays.head as NDArray).length;
  }

  get nBlocks(): number {
    return this.arrays.block_balls.shape[1];
  }

  get nSheets(): number {
    return (this.arrays.sheet_cell as NDArray).length;
  }

  /** The current triangles, three vertices each. */
  leafFaces(): Int32Array {
    if (!this.refines) return this.baseFaces;
    const nodes = Number(this.arrays.counts.data[1]);
    const child = this.arrays.child.data;
    const corners = this.arrays.node_vertices.data;
    const faces = new Int32Array(3 * nodes);
    let n = 0;
    for (let node = 0; node < nodes; node++) {
      if (child[node] >= 0) continue;
      faces[n++] = corners[3 * node];
      faces[n++] = corners[3 * node + 1];
      faces[n++] = corners[3 * node + 2];
    }
    return faces.subarray(0, n);
  }
}

/** A tree of boxes over an object's triangles. */
export function readTree(
  kernels: Kernels, object: Bundle<ObjectWords>, kind: "contact" | "closest",
): ContactTree {
  const triangles = object.array(kernels, `${kind}.triangles`, "i4");
  const points = object.array(kernels, `${kind}.points`, "f4");
  const leafSize = object.words.leaf_sizes[kind];
  let leaves = 1;
  while (leaves * leafSize < triangles.length) leaves *= 2;
  const boxes = kernels.zeros("f4", 2 * leaves, 6);
  kernels.call("mesh.kernels.bvh.build_boxes", triangles, points, boxes, leafSize);
  return {
    order: object.array(kernels, `${kind}.order`, "i4"),
    boxes,
    triangles,
    points,
    normals: object.array(kernels, `${kind}.normals`, "f4"),
  };
}
