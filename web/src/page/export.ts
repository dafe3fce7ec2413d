/** The painted object as a file for other programs: GLB (glTF 2.0) and PLY. */

import type { PaintedSurface } from "../surface/painted_surface";

const MM = 1e-3; // glTF counts in m, y up

/** sRGB codes as linear light of 16 bits, which glTF wants of colours. */
const LINEAR = Uint16Array.from({ length: 256 }, (_, code) => {
  const c = code / 255.0;
  return Math.round(65535.0 * (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
});

/** Binary glTF: one mesh with normals and a colour at each vertex. */
export function glbOf(surface: PaintedSurface, name: string): Blob {
  surface.refresh();
  const n = surface.nVertices;
  const { px, py, pz, nx, ny, nz } = surface.paintMesh.arrays;
  const places = new Float32Array(3 * n);
  const normals = new Float32Array(3 * n);
  const colours = new Uint16Array(4 * n);
  const [x, y, z, u, v, w] = [px.data, py.data, pz.data, nx.data, ny.data, nz.data];
  const codes = surface.codes.data;
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < n; i++) {
    places.set([MM * x[i], MM * z[i], -MM * y[i]], 3 * i);
    const length = Math.hypot(u[i], v[i], w[i]) || 1.0;
    normals.set([u[i] / length, w[i] / length, -v[i] / length], 3 * i);
    for (let k = 0; k < 3; k++) {
      colours[4 * i + k] = LINEAR[codes[3 * i + k]];
      low[k] = Math.min(low[k], places[3 * i + k]);
      high[k] = Math.max(high[k], places[3 * i + k]);
    }
    colours[4 * i + 3] = 65535;
  }
  const parts = [places, normals, colours, Uint32Array.from(surface.paintMesh.leafFaces())];
  let size = 0;
  const views = parts.map((part, k) => {
    const view = { buffer: 0, byteOffset: size, byteLength: part.byteLength, target: k < 3 ? 34962 : 34963 };
    size += part.byteLength;
    return view;
  });
  const words = {
    asset: { version: "2.0", generator: "paint3d" },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0, name }],
    meshes: [{ name, primitives: [{ attributes: { POSITION: 0, NORMAL: 1, COLOR_0: 2 }, indices: 3, material: 0 }] }],
    materials: [
      {
        name: surface.material.name,
        doubleSided: true,
        pbrMetallicRoughness: { metallicFactor: 0, roughnessFactor: surface.material.seen_roughness },
      },
    ],
    buffers: [{ byteLength: size }],
    bufferViews: views,
    accessors: [
      { bufferView: 0, componentType: 5126, count: n, type: "VEC3", min: low, max: high },
      { bufferView: 1, componentType: 5126, count: n, type: "VEC3" },
      { bufferView: 2, componentType: 5123, normalized: true, count: n, type: "VEC4" },
      { bufferView: 3, componentType: 5125, count: parts[3].length, type: "SCALAR" },
    ],
  };
  const json = new TextEncoder().encode(JSON.stringify(words));
  const room = Math.ceil(json.length / 4) * 4;
  const head = new Uint32Array([0x46546c67, 2, 28 + room + size, room, 0x4e4f534a]);
  const padded = new Uint8Array(room).fill(0x20);
  padded.set(json);
  const body = new Uint32Array([size, 0x004e4942]);
  return new Blob([head, padded, body, ...parts], { type: "model/gltf-binary" });
}

/** Binary PLY, in mm, z up: places, normals and sRGB codes of the vertices, and triangles. */
export function plyOf(surface: PaintedSurface): Blob {
  surface.refresh();
  const n = surface.nVertices;
  const faces = surface.paintMesh.leafFaces();
  const axes = ["px", "py", "pz", "nx", "ny", "nz"].map(
    (name) => surface.paintMesh.arrays[name] as typeof surface.paintMesh.arrays.px,
  );
  const names = ["x", "y", "z", "nx", "ny", "nz"];
  const text = [
    "ply", "format binary_little_endian 1.0", `element vertex ${n}`,
    ...names.map((name) => `property float ${name}`),
    ...["red", "green", "blue"].map((name) => `property uchar ${name}`),
    `element face ${faces.length / 3}`, "property list uchar int vertex_indices", "end_header", "",
  ].join("\n"); // prettier-ignore
  const rows = new DataView(new ArrayBuffer(27 * n));
  const codes = surface.codes.data;
  const columns = axes.map((axis) => axis.data);
  for (let i = 0; i < n; i++) {
    for (let k = 0; k < 6; k++) rows.setFloat32(27 * i + 4 * k, columns[k][i], true);
    for (let k = 0; k < 3; k++) rows.setUint8(27 * i + 24 + k, codes[3 * i + k]);
  }
  const lists = new DataView(new ArrayBuffer((13 * faces.length) / 3));
  for (let f = 0; f < faces.length / 3; f++) {
    lists.setUint8(13 * f, 3);
    for (let k = 0; k < 3; k++) lists.setInt32(13 * f + 1 + 4 * k, faces[3 * f + k], true);
  }
  return new Blob([text, rows, lists], { type: "application/octet-stream" });
}
