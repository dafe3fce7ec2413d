/** The object to be painted: triangles in millimetres, checked once: `paint3d/mesh/triangle_mesh.py`. */

import { blake2b } from "@noble/hashes/blake2.js";

import { MeshError } from "../files/mesh_error";

const MOST_MM = 1e12; // a million km: larger sizes come from broken files

export interface TriangleMesh {
  name: string;
  vertices: Float32Array; // (V, 3) mm
  faces: Int32Array; // (F, 3)
  colours: Uint8Array | null; // (V, 3) sRGB
  normals: Float32Array | null; // (V, 3) unit, as the file gave them
}

/** A mesh of vertices (V, 3) in mm, or the error that says what is wrong with them. */
export function makeMesh(
  name: string, vertices: Float64Array, faces: Int32Array, colours: Uint8Array | null,
  normals: Float64Array | null,
): TriangleMesh {
  let largest = 0.0;
  for (const x of vertices) largest = Math.max(largest, Math.abs(x));
  if (largest > MOST_MM)
    throw new MeshError("a coordinate is {largest:g} mm; expected at most {most:g} mm", { largest, most: MOST_MM });
  if (faces.length === 0) throw new MeshError("no faces; expected at least one triangle");
  return {
    name, faces, colours,
    vertices: Float32Array.from(vertices),
    normals: normals === null ? null : Float32Array.from(normals),
  }; // prettier-ignore
}

/** 16 hexadecimal digits that tell meshes of one name apart: a hash of their arrays. */
export function digestOf(mesh: TriangleMesh): string {
  const digest = blake2b.create({ dkLen: 8 });
  for (const array of [mesh.vertices, mesh.faces, mesh.normals])
    digest.update(
      array === null ? new TextEncoder().encode("none") : new Uint8Array(array.buffer, array.byteOffset, array.byteLength),
    );
  return Array.from(digest.digest(), (byte) => byte.toString(16).padStart(2, "0")).join("");
}
