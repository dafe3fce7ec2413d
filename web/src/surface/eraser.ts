/** A brush that takes dry paint off where it would have put ink: `paint3d/surface/eraser.py`. */

import type { Kernels } from "../core/kernels";
import type { PaintedSurface } from "./painted_surface";

const ALL = Math.fround(0.98); // covered share from which nothing is left

export class Eraser {
  #gone = new Float32Array(); // share of each vertex that has been erased

  /** Erase during one stroke; wet paint dries first. */
  constructor(
    private readonly kernels: Kernels,
    private readonly surface: PaintedSurface,
  ) {
    surface.dry();
  }

  /** Take off what lies where the brush has just been; how much ink is gone, coats x mm2. */
  wipe(): number {
    const { surface } = this;
    const count = surface.pigments.length;
    const { dirty_ids, n_dirty, amounts, coverage } = surface.ink;
    const [inks, covers] = [amounts.data, coverage.data];
    const ids = dirty_ids.data.slice(0, Number(n_dirty.data[0])).filter(
      (id) => covers[id] > 0.0 || inks.subarray(id * count, (id + 1) * count).some((own) => own !== 0.0),
    ); // prettier-ignore
    if (ids.length === 0) return 0.0;
    if (this.#gone.length < surface.nVertices) {
      const longer = new Float32Array(surface.paintMesh.capacity);
      longer.set(this.#gone);
      this.#gone = longer;
    }
    const gone = this.#gone;
    const covered = new Map(Array.from(ids, (id) => [id, covers[id] >= ALL ? 1.0 : covers[id]]));
    this.#takeBackInk(ids);
    const dry = surface.dryLayers;
    const less = ids.filter((id) => (covered.get(id) ?? 0.0) > gone[id] && dry.rowOf(id) >= 0);
    const { area_units: units, area_unit: unit } = surface.paintMesh.arrays;
    const lost: number[] = [];
    for (const id of less) {
      const now = covered.get(id) ?? 0.0;
      const stays = Math.fround(Math.fround(1.0 - now) / Math.fround(1.0 - gone[id]));
      gone[id] = now;
      lost.push(Number(units.data[id]) * unit * dry.fade(dry.rowOf(id), stays, surface.bareSteps(id)));
    }
    if (less.length > 0) dry.changes++;
    surface.touch(less);
    return exactSum(lost);
  }

  /** Have the brush hold again what it left on vertices. */
  #takeBackInk(ids: Int32Array): void {
    const { surface } = this;
    const { ink } = surface;
    const count = surface.pigments.length;
    const { area_units: units, area_unit: unit } = surface.paintMesh.arrays;
    const [areas, amounts, coverage] = [units.data, ink.amounts.data, ink.coverage.data];
    const caught = surface.pigments.map((_, p) =>
      exactSum(Array.from(ids, (id) => Number(areas[id]) * unit * amounts[id * count + p])),
    );
    for (const id of ids) {
      amounts.fill(0.0, id * count, (id + 1) * count);
      coverage[id] = 0.0;
    }
    const [load, off, reservoirs] = [ink.load.data, ink.off_surface.data, ink.reservoirs.data];
    const rows = ink.reservoirs.length;
    for (let p = 0; p < count; p++) {
      const wanted = load[p] + caught[p];
      const held = Math.max(wanted, 0.0);
      const isEmpty = load[p] <= 0.0 && held > 0.0;
      const share = load[p] > 0.0 ? held / load[p] : 0.0;
      for (let k = p; k < reservoirs.length; k += count)
        reservoirs[k] = isEmpty && rows > 1 ? held / rows : reservoirs[k] * share;
      load[p] = held;
      off[p] += wanted - held;
    }
    if (rows > 1) this.kernels.call("brush_engine.ink_transfer.level_reservoirs", ink.reservoirs);
  }
}

/** The sum of numbers, rounded once: Shewchuk's partial sums, as `math.fsum`. */
export function exactSum(values: readonly number[]): number {
  const parts: number[] = [];
  for (let x of values) {
    let n = 0;
    for (let y of parts) {
      if (Math.abs(x) < Math.abs(y)) [x, y] = [y, x];
      const high = x + y;
      const low = y - (high - x);
      if (low !== 0.0) parts[n++] = low;
      x = high;
    }
    parts.length = n;
    parts.push(x);
  }
  let n = parts.length - 1;
  if (n < 0) return 0.0;
  let high = parts[n];
  let low = 0.0;
  while (n > 0) {
    const [x, y] = [high, parts[--n]];
    high = x + y;
    low = y - (high - x);
    if (low !== 0.0) break;
  }
  // half way between two numbers: the parts below say to which
  if (n > 0 && ((low < 0.0 && parts[n - 1] < 0.0) || (low > 0.0 && parts[n - 1] > 0.0))) {
    const y = 2.0 * low;
    const x = high + y;
    if (y === x - high) high = x;
  }
  return high;
}
