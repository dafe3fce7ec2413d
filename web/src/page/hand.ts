/**
 * From a pointer over a picture of the object to a brush standing on it: `Hand` of
 * `paint3d/app/model/input/hand.py`, for pens, fingers and mice.
 *
 * Where the pointer's ray meets the object is what every sample says as its contact: the middle of
 * the footprint comes to lie there, however the pen leans. A stroke waits until it is known whither
 * it goes, so that the tuft comes down trailing and need not turn round.
 */

import { NDArray } from "../core/arrays";
import type { Kernels } from "../core/kernels";
import { fromAxes, type Vector } from "../core/quaternion";
import { cross, dot, lengthOf, minus, plus, times, turned, unit } from "../core/vectors";
import type { Brush } from "../brush/brush";
import type { Sizes } from "../brush_engine/scratch";
import type { ClosestPoints, Found } from "../mesh/closest_points";
import { AT_REST, type DeviceSample } from "../recording/recording";

const MOST_LEAN = (60.0 * Math.PI) / 180.0;
const STEEPEST_TILT = 85.0; // degrees that a tablet may say
const LEANS = Math.sin((5.0 * Math.PI) / 180.0); // more, and the tip is on the other side
const TRAIL = 0.12; // of the tuft's length: how far its tip trails behind the brush
const SURE = 0.3; // of the trail: a way that tells whither a stroke goes
const LEAST_SURE = 0.15; // the same, if need be
const STANDS_NS = 150_000_000n; // after which a brush that does not move comes down as it is
const STEP_NS = 1_000_000n;
const LANDING_S = 0.06; // over which the pressure of a device that has none rises
const STEADY_MM_S = 150.0; // at which it has fallen to a half
const FILTER_S = 0.03; // over which the pointer's speed is taken
const UNDER = 0.07; // of the tuft's length: half a footprint, about
const SUNK = 0.35; // of that: how far under the surface its rim is looked for
const OTHER_SIDE = -0.5; // cosine to the normal: what faces farther away is a wall's other side
const LEAST_GAP_MM = 3.0;
const MOST_OFF = 0.2; // of the way between two events
const PLACES_BETWEEN = [0.25, 0.5, 0.75];

/** What a pointer said at one instant; vectors in the object's frame. */
export interface PointerInput {
  timeNs: bigint;
  origin: Vector; // of the ray through it
  direction: Vector;
  right: Vector; // the picture's axes, which tilt is counted by
  up: Vector;
  pressure: number | null; // 0 to 1; null where the device has none
  xTilt: number; // degrees that the pen leans to the right
  yTilt: number; // and towards the user
}

interface State {
  timeNs: bigint;
  target: Vector; // where the pointer is, on the surface
  tip: Vector; // where the tuft's tip trails
  point: Vector; // where the brush is
  beganNs: bigint | null;
  sentNs: bigint;
  beside: boolean;
  speed: number;
}

/** Where the brush is at one instant, but for whither its tip trails. */
interface Stand {
  timeNs: bigint;
  point: Vector;
  normal: Vector;
  lean: Vector; // unit, up the handle
  rest: Vector; // whither a tip points that nothing drags
  pressure: number;
}

/** How hard a pen or a made pressure presses; 1: as it says. */
export interface HandSettings {
  firmness: number;
  mousePressure: number; // of a device that has none, 0 to 1
}

export class Hand {
  #state: State | null = null;
  #waiting: Stand[] = [];
  #last: Stand | null = null;
  readonly #outline: { [name: string]: NDArray<"f8"> };

  constructor(
    private readonly kernels: Kernels,
    sizes: Sizes,
    private readonly surface: ClosestPoints,
    readonly settings: HandSettings,
  ) {
    this.#outline = {
      scratch: kernels.zeros("f8", sizes.tuft_scratch),
      reach: kernels.zeros("f8", sizes.outline),
      half: kernels.zeros("f8", sizes.outline),
    };
  }

  /** The brush comes down; null where the pointer is beside the object. */
  begin(event: PointerInput, brush: Brush): DeviceSample[] | null {
    const found = this.surface.cast(event.origin, event.direction);
    if (found === null) return null;
    const stand = this.#follow(event, found, brush, false);
    const state = this.#now();
    Object.assign(state, { beganNs: event.timeNs, sentNs: event.timeNs, beside: false, speed: 0.0 });
    this.#waiting = [{ ...stand, timeNs: stand.timeNs - STEP_NS }];
    const pressure = this.#pressure(event);
    if (pressure > 0.0) this.#waiting.push({ ...stand, pressure });
    return this.#ready(brush);
  }

  /** The pointer went on. */
  move(event: PointerInput, brush: Brush): DeviceSample[] {
    const state = this.#state;
    if (state === null || state.beganNs === null || event.timeNs <= state.sentNs) return [];
    const found = this.surface.cast(event.origin, event.direction);
    if (found === null) {
      state.beside = true;
      return [];
    }
    if (state.beside || this.#isApart(found.point)) {
      const lifted = this.end(state.sentNs, brush);
      const last = lifted[lifted.length - 1].timeNs + 2n * STEP_NS;
      const timeNs = event.timeNs > last ? event.timeNs : last;
      return [...lifted, ...(this.begin({ ...event, timeNs }, brush) ?? [])];
    }
    const stand = this.#follow(event, found, brush, true);
    state.sentNs = event.timeNs;
    if (this.#waiting.length === 0) {
      this.#drag(stand, brush);
      return [this.#sample(stand, brush)];
    }
    this.#waiting.push(stand);
    return this.#ready(brush);
  }

  /** The brush goes up. */
  end(timeNs: bigint, brush: Brush): DeviceSample[] {
    const state = this.#state;
    if (state === null || state.beganNs === null) return [];
    const samples = this.#land(brush);
    state.beganNs = null;
    const least = state.sentNs + STEP_NS;
    const lifted = { ...this.#latest(), timeNs: timeNs > least ? timeNs : least, pressure: 0.0 };
    state.sentNs = lifted.timeNs;
    return [...samples, this.#sample(lifted, brush)];
  }

  #now(): State {
    if (this.#state === null) throw new Error("the pointer has not been over the object");
    return this.#state;
  }

  #latest(): Stand {
    if (this.#last === null) throw new Error("no stroke goes on");
    return this.#last;
  }

  /** Whether the way to a point leaves the surface, as from a rim to what is behind it. */
  #isApart(point: Vector): boolean {
    const from = this.#now().target;
    const way = minus(point, from);
    const distance = lengthOf(way);
    if (distance < LEAST_GAP_MM) return false;
    return PLACES_BETWEEN.some((share) => {
      const between = plus(from, times(way, share));
      return lengthOf(minus(this.surface.find(between).point, between)) > MOST_OFF * distance;
    });
  }

  #follow(event: PointerInput, found: Found, brush: Brush, pressed: boolean): Stand {
    const { point } = found;
    this.#state ??= {
      timeNs: event.timeNs, target: point, tip: plus(point, anyTangent(found.normal, [0, 0, 0])),
      point, beganNs: null, sentNs: 0n, beside: false, speed: 0.0,
    }; // prettier-ignore
    const state = this.#state;
    const seconds = Number(event.timeNs - state.timeNs) * 1e-9;
    if (seconds > 0.0) {
      const now = lengthOf(minus(point, state.target)) / seconds;
      state.speed += (1.0 - Math.exp(-seconds / FILTER_S)) * (now - state.speed);
    }
    Object.assign(state, { timeNs: event.timeNs, target: point, point });
    const normal = this.#normalUnder(found, brush);
    const lean = leanOf(normal, event);
    const aside = minus(lean, times(normal, dot(lean, normal)));
    const rest =
      lengthOf(aside) > LEANS
        ? anyTangent(normal, times(aside, -1.0))
        : anyTangent(normal, minus(event.up, event.right));
    const pressure = pressed ? this.#pressure(event) : 0.0;
    return { timeNs: event.timeNs, point, normal, lean, rest, pressure };
  }

  #pressure(event: PointerInput): number {
    if (event.pressure !== null) return Math.min(1.0, event.pressure * this.settings.firmness);
    const state = this.#now();
    let pressure = this.settings.mousePressure / (1.0 + state.speed / STEADY_MM_S);
    const since = Number(event.timeNs - (state.beganNs ?? event.timeNs)) * 1e-9;
    if (since < LANDING_S) pressure *= since / LANDING_S;
    return pressure;
  }

  /** What waits, if it need not wait any longer. */
  #ready(brush: Brush): DeviceSample[] {
    const [first, last] = [this.#waiting[0], this.#waiting[this.#waiting.length - 1]];
    const far = lengthOf(minus(last.point, first.point)) >= SURE * TRAIL * brush.lengthMm;
    return far || last.timeNs - first.timeNs >= STANDS_NS ? this.#land(brush) : [];
  }

  /** Samples of all that waited; the tip trails behind the way, or points as it rests. */
  #land(brush: Brush): DeviceSample[] {
    const stands = this.#waiting;
    this.#waiting = [];
    if (stands.length === 0) return [];
    const first = stands[0];
    const trail = TRAIL * brush.lengthMm;
    const way = minus(stands[stands.length - 1].point, first.point);
    const moved = lengthOf(way) >= LEAST_SURE * trail;
    const back = moved ? anyTangent(first.normal, times(way, -1.0)) : first.rest;
    this.#now().tip = plus(first.point, times(back, trail));
    this.#last = first;
    return stands.map((stand) => {
      this.#drag(stand, brush);
      return this.#sample(stand, brush);
    });
  }

  /** Bring the brush to its place; its tip is dragged along the surface behind it. */
  #drag(stand: Stand, brush: Brush): void {
    const [state, last, trail] = [this.#now(), this.#latest(), TRAIL * brush.lengthMm];
    let back = turnedWith(last.normal, stand.normal, minus(state.tip, last.point));
    const way = minus(stand.point, last.point);
    const across = minus(way, times(stand.normal, dot(way, stand.normal)));
    const length = lengthOf(across);
    if (length > 1e-9) back = minus(back, times(across, lengthOf(way) / length));
    back = minus(back, times(stand.normal, dot(back, stand.normal)));
    const distance = lengthOf(back);
    if (distance < 1e-9) back = times(stand.rest, trail);
    else if (distance > trail) back = times(back, trail / distance);
    state.tip = plus(stand.point, back);
    this.#last = stand;
  }

  /** The mean normal under a footprint: over a crease the handle turns by and by. */
  #normalUnder({ point, normal }: Found, brush: Brush): Vector {
    const ahead = anyTangent(normal, [1.0, 0.0, 0.0]);
    const aside = cross(normal, ahead);
    let mean = times(normal, 2.0);
    for (let k = 0; k < 8; k++) {
      const angle = 0.25 * Math.PI * k;
      const rim = plus(times(ahead, Math.cos(angle)), times(aside, Math.sin(angle)));
      const place = times(minus(rim, times(normal, SUNK)), UNDER * brush.lengthMm);
      const found = this.surface.find(plus(point, place)).normal;
      if (dot(found, normal) > OTHER_SIDE) mean = plus(mean, found);
    }
    return unit(mean);
  }

  #sample(stand: Stand, brush: Brush): DeviceSample {
    const { normal, point, pressure } = stand;
    const z = heldOver(stand.lean, normal);
    const bend = anyTangent(normal, minus(this.#now().tip, point));
    const x = unit(minus(bend, times(normal, dot(bend, z) / dot(normal, z))));
    return {
      timeNs: stand.timeNs,
      position: this.#rootOver(brush, point, normal, bend, z, pressure),
      orientation: fromAxes(x, cross(z, x), z),
      pressure,
      buttons: 0,
      objectPosition: AT_REST.position,
      objectOrientation: AT_REST.orientation,
      contact: point,
    };
  }

  /** Where the tuft's root is when the middle of its footprint lies at a place. */
  #rootOver(
    brush: Brush, place: Vector, normal: Vector, bend: Vector, handle: Vector, pressure: number,
  ): Vector {
    if (pressure <= 0.0) return plus(place, times(handle, brush.lengthMm));
    const [upright, ahead] = [dot(handle, normal), dot(handle, bend)];
    const tilt = Math.acos(Math.min(1.0, Math.max(0.0, -ahead)));
    const tuft = brush.tuft;
    const deepest = this.kernels.call(
      "brush_engine.tuft.greatest_descent", tuft, Math.max(tilt, tuft.lowest_tilt),
    ) as number; // prettier-ignore
    const descent = Math.min(pressure * tuft.full_press, deepest);
    const { scratch, reach, half } = this.#outline;
    const n = this.kernels.call(
      "brush_engine.outline.trace_outline", tuft, descent, tilt, pressure, scratch, reach, half,
    ) as number; // prettier-ignore
    const middle = n > 0 ? 0.5 * (reach.data[0] + reach.data[n - 1]) : 0.0;
    const foot = minus(place, times(bend, middle));
    const height = Math.max(0.0, brush.lengthMm * upright - descent);
    const aside = minus(
      minus(handle, times(normal, upright)),
      times(bend, Math.min(0.0, ahead)),
    ); // what is no lean along the bend
    return plus(plus(foot, times(normal, height)), times(aside, brush.lengthMm));
  }
}

/** Up the handle: the surface's normal, leaned over as the pen leans in the picture. */
export function leanOf(
  normal: Vector, { right, up, xTilt, yTilt }: Pick<PointerInput, "right" | "up" | "xTilt" | "yTilt">,
): Vector {
  if (xTilt === 0 && yTilt === 0) return normal;
  const [x, y] = [xTilt, yTilt].map((tilt) =>
    Math.tan((Math.min(Math.max(tilt, -STEEPEST_TILT), STEEPEST_TILT) * Math.PI) / 180.0),
  );
  let aside = minus(times(right, x), times(up, y));
  aside = minus(aside, times(normal, dot(aside, normal)));
  const length = lengthOf(aside);
  if (length < 1e-9) return normal;
  const angle = Math.min(Math.atan(length), MOST_LEAN);
  return plus(times(normal, Math.cos(angle)), times(aside, Math.sin(angle) / length));
}

/** A handle's direction, where it is farther than 60 degrees from a normal turned towards it. */
function heldOver(lean: Vector, normal: Vector): Vector {
  if (dot(lean, normal) >= Math.cos(MOST_LEAN) - 1e-9) return lean;
  return turned(normal, unit(cross(normal, lean)), MOST_LEAN);
}

/** A vector that is turned as one normal turns into another, the shortest way. */
function turnedWith(before: Vector, after: Vector, vector: Vector): Vector {
  const both = plus(before, after);
  const fraction = 0.5 * dot(both, both); // 1 + the cosine between them
  if (fraction < 1e-9) return vector;
  return plus(
    minus(vector, times(both, dot(both, vector) / fraction)),
    times(after, 2.0 * dot(before, vector)),
  );
}

/** The unit vector across the normal that is nearest to the wanted one. */
function anyTangent(normal: Vector, wanted: Vector): Vector {
  for (const candidate of [wanted, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] as Vector[]) {
    const across = minus(candidate, times(normal, dot(candidate, normal)));
    const length = lengthOf(across);
    if (length > 1e-9 * Math.max(1.0, lengthOf(candidate))) return times(across, 1.0 / length);
  }
  return [0.0, 0.0, 1.0];
}
