/** The wet part of a surface: water and pigment on the flow graph; `paint3d/surface/wet_patch.py`. */

import { NDArray } from "../core/arrays";
import type { Argument, Kernels } from "../core/kernels";
import { rowSum, widened, type DryLayers } from "./dry_layers";
import { distinct, withRoom, type FlowGraph } from "./flow_graph";
import type { PaintedSurface } from "./painted_surface";
import { clip, closePore, evenExp, PoreFinder } from "./pores";

export const WET_COAT_MM = 0.03;
const WET_INK_MM = 0.015;
const THICK = 9.0;
const LOOSE = 0.6;
const LAID = 0.5;
const FRESH = 0.02;
const PARTICLES = 0.65;
/** The time step of a block after ink arrived, s. */
export const FIRST_PACE = 1.0 / 30.0;
const KEPT = ["water", "inside", "soaked", "laid", "pigment", "fine", "loose"] as const;

/** The patch at an instant, for undo, by nodes and places; the graph only grows. */
export interface KeptPatch {
  nPigments: number;
  nodes: Record<(typeof KEPT)[number], Float32Array | Float64Array>;
  written: Float32Array;
  owed: Float32Array;
  pace: Float32Array;
}

export class WetPatch {
  readonly graph: FlowGraph;
  water: NDArray<"f8">;
  inside: NDArray<"f4">;
  soaked: NDArray<"f4">;
  laid: NDArray<"f4">;
  pigment: NDArray<"f8">;
  fine: NDArray<"f8">;
  loose: NDArray<"f8">;
  changed: NDArray<"b1">;
  isHeld: NDArray<"b1">;
  residual: NDArray<"f8">;
  strength: NDArray<"f8">;
  sieve: NDArray<"f8">;
  catch: NDArray<"f8">;
  entryDepth: NDArray<"f8">;
  entry: NDArray<"f8">;
  dryEntry: NDArray<"f8">;
  conductance: NDArray<"f8">;
  place: NDArray<"i4">;
  bareEntryDepth: NDArray<"f8">;
  bareConductance: NDArray<"f8">;
  written: NDArray<"f4">;
  share: NDArray<"f8">;
  weights: NDArray<"f8">;
  totals: NDArray<"f8">;
  readonly owed: NDArray<"f4">;
  readonly pace: NDArray<"f4">;
  #mobility: NDArray<"f8">;
  #sticks: NDArray<"f8">;
  #count: number; // pigments
  #nNodes = 0;
  #nLinks = 0;
  #seen: readonly [DryLayers, number];
  readonly #pores: PoreFinder;

  constructor(
    private readonly kernels: Kernels,
    readonly surface: PaintedSurface,
    frames: Float64Array,
  ) {
    this.graph = surface.flowGraph;
    this.#pores = new PoreFinder(kernels, surface.material, frames, surface.paintMesh.arrays.resolution);
    const count = (this.#count = surface.pigments.length);
    const empty = (): NDArray<"f8"> => kernels.zeros("f8", 0);
    this.water = empty();
    this.inside = kernels.zeros("f4", 0);
    this.soaked = kernels.zeros("f4", 0);
    this.laid = kernels.zeros("f4", 0);
    this.pigment = kernels.zeros("f8", 0, count);
    this.fine = kernels.zeros("f8", 0, count);
    this.loose = kernels.zeros("f8", 0, count);
    this.changed = kernels.zeros("b1", 0);
    this.isHeld = kernels.zeros("b1", 0);
    this.residual = empty();
    this.strength = empty();
    this.sieve = empty();
    this.catch = empty();
    this.entryDepth = empty();
    this.entry = empty();
    this.dryEntry = empty();
    this.conductance = empty();
    this.place = kernels.zeros("i4", 0);
    this.bareEntryDepth = empty();
    this.bareConductance = empty();
    this.written = kernels.zeros("f4", 0, count);
    this.share = empty();
    this.weights = empty();
    this.totals = empty();
    this.#mobility = empty();
    this.#sticks = empty();
    this.#findMobility();
    const blocks = this.graph.nBlocks;
    this.owed = NDArray.of(kernels, "f4", new Float32Array(blocks).fill(Infinity));
    this.pace = NDArray.of(kernels, "f4", new Float32Array(blocks).fill(FIRST_PACE));
    this.#seen = [surface.dryLayers, surface.dryLayers.changes];
    this.#follow();
  }

  /** Remove all water and pigment. */
  clear(): void {
    this.#knowPigments();
    for (const name of KEPT) this[name].bytes.fill(0);
    this.written.bytes.fill(0);
    this.updateGlue();
    this.entry.data.set(this.dryEntry.data);
    this.changed.bytes.fill(0);
    this.owed.data.fill(Infinity);
    this.pace.data.fill(FIRST_PACE);
  }

  keep(): KeptPatch {
    this.#knowPigments();
    const { nNodes: n, nPlaces } = this.graph;
    const rows = (array: NDArray<"f4"> | NDArray<"f8">, used: number): Float32Array | Float64Array =>
      array.data.slice(0, used * (array.shape[1] ?? 1));
    return {
      nPigments: this.#count,
      nodes: {
        water: rows(this.water, n), inside: rows(this.inside, n), soaked: rows(this.soaked, n),
        laid: rows(this.laid, n), pigment: rows(this.pigment, n), fine: rows(this.fine, n), loose: rows(this.loose, n),
      },
      written: this.written.data.slice(0, nPlaces * this.#count),
      owed: this.owed.data.slice(),
      pace: this.pace.data.slice(),
    }; // prettier-ignore
  }

  /** Go on from what was kept; as after `restore` in Python, dry blocks are as they were new. */
  restore(kept: KeptPatch): void {
    this.clear();
    const [before, now] = [kept.nPigments, this.#count];
    for (const name of KEPT) {
      const [from, to] = [kept.nodes[name], this[name].data];
      if (this[name].shape.length === 1) to.set(from);
      else for (let k = 0; k < from.length; k++) to[Math.floor(k / before) * now + (k % before)] = from[k];
    }
    this.written.data.set(widened(kept.written, before, now));
    const [soaked, entry, dryEntry] = [this.soaked.data, this.entry.data, this.dryEntry.data];
    for (let k = 0; k < entry.length; k++) entry[k] = soaked[k] >= 1.0 ? 0.0 : dryEntry[k];
    const [water, block] = [this.water.data, this.graph.block.data];
    const [owed, pace] = [this.owed.data, this.pace.data];
    for (let node = 0; node < this.graph.nNodes; node++) {
      if (!(water[node] > 0.0)) continue;
      const own = block[node];
      owed[own] = Number.isFinite(kept.owed[own]) ? kept.owed[own] : 0.0;
      pace[own] = kept.pace[own];
    }
  }

  /** The arrays for a step (`WetFields`). */
  fields(due: NDArray<"b1">, mobile: NDArray<"b1">, moved: NDArray<"f8">): { [name: string]: Argument } {
    const graph = this.graph;
    return {
      first: graph.first, last: graph.last, links: graph.links, weights: this.weights,
      area: graph.area, block: graph.block, closed: graph.closed, place: this.place,
      residual: this.residual, strength: this.strength, sieve: this.sieve, catch: this.catch,
      entry_depth: this.entryDepth, entry: this.entry, water: this.water, pigment: this.pigment,
      fine: this.fine, loose: this.loose, mobility: this.#mobility, sticks: this.#sticks,
      soaked: this.soaked, changed: this.changed, owed: this.owed, due, mobile, moved,
    }; // prettier-ignore
  }

  isWet(): boolean {
    return this.owed.data.some(Number.isFinite);
  }

  /** The blocks with water, ascending. */
  wetBlocks(): Int32Array {
    const owed = this.owed.data;
    const found: number[] = [];
    for (let k = 0; k < owed.length; k++) if (Number.isFinite(owed[k])) found.push(k);
    return Int32Array.from(found);
  }

  // -- exchange with the surface --------------------------------------------------------------

  /** The places of those vertices whose ink is not what was handed back, ascending. */
  findChanged(fresh: Int32Array): Int32Array {
    const { graph, kernels, surface } = this;
    this.#knowPigments();
    this.updateGlue();
    const given = [
      NDArray.of(kernels, "i4", fresh),
      NDArray.of(kernels, "i4", fresh.map((id) => graph.placeOf(id))),
    ];
    const isNew = kernels.zeros("b1", fresh.length);
    kernels.call(
      "surface.kernels.diffusion.mark_news",
      ...given, graph.nodeOf, graph.block, graph.blockOpen, this.written, surface.ink.amounts, isNew,
    ); // prettier-ignore
    const marks = isNew.data.slice();
    for (const array of [...given, isNew]) array.free();
    const news = fresh.filter((_, k) => marks[k] !== 0);
    const count = this.#count;
    const wet = this.#wetOf(news);
    if (this.#closedOf(wet).length > 0) this.reach(wet);
    const [amounts, written, vertices] = [surface.ink.amounts.data, this.written.data, graph.vertices.data];
    const places = distinct(news.map((id) => graph.placeOf(id)).filter((place) => place >= 0));
    return places.filter((place) => {
      for (let p = 0; p < count; p++)
        if (amounts[vertices[place] * count + p] !== written[place * count + p]) return true;
      return false;
    });
  }

  /** Those of some vertices that have ink. */
  #wetOf(ids: Int32Array): Int32Array {
    const amounts = this.surface.ink.amounts.data;
    const count = this.surface.pigments.length;
    return ids.filter((id) => {
      for (let k = id * count; k < (id + 1) * count; k++) if (amounts[k] !== 0.0) return true;
      return false;
    });
  }

  /** Those of some vertices that are in no open block. */
  #closedOf(ids: Int32Array): Int32Array {
    const { graph } = this;
    const [open, block, nodeOf] = [graph.blockOpen.data, graph.block.data, graph.nodeOf.data];
    return ids.filter((id) => {
      const place = graph.placeOf(id);
      return place < 0 || open[block[nodeOf[place]]] === 0;
    });
  }

  /** Apply changes of the ink at places to water and pigment; the nodes on which a tuft lies. */
  readSurface(at: Int32Array): Int32Array {
    const { graph, surface } = this;
    const count = this.#count;
    const { pigments } = surface;
    const [amounts, coverage] = [surface.ink.amounts.data, surface.ink.coverage.data];
    const [nodeOf, vertices, blockOf] = [graph.nodeOf.data, graph.vertices.data, graph.block.data];
    const [written, share] = [this.written.data, this.share.data];
    const [water, soaked, entry, changed] = [this.water.data, this.soaked.data, this.entry.data, this.changed.data];
    const n = at.length;
    const node = Array.from(at, (place) => nodeOf[place]);
    const change = new Float64Array(n * count);
    const came = new Float64Array(n);
    const coats = new Float64Array(n);
    const kept = new Float64Array(n);
    for (let i = 0; i < n; i++) {
      const [to, from] = [vertices[at[i]] * count, at[i] * count];
      const out: number[] = [];
      const laid: number[] = [];
      for (let p = 0; p < count; p++) {
        const by = Math.fround(amounts[to + p] - written[from + p]);
        change[i * count + p] = by;
        came[i] += Math.max(by, 0.0) * (pigments[p].lasting ? WET_INK_MM : WET_COAT_MM);
        out.push(Math.max(-by, 0.0));
        if (pigments[p].lasting) laid.push(Math.max(by, 0.0));
      }
      const went = rowSum(out);
      const before = rowSum(written.subarray(from, from + count));
      kept[i] = 1.0 - share[at[i]] * (before > 0.0 ? went / before : 0.0);
      coats[i] = rowSum(laid);
    }
    const [pigment, fine, loose] = [this.pigment.data, this.fine.data, this.loose.data];
    for (let i = 0; i < n; i++) water[node[i]] *= kept[i];
    const [deep, added] = [this.laid.data, new Float64Array(n)];
    const underTuft = new Set<number>();
    const thin = Float64Array.from(node, (to, i) => {
      // what comes runs together with what is there
      const there = rowSum(pigment.subarray(to * count, (to + 1) * count)) + coats[i];
      const ran = coats[i] > 0.0 && deep[to] < LAID * water[to];
      const own = ran ? (came[i] / coats[i]) * there : Infinity;
      added[i] = Math.min(came[i], Math.max(own - water[to], 0.0));
      const liquid = water[to] + added[i];
      if (coats[i] > 0.0 && came[i] > FRESH * liquid) underTuft.add(to);
      const thick = liquid > 0.0 ? there / (THICK * liquid) : 1.0;
      return Math.max(0.0, 1.0 - thick * thick);
    });
    for (let i = 0; i < n; i++) {
      water[node[i]] += share[at[i]] * added[i];
      deep[node[i]] += Math.fround(share[at[i]] * came[i]);
    }
    this.#addPigment(node, at, change, thin);
    for (let i = 0; i < n; i++)
      for (let p = 0; p < count; p++) {
        written[at[i] * count + p] = amounts[vertices[at[i]] * count + p];
        if (pigments[p].lasting) continue;
        const k = node[i] * count + p;
        pigment[k] = fine[k] = loose[k] = 0.0;
      }
    const [owed, pace] = [this.owed.data, this.pace.data];
    for (let i = 0; i < n; i++) {
      if (came[i] > 0.0) {
        const to = node[i];
        soaked[to] = Math.max(soaked[to], coverage[vertices[at[i]]]); // wetted by the brush
        if (soaked[to] >= 1.0) entry[to] = 0.0;
      }
      changed[node[i]] = 1;
    }
    for (let i = 0; i < n; i++) {
      const own = pigment.subarray(node[i] * count, (node[i] + 1) * count);
      if (rowSum(own) + water[node[i]] <= 0.0) water[node[i]] = 0.0;
      if (!(came[i] > 0.0)) continue;
      const block = blockOf[node[i]];
      pace[block] = FIRST_PACE;
      if (owed[block] === Infinity) owed[block] = 0.0;
    }
    return distinct(underTuft);
  }

  /** Add pigment to nodes, or remove it, of all kinds in proportion. */
  #addPigment(node: number[], at: Int32Array, change: Float64Array, thin: Float64Array): void {
    const count = this.#count;
    const [pigment, fine, loose] = [this.pigment.data, this.fine.data, this.loose.data];
    const share = this.share.data;
    const mobility = this.#mobility.data;
    const { pigments } = this.surface;
    const n = node.length;
    const left = new Float64Array(n * count);
    for (let i = 0; i < n; i++)
      for (let p = 0; p < count; p++) {
        const k = i * count + p;
        change[k] = share[at[i]] * change[k];
        const before = pigment[node[i] * count + p];
        const came = Math.max(change[k], 0.0);
        left[k] = 1.0 + (before > 0.0 ? (change[k] - came) / before : 0.0);
      }
    const every = (work: (to: number, k: number, p: number, i: number) => void): void => {
      for (let i = 0; i < n; i++)
        for (let p = 0; p < count; p++) work(node[i] * count + p, i * count + p, p, i);
    };
    every((to, k) => (pigment[to] += change[k]));
    every((to) => (pigment[to] = Math.max(pigment[to], 0.0)));
    const rest = new Float64Array(n * count);
    every((to, k) => (rest[k] = pigment[to]));
    const looseOf = (p: number, i: number): number => LOOSE * mobility[p] * thin[i];
    const parts = [
      [fine, (p: number, i: number) => pigments[p].fine * (1.0 - looseOf(p, i))],
      [loose, looseOf],
    ] as const;
    for (const [amounts, fraction] of parts) {
      every((to, k) => (amounts[to] *= clip(left[k], 0.0, 1.0)));
      every((to, k, p, i) => (amounts[to] += fraction(p, i) * Math.max(change[k], 0.0)));
      // at once, as two places may share a node
      const now = new Float64Array(n * count);
      every((to, k) => (now[k] = Math.min(amounts[to], rest[k])));
      every((to, k) => (amounts[to] = now[k]));
      every((to, k) => (rest[k] = Math.max(rest[k] - amounts[to], 0.0)));
    }
  }

  /** Add columns for pigments that are new on the surface. */
  #knowPigments(): void {
    const count = this.surface.pigments.length;
    if (count === this.#count) return;
    const before = this.#count;
    for (const name of ["pigment", "fine", "loose"] as const) this[name] = columns(this[name], before, count);
    this.written = columns(this.written, before, count);
    this.#count = count;
    this.#findMobility();
  }

  #findMobility(): void {
    const { pigments, material } = this.surface;
    this.#mobility.free();
    this.#sticks.free();
    this.#mobility = NDArray.of(this.kernels, "f8", pigments.map((p) => material.mobility[p.name]));
    this.#sticks = NDArray.of(
      this.kernels, "f8", pigments.map((p) => Math.min(1.0, (1.0 - p.fine) / PARTICLES)),
    ); // prettier-ignore
  }

  /** Write pigment that moved back to the vertices; ink that came since stays there. */
  writeSurface(): void {
    const { graph, kernels } = this;
    const n = graph.nPlaces;
    const seen = (array: NDArray<"i4">): NDArray<"i4"> =>
      new NDArray(kernels, "i4", [n], array.address);
    const out = kernels.zeros("i4", n);
    const given = kernels.call(
      "surface.kernels.diffusion.give_back",
      seen(graph.vertices), seen(graph.nodeOf), this.changed, this.pigment, this.soaked,
      this.written, this.surface.ink, out,
    ) as number; // prettier-ignore
    const ids = out.data.slice(0, given);
    out.free();
    this.surface.touch(ids);
  }

  /** Turn the pigment on nodes, which have lost their water, into dried paint. */
  dry(nodes: Int32Array): void {
    this.writeSurface();
    const { graph, surface } = this;
    const count = this.#count;
    const at = graph.placesAt(nodes);
    const vertices = graph.vertices.data;
    const ids = at.map((place) => vertices[place]);
    const covered = new Float32Array(ids.length);
    const came = new Float32Array(ids.length * count);
    {
      const [amounts, coverage] = [surface.ink.amounts.data, surface.ink.coverage.data];
      const written = this.written.data;
      for (let i = 0; i < ids.length; i++) {
        covered[i] = coverage[ids[i]];
        for (let p = 0; p < count; p++) {
          const k = ids[i] * count + p;
          came[i * count + p] = Math.max(Math.fround(amounts[k] - written[at[i] * count + p]), 0.0);
          amounts[k] = amounts[k] - came[i * count + p];
        }
      }
      const [pigment, fine, loose] = [this.pigment.data, this.fine.data, this.loose.data];
      const [soaked, laid] = [this.soaked.data, this.laid.data];
      for (const node of nodes) {
        soaked[node] = laid[node] = 0.0;
        for (let k = node * count; k < (node + 1) * count; k++) pigment[k] = fine[k] = loose[k] = 0.0;
      }
    }
    surface.settle(ids.filter((_, i) => covered[i] > 0.0));
    this.#seen = [surface.dryLayers, surface.dryLayers.changes];
    this.#clogPores(nodes);
    this.#weigh(nodes);
    surface.touch(ids.filter((_, i) => !(covered[i] > 0.0)));
    const [amounts, coverage] = [surface.ink.amounts.data, surface.ink.coverage.data];
    const written = this.written.data;
    for (let i = 0; i < ids.length; i++) {
      let any = false;
      for (let p = 0; p < count; p++) {
        const more = came[i * count + p];
        amounts[ids[i] * count + p] = more;
        any ||= more !== 0.0;
        written[at[i] * count + p] = 0.0;
      }
      if (any) coverage[ids[i]] = covered[i];
    }
  }

  /** Let no water run from or to nodes on which a tuft lies, or let it run again. */
  hold(nodes: Int32Array, isHeld: boolean): void {
    for (const node of nodes) this.isHeld.data[node] = Number(isHeld);
    this.#weigh(nodes);
  }

  // -- growth -----------------------------------------------------------------------------------

  /** Extend the patch to vertices. */
  reach(ids: Int32Array): void {
    this.open(this.graph.blocksOf(this.graph.cellsOf(ids)));
  }

  /**
   * Extend it to vertices with ink, by so many blocks at most. Those that can be taken up now, and
   * those that wait.
   */
  openSome(ids: Int32Array, most: number): [Int32Array, Int32Array] {
    const wanted = this.#closedOf(this.#wetOf(ids));
    if (wanted.length === 0) return [ids, new Int32Array(0)];
    const { graph } = this;
    const waiting = new Set(this.#openOf(distinct(graph.blockOf(wanted)), most));
    const block = graph.blockOf(wanted);
    const later = wanted.filter((_, k) => waiting.has(block[k]));
    const waits = new Set(later);
    return [ids.filter((id) => !waits.has(id)), later];
  }

  /** Open at most so many blocks with water; whether all are open now. */
  openWet(most: number): boolean {
    const open = this.graph.blockOpen.data;
    return this.#openOf(this.wetBlocks().filter((block) => open[block] === 0), most).length === 0;
  }

  #openOf(closed: Int32Array, most: number): Int32Array {
    this.open(closed.subarray(0, most));
    return closed.subarray(most);
  }

  open(blocks: Iterable<number>): void {
    this.graph.open(blocks);
    this.#follow();
  }

  /** Initialise the nodes and links that were added to the graph. */
  #follow(): void {
    const { graph, surface } = this;
    const n = graph.nNodes;
    for (const name of ["water", "pigment", "fine", "loose", "residual", "strength", "sieve", "catch",
      "entryDepth", "entry", "dryEntry", "conductance", "bareEntryDepth", "bareConductance", "totals"] as const)
      this[name] = withRoom(this[name], n); // prettier-ignore
    this.inside = withRoom(this.inside, n);
    this.soaked = withRoom(this.soaked, n);
    this.laid = withRoom(this.laid, n);
    this.changed = withRoom(this.changed, n);
    this.isHeld = withRoom(this.isHeld, n);
    this.place = withRoom(this.place, n);
    this.written = withRoom(this.written, graph.nPlaces);
    this.share = withRoom(this.share, graph.nPlaces);
    this.weights = withRoom(this.weights, graph.nLinks);
    if (this.#nNodes < n) {
      const from = this.#nNodes;
      const found = this.#pores.find(graph.points.data.slice(3 * from, 3 * n));
      const area = graph.area.data;
      this.residual.data.set(found.residual, from);
      this.strength.data.set(found.strength, from);
      this.sieve.data.set(found.sieve, from);
      this.bareEntryDepth.data.set(found.entryDepth, from);
      this.bareConductance.data.set(found.conductance, from);
      const caught = this.catch.data;
      for (let k = from; k < n; k++) caught[k] = 1.0 - evenExp(-Math.sqrt(area[k]) / found.catch[k - from]);
      this.#clogPores(Int32Array.from({ length: n - from }, (_, k) => from + k));
      const { area_units: units, area_unit: unit } = surface.paintMesh.arrays;
      const [share, all, vertices, nodeOf] = [this.share.data, units.data, graph.vertices.data, graph.nodeOf.data];
      for (let place = graph.firstPlace(from); place < graph.nPlaces; place++)
        share[place] = (Number(all[vertices[place]]) * unit) / area[nodeOf[place]];
    }
    if (this.#nLinks < graph.nLinks) {
      this.#weighLinks(this.#nLinks, graph.nLinks);
      const [owner, weights, totals] = [graph.owner.data, this.weights.data, this.totals.data];
      const own = new Float64Array(n);
      for (let k = this.#nLinks; k < graph.nLinks; k++) own[owner[k]] += weights[k];
      for (let k = 0; k < n; k++) totals[k] += own[k];
    }
    this.#nNodes = n;
    this.#nLinks = graph.nLinks;
  }

  /** Close the pores of nodes by the glue of the ink that has dried there. */
  #clogPores(nodes: Int32Array): void {
    const { graph, surface } = this;
    const [residual, strength] = [this.residual.data, this.strength.data];
    const [bareEntryDepth, bareConductance] = [this.bareEntryDepth.data, this.bareConductance.data];
    const [entryDepth, dryEntry, conductance, entry, soaked] = [this.entryDepth.data, this.dryEntry.data, this.conductance.data, this.entry.data, this.soaked.data];
    const vertices = graph.vertices.data;
    for (const node of nodes) {
      const glue = surface.dryLayers.count > 0 ? surface.dryLayers.glueOf(vertices[graph.firstPlace(node)]) : 0.0;
      [entryDepth[node], dryEntry[node], conductance[node]] = closePore(
        surface.material, residual[node], strength[node], bareEntryDepth[node], bareConductance[node], glue,
      ); // prettier-ignore
      entry[node] = soaked[node] >= 1.0 ? 0.0 : dryEntry[node];
    }
  }

  /** Update all pores if dried paint came or went by other means than `dry`. */
  updateGlue(): void {
    const { dryLayers } = this.surface;
    if (dryLayers === this.#seen[0] && dryLayers.changes === this.#seen[1]) return;
    this.#seen = [dryLayers, dryLayers.changes];
    const before = this.conductance.data.slice();
    this.#clogPores(Int32Array.from({ length: this.#nNodes }, (_, k) => k));
    const conductance = this.conductance.data;
    this.#weigh(Int32Array.from(before.keys()).filter((k) => conductance[k] !== before[k]));
  }

  /** Update the weights of all links from and to nodes whose conductance has changed. */
  #weigh(nodes: Int32Array): void {
    if (nodes.length === 0) return;
    const { graph } = this;
    const [first, last, links] = [graph.first.data, graph.last.data, graph.links.data];
    const owners = new Set<number>(nodes);
    for (const node of nodes)
      for (let k = Number(first[node]); k < Number(last[node]); k++) owners.add(links[k]);
    const [weights, totals] = [this.weights.data, this.totals.data];
    for (const owner of Array.from(owners).sort((a, b) => a - b)) {
      const [from, to] = [Number(first[owner]), Number(last[owner])];
      this.#weighLinks(from, to);
      let sum = 0.0;
      for (let k = from; k < to; k++) sum += weights[k];
      totals[owner] = sum;
    }
  }

  #weighLinks(from: number, to: number): void {
    const { graph } = this;
    const [conductance, isHeld] = [this.conductance.data, this.isHeld.data];
    const [owner, links] = [graph.owner.data, graph.links.data];
    const [bare, weights] = [graph.weights.data, this.weights.data];
    for (let k = from; k < to; k++) {
      const [start, end] = [conductance[owner[k]], conductance[links[k]]];
      const stops = isHeld[owner[k]] !== 0 || isHeld[links[k]] !== 0;
      weights[k] = stops ? 0.0 : bare[k] * ((2.0 * start * end) / (start + end));
    }
  }
}

/** The same with columns of zeros more; the old array is let go. */
function columns<K extends "f4" | "f8">(array: NDArray<K>, before: number, after: number): NDArray<K> {
  const wider = NDArray.zeros(array.memory, array.kind, [array.length, after]);
  const [from, to] = [array.data, wider.data];
  for (let k = 0; k < from.length; k++) to[Math.floor(k / before) * after + (k % before)] = from[k];
  array.free();
  return wider;
}
