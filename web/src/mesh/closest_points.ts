/** Closest points and ray hits on the object: `ClosestPoints` of `paint3d/mesh/bvh.py`. */

import { NDArray } from "../core/arrays";
import type { Bundle } from "../core/bundle";
import type { Kernels } from "../core/kernels";
import type { Vector } from "../core/quaternion";
import { readTree, type ContactTree, type ObjectWords } from "./refined_mesh";

/** A place on the surface. */
export interface Found {
  point: Vector;
  normal: Vector;
}

export class ClosestPoints {
  readonly tree: ContactTree;
  readonly #row: Record<string, NDArray<"f8">>;
  readonly #face: NDArray<"i8">;

  constructor(
    private readonly kernels: Kernels,
    object: Bundle<ObjectWords>,
  ) {
    this.tree = readTree(kernels, object, "closest");
    this.#row = {
      query: kernels.zeros("f8", 1, 3),
      point: kernels.zeros("f8", 1, 3),
      weights: kernels.zeros("f8", 1, 3),
      normal: kernels.zeros("f8", 1, 3),
      ray: kernels.zeros("f8", 1, 6),
      distance: kernels.zeros("f8", 1),
    };
    this.#face = kernels.zeros("i8", 1);
  }

  /** The closest point of the surface, and the normal there. */
  find(place: Vector): Found {
    const { query, point, weights, normal } = this.#row;
    query.data.set(place);
    this.kernels.call(
      "mesh.kernels.bvh.find_closest", this.tree, query, point, this.#face, weights, normal,
    ); // prettier-ignore
    return { point: vector(point.data), normal: vector(normal.data) };
  }

  /** The same of places (N, 3) at once. */
  findAll(places: Float64Array): Found[] {
    const { kernels } = this;
    const n = places.length / 3;
    const [query, point, weights, normal] = [NDArray.of(kernels, "f8", places, [n, 3]),
      ...[0, 1, 2].map(() => kernels.zeros("f8", n, 3))]; // prettier-ignore
    const face = kernels.zeros("i8", n);
    kernels.call("mesh.kernels.bvh.find_closest", this.tree, query, point, face, weights, normal);
    const rows = [point, normal].map((array) => array.data.slice());
    for (const array of [query, point, weights, normal, face]) array.free();
    return Array.from({ length: n }, (_, i) => ({
      point: vector(rows[0].subarray(3 * i, 3 * i + 3)), normal: vector(rows[1].subarray(3 * i, 3 * i + 3)),
    })); // prettier-ignore
  }

  /** Where a ray first meets the surface; null where it meets none. */
  cast(origin: Vector, direction: Vector): Found | null {
    const { ray, distance } = this.#row;
    ray.data.set([...origin, ...direction]);
    this.kernels.call("mesh.kernels.bvh.find_hits", this.tree, ray, distance, this.#face);
    const far = distance.data[0];
    if (!Number.isFinite(far)) return null;
    return this.find([
      origin[0] + far * direction[0],
      origin[1] + far * direction[1],
      origin[2] + far * direction[2],
    ]);
  }
}

function vector(row: Float64Array): Vector {
  return [row[0], row[1], row[2]];
}
