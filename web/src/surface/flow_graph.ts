/** The weighted graph on which liquids move over a surface: `paint3d/surface/flow_graph.py`. */

import { NDArray, type Kind } from "../core/arrays";
import type { Kernels } from "../core/kernels";
import { joined } from "../core/numbers";
import type { PaintMesh } from "../mesh/refined_mesh";

const BLOCK_CELLS = 3; // along an axis
const MARGIN_EDGES = 2.5;

/** The array, or one with room for n, the rest 0; the old one is let go. */
export function withRoom<K extends Kind>(array: NDArray<K>, n: number): NDArray<K> {
  if (array.length >= n) return array;
  return array.grown(array.length, Math.max(n, 2 * array.length));
}

/** Distinct numbers, ascending. */
export function distinct(values: Iterable<number>): Int32Array {
  return Int32Array.from(new Set(values)).sort();
}

/** The first place in ascending numbers at which one is not below a value. */
function firstAt(values: Int32Array, n: number, value: number): number {
  let [low, high] = [0, n];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

export class FlowGraph {
  nNodes = 0;
  nPlaces = 0;
  nLinks = 0;
  readonly nBlocks: number;
  vertices: NDArray<"i4">;
  nodeOf: NDArray<"i4">;
  points: NDArray<"f8">;
  area: NDArray<"f8">;
  block: NDArray<"i4">;
  closed: NDArray<"u1">;
  first: NDArray<"i8">;
  last: NDArray<"i8">;
  links: NDArray<"i4">;
  owner: NDArray<"i4">;
  weights: NDArray<"f8">;
  beside: NDArray<"i4">;
  firstBeside: NDArray<"i8">;
  lastBeside: NDArray<"i8">;
  blockOpen: NDArray<"b1">;
  readonly blockNodes: Float64Array;
  readonly #cellBlock: Int32Array;
  readonly #cells: Int32Array; // by blocks
  readonly #cellRuns: Int32Array;
  readonly #blockPlaces: Int32Array;
  readonly #rims = new Map<number, Int32Array>();
  readonly #heads: NDArray<"i4">;
  readonly #known: Uint8Array;
  readonly #start: Float64Array;
  readonly #stop: Float64Array;
  #nBeside = 0;
  #place = new Int32Array(); // of each vertex plus 1, 0 for unknown ones

  constructor(
    private readonly kernels: Kernels,
    private readonly mesh: PaintMesh,
    private readonly makeRoom: () => void,
  ) {
    const places = (mesh.arrays.cell_place as NDArray<"i4">).data;
    const n = mesh.nCells;
    const order = Int32Array.from({ length: n }, (_, k) => k);
    const at = Int32Array.from(places, (x) => Math.floor(x / BLOCK_CELLS));
    const compare = (a: number, b: number): number =>
      at[3 * a] - at[3 * b] || at[3 * a + 1] - at[3 * b + 1] || at[3 * a + 2] - at[3 * b + 2];
    order.sort((a, b) => compare(a, b) || a - b);
    this.#cells = order;
    this.#cellBlock = new Int32Array(n);
    const runs: number[] = [];
    const found: number[] = [];
    for (let k = 0; k < n; k++) {
      if (k === 0 || compare(order[k - 1], order[k]) !== 0) {
        runs.push(k);
        found.push(...at.subarray(3 * order[k], 3 * order[k] + 3));
      }
      this.#cellBlock[order[k]] = runs.length - 1;
    }
    this.nBlocks = runs.length;
    this.#cellRuns = Int32Array.from([...runs, n]);
    this.#blockPlaces = Int32Array.from(found);
    const blocks = this.nBlocks;
    this.beside = kernels.zeros("i4", 0);
    this.firstBeside = kernels.zeros("i8", blocks);
    this.lastBeside = kernels.zeros("i8", blocks);
    this.#heads = NDArray.of(kernels, "i4", new Int32Array(blocks).fill(-1));
    this.blockOpen = kernels.zeros("b1", blocks);
    this.blockNodes = new Float64Array(blocks);
    this.#known = new Uint8Array(n);
    this.#start = new Float64Array(n);
    this.#stop = new Float64Array(n);
    this.vertices = kernels.zeros("i4", 0);
    this.nodeOf = kernels.zeros("i4", 0);
    this.points = kernels.zeros("f8", 0, 3);
    this.area = kernels.zeros("f8", 0);
    this.block = kernels.zeros("i4", 0);
    this.closed = kernels.zeros("u1", 0);
    this.first = kernels.zeros("i8", 0);
    this.last = kernels.zeros("i8", 0);
    this.links = kernels.zeros("i4", 0);
    this.owner = kernels.zeros("i4", 0);
    this.weights = kernels.zeros("f8", 0);
  }

  #field<K extends Kind>(name: string): NDArray<K> {
    return this.mesh.arrays[name] as NDArray<K>;
  }

  // -- look-up ------------------------------------------------------------------------------

  /** The place of a vertex, -1 where it is not known. */
  placeOf(id: number): number {
    return id < this.#place.length ? this.#place[id] - 1 : -1;
  }

  /** The places of nodes, node after node. */
  placesAt(nodes: Iterable<number>): Int32Array {
    const nodeOf = this.nodeOf.data;
    const found: number[] = [];
    for (const node of nodes) {
      let place = firstAt(nodeOf, this.nPlaces, node);
      while (place < this.nPlaces && nodeOf[place] === node) found.push(place++);
    }
    return Int32Array.from(found);
  }

  /** The first place of a node. */
  firstPlace(node: number): number {
    return firstAt(this.nodeOf.data, this.nPlaces, node);
  }

  /** The cells in which vertices lie, ascending. */
  cellsOf(ids: Iterable<number>): Int32Array {
    const [cell, sheet] = [this.#field<"i4">("sheet_cell").data, this.#field<"i4">("vertex_sheet").data];
    const cells = new Set<number>();
    for (const id of ids) cells.add(cell[sheet[id]]);
    return Int32Array.from(cells).sort();
  }

  /** The blocks in which vertices lie, one for each. */
  blockOf(ids: Int32Array): Int32Array {
    const [cell, sheet] = [this.#field<"i4">("sheet_cell").data, this.#field<"i4">("vertex_sheet").data];
    return ids.map((id) => this.#cellBlock[cell[sheet[id]]]);
  }

  blocksOf(cells: Int32Array): Int32Array {
    return distinct(cells.map((cell) => this.#cellBlock[cell]));
  }

  around(cells: Int32Array): Int32Array {
    const sheets = this.#field<"i4">("cell_sheets").data;
    const links = this.#field<"i8">("sheet_links").data;
    const linked = this.#field<"i4">("linked_sheet").data;
    const cellOf = this.#field<"i4">("sheet_cell").data;
    const found = new Set<number>(cells);
    for (const cell of cells)
      for (let sheet = sheets[cell]; sheet < sheets[cell + 1]; sheet++)
        for (let k = Number(links[sheet]); k < Number(links[sheet + 1]); k++)
          found.add(cellOf[linked[k]]);
    return Int32Array.from(found).sort();
  }

  #cellsIn(blocks: Int32Array): Int32Array {
    const runs = this.#cellRuns;
    return joined(Array.from(blocks, (block) => this.#cells.subarray(runs[block], runs[block + 1])), Int32Array);
  }

  blocksAround(blocks: Int32Array): Int32Array {
    return this.blocksOf(this.around(this.#cellsIn(blocks)));
  }

  /** Split open blocks, ascending, into groups such that no block adjoins two of them. */
  apart(blocks: Int32Array): Int32Array[] {
    const { kernels } = this;
    const given = NDArray.of(kernels, "i8", BigInt64Array.from(blocks, BigInt));
    const group = kernels.zeros("i4", blocks.length);
    const count = kernels.call(
      "surface.kernels.wet_graph.group_blocks",
      given, this.firstBeside, this.lastBeside, this.beside, this.#heads, group,
    ) as number; // prettier-ignore
    const groups: number[][] = Array.from({ length: count }, () => []);
    for (const [k, g] of group.data.entries()) groups[g].push(blocks[k]);
    given.free();
    group.free();
    return groups.map((one) => Int32Array.from(one));
  }

  /** The known nodes of blocks, always in the same order. */
  nodesOf(blocks: Int32Array): Int32Array {
    const cells = this.#cellsIn(blocks).filter((cell) => this.#known[cell] !== 0);
    const nodes = new Int32Array(
      cells.reduce((sum, cell) => sum + this.#stop[cell] - this.#start[cell], 0),
    );
    let n = 0;
    for (const cell of cells)
      for (let node = this.#start[cell]; node < this.#stop[cell]; node++) nodes[n++] = node;
    return nodes;
  }

  /** The nodes beside open blocks; one may occur twice. */
  rimsOf(blocks: Int32Array): Int32Array {
    return joined(Array.from(blocks, (block) => this.#rims.get(block) ?? new Int32Array(0)), Int32Array);
  }

  // -- growth -------------------------------------------------------------------------------

  /** Refine cells and create the nodes of their vertices. */
  know(wanted: Int32Array): void {
    const cells = wanted.filter((cell) => this.#known[cell] === 0);
    if (cells.length === 0) return;
    const given = NDArray.of(this.kernels, "i8", BigInt64Array.from(cells, BigInt));
    let done = 0;
    while (done < cells.length) {
      done = this.kernels.call(
        "surface.kernels.diffusion.activate_cells", this.mesh.arrays, given, done,
      ) as number; // prettier-ignore
      if (done < cells.length) this.makeRoom();
    }
    this.#addNodes(cells, given);
    given.free();
  }

  #addNodes(cells: Int32Array, given: NDArray<"i8">): void {
    const { kernels, mesh } = this;
    const fields = mesh.arrays;
    const count = kernels.call("surface.kernels.wet_graph.count_vertices", fields, given) as number;
    const [listed, numbered] = [kernels.zeros("i4", count), kernels.zeros("i4", count)];
    kernels.call("surface.kernels.wet_graph.list_vertices", fields, given, listed, numbered);
    const [ids, number] = [listed.data.slice(), numbered.data.slice()];
    listed.free();
    numbered.free();
    const key = this.#field<"u8">("key").data;
    const keys = BigUint64Array.from(ids, (id) => key[id]);
    const order = Int32Array.from(ids.keys());
    order.sort((a, b) => number[a] - number[b] || (keys[a] < keys[b] ? -1 : keys[a] > keys[b] ? 1 : a - b));
    const nodes = new Int32Array(count);
    let n = this.nNodes;
    for (let k = 0; k < count; k++) {
      const [a, b] = [order[k - 1], order[k]];
      if (k === 0 || keys[a] !== keys[b] || number[a] !== number[b]) n++;
      nodes[k] = n - 1;
    }
    const c = this.nPlaces + count;
    this.points = withRoom(this.points, n);
    this.area = withRoom(this.area, n);
    this.block = withRoom(this.block, n);
    this.closed = withRoom(this.closed, n);
    this.first = withRoom(this.first, n);
    this.last = withRoom(this.last, n);
    this.vertices = withRoom(this.vertices, c);
    this.nodeOf = withRoom(this.nodeOf, c);
    const [px, py, pz] = [fields.px.data, fields.py.data, fields.pz.data];
    const units = fields.area_units.data;
    const [points, area, block, closed] = [this.points.data, this.area.data, this.block.data, this.closed.data];
    const [vertices, nodeOf] = [this.vertices.data, this.nodeOf.data];
    if (this.#place.length < mesh.capacity) {
      const place = new Int32Array(mesh.capacity);
      place.set(this.#place);
      this.#place = place;
    }
    const counts = new Int32Array(cells.length);
    for (let k = 0; k < count; k++) {
      const [id, node] = [ids[order[k]], nodes[k]];
      if (k === 0 || nodes[k - 1] !== node) {
        points[3 * node] = px[id];
        points[3 * node + 1] = py[id];
        points[3 * node + 2] = pz[id];
        area[node] = 0.0;
        block[node] = this.#cellBlock[cells[number[order[k]]]];
        closed[node] = 1;
        counts[number[order[k]]]++;
      }
      area[node] += Number(units[id]) * fields.area_unit;
      vertices[this.nPlaces + k] = id;
      nodeOf[this.nPlaces + k] = node;
      this.#place[id] = this.nPlaces + k + 1;
    }
    let stop = this.nNodes;
    for (const [k, cell] of cells.entries()) {
      this.#start[cell] = stop;
      this.#stop[cell] = stop += counts[k];
      this.blockNodes[this.#cellBlock[cell]] += counts[k];
      this.#known[cell] = 1;
    }
    this.nNodes = n;
    this.nPlaces = c;
  }

  /** Compute the links of all nodes of blocks. */
  open(blocks: Iterable<number>): void {
    for (const block of blocks) if (this.blockOpen.data[block] === 0) this.#open(block);
  }

  #open(block: number): void {
    const { kernels } = this;
    const own = this.#cells.slice(this.#cellRuns[block], this.#cellRuns[block + 1]);
    const around = this.around(own);
    this.know(around);
    const faces = this.#facesNear(block, around);
    const far = this.cellsOf(faces);
    if (far.some((cell) => this.#known[cell] === 0)) this.know(far); // triangles longer than cells
    const nodeOf = this.nodeOf.data;
    const nodes = faces.map((id) => nodeOf[this.#place[id] - 1]);
    const key = this.#field<"u8">("key").data;
    const vertices = this.vertices.data;
    const ids = distinct(nodes);
    const keys = new Map(Array.from(ids, (node) => [node, key[vertices[this.firstPlace(node)]]]));
    ids.sort((a, b) => {
      const [x, y] = [keys.get(a) ?? 0n, keys.get(b) ?? 0n];
      return x < y ? -1 : x > y ? 1 : a - b;
    });
    const rank = new Map(Array.from(ids, (node, k) => [node, k]));
    const points = this.points.data;
    const given = {
      points: NDArray.of(kernels, "f8", Float64Array.from({ length: 3 * ids.length }, (_, k) => points[3 * ids[Math.floor(k / 3)] + (k % 3)]), [ids.length, 3]),
      faces: NDArray.of(kernels, "i4", nodes.map((node) => rank.get(node) ?? 0), [nodes.length / 3, 3]),
      runs: kernels.zeros("i8", ids.length + 1),
      links: kernels.zeros("i4", 2 * nodes.length),
      weights: kernels.zeros("f8", 2 * nodes.length),
    }; // prettier-ignore
    kernels.call("surface.kernels.intrinsic_delaunay.link_triangles", ...Object.values(given));
    const runs = given.runs.data;
    const blockOf = this.block.data;
    const rows = [...ids.keys()].filter((k) => blockOf[ids[k]] === block);
    let n = this.nLinks;
    for (const row of rows) n += Number(runs[row + 1] - runs[row]);
    this.links = withRoom(this.links, n);
    this.owner = withRoom(this.owner, n);
    this.weights = withRoom(this.weights, n);
    // they may have moved, and the memory with them
    const taken = { runs: given.runs.data, links: given.links.data, weights: given.weights.data };
    const [toLinks, toOwner, toWeights] = [this.links.data, this.owner.data, this.weights.data];
    const [first, last] = [this.first.data, this.last.data];
    const isRim = new Uint8Array(ids.length);
    let at = this.nLinks;
    for (const row of rows) {
      first[ids[row]] = BigInt(at);
      for (let k = Number(taken.runs[row]); k < Number(taken.runs[row + 1]); k++, at++) {
        toLinks[at] = ids[taken.links[k]];
        toOwner[at] = ids[row];
        toWeights[at] = taken.weights[k];
        isRim[taken.links[k]] = 1;
      }
      last[ids[row]] = BigInt(at);
    }
    for (const row of rows) isRim[row] = 0;
    const rims = ids.filter((_, k) => isRim[k] === 1);
    this.#rims.set(block, rims);
    const beside = distinct(rims.map((node) => this.block.data[node]));
    const m = this.#nBeside + beside.length;
    this.beside = withRoom(this.beside, m);
    this.beside.data.set(beside, this.#nBeside);
    this.firstBeside.data[block] = BigInt(this.#nBeside);
    this.lastBeside.data[block] = BigInt(m);
    this.#nBeside = m;
    const closed = this.closed.data;
    for (const node of this.nodesOf(Int32Array.of(block))) closed[node] = 0;
    this.nLinks = n;
    this.blockOpen.data[block] = 1;
    for (const array of Object.values(given)) array.free();
  }

  /** The triangles in a block and a margin around it, as vertex ids. */
  #facesNear(block: number, cells: Int32Array): Int32Array {
    const { kernels, mesh } = this;
    const fields = mesh.arrays;
    const size = fields.cell_size as number;
    const margin = Math.min(MARGIN_EDGES * fields.resolution, size);
    const origin = this.#field<"f8">("origin").data;
    const low = new Float64Array(3);
    const high = new Float64Array(3);
    for (let k = 0; k < 3; k++) {
      low[k] = origin[k] + this.#blockPlaces[3 * block + k] * (BLOCK_CELLS * size) - margin;
      high[k] = low[k] + BLOCK_CELLS * size + 2.0 * margin;
    }
    const pairs = this.#field<"i8">("cell_pairs").data;
    const root = this.#field<"i4">("pair_root").data;
    const found: number[] = [];
    for (const cell of cells)
      for (let k = Number(pairs[cell]); k < Number(pairs[cell + 1]); k++) found.push(root[k]);
    const given = [
      NDArray.of(kernels, "i4", distinct(found)),
      mesh.refines ? fields.node_vertices : NDArray.of(kernels, "i4", mesh.baseFaces, [mesh.baseFaces.length / 3, 3]),
      NDArray.of(kernels, "f8", low),
      NDArray.of(kernels, "f8", high),
    ]; // prettier-ignore
    let out = kernels.zeros("i4", 4096);
    let n: number;
    for (;;) {
      n = kernels.call("surface.kernels.wet_graph.leaves_in_box", fields, ...given, out) as number;
      if (n >= 0) break;
      const room = 2 * out.length;
      out.free();
      out = kernels.zeros("i4", room);
    }
    const corners = given[1].data as Int32Array;
    const faces = new Int32Array(3 * n);
    for (const [k, face] of out.data.subarray(0, n).entries())
      faces.set(corners.subarray(3 * face, 3 * face + 3), 3 * k);
    out.free();
    for (const array of given) if (array !== fields.node_vertices) array.free();
    return faces;
  }
}
