/**
 * Wet ink on an absorbent surface: it spreads, lags, stops, and dries. `Flow` and `Water` of
 * `paint3d/surface/flow.py`, which says what each step is for.
 */

import { NDArray } from "../core/arrays";
import type { Kernels } from "../core/kernels";
import { joined } from "../core/numbers";
import { distinct } from "./flow_graph";
import type { PaintedSurface } from "./painted_surface";
import { capacityOf, clip, entryRatioOf, filmOf } from "./pores";
import { FIRST_PACE, WET_COAT_MM, WetPatch, type KeptPatch } from "./wet_patch";

const BUNDLE = 4000;
const LONGEST_STEP = 20.0; // s
const SHORTEST = 0.05; // s
const [MOST, MEAN] = [0.3, 0.01];
const EASE = 2.5;
const GROWTH = 1.5;
const UNLIKE = 1.15;
const REST = 60.0; // s
const PIECE = 0.05; // s
const LATE = 0.12; // s
const OPENED = 6;
const NEARLY = 0.7;
const BESIDE = 0.35;
const [EDGE_GAIN, EDGE_REACH] = [8.0, 1.0];
const EDGE_SWEEPS = 2;
const DRY = 1e-9; // mm
const WORKSPACE_TOO_SMALL = -2;
const ROOM = 1 << 18; // floats
const MOST_NODES = 60_000; // that are moved at once

/** Results of one step by blocks. */
interface Step {
  due: NDArray<"b1">;
  moved: NDArray<"f8">; // (B, 3)
  mobile: NDArray<"b1">;
  stillWet: NDArray<"b1">;
  rings: number;
}

export interface KeptFlow {
  patch: KeptPatch;
  fresh: Int32Array;
}

export class Flow {
  waiting: Int32Array = new Int32Array(0);
  readonly patch: WetPatch;
  #waited = 0.0;
  #floats: NDArray<"f8">;
  #ints: NDArray<"i4">;

  constructor(
    private readonly kernels: Kernels,
    surface: PaintedSurface,
    frames: Float64Array,
  ) {
    this.patch = new WetPatch(kernels, surface, frames);
    this.#floats = kernels.zeros("f8", ROOM);
    this.#ints = kernels.zeros("i4", ROOM / 2);
  }

  get isDry(): boolean {
    return !(this.patch.isWet() || this.waiting.length > 0);
  }

  clear(): void {
    this.patch.clear();
    this.waiting = new Int32Array(0);
  }

  restore(kept: KeptPatch): void {
    this.waiting = new Int32Array(0);
    this.patch.restore(kept);
  }

  /** Let time pass beside a hand: a bounded amount of work; whether nothing lags visibly. */
  follow(seconds: number, fresh: Int32Array): boolean {
    const { patch } = this;
    const [now, waiting] = patch.openSome(fresh, OPENED);
    this.waiting = waiting;
    this.#waited = waiting.length > 0 ? this.#waited + seconds : 0.0;
    const underTuft = this.#readSurface(now);
    if (!patch.openWet(OPENED)) {
      this.#wait(seconds);
      patch.writeSurface();
      return false;
    }
    patch.hold(underTuft, true);
    const pieces = Math.max(1, Math.ceil(seconds / PIECE));
    for (let k = 0; k < pieces; k++) {
      this.#wait(seconds / pieces);
      this.#step(this.#mostUrgent(this.#due(patch.wetBlocks())));
    }
    patch.hold(underTuft, false);
    patch.writeSurface();
    const [owed, pace] = [patch.owed.data, patch.pace.data];
    const isLate = patch.wetBlocks().some((k) => owed[k] >= Math.max(Math.fround(LATE), Math.fround(3.0 * pace[k])));
    return !isLate && this.#waited < LATE;
  }

  #wait(seconds: number): void {
    const owed = this.patch.owed.data;
    const by = Math.fround(seconds);
    for (let k = 0; k < owed.length; k++) owed[k] += by;
  }

  /** Those of the wet blocks, and of those beside, that take a step now. */
  #due(wet: Int32Array): Int32Array {
    const { patch } = this;
    const { graph } = patch;
    const [owed, pace] = [patch.owed.data, patch.pace.data];
    const elapsed = new Float64Array(graph.nBlocks);
    for (const block of wet) elapsed[block] = Math.fround(owed[block] / pace[block]);
    const [first, last, beside] = [graph.firstBeside.data, graph.lastBeside.data, graph.beside.data];
    const isDue = Uint8Array.from(elapsed, (share) => Number(share >= NEARLY));
    const found = [...isDue.keys()].filter((block) => isDue[block] === 1);
    for (const block of found)
      for (let k = Number(first[block]); k < Number(last[block]); k++)
        if (elapsed[beside[k]] >= BESIDE) isDue[beside[k]] = 1;
    return Int32Array.from(isDue.keys()).filter((block) => isDue[block] === 1);
  }

  /** The most overdue of blocks within what may be moved at once, ascending; at least one. */
  #mostUrgent(due: Int32Array): Int32Array {
    const { patch } = this;
    const [owed, pace] = [patch.owed.data, patch.pace.data];
    const late = new Map(Array.from(due, (k) => [k, Math.fround(-owed[k] / pace[k])]));
    const order = due.slice().sort((a, b) => (late.get(a) ?? 0) - (late.get(b) ?? 0) || a - b);
    let [sum, n] = [0, 0];
    while (n < order.length && (sum += patch.graph.blockNodes[order[n]]) <= MOST_NODES) n++;
    return order.slice(0, Math.max(1, n)).sort();
  }

  /** Take up ink that changed, after bringing the water there up to the present; where a tuft is. */
  #readSurface(fresh: Int32Array): Int32Array {
    const { patch } = this;
    const at = patch.findChanged(fresh);
    if (at.length === 0) return at;
    const [nodeOf, blockOf, owed] = [patch.graph.nodeOf.data, patch.graph.block.data, patch.owed.data];
    const blocks = distinct(at.map((place) => blockOf[nodeOf[place]]));
    this.#step(blocks.filter((block) => Number.isFinite(owed[block]) && owed[block] > 0.0));
    return patch.readSurface(at);
  }

  // -- steps ----------------------------------------------------------------------------------

  /** Move and dry the water of blocks, ascending, for the time that they are behind. */
  #step(blocks: Int32Array): void {
    if (blocks.length === 0) return;
    const { kernels, patch } = this;
    const { graph } = patch;
    const n = graph.nBlocks;
    const step: Step = {
      due: kernels.zeros("b1", n),
      moved: kernels.zeros("f8", n, 3),
      mobile: kernels.zeros("b1", n),
      stillWet: kernels.zeros("b1", n),
      rings: 0,
    };
    for (const block of blocks) step.due.data[block] = 1;
    const wasDry = Array.from(patch.owed.data, (owed) => owed === Infinity);
    patch.open(blocks);
    const nodes = this.#listed(graph.nodesOf(blocks), graph.rimsOf(blocks));
    kernels.call("surface.kernels.diffusion.ease_entries", nodes, this.#fields(step), patch.dryEntry);
    nodes.free();
    const work = this.#bundles(blocks).map((bundle) => ({ bundle, rest: kernels.zeros("f8", 1) }));
    const done = work.map(({ bundle, rest }) => this.#moveAndDry(bundle, rest, step));
    const dried: number[] = [];
    for (const [k, { bundle, rest }] of work.entries()) {
      let gone = done[k];
      while (gone === null) {
        patch.open(this.#blocksToOpen(bundle, step)); // more of the surface has to be open first
        gone = this.#moveAndDry(bundle, rest, step);
      }
      for (const node of gone) dried.push(node);
    }
    if (dried.length > 0) patch.dry(Int32Array.from(dried));
    const [owed, pace, stillWet] = [patch.owed.data, patch.pace.data, step.stillWet.data];
    for (const { bundle, rest } of work) {
      const left = rest.data[0];
      const length = bundle.reduce((most, block) => Math.max(most, owed[block]), -Infinity) - left;
      for (const block of bundle) {
        pace[block] = Math.min(pace[block], length);
        owed[block] = stillWet[block] !== 0 ? Math.min(owed[block], left) : Infinity;
      }
      rest.free();
    }
    this.#choosePace(step, wasDry);
    for (const array of [step.due, step.moved, step.mobile, step.stillWet]) array.free();
  }

  #fields(step: Step): ReturnType<WetPatch["fields"]> {
    return this.patch.fields(step.due, step.mobile, step.moved);
  }

  #listed(...lists: Int32Array[]): NDArray<"i4"> {
    return NDArray.of(this.kernels, "i4", joined(lists, Int32Array));
  }

  /** Blocks in bundles of which none touches another, of so many nodes where there are. */
  #bundles(blocks: Int32Array): Int32Array[] {
    const { graph } = this.patch;
    const bundles: number[][] = [];
    let size = BUNDLE;
    for (const group of graph.apart(blocks)) {
      if (size >= BUNDLE) {
        bundles.push([]);
        size = 0;
      }
      bundles[bundles.length - 1].push(...group);
      for (const block of group) size += graph.blockNodes[block];
    }
    return bundles.map((bundle) => Int32Array.from(bundle).sort());
  }

  /** Fit the time steps to the motion in this one. */
  #choosePace(step: Step, wasDry: boolean[]): void {
    const { kernels, patch } = this;
    const { graph } = patch;
    const pores = Math.max(patch.surface.material.pores_mm, WET_COAT_MM);
    const [owed, pace] = [patch.owed.data, patch.pace.data];
    const [due, moved, mobile] = [step.due.data, step.moved.data, step.mobile.data];
    let shortest = LONGEST_STEP;
    for (let k = 0; k < due.length; k++) {
      if (due[k] === 0) continue;
      const [most, volume, area] = moved.subarray(3 * k, 3 * k + 3);
      const change = Math.max(most / MOST, volume / Math.max(area, 1e-12) / MEAN);
      const longer = pace[k] * clip((EASE * pores) / Math.max(change, 1e-12), 0.5, GROWTH);
      pace[k] =
        mobile[k] !== 0 ? clip(longer, FIRST_PACE, LONGEST_STEP) : Math.min(REST, Math.fround(2.0 * pace[k]));
      shortest = Math.min(shortest, pace[k]);
    }
    for (let k = 0; k < pace.length; k++) {
      if (wasDry[k] && Number.isFinite(owed[k])) pace[k] = shortest;
      if (owed[k] === Infinity) pace[k] = Infinity;
    }
    const wet = NDArray.of(kernels, "i8", BigInt64Array.from(patch.wetBlocks(), BigInt));
    kernels.call(
      "surface.kernels.wet_graph.grade_paces",
      wet, graph.firstBeside, graph.lastBeside, graph.beside, UNLIKE, patch.pace,
    ); // prettier-ignore
    wet.free();
    const [still, graded] = [patch.owed.data, patch.pace.data];
    for (let k = 0; k < graded.length; k++) if (still[k] === Infinity) graded[k] = FIRST_PACE;
  }

  /** Move and dry a bundle: the nodes that have dried, null where more has to be opened first. */
  #moveAndDry(blocks: Int32Array, rest: NDArray<"f8">, step: Step): Int32Array | null {
    const { kernels, patch } = this;
    const { material } = patch.surface;
    const nodes = this.#listed(patch.graph.nodesOf(blocks));
    const rims = this.#listed(patch.graph.rimsOf(blocks));
    const absorption = {
      capacity: capacityOf(material), film: filmOf(material), passing: material.passing,
      pores: material.pores_mm, entry_ratio: entryRatioOf(material),
    };
    let stages: number;
    for (;;) {
      stages = kernels.call(
        "surface.kernels.wet_step.move_water",
        this.#fields(step), nodes, rims, absorption, SHORTEST, rest,
        { floats: this.#floats, ints: this.#ints },
      ) as number; // prettier-ignore
      if (stages !== WORKSPACE_TOO_SMALL) break;
      const room = 2 * this.#floats.length;
      this.#floats.free();
      this.#ints.free();
      this.#floats = kernels.zeros("f8", room);
      this.#ints = kernels.zeros("i4", room / 2);
    }
    const all = nodes.data.slice();
    nodes.free();
    rims.free();
    if (stages < 0) return null;
    const [water, inside] = [patch.water.data, patch.inside.data];
    const wet = all.filter((node) => water[node] > 0.0);
    for (const node of all) if (!(water[node] > 0.0)) inside[node] = 0.0;
    const [given, dried] = [NDArray.of(kernels, "i4", wet), kernels.zeros("i4", wet.length)];
    kernels.call(
      "surface.kernels.diffusion.solve_edges",
      given, this.#fields(step), patch.totals, EDGE_REACH, EDGE_SWEEPS, patch.inside,
    ); // prettier-ignore
    const drying = { rate: material.drying_mm_s, gain: EDGE_GAIN, dry: DRY, capacity: capacityOf(material) };
    const count = kernels.call(
      "surface.kernels.diffusion.evaporate",
      given, this.#fields(step), rest.data[0], drying, patch.inside, dried, step.stillWet,
    ) as number; // prettier-ignore
    const gone = dried.data.slice(0, count);
    given.free();
    dried.free();
    return gone;
  }

  #blocksToOpen(blocks: Int32Array, step: Step): Int32Array {
    const { graph, water: depths } = this.patch;
    const [block, closed, water, due] = [graph.block.data, graph.closed.data, depths.data, step.due.data];
    const missing = graph
      .rimsOf(blocks)
      .filter((node) => due[block[node]] === 0)
      .filter((node) => closed[node] === 2 || (closed[node] === 1 && water[node] > 0.0));
    step.rings++;
    let wanted = distinct(missing.map((node) => block[node]));
    for (let k = 0; k < Math.floor(step.rings / 2); k++) wanted = graph.blocksAround(wanted);
    return wanted;
  }
}

/** The water on a surface, made when first used, and the ink that it has yet to take up. */
export class Water {
  fresh: Int32Array[] | null = null;
  keepsUp = true;
  #flow: Flow | null = null;
  #still: Flow | null = null;

  constructor(
    private readonly kernels: Kernels,
    private readonly surface: PaintedSurface,
    private readonly frames: Float64Array,
  ) {}

  get flow(): Flow {
    if (this.#flow === null) {
      this.#flow = this.#still ?? new Flow(this.kernels, this.surface, this.frames);
      this.#still = null;
      this.#flow.clear();
      const coverage = this.surface.ink.coverage.data;
      this.fresh = [Int32Array.from({ length: this.surface.nVertices }, (_, k) => k).filter((k) => coverage[k] > 0.0)];
    }
    return this.#flow;
  }

  /** Whether nothing would change, however long one waited. */
  get isStill(): boolean {
    const { ink } = this.surface;
    if (ink.n_dirty.data[0] > 0n || this.fresh?.some((ids) => ids.length > 0) === true) return false;
    return this.#flow === null ? !ink.coverage.data.some((share) => share > 0.0) : this.#flow.isDry;
  }

  /** Let time pass, or not until the water has caught up; whether it keeps up. */
  followTime(seconds: number): boolean {
    const flow = this.flow;
    const fresh = joined([...(this.fresh ?? []), this.#dirty()], Int32Array);
    this.fresh = [];
    this.keepsUp = flow.follow(this.keepsUp ? seconds : 0.0, fresh);
    this.fresh.push(flow.waiting);
    return this.keepsUp;
  }

  keep(): KeptFlow | null {
    if (this.#flow === null) return null;
    const fresh = joined([...(this.fresh ?? []), this.#dirty()], Int32Array);
    return { patch: this.#flow.patch.keep(), fresh: distinct(fresh) };
  }

  restore(kept: KeptFlow | null): void {
    this.drop();
    if (kept === null) return;
    this.flow.restore(kept.patch);
    this.fresh = [kept.fresh];
  }

  /** Let all water go. */
  drop(): void {
    this.#still = this.#flow ?? this.#still;
    this.#flow = this.fresh = null;
  }

  #dirty(): Int32Array {
    const { dirty_ids, n_dirty } = this.surface.ink;
    return dirty_ids.data.slice(0, Number(n_dirty.data[0]));
  }
}
