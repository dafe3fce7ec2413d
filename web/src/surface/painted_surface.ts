/**
 * The painted object: ink on a mesh, wet over dry, and what it looks like: `InkStore` and
 * `PaintedSurface` of `paint3d/surface`, with one layer.
 */

import { NDArray, type Records } from "../core/arrays";
import type { Bundle } from "../core/bundle";
import type { Argument, Kernels } from "../core/kernels";
import type { Material, Pigment } from "../colour/materials";
import { GlazeModel } from "../colour/glazing";
import { ColourModel } from "../colour/vertex_colours";
import type { ContactTree, ObjectWords, PaintMesh } from "../mesh/refined_mesh";
import type { Ground, Studio } from "../studio";
import { DryLayers, type KeptRows } from "./dry_layers";
import { Water, type KeptFlow } from "./flow";
import { FlowGraph } from "./flow_graph";
import { LayerStack, type KeptStack } from "./layer_stack";
import { MeshColours } from "./mesh_colours";

export interface InkField {
  [name: string]: Argument;
  amounts: NDArray<"f4">;
  coverage: NDArray<"f4">;
  dirty: NDArray<"u1">;
  dirty_ids: NDArray<"i4">;
  n_dirty: NDArray<"i8">;
  load: NDArray<"f8">;
  off_surface: NDArray<"f8">;
  reservoirs: NDArray<"f8">;
  transfer: Records;
}

/** The ink in the brush, and that which went off the surface. */
export interface BrushLoad {
  nPigments: number;
  load: Float64Array;
  offSurface: Float64Array;
  reservoirs: Float64Array;
  nReservoirs: number;
  capacity: number;
  reservoirMm: number;
}

/** A painting at an instant, for undo. */
export interface Snapshot extends BrushLoad {
  n: number;
  amounts: Float32Array;
  coverage: Float32Array;
  dried: KeptRows;
  water: KeptFlow | null;
  stack: KeptStack | null;
}

export class PaintedSurface {
  readonly pigments: Pigment[] = [];
  readonly material: Material;
  ink: InkField;
  codes: NDArray<"u1">;
  dryLayers: DryLayers;
  layers: LayerStack | null = null;
  readonly water: Water;
  readonly #own: MeshColours | null; // that the object came with
  readonly #bareSteps: Float64Array;
  #flowGraph: FlowGraph | null = null;
  #colours: ColourModel | null = null;
  #glaze: GlazeModel | null = null;
  #looksOtherwise = false;
  #changed: [number, number] = [Infinity, 0]; // of `takeChanged`

  constructor(
    private readonly kernels: Kernels,
    private readonly studio: Studio,
    readonly object: Bundle<ObjectWords>,
    private readonly ground: Ground,
    readonly paintMesh: PaintMesh,
    readonly contactTree: ContactTree,
  ) {
    this.material = ground.material;
    this.paintMesh.layPaper(Math.sqrt(2.0 * this.material.grain));
    const capacity = this.paintMesh.capacity;
    this.codes = kernels.zeros("u1", capacity, 3);
    this.#fillBare(0);
    this.#bareSteps = Float64Array.from(this.reflectance, (r) =>
      Math.trunc(Math.fround(Math.fround(Math.min(Math.max(r, 0.0), 1.0) * 65535.0) + 0.5)),
    );
    this.#own = null;
    if (object.has("colours")) {
      const own = object.numbers("colours", "u1");
      this.codes.data.set(own);
      this.#own = new MeshColours(kernels, own, studio.decodedCodes, capacity);
    }
    this.dryLayers = new DryLayers(kernels);
    this.water = new Water(kernels, this, studio.fibreFrames);
    const transfer = kernels.records("brush_engine.ink_transfer.TRANSFER");
    transfer.field("grain")[0] = this.material.grain;
    transfer.field("tooth_mm")[0] = this.material.tooth_mm;
    transfer.field("reservoir_mm")[0] = 1.0;
    transfer.field("water")[0] = -1;
    this.ink = {
      amounts: kernels.zeros("f4", capacity, 0),
      coverage: kernels.zeros("f4", capacity),
      dirty: kernels.zeros("u1", capacity),
      dirty_ids: kernels.zeros("i4", capacity + 1),
      n_dirty: kernels.zeros("i8", 1),
      load: kernels.zeros("f8", 0),
      off_surface: kernels.zeros("f8", 0),
      reservoirs: kernels.zeros("f8", 1, 0),
      transfer,
      noise: studio.noise,
      bundles: studio.bundles,
    };
  }

  /** The layers; existing paint becomes the first. */
  useLayers(): LayerStack {
    if (this.layers === null) {
      if (this.dryLayers.count > 0) throw new RangeError("something has dried before there were layers");
      this.dryLayers = new DryLayers(this.kernels, true);
      this.dryLayers.fit(this.paintMesh.capacity, this.pigments.length);
      this.layers = new LayerStack(this.kernels, this);
    }
    return this.layers;
  }

  /** The vertices with wet ink. */
  inked(): Int32Array {
    const [amounts, coverage] = [this.ink.amounts.data, this.ink.coverage.data];
    const count = this.pigments.length;
    const found: number[] = [];
    for (let id = 0; id < this.nVertices; id++) {
      let any = coverage[id] > 0.0;
      for (let k = id * count; !any && k < (id + 1) * count; k++) any = amounts[k] !== 0.0;
      if (any) found.push(id);
    }
    return Int32Array.from(found);
  }

  /** The vertices with paint on them, wet or dry, on any layer. */
  paintedIds(): Set<number> {
    const coverage = this.ink.coverage.data;
    const ids = new Set([...this.dryLayers.ids.subarray(0, this.dryLayers.count), ...(this.layers?.paintedIds() ?? [])]);
    for (let id = 0; id < this.nVertices; id++) if (coverage[id] > 0.0) ids.add(id);
    return ids;
  }

  /** What a vertex reflects where it is bare: 31 bands, in steps of 1/65535. */
  bareSteps(id: number): Float64Array {
    return this.#own?.steps(id, this.studio.colourTables.primaries) ?? this.#bareSteps;
  }

  /** Codes of vertices `first` to n, as of the last `refresh`, without any paint. */
  bareCodes(first: number, n: number): Uint8Array {
    const { bare } = this.ground;
    return this.#own?.codes(first, n) ?? Uint8Array.from({ length: 3 * (n - first) }, (_, k) => bare[k % 3]);
  }

  /** What the material reflects, as measured: 31 bands. */
  get reflectance(): Float32Array {
    return this.ground.backing.reflectance;
  }

  get nVertices(): number {
    return this.paintMesh.nVertices;
  }

  /** The graph on which liquids move over the shape, built where any has come. */
  get flowGraph(): FlowGraph {
    this.#flowGraph ??= new FlowGraph(this.kernels, this.paintMesh, () => this.makeRoom());
    return this.#flowGraph;
  }

  /** Reserve capacity for more vertices. */
  makeRoom(): void {
    const n = this.paintMesh.capacity;
    this.paintMesh.reserve();
    const capacity = this.paintMesh.capacity;
    this.codes = this.codes.grown(n, capacity);
    this.#fillBare(n);
    this.#own?.fit(capacity);
    const ink = this.ink;
    ink.amounts = ink.amounts.grown(n, capacity);
    ink.coverage = ink.coverage.grown(n, capacity);
    ink.dirty = ink.dirty.grown(n, capacity);
    ink.dirty_ids = ink.dirty_ids.grown(n, capacity + 1);
    this.dryLayers.fit(capacity, this.pigments.length);
  }

  #fillBare(first: number): void {
    const codes = this.codes.data;
    for (let k = 3 * first; k < codes.length; k++) codes[k] = this.ground.bare[k % 3];
  }

  /** The column of a pigment in the ink's arrays; a new one is added at the end. */
  columnOf(pigment: Pigment): number {
    const known = this.pigments.findIndex((other) => other.name === pigment.name);
    if (known >= 0) return known;
    this.pigments.push(pigment);
    const count = this.pigments.length;
    const ink = this.ink;
    ink.amounts = this.#widened(ink.amounts, count);
    ink.load = this.#widened(ink.load, count);
    ink.off_surface = this.#widened(ink.off_surface, count);
    ink.reservoirs = this.#widened(ink.reservoirs, count);
    if (!pigment.lasting) ink.transfer.field("water")[0] = count - 1;
    this.#colours?.free();
    this.#colours = new ColourModel(
      this.kernels, this.studio.colourTables, this.pigments, this.ground.backing,
    ); // prettier-ignore
    this.#glaze?.free();
    this.#glaze = new GlazeModel(
      this.kernels, this.studio.colourTables, this.pigments, this.ground.backing,
    ); // prettier-ignore
    this.dryLayers.fit(this.paintMesh.capacity, count);
    this.#looksOtherwise = count > 1;
    return count - 1;
  }

  /** The same with a column of zeros more at the end; the old array is let go. */
  #widened<K extends "f4" | "f8">(array: NDArray<K>, columns: number): NDArray<K> {
    const shape = [...array.shape.slice(0, -1), columns];
    const wider = NDArray.zeros(this.kernels, array.kind, shape);
    const [from, to] = [array.data, wider.data];
    const before = columns - 1;
    for (let k = 0; k < from.length; k++)
      to[Math.floor(k / before) * columns + (k % before)] = from[k];
    array.free();
    return wider;
  }

  /** Bring colours up to date. */
  refresh(): void {
    this.#knowVertices();
    const { n_dirty, dirty, dirty_ids } = this.ink;
    const fresh = dirty_ids.data.slice(0, Number(n_dirty.data[0]));
    const [colours, glaze] = [this.#colours, this.#glaze];
    if (colours === null || glaze === null) return;
    let seen = fresh;
    if (this.#looksOtherwise) {
      const coverage = this.ink.coverage.data;
      const marks = new Uint8Array(this.paintMesh.capacity);
      for (const id of fresh) marks[id] = 1;
      for (const id of this.dryLayers.ids.subarray(0, this.dryLayers.count)) marks[id] = 1;
      for (let id = 0; id < this.nVertices; id++) if (coverage[id] > 0.0) marks[id] = 1;
      for (const id of this.layers?.paintedIds() ?? []) marks[id] = 1;
      seen = Int32Array.from(marks.keys()).filter((id) => marks[id] === 1);
      this.#looksOtherwise = false;
    }
    if (seen.length > 0) {
      if (this.layers !== null && !this.layers.isPlain) this.layers.colour(glaze, seen, this.codes);
      else this.#colourAsOne(colours, glaze, seen);
      this.water.fresh?.push(fresh);
      const marks = dirty.data;
      for (const id of fresh) marks[id] = 0;
      n_dirty.data[0] = 0n;
    }
    let [low, high] = this.#changed;
    for (const id of seen) {
      if (id < low) low = id;
      if (id >= high) high = id + 1;
    }
    this.#changed = [low, high];
  }

  /** The same; among which vertices, first and one past the last, colours may have changed since this was last asked. */
  takeChanged(): [number, number] {
    this.refresh();
    const changed = this.#changed;
    this.#changed = [Infinity, 0];
    return changed;
  }

  /** Interpolate the object's own colours at vertices that were added since. */
  #knowVertices(): void {
    const { arrays, nVertices } = this.paintMesh;
    this.#own?.know(arrays.parents as NDArray<"i4">, nVertices, this.codes);
  }

  #colourAsOne(colours: ColourModel, glaze: GlazeModel, seen: Int32Array): void {
    const { amounts, coverage } = this.ink;
    const isDried = (id: number): boolean => this.dryLayers.rowOf(id) >= 0;
    const isOwn = this.#own !== null;
    const own = isOwn ? seen : this.dryLayers.count > 0 ? seen.filter(isDried) : seen.subarray(0, 0);
    const plain = isOwn ? seen.subarray(0, 0) : own.length > 0 ? seen.filter((id) => !isDried(id)) : seen;
    if (plain.length > 0) {
      const ids = NDArray.of(this.kernels, "i4", plain);
      colours.srgb(amounts, coverage, this.codes, ids);
      ids.free();
    }
    if (own.length > 0) {
      const ids = NDArray.of(this.kernels, "i4", own);
      const { slots, spectra } = this.dryLayers;
      glaze.srgb(amounts, coverage, { slots, spectra, linearRgb: this.#own?.linear }, this.codes, ids);
      ids.free();
    }
  }

  /** Dry the wet paint of some vertices. */
  settle(ids: Int32Array): void {
    const glaze = this.#glaze;
    if (ids.length === 0 || glaze === null) return;
    const { kernels, dryLayers: dry } = this;
    const count = this.pigments.length;
    const rows = dry.reserveRows(ids, this.paintMesh.capacity);
    const own = new Float32Array(ids.length * count);
    const share = new Float32Array(ids.length);
    const [amounts, coverage] = [this.ink.amounts.data, this.ink.coverage.data];
    for (const [k, id] of ids.entries()) {
      own.set(amounts.subarray(id * count, (id + 1) * count), k * count);
      share[k] = coverage[id];
    }
    const given = {
      amounts: NDArray.of(kernels, "f4", own, [ids.length, count]),
      share: NDArray.of(kernels, "f4", share),
      slots: NDArray.of(kernels, "i4", ids.map((id) => dry.rowOf(id))),
      every: NDArray.of(kernels, "i4", ids.map((_, k) => k)),
      rows: NDArray.of(kernels, "i4", rows),
    };
    const below = { slots: given.slots, spectra: dry.spectra };
    const linearRgb = this.#linearAt(ids);
    glaze.dry(given.amounts, given.share, { ...below, linearRgb }, given.every, given.rows);
    linearRgb?.free();
    for (const [k, over] of dry.over.entries())
      glaze.dry(given.amounts, given.share, { slots: given.slots, spectra: over }, given.every, given.rows, k);
    for (const array of Object.values(given)) array.free();
    for (let k = 0; k < own.length; k++) if (!this.pigments[k % count].lasting) own[k] = 0.0;
    dry.settle(ids, rows, own, share);
    const [wet, covered] = [this.ink.amounts.data, this.ink.coverage.data];
    for (const id of ids) {
      wet.fill(0.0, id * count, (id + 1) * count);
      covered[id] = 0.0;
    }
    this.touch(ids);
  }

  /** The object's own colours at some vertices (N, 3), linear. */
  #linearAt(ids: Int32Array): NDArray<"f4"> | undefined {
    if (this.#own === null) return undefined;
    this.#knowVertices();
    const rows = this.kernels.zeros("f4", ids.length, 3);
    const [to, from] = [rows.data, this.#own.linear.data];
    ids.forEach((id, k) => to.set(from.subarray(3 * id, 3 * id + 3), 3 * k));
    return rows;
  }

  /** Dry all wet paint at once where it is; water is let go. */
  dry(): void {
    const coverage = this.ink.coverage.data;
    this.settle(Int32Array.from({ length: this.nVertices }, (_, id) => id).filter((id) => coverage[id] > 0.0));
    this.water.drop();
  }

  /** Mark the colours of some vertices as out of date. */
  touch(vertexIds: Iterable<number>): void {
    const { n_dirty, dirty, dirty_ids } = this.ink;
    const [marks, list] = [dirty.data, dirty_ids.data];
    let n = Number(n_dirty.data[0]);
    for (const id of vertexIds) {
      if (marks[id] !== 0) continue;
      marks[id] = 1;
      list[n++] = id;
    }
    n_dirty.data[0] = BigInt(n);
  }

  /** The sum of a quantity over the pigments, without water. */
  lasting(perPigment: ArrayLike<number>): number {
    return this.pigments.reduce((sum, p, k) => sum + (p.lasting ? perPigment[k] : 0.0), 0.0);
  }

  /** The wet pigment on the surface, coats x mm2. */
  wetInk(): number {
    const { area_units, area_unit } = this.paintMesh.arrays;
    const [areas, amounts] = [area_units.data, this.ink.amounts.data];
    const count = this.pigments.length;
    let sum = 0.0;
    for (let id = 0; id < this.nVertices; id++) {
      let own = 0.0;
      for (let p = 0; p < count; p++)
        if (this.pigments[p].lasting) own += amounts[id * count + p];
      if (own !== 0.0) sum += Number(areas[id]) * area_unit * own;
    }
    return sum;
  }

  /** The pigment that has dried on the surface, coats x mm2. */
  dryInk(): number {
    const { area_units, area_unit } = this.paintMesh.arrays;
    const areas = area_units.data;
    const { ids, amounts, count } = this.dryLayers;
    const n = this.pigments.length;
    let sum = 0.0;
    for (let k = 0; k < n * count; k++)
      sum += Number(areas[ids[Math.floor(k / n)]]) * area_unit * amounts[k]; // water leaves nothing
    return sum;
  }

  keep(): Snapshot {
    const ink = this.ink;
    const n = this.nVertices;
    return {
      ...this.keepLoad(),
      n,
      amounts: ink.amounts.data.slice(0, n * this.pigments.length),
      coverage: ink.coverage.data.slice(0, n),
      dried: this.dryLayers.keep(),
      water: this.water.keep(),
      stack: this.layers?.keep() ?? null,
    };
  }

  /** Return to a painting that was kept; vertices that came since stay, bare. */
  restore(kept: Snapshot): void {
    const shown = this.layers?.paintedIds() ?? [];
    if (kept.stack !== null) this.layers?.restore(kept.stack);
    const ink = this.ink;
    const count = this.pigments.length;
    const [amounts, coverage] = [ink.amounts.data, ink.coverage.data];
    const changed: number[] = [];
    for (let id = 0; id < this.nVertices; id++) {
      const before = id < kept.n ? kept.coverage[id] : 0.0;
      let differs = coverage[id] !== before;
      coverage[id] = before;
      for (let p = 0; p < count; p++) {
        const was = id < kept.n && p < kept.nPigments ? kept.amounts[id * kept.nPigments + p] : 0.0;
        differs ||= amounts[id * count + p] !== was;
        amounts[id * count + p] = was;
      }
      if (differs) changed.push(id);
    }
    this.takeLoad(kept);
    const dried = this.dryLayers;
    const ids = [...dried.ids.subarray(0, dried.count), ...kept.dried.ids];
    if (ids.length > 0) dried.restore(kept.dried, this.paintMesh.capacity);
    this.touch([...changed, ...ids, ...shown, ...(this.layers?.paintedIds() ?? [])]);
    this.water.restore(kept.water);
  }

  /** What the brush holds, and what went off the surface. */
  keepLoad(): BrushLoad {
    const { ink } = this;
    return {
      nPigments: this.pigments.length,
      load: ink.load.data.slice(),
      offSurface: ink.off_surface.data.slice(),
      reservoirs: ink.reservoirs.data.slice(),
      nReservoirs: ink.reservoirs.length,
      capacity: ink.transfer.field("capacity")[0],
      reservoirMm: ink.transfer.field("reservoir_mm")[0],
    };
  }

  /** Have the brush hold what was kept; of pigments that came since, nothing. */
  takeLoad(kept: BrushLoad): void {
    const { ink } = this;
    const count = this.pigments.length;
    const wide = (row: Float64Array, rows: number): Float64Array => {
      const to = new Float64Array(rows * count);
      for (let k = 0; k < row.length; k++)
        to[Math.floor(k / kept.nPigments) * count + (k % kept.nPigments)] = row[k];
      return to;
    };
    ink.load.data.set(wide(kept.load, 1));
    ink.off_surface.data.set(wide(kept.offSurface, 1));
    this.setReservoirs(wide(kept.reservoirs, kept.nReservoirs), kept.nReservoirs);
    ink.transfer.field("capacity")[0] = kept.capacity;
    ink.transfer.field("reservoir_mm")[0] = kept.reservoirMm;
  }

  /** Replace the ink along the tuft, tip first. */
  setReservoirs(values: Float64Array, rows: number): void {
    this.ink.reservoirs.free();
    const shape = [rows, this.pigments.length];
    this.ink.reservoirs = NDArray.of(this.kernels, "f8", values, shape);
  }
}
