/**
 * Paint recordings and scores in Node, and print what came of it as JSON: what the tests compare with the
 * desktop's. `node replay.mjs FOLDER '{"recording": .., "object": .., "resolution": ..}' ...`
 */

import { Buffer } from "node:buffer";
import { createHash } from "node:crypto";
import { readFile, writeFile } from "node:fs/promises";
import { basename, join } from "node:path";
import process from "node:process";
import { gunzipSync } from "node:zlib";

import { Bundle } from "./core/bundle";
import type { KernelIndex } from "./core/kernels";
import { filled, MeshError } from "./files/mesh_error";
import { openOwnObject } from "./files/own_object";
import { readMesh } from "./files/reading";
import type { Wanted } from "./files/wanted";
import type { ObjectWords } from "./mesh/refined_mesh";
import { digestOf } from "./mesh/triangle_mesh";
import type { Vector } from "./core/quaternion";
import { dot, minus, times } from "./core/vectors";
import { decodeReport, findMouseLayout, MOUSE_AT_REST, type Collection } from "./device/six_dof";
import { deflection, quirksOf } from "./device/space_mouse";
import { Camera } from "./page/camera";
import { Document } from "./page/document";
import { FULL_DIP, type DipAmount } from "./brush/brush";
import { Painter } from "./painter/painter";
import { readRecording } from "./recording/recording";
import type { PaintedSurface } from "./surface/painted_surface";
import { Studio } from "./studio";

interface Asked {
  score?: string; // a whole painting, by a page
  mouse?: { collections: Collection[]; reports: [number, number[]][] }; // a 3-D mouse
  seconds?: number; // that it steers for at the last report's deflection
  own?: string; // a file that it is painted on
  wanted?: Wanted;
  recording: string;
  object: string;
  resolution: number;
  material?: string;
  brush: string;
  parts: Record<string, number>;
  azimuth?: "commanded" | "dragged";
  amount?: DipAmount;
  pickup?: number;
  save?: string; // a file for the codes, and after them the amounts
  wet?: number; // the ink spreads, and goes on for so many seconds
  live?: number; // samples handed over at once, as a hand does; a whole recording without
}

function sha(bytes: Uint8Array): string {
  return createHash("sha256").update(bytes).digest("hex");
}

/** Of what has dried: the vertices, and what they show. */
function dried({ dryLayers: { ids, count, spectra, amounts } }: PaintedSurface): string {
  const bytes = [ids.subarray(0, count), spectra.data.subarray(0, 31 * count), amounts].map(
    (array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength),
  );
  const n = count === 0 ? 0 : (amounts.length / ids.length) * count;
  return sha(Buffer.concat([bytes[0], bytes[1], bytes[2].subarray(0, 4 * n)]));
}

/** What a score gives. */
async function repeat(studio: Studio, path: string, own?: string, wanted?: Wanted): Promise<unknown> {
  const text = await readFile(path, "utf-8");
  const head = JSON.parse(text.slice(0, text.indexOf("\n"))) as Record<string, unknown>;
  const resolution = head.resolution_mm as number;
  const about = own === undefined
    ? studio.contents.objects.find((one) => one.name === head.object && one.resolution === resolution)
    : { name: head.object as string, chinese: "", resolution, material: "porcelain", file: "" };
  const ink = studio.contents.inks.find((one) => JSON.stringify(one.parts) === JSON.stringify(head.ink));
  if (about === undefined || ink === undefined) throw new Error(`${path}: the page has none of it`);
  const bundle = own === undefined ? null : await ownObject(own, resolution, wanted);
  const document = await Document.open(studio, about, head.brush as string, ink.name, head.material as string, bundle);
  await document.repeat(studio, text, () => {});
  return { ...hashes(document.surface), ledger: document.painter.ledger() };
}

/** A file's object, prepared as the page's worker does it. */
async function ownObject(path: string, resolution: number, wanted?: Wanted): Promise<Bundle<ObjectWords>> {
  const data = new Uint8Array(await readFile(path));
  const given = {
    wasm: await fetch("kernels.wasm"), index: JSON.parse(new TextDecoder().decode(await fetch("kernels.json"))) as KernelIndex,
    common: await fetch("common.bin.gz"), name: basename(path), data, resolution, wanted,
  }; // prettier-ignore
  const { words, arrays } = await openOwnObject(given, () => {});
  return Bundle.of(words, arrays, path);
}

/** What is read of a file, or why it cannot be. */
async function read(path: string, wanted?: Wanted): Promise<unknown> {
  try {
    const { mesh, notes } = await readMesh(basename(path), new Uint8Array(await readFile(path)), wanted);
    const bytes = (array: ArrayBufferView | null): string =>
      array === null ? "" : sha(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    return {
      vertices: bytes(mesh.vertices), faces: bytes(mesh.faces), colours: bytes(mesh.colours),
      normals: bytes(mesh.normals), digest: digestOf(mesh), notes: notes.map((note) => filled(note)),
    }; // prettier-ignore
  } catch (cause) {
    if (cause instanceof MeshError) return { refused: cause.message };
    throw cause;
  }
}

/** What a 3-D mouse's reports say, and where a camera sees some places before and after it has steered. */
function steer({ collections, reports }: NonNullable<Asked["mouse"]>, seconds: number): unknown {
  const layout = findMouseLayout(collections);
  let reading = MOUSE_AT_REST;
  const readings = reports.map(([id, bytes]) => {
    reading = decodeReport(layout, id, new DataView(Uint8Array.from(bytes).buffer), reading);
    return { ...reading, deflection: deflection(reading.axes, quirksOf(0, 0)) };
  });
  const camera = new Camera([1, 2, 3], 50.0, false, [[1, 2, 3], [20, 0, 0]]);
  const places: Vector[] = [[0, 0, 0], [30, 0, 0], [0, 30, 5]];
  const seen = (): number[][] => places.map((place) => camera.axes.map((axis) => dot(axis, minus(place, camera.eye))));
  const [axes, eye, before] = [camera.axes, camera.eye, seen()];
  const [x, y, z, rx, ry, rz] = readings[readings.length - 1].deflection;
  const [n, step] = [1000, seconds / 1000];
  for (let k = 0; k < n; k++) camera.steer(times([x, y, z], 150.0 * step), times([rx, ry, rz], 1.5 * step));
  return { readings, axes, eye, before, after: seen(), places };
}

function hashes(surface: PaintedSurface): Record<string, unknown> {
  const n = surface.nVertices;
  return {
    vertices: n,
    srgb: sha(surface.codes.bytes.subarray(0, 3 * n)),
    amounts: sha(surface.ink.amounts.bytes.subarray(0, 4 * n * surface.pigments.length)),
    coverage: sha(surface.ink.coverage.bytes.subarray(0, 4 * n)),
  };
}

async function paint(studio: Studio, asked: Asked): Promise<unknown> {
  if (asked.score !== undefined) return repeat(studio, asked.score, asked.own, asked.wanted);
  if (asked.mouse !== undefined) return steer(asked.mouse, asked.seconds ?? 0.0);
  if (asked.own !== undefined) return read(asked.own, asked.wanted);
  const surface = await studio.surface(asked.object, asked.resolution, asked.material);
  const painter = new Painter(
    studio.kernels, studio.sizes, surface, await studio.brush(asked.brush),
    studio.mixture(asked.parts), asked.azimuth, asked.amount ?? FULL_DIP, asked.pickup ?? null,
  ); // prettier-ignore
  const bytes = await readFile(asked.recording);
  const text = (bytes[0] === 0x1f ? gunzipSync(bytes) : bytes).toString("utf-8");
  const recording = readRecording(text, asked.recording);
  const began = performance.now();
  if (asked.live === undefined) {
    painter.replay(recording, asked.wet !== undefined);
    painter.rest(recording.samples[recording.samples.length - 1].timeNs, asked.wet ?? 0.0);
  }
  else {
    for (let k = 0; k < recording.samples.length; k += asked.live) {
      painter.advance(recording.samples.slice(k, k + asked.live));
      surface.refresh();
    }
    painter.finish();
  }
  surface.refresh();
  const seconds = (performance.now() - began) / 1000;
  const n = surface.nVertices;
  const count = surface.pigments.length;
  if (asked.save !== undefined) {
    const codes = surface.codes.bytes.subarray(0, 3 * n);
    await writeFile(asked.save, Buffer.concat([codes, surface.ink.amounts.bytes.subarray(0, 4 * n * count)]));
  }
  return {
    ...hashes(surface),
    ...(asked.wet === undefined ? {} : { dried: dried(surface) }),
    ledger: painter.ledger(),
    seconds,
  };
}

const [folder, ...cases] = process.argv.slice(2);
const fetch = async (name: string): Promise<ArrayBuffer> => {
  const bytes = await readFile(join(folder, name));
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) as ArrayBuffer;
};
const studio = await Studio.open(fetch);
for (const words of cases)
  process.stdout.write(`${JSON.stringify(await paint(studio, JSON.parse(words) as Asked))}\n`);
