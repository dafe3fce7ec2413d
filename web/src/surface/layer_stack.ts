/**
 * Layers as in a paint program: `LayerStack` of `paint3d/surface/layer_stack.py`. The active one has
 * its ink in the surface's own arrays; of the others what was painted is stored.
 */

import { NDArray } from "../core/arrays";
import type { Kernels } from "../core/kernels";
import type { GlazeModel } from "../colour/glazing";
import { roundHalfToEven } from "../core/numbers";
import { DryLayers, SPECTRUM_STEPS, widened, type KeptRows } from "./dry_layers";
import type { KeptFlow } from "./flow";
import { distinct } from "./flow_graph";
import type { PaintedSurface } from "./painted_surface";

const BANDS = 31;
const AT_ONCE = 1 << 16; // vertices

/** What is said of a layer. */
export interface Layer {
  name: string;
  visible: boolean;
  opacity: number;
  blend: Blend;
}

/** How a layer lies on those below it. */
export type Blend = "normal" | "multiply";

/** Paint of a layer that rests; it does not change, but for `dry` once the layer is painted on again. */
interface Content {
  dry: DryLayers;
  rows: KeptRows;
  wet: Map<number, number>; // of vertices with wet ink: their places in the next two
  amounts: Float32Array;
  coverage: Float32Array;
  nPigments: number;
  flow: KeptFlow | null;
  isUsed: boolean; // `dry` is not what it was
}

/** The stack at an instant, for undo. */
export interface KeptStack {
  keys: number[];
  active: number;
  about: Map<number, Layer>;
  contents: Map<number, Content>;
}

export class LayerStack {
  #about = new Map<number, Layer>([[0, freshLayer("1")]]);
  #contents = new Map<number, Content>();
  #keys = [0];
  #active = 0;
  #next = 1;

  constructor(
    private readonly kernels: Kernels,
    private readonly surface: PaintedSurface,
  ) {}

  /** What is said of each, the lowest first. */
  get layers(): Layer[] {
    return this.#keys.map((key) => this.#said(key));
  }

  /** What each is known by, the lowest first. */
  get keys(): number[] {
    return [...this.#keys];
  }

  /** Place of the active one. */
  get active(): number {
    return this.#keys.indexOf(this.#active);
  }

  /** Whether there is one, which shows as it was painted. */
  get isPlain(): boolean {
    const { visible, opacity, blend } = this.#said(this.#active);
    return this.#keys.length === 1 && visible && opacity === 1.0 && blend === "normal";
  }

  #said(key: number): Layer {
    const layer = this.#about.get(key);
    if (layer === undefined) throw new RangeError(`there is no layer ${key}`);
    return layer;
  }

  /** Put an empty layer above the active one and paint on it. */
  add(): void {
    const names = new Set(this.layers.map(({ name }) => name));
    let number = 1;
    while (names.has(String(number))) number++;
    const key = this.#next++;
    const place = this.active + 1;
    this.#about.set(key, freshLayer(String(number)));
    const dry = this.#freshDry();
    this.#contents.set(key, {
      dry, rows: dry.keep(), wet: new Map(), amounts: new Float32Array(0),
      coverage: new Float32Array(0), nPigments: this.surface.pigments.length, flow: null, isUsed: false,
    }); // prettier-ignore
    this.#keys.splice(place, 0, key);
    this.activate(place);
  }

  #freshDry(): DryLayers {
    const dry = new DryLayers(this.kernels, true);
    dry.fit(this.surface.paintMesh.capacity, this.surface.pigments.length);
    return dry;
  }

  remove(place: number): void {
    const key = this.#keys[place];
    if (key === this.#active) this.activate(place > 0 ? place - 1 : 1);
    this.#keys.splice(this.#keys.indexOf(key), 1);
  }

  move(place: number, to: number): void {
    const [key] = this.#keys.splice(place, 1);
    this.#keys.splice(to, 0, key);
  }

  setProperties(place: number, changes: Partial<Layer>): void {
    const key = this.#keys[place];
    this.#about.set(key, { ...this.#said(key), ...changes });
  }

  /** Paint on another layer; nothing visible changes. */
  activate(place: number): void {
    const key = this.#keys[place];
    if (key === this.#active) return;
    this.#contents.set(this.#active, this.#unload());
    this.#active = key;
    const content = this.#contents.get(key);
    this.#contents.delete(key);
    if (content !== undefined) this.#load(content);
  }

  /** Take the active layer's paint out of the surface's arrays. */
  #unload(): Content {
    const { surface } = this;
    const count = surface.pigments.length;
    const ids = surface.inked();
    const [amounts, coverage] = [surface.ink.amounts.data, surface.ink.coverage.data];
    const own = new Float32Array(ids.length * count);
    const covered = new Float32Array(ids.length);
    const wet = new Map<number, number>();
    for (const [k, id] of ids.entries()) {
      own.set(amounts.subarray(id * count, (id + 1) * count), k * count);
      covered[k] = coverage[id];
      wet.set(id, k);
    }
    const flow = surface.water.keep();
    for (const id of ids) {
      surface.ink.amounts.data.fill(0.0, id * count, (id + 1) * count);
      surface.ink.coverage.data[id] = 0.0;
    }
    surface.water.drop();
    const dry = surface.dryLayers;
    return {
      dry, rows: dry.keep(), wet, amounts: own, coverage: covered, nPigments: count, flow,
      isUsed: false,
    }; // prettier-ignore
  }

  /** Put a resting layer's paint into them. */
  #load(content: Content): void {
    const { surface } = this;
    const count = surface.pigments.length;
    const amounts = widened(content.amounts, content.nPigments, count);
    for (const [id, k] of content.wet) {
      surface.ink.amounts.data.set(amounts.subarray(k * count, (k + 1) * count), id * count);
      surface.ink.coverage.data[id] = content.coverage[k];
    }
    surface.dryLayers = this.#dryOf(content);
    content.isUsed = true;
    surface.dryLayers.fit(surface.paintMesh.capacity, count);
    if (content.flow !== null) surface.water.restore(content.flow);
  }

  /** Its dried rows as they were when it came to rest. */
  #dryOf(content: Content): DryLayers {
    if (!content.isUsed) return content.dry;
    const dry = this.#freshDry();
    dry.restore(content.rows, this.surface.paintMesh.capacity);
    return dry;
  }

  keep(): KeptStack {
    return {
      keys: [...this.#keys], active: this.#active,
      about: new Map(this.#about), contents: new Map(this.#contents),
    }; // prettier-ignore
  }

  /**
   * Return to a stack that was kept; the active layer's paint is the surface's to restore. Names, and
   * what is hidden, are no steps: they stay.
   */
  restore(kept: KeptStack): void {
    for (const key of kept.keys) {
      const { opacity, blend } = kept.about.get(key) as Layer;
      this.#about.set(key, { ...this.#said(key), opacity, blend });
    }
    this.#keys = [...kept.keys];
    this.#active = kept.active;
    this.#contents = new Map(
      Array.from(kept.contents, ([key, content]) => [
        key,
        content.isUsed ? { ...content, dry: this.#dryOf(content), isUsed: false } : content,
      ]),
    );
  }

  // -- compositing ------------------------------------------------------------------------------

  /** Fill the codes of some distinct vertices. */
  colour(glaze: GlazeModel, vertexIds: Int32Array, codes: NDArray<"u1">): void {
    const { kernels, surface } = this;
    const count = surface.pigments.length;
    for (let start = 0; start < vertexIds.length; start += AT_ONCE) {
      const ids = vertexIds.slice(start, start + AT_ONCE);
      const n = ids.length;
      const spectra = kernels.zeros("u2", n, BANDS);
      for (let k = 0; k < n; k++) spectra.data.set(surface.bareSteps(ids[k]), BANDS * k);
      for (const key of this.#keys) if (this.#said(key).visible) this.#layOver(glaze, key, ids, spectra);
      const every = NDArray.of(kernels, "i4", ids.map((_, k) => k));
      const [noInk, none] = [kernels.zeros("f4", n, count), kernels.zeros("f4", n)];
      const out = kernels.zeros("u1", n, 3);
      glaze.srgb(noInk, none, { slots: every, spectra }, out, every);
      const [from, to] = [out.data, codes.data];
      for (const [k, id] of ids.entries()) to.set(from.subarray(3 * k, 3 * k + 3), 3 * id);
      for (const array of [spectra, every, noInk, none, out]) array.free();
    }
  }

  #layOver(glaze: GlazeModel, key: number, ids: Int32Array, spectra: NDArray<"u2">): void {
    const { opacity, blend } = this.#said(key);
    if (opacity === 1.0 && blend === "normal") return this.#layPlainly(glaze, key, ids, spectra);
    const below = spectra.data.slice();
    if (blend === "multiply") spectra.data.fill(SPECTRUM_STEPS);
    this.#layPlainly(glaze, key, ids, spectra);
    const shown = spectra.data;
    for (let k = 0; k < below.length; k++) {
      const above = blend === "multiply" ? shown[k] * (below[k] / SPECTRUM_STEPS) : shown[k];
      shown[k] = roundHalfToEven(below[k] + opacity * (above - below[k]));
    }
  }

  #layPlainly(glaze: GlazeModel, key: number, ids: Int32Array, spectra: NDArray<"u2">): void {
    const { kernels, surface } = this;
    const count = surface.pigments.length;
    const content = key === this.#active ? null : this.#contents.get(key);
    if (content === undefined) return;
    const dry = content === null ? surface.dryLayers : content.dry;
    const dried = [...ids.keys()].filter((k) => dry.rowOf(ids[k]) >= 0);
    if (dried.length > 0) {
      const places = NDArray.of(kernels, "i4", dried);
      const rows = NDArray.of(kernels, "i4", dried.map((k) => dry.rowOf(ids[k])));
      kernels.call("colour.kernels.glazing.see_through", places, rows, ...dry.over, spectra);
      places.free();
      rows.free();
    }
    const [amounts, coverage] =
      content === null
        ? [surface.ink.amounts.data, surface.ink.coverage.data]
        : [widened(content.amounts, content.nPigments, count), content.coverage];
    const placeOf = (id: number): number => (content === null ? id : (content.wet.get(id) ?? -1));
    const wet = [...ids.keys()].filter((k) => {
      const place = placeOf(ids[k]);
      return place >= 0 && (content !== null || coverage[place] > 0.0);
    });
    if (wet.length === 0) return;
    const own = new Float32Array(wet.length * count);
    const covered = new Float32Array(wet.length);
    for (const [j, k] of wet.entries()) {
      const place = placeOf(ids[k]);
      own.set(amounts.subarray(place * count, (place + 1) * count), j * count);
      covered[j] = coverage[place];
    }
    const given = {
      own: NDArray.of(kernels, "f4", own, [wet.length, count]),
      covered: NDArray.of(kernels, "f4", covered),
      every: NDArray.of(kernels, "i4", wet.map((_, j) => j)),
      wet: NDArray.of(kernels, "i4", wet),
    };
    glaze.dry(given.own, given.covered, { slots: given.wet, spectra }, given.every, given.wet);
    for (const array of Object.values(given)) array.free();
  }

  /** The vertices with paint on any layer. */
  paintedIds(): Int32Array {
    const { dryLayers: dry } = this.surface;
    const found = [...this.surface.inked(), ...dry.ids.subarray(0, dry.count)];
    for (const key of this.#keys) {
      const content = this.#contents.get(key);
      if (key !== this.#active && content !== undefined)
        for (const id of [...content.wet.keys(), ...content.rows.ids]) found.push(id);
    }
    return distinct(found);
  }
}

function freshLayer(name: string): Layer {
  return { name, visible: true, opacity: 1.0, blend: "normal" };
}
