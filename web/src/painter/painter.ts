/** The painter: moves one inked brush over a surface along timed poses; `paint3d/painter/painter.py`. */

import { NDArray } from "../core/arrays";
import type { Argument, Kernels } from "../core/kernels";
import { amountOfTuft, FULL_DIP, type Brush, type DipAmount, type Tuft } from "../brush/brush";
import {
  growScratch, makeProgress, makeScratch, type Progress, type Scratch, type Sizes,
} from "../brush_engine/scratch"; // prettier-ignore
import type { Pigment } from "../colour/materials";
import { objectPoses } from "../pose/brush_pose";
import { DIP, ERASER, RecordingError, type DeviceSample, type Recording } from "../recording/recording";
import { HairTuft, type KeptHairs } from "./bristle_state";
import type { PaintedSurface, Snapshot } from "../surface/painted_surface";

/** Parts of an ink by pigment. */
export type Ink = ReadonlyMap<Pigment, number>;

/** Samples that must be known beyond an interval before it is painted. */
export const LOOKAHEAD = 2;
/** A time step of wet ink. */
export const INK_STEP_S = 0.05;
const INK_STEP_NS = 50_000_000n;
const FINISHED = 0;
const RESERVOIRS = 12; // segments of a tuft whose load varies along its length

interface Samples {
  [name: string]: NDArray;
}

/** All state between strokes except the surface. */
export interface Kept {
  brush: Brush;
  tuft: Tuft;
  amount: DipAmount;
  loaded: number;
  dipped: Ink;
  dips: readonly (readonly [Ink, number | null])[];
  hairs: HairTuft | null;
  ofHairs: KeptHairs | null;
}

export class Painter {
  tuft: Tuft;
  loaded = 0.0;
  #hairs: HairTuft | null;
  #progress: Progress;
  #scratch: Scratch;
  #pending: DeviceSample[] = [];
  #originNs = 0n;
  #dipped: Ink = new Map();
  #dips: readonly (readonly [Ink, number | null])[] = [];

  constructor(
    private readonly kernels: Kernels,
    sizes: Sizes,
    readonly surface: PaintedSurface,
    public brush: Brush,
    ink: Ink,
    public azimuth: "commanded" | "dragged" = "commanded",
    public amount: DipAmount = FULL_DIP,
    pickup: number | null = null,
  ) {
    this.tuft = this.#dippedTuft(brush);
    this.#hairs = this.#makeHairs();
    this.#progress = makeProgress(kernels, sizes);
    this.#scratch = makeScratch(kernels, sizes, surface.paintMesh, surface.pigments.length);
    if (pickup !== null) surface.ink.transfer.field("pickup")[0] = pickup;
    this.dip(ink);
  }

  // -- the brush ----------------------------------------------------------------------------

  /**
   * Rinse the brush and load it with an ink; without one repeat the last dips, whole and tip. With
   * a reach only this fraction of the tuft's length is dipped, from the tip. An amount is how much
   * ink the brush takes up from now on, of whole dips.
   */
  dip(ink: Ink | null = null, reach: number | null = null, amount: DipAmount | null = null): void {
    if (amount !== null && reach !== null)
      throw new RangeError("an amount is said with a reach; expected it for a whole dip");
    if (amount !== null) {
      this.amount = amount;
      this.tuft = this.#dippedTuft(this.brush);
    }
    if (ink === null && reach === null && this.#dips.length > 1) {
      for (const [again, deep] of this.#dips) this.dip(again, deep);
      return;
    }
    ink ??= this.#dipped;
    const parts = this.#mixture(ink);
    const depth = reach ?? 1.0;
    const surface = this.surface;
    const hairs = this.#hairs;
    if (hairs !== null && reach !== null)
      throw new RangeError("a page does not dip the tip of single hairs; expected a whole dip");
    hairs?.rescale(surface.ink.load.data.slice());
    if (reach === null) this.#hold(parts.map((part) => part * this.tuft.load));
    else {
      const count = parts.length;
      let along = surface.ink.reservoirs.data.slice();
      if (surface.ink.reservoirs.length === 1) {
        const share = surface.ink.load.data.map((held) => held / RESERVOIRS);
        along = new Float64Array(RESERVOIRS * count);
        for (let k = 0; k < along.length; k++) along[k] = share[k % count];
      }
      const n = along.length / count;
      for (let k = 0; k < n; k++)
        if ((k + 0.5) / n < depth)
          for (let p = 0; p < count; p++) along[k * count + p] = (parts[p] * this.tuft.load) / n;
      this.#holdAlong(along, n);
    }
    if (hairs !== null) {
      hairs.dip(surface.ink.load.data.slice());
      surface.ink.load.data.set(hairs.total());
      hairs.shape();
    }
    // A dip hides earlier ones of the same reach or less:
    const deeper =
      reach === null ? [] : this.#dips.filter(([, other]) => other === null || other > depth);
    this.#dips = [...deeper, [ink, reach === null ? null : depth]];
    this.#dipped = ink;
    this.#fitScratch();
  }

  /** The ink of the last dip. */
  get dipped(): Ink {
    return this.#dipped;
  }

  /** Switch to another brush, fully loaded with the same ink. */
  changeBrush(brush: Brush): void {
    this.tuft = this.#dippedTuft(brush);
    this.brush = brush;
    this.#hairs = this.#makeHairs();
    this.dip(this.#dipped);
  }

  #makeHairs(): HairTuft | null {
    return this.brush.hasHairs ? new HairTuft(this.kernels, this.brush) : null;
  }

  /** Snapshot, for `restore`, all state between strokes except the surface. */
  keep(): Kept {
    const { brush, tuft, amount, loaded } = this;
    const hairs = this.#hairs;
    const ofHairs = hairs?.keep() ?? null;
    return { brush, tuft, amount, loaded, dipped: this.#dipped, dips: this.#dips, hairs, ofHairs };
  }

  /** Take a full brush for a while; what is called then gives back the one in hand, as it was. */
  lend(): () => void {
    const [kept, load] = [this.keep(), this.surface.keepLoad()];
    this.changeBrush(this.brush);
    this.dip(this.#dipped);
    return () => {
      const [before, loaded] = [this.inBrush(), this.loaded];
      const off = this.surface.ink.off_surface.data.slice();
      this.surface.takeLoad(load);
      this.surface.ink.off_surface.data.set(off);
      this.#take({ ...kept, loaded: loaded + this.inBrush() - before });
      this.#fitScratch();
    };
  }

  /** Return to snapshots of the painter and of the surface. */
  restore(kept: Kept, surface: Snapshot): void {
    this.#take(kept);
    this.surface.restore(surface);
    this.#fitScratch();
  }

  #take(kept: Kept): void {
    ({ brush: this.brush, tuft: this.tuft, amount: this.amount, loaded: this.loaded } = kept);
    this.#dipped = kept.dipped;
    this.#dips = kept.dips;
    this.#hairs = kept.hairs;
    if (kept.ofHairs !== null) this.#hairs?.restore(kept.ofHairs);
  }

  #dippedTuft(brush: Brush): Tuft {
    return amountOfTuft(this.amount, brush.tuftOn(this.surface.material));
  }

  /** Fractions of the surface's pigments in an ink; they sum to 1. */
  #mixture(ink: Ink): Float64Array {
    const columns = [...ink.keys()].map((pigment) => this.surface.columnOf(pigment));
    const parts = new Float64Array(this.surface.pigments.length);
    const sum = [...ink.values()].reduce((a, b) => a + b, 0.0);
    for (const [k, weight] of [...ink.values()].entries()) parts[columns[k]] += weight / sum;
    return parts;
  }

  /** The same of paste, float32, which the brush does not hold. */
  partsOf(ink: Ink): Float32Array {
    const columns = [...ink.keys()].map((pigment) => this.surface.columnOf(pigment));
    const parts = new Float32Array(this.surface.pigments.length);
    const sum = Math.fround([...ink.values()].reduce((a, b) => a + b, 0.0));
    for (const [k, weight] of [...ink.values()].entries()) parts[columns[k]] += Math.fround(weight) / sum;
    this.#fitScratch();
    return parts;
  }

  /** Set the load, uniform along the tuft. */
  #hold(load: Float64Array): void {
    const { ink } = this.surface;
    const held = ink.load.data;
    this.loaded += this.surface.lasting(load.map((part, p) => part - held[p]));
    held.set(load);
    ink.transfer.field("capacity")[0] = this.tuft.load;
    this.surface.setReservoirs(new Float64Array(load.length), 1);
  }

  /** Set the load along the tuft, tip first. */
  #holdAlong(reservoirs: Float64Array, rows: number): void {
    const { surface } = this;
    surface.setReservoirs(reservoirs, rows);
    this.kernels.call("brush_engine.ink_transfer.level_reservoirs", surface.ink.reservoirs);
    const levelled = surface.ink.reservoirs.data;
    const load = new Float64Array(surface.pigments.length);
    for (let k = 0; k < levelled.length; k++) load[k % load.length] += levelled[k];
    const held = surface.ink.load.data;
    this.loaded += surface.lasting(load.map((part, p) => part - held[p]));
    held.set(load);
    surface.ink.transfer.field("capacity")[0] = this.tuft.load;
    surface.ink.transfer.field("reservoir_mm")[0] = this.brush.lengthMm / rows;
  }

  /** Pigment in the brush, coats x mm2. */
  inBrush(): number {
    return this.surface.lasting(this.surface.ink.load.data);
  }

  /** The share of a full dip that the brush holds. */
  inkLeft(): number {
    return this.surface.ink.load.data.reduce((a, b) => a + b, 0.0) / this.tuft.load;
  }

  /** The ink balance, coats x mm2: loaded = inBrush + wet + dry + offSurface. */
  ledger(): Record<"loaded" | "inBrush" | "wet" | "dry" | "offSurface", number> {
    return {
      loaded: this.loaded,
      inBrush: this.inBrush(),
      wet: this.surface.wetInk(),
      dry: this.surface.dryInk(),
      offSurface: this.surface.lasting(this.surface.ink.off_surface.data),
    };
  }

  // -- painting -----------------------------------------------------------------------------

  /** Paint a whole recording; `wet`: let the ink spread and dry meanwhile, in its own time. */
  replay(recording: Recording, wet = false): void {
    this.finish();
    const { header, samples: given } = recording;
    if ("loads" in header || "strengths" in header || given.some((s) => (s.buttons & ERASER) !== 0))
      throw new RecordingError(
        "it changes its load, or erases, which a page does not replay; expected strokes alone",
      );
    this.#originNs = given[0].timeNs;
    const [samples] = this.#samples(given);
    for (const [pause, pieces] of wet ? pausesOf(given, samples.joined.data as Uint8Array) : []) {
      if (pause >= 0) this.#paintTo(samples, given, pause);
      this.#stepInk(pieces);
    }
    this.#paintTo(samples, given, given.length - 1);
    for (const array of Object.values(samples)) array.free();
    this.#begin();
  }

  /** Let the ink of a wet replay go on for so long after the last sample. */
  rest(lastNs: bigint, seconds: number): void {
    const n = Number((lastNs + BigInt(Math.round(1e9 * seconds))) / INK_STEP_NS - lastNs / INK_STEP_NS);
    let [passed, isDry] = [0, false];
    while (passed < n && !isDry) {
      passed += Number(this.surface.water.keepsUp);
      isDry = this.#stepInk(1);
    }
  }

  /** Let so many time steps pass; whether all is dry. */
  #stepInk(pieces: number): boolean {
    const { water } = this.surface;
    for (let k = 0; k < pieces; k++) {
      water.followTime(INK_STEP_S);
      if (water.flow.isDry) return true;
    }
    return false;
  }

  /** Paint live; the last two samples stay pending until their successors arrive. */
  advance(samples: readonly DeviceSample[]): void {
    if (this.#pending.length === 0 && samples.length > 0) this.#originNs = samples[0].timeNs;
    this.#pending.push(...samples);
    this.#paintPending(this.#pending.length - 1 - LOOKAHEAD);
  }

  /** Paint all pending samples and lift the brush. */
  finish(): void {
    this.#paintPending(this.#pending.length - 1);
    this.#pending = [];
    this.#begin();
  }

  #begin(): void {
    this.#progress.at.data.fill(0n);
    this.#progress.before.values.bytes.fill(0);
    this.#scratch.warm.data[0] = 0.0;
  }

  /** Paint pending samples up to `last`, and release those that no later interval needs. */
  #paintPending(last: number): void {
    const at = (): number => Number(this.#progress.at.data[0]);
    if (last <= at()) return;
    const origins = this.#paint(this.#pending, last);
    const done = Math.max(0, at() - LOOKAHEAD);
    this.#originNs = origins[done];
    this.#pending = this.#pending.slice(done);
    this.#progress.at.data[0] -= BigInt(done);
  }

  /** Prepare samples and paint up to one of them; origins of time by sample. */
  #paint(given: readonly DeviceSample[], last: number): BigInt64Array {
    const [samples, origins] = this.#samples(given);
    this.#paintTo(samples, given, last);
    for (const array of Object.values(samples)) array.free();
    return origins;
  }

  /** Paint up to sample `last`, dipping where the button goes down. */
  #paintTo(samples: Samples, given: readonly DeviceSample[], last: number): void {
    const first = Number(this.#progress.at.data[0]);
    for (let k = 1; k < given.length; k++) {
      const down = (given[k].buttons & DIP) !== 0 && (given[k - 1].buttons & DIP) === 0;
      if (!down || !(first < k && k <= last)) continue;
      this.#run(samples, k);
      this.dip();
    }
    this.#run(samples, last);
  }

  /** Prepare samples for interpolation by the kernels: time counts from the latest touch-down. */
  #samples(given: readonly DeviceSample[]): [Samples, BigInt64Array] {
    const { kernels } = this;
    const n = given.length;
    const path = objectPoses(kernels, given);
    const samples = {
      time: kernels.zeros("f8", n),
      position: kernels.zeros("f8", n, 3),
      velocity: kernels.zeros("f8", n, 3),
      orientation: kernels.zeros("f8", n, 4),
      pressure: path.pressures,
      joined: kernels.zeros("b1", n),
      on_surface: path.hasContact,
    };
    const timeNs = NDArray.of(kernels, "i8", BigInt64Array.from(given, (sample) => sample.timeNs));
    const origins = kernels.zeros("i8", n);
    kernels.call(
      "brush_engine.stroke_loop.prepare_samples",
      timeNs, this.#originNs, path.orientation, path.points, samples, origins,
    ); // prettier-ignore
    const since = origins.data.slice();
    for (const array of [path.orientation, path.points, timeNs, origins]) array.free();
    return [samples, since];
  }

  /** Run the stroke kernel up to sample `last`, growing the surface as often as it asks. */
  #run(samples: Samples, last: number): void {
    const { surface } = this;
    const isSmall = this.#scratch.found.ids.length !== surface.paintMesh.capacity + 1;
    if (isSmall || this.#scratch.part.length !== surface.pigments.length) this.#fitScratch();
    const brush = { tuft: this.tuft, curves: this.brush.curves, dragged: this.azimuth === "dragged" };
    for (;;) {
      const canvas: Argument = {
        tree: surface.contactTree, field: surface.paintMesh.arrays, ink: surface.ink,
      }; // prettier-ignore
      const given = [samples, last, brush, canvas, this.#progress, this.#scratch];
      const hairs = this.#hairs?.work(surface.ink);
      const state =
        hairs === undefined
          ? this.kernels.call("brush_engine.stroke_loop.paint_samples", ...given)
          : this.kernels.call("brush_engine.bristles.stroke_loop.paint_with_hairs", ...given, hairs);
      if (state === FINISHED) break;
      surface.makeRoom();
      this.#fitScratch();
    }
    surface.ink.transfer.field("capacity")[0] = this.tuft.load; // input curves may have changed it
  }

  #fitScratch(): void {
    const { paintMesh, pigments } = this.surface;
    this.#scratch = growScratch(this.kernels, this.#scratch, paintMesh, pigments.length);
  }
}

/** At which samples painting pauses for time steps of the ink, and for how many: `painter.ink_time`. */
function pausesOf(samples: readonly DeviceSample[], joined: Uint8Array): [number, number][] {
  const pauses: [number, number][] = [];
  let cameDown = 0;
  for (let k = 1; k < samples.length; k++) {
    if (joined[k] === 0) cameDown = k;
    const due = samples[k].timeNs / INK_STEP_NS - samples[k - 1].timeNs / INK_STEP_NS;
    if (due > 0n) pauses.push([Math.max(k - LOOKAHEAD, cameDown) - 1, Number(due)]);
  }
  return pauses;
}
