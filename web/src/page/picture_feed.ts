/** What has changed of a painting since it was last shown, in arrays that can be handed to another thread. */

import type { NDArray } from "../core/arrays";
import type { Document } from "./document";

export const AXES = ["px", "py", "pz", "nx", "ny", "nz"] as const;

/** Vertices that came, colours that changed, and triangles, where there are others. */
export interface PictureChange {
  capacity: number; // of vertices; another one than before: all of them come
  first: number; // of the vertices that came
  axes: Float32Array[]; // of these: places and normals, by `AXES`
  openness: Uint8Array; // of these: how much of the sky each sees
  bare: Uint8Array; // of these: their codes without paint
  low: number; // of the vertices whose colours come
  codes: Uint8Array; // of these
  faces: Int32Array | null;
}

export class PictureFeed {
  #capacity = 0;
  #known = 0; // vertices that were handed out
  #nodes = -1;
  #openness = new Uint8Array();

  constructor(private readonly document: Document) {}

  /** Nothing is known any more of what was handed out. */
  forget(): void {
    this.#capacity = this.#known = 0;
    this.#nodes = -1;
  }

  /** What has changed since this was last asked. */
  change(): PictureChange {
    const { surface } = this.document;
    let [low, high] = surface.takeChanged();
    const { paintMesh: mesh, codes } = surface;
    const field = mesh.arrays;
    if (mesh.capacity !== this.#capacity) {
      this.forget();
      this.#capacity = mesh.capacity;
    }
    const [first, n] = [this.#known, mesh.nVertices];
    this.#known = n;
    this.#letLightIn(n);
    if (n > first) [low, high] = [Math.min(low, first), n];
    const nodes = mesh.refines ? Number(field.counts.data[1]) : 0;
    const isRefined = nodes !== this.#nodes;
    this.#nodes = nodes;
    return {
      capacity: mesh.capacity,
      first,
      axes: AXES.map((name) => field[name].data.slice(first, n)),
      openness: this.#openness.slice(first, n),
      bare: surface.bareCodes(first, n),
      low: Math.min(low, n),
      codes: high > low ? codes.data.slice(3 * low, 3 * high) : new Uint8Array(),
      faces: isRefined ? mesh.leafFaces().slice() : null,
    };
  }

  /** How open new vertices are: as the ends of the edges that they halve. */
  #letLightIn(n: number): void {
    const before = this.#openness.length;
    if (n <= before) return;
    const { openness, surface } = this.document;
    const larger = new Uint8Array(n);
    larger.set(this.#openness);
    const parents = (surface.paintMesh.arrays.parents as NDArray<"i4">).data;
    for (let id = before; id < n; id++)
      larger[id] = id < openness.length ? openness[id] : (larger[parents[2 * id]] + larger[parents[2 * id + 1]]) >> 1;
    this.#openness = larger;
  }
}

/** The buffers of a change, to be handed over rather than copied. */
export function buffersOf({ axes, openness, bare, codes, faces }: PictureChange): ArrayBuffer[] {
  return [...axes, openness, bare, codes, ...(faces === null ? [] : [faces])].map(({ buffer }) => buffer as ArrayBuffer);
}
