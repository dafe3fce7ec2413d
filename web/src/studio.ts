/** What Python has made of colours, brushes and objects, opened by name (`paint3d/page`). */

import { NDArray } from "./core/arrays";
import { Bundle } from "./core/bundle";
import { Kernels, type KernelIndex } from "./core/kernels";
import { Brush, type BrushWords } from "./brush/brush";
import type { Sizes } from "./brush_engine/scratch";
import type { Material, Pigment } from "./colour/materials";
import type { Backing, ColourTables } from "./colour/vertex_colours";
import type { Preparing } from "./mesh/base_surface";
import { PaintMesh, readTree, type ObjectWords } from "./mesh/refined_mesh";
import type { CopybookContents, LaidOut } from "./page/copybook";
import type { Ink } from "./painter/painter";
import { PaintedSurface } from "./surface/painted_surface";

/** The score of the painting that a page of one file carries. */
export const SCORE = "painting.score.jsonl";

/** What there is, by name: `contents.json`. */
export interface Contents {
  version: string;
  objects: { name: string; chinese: string; resolution: number; material: string; file: string; texts?: LaidOut[] }[];
  brushes: { name: string; chinese: string; file: string }[];
  inks: { name: string; chinese: string; parts: Record<string, number>; srgb: number[] }[];
  materials: { name: string; chinese: string; file: string }[];
  copybook?: CopybookContents;
  seals?: { file: string }; // lines that they are cut from
  hosted?: boolean; // what shows the page in a frame keeps the piece
  painting?: { title: string; id: string }; // that a page of one file shows first: `SCORE`
}

/** What lies below the ink: a material, and its tables. */
export interface Ground {
  material: Material;
  bare: Uint8Array;
  backing: Backing;
}

export interface StudioWords {
  sizes: Sizes;
  preparing: Preparing;
  saunderson: [number, number];
  pigments: Omit<Pigment, "K" | "S">[];
}

/** Reads a file of the folder that `paint3d page build` wrote. */
export type Fetch = (name: string) => Promise<ArrayBuffer>;

/** A name that the folder does not hold. */
export class UnknownNameError extends Error {
  override name = "UnknownNameError";

  constructor(
    readonly kind: "brush" | "ink" | "material" | "object" | "pigment",
    readonly unknown: string,
    known: string[] = [],
  ) {
    super(`no ${kind} is called ${unknown}${known.length > 0 ? `; expected ${known.join(", ")}` : ""}`);
  }
}

export class Studio {
  readonly noise: NDArray<"i1">;
  readonly bundles: NDArray<"i4">;
  readonly colourTables: ColourTables;
  readonly sizes: Sizes;
  readonly fibreFrames: Float64Array;
  readonly decodedCodes: Float32Array; // linear light of every sRGB code
  readonly #pigments: Map<string, Pigment>;
  readonly #brushes = new Map<string, Promise<Brush>>();

  private constructor(
    readonly kernels: Kernels,
    readonly contents: Contents,
    readonly fetch: Fetch,
    common: Bundle<StudioWords>,
  ) {
    this.sizes = common.words.sizes;
    this.noise = common.array(kernels, "noise", "i1");
    this.bundles = common.array(kernels, "bundles", "i4");
    this.colourTables = {
      codes: common.array(kernels, "srgb_codes", "u1"),
      noRgb: NDArray.zeros(kernels, "f4", [0, 3]),
      liveBands: common.numbers("live_bands", "i4"),
      liveWeights: common.numbers("live_weights", "f8"),
      rgbWeights: common.numbers("rgb_weights", "f8"),
      saunderson: common.words.saunderson,
      primaries: common.numbers("srgb_primaries", "f4"),
    };
    this.fibreFrames = common.numbers("fibre_frames", "f8");
    this.decodedCodes = common.numbers("decoded_codes", "f4");
    this.#pigments = new Map(
      common.words.pigments.map((words) => [
        words.name,
        {
          ...words,
          K: common.numbers(`K.${words.name}`, "f8"),
          S: common.numbers(`S.${words.name}`, "f8"),
        },
      ]),
    );
  }

  /** Load the kernels and what all paintings share. */
  static async open(fetch: Fetch): Promise<Studio> {
    const [wasm, index, contents, common] = await Promise.all([
      fetch("kernels.wasm"),
      fetch("kernels.json").then(json<KernelIndex>),
      fetch("contents.json").then(json<Contents>),
      fetch("common.bin.gz"),
    ]);
    const kernels = await Kernels.load(wasm, index);
    const bundle = await Bundle.read<StudioWords>(common, "common.bin.gz");
    return new Studio(kernels, contents, fetch, bundle);
  }

  /** A brush; it is read once. */
  brush(name: string): Promise<Brush> {
    let brush = this.#brushes.get(name);
    if (brush === undefined) {
      const { file } = named(this.contents.brushes, "brush", name);
      brush = this.fetch(file)
        .then((bytes) => Bundle.read<BrushWords>(bytes, file))
        .then((bundle) => new Brush(this.kernels, bundle));
      brush.catch(() => this.#brushes.delete(name)); // it may be had later
      this.#brushes.set(name, brush);
    }
    return brush;
  }

  /** The parts, by pigment, of an ink by its name. */
  ink(name: string): Ink {
    return this.mixture(named(this.contents.inks, "ink", name).parts);
  }

  /** The same by the pigments' names. */
  partsOf(name: string): Record<string, number> {
    return named(this.contents.inks, "ink", name).parts;
  }

  /** The parts, by pigment, of parts by names of pigments. */
  mixture(parts: Record<string, number>): Ink {
    return new Map(
      Object.entries(parts).map(([name, part]) => {
        const pigment = this.#pigments.get(name);
        if (pigment === undefined) throw new UnknownNameError("pigment", name);
        return [pigment, part];
      }),
    );
  }

  /** A fresh object of the folder to paint on. */
  async surface(name: string, resolution: number, material?: string): Promise<PaintedSurface> {
    const found = this.contents.objects.find((o) => o.name === name && o.resolution === resolution);
    if (found === undefined)
      throw new UnknownNameError(
        "object", `${name} at ${resolution} mm`,
        this.contents.objects.map((o) => `${o.name} at ${o.resolution} mm`),
      ); // prettier-ignore
    const object = await this.fetch(found.file).then((bytes) => Bundle.read<ObjectWords>(bytes, found.file));
    return this.surfaceOf(object, material ?? found.material);
  }

  /** A fresh object to paint on, whoever prepared it. */
  async surfaceOf(object: Bundle<ObjectWords>, materialName: string): Promise<PaintedSurface> {
    const material = named(this.contents.materials, "material", materialName);
    const bytes = await this.fetch(material.file);
    const tables = await Bundle.read<Material>(bytes, material.file);
    const mesh = new PaintMesh(this.kernels, object);
    const tree = readTree(this.kernels, object, "contact");
    return new PaintedSurface(this.kernels, this, object, groundOf(tables), mesh, tree);
  }
}

function groundOf(tables: Bundle<Material & { bends?: Record<string, number> }>): Ground {
  const bends = tables.words.bends ?? {};
  return {
    material: tables.words,
    bare: tables.numbers("bare", "u1"),
    backing: {
      reflectance: tables.numbers("reflectance", "f4"),
      bareLinearRgb: tables.numbers("bare_linear_rgb", "f4"),
      tables: Object.fromEntries(
        Object.entries(bends).map(([name, bend]) => [
          name,
          {
            table: tables.numbers(`table.${name}`, "f4"),
            shades: tables.numbers(`shades.${name}`, "u1"),
            bend,
          },
        ]),
      ),
    },
  };
}

function json<T>(bytes: ArrayBuffer): T {
  return JSON.parse(new TextDecoder().decode(bytes)) as T;
}

function named<T extends { name: string }>(list: T[], kind: UnknownNameError["kind"], name: string): T {
  const found = list.find((one) => one.name === name);
  if (found === undefined)
    throw new UnknownNameError(kind, name, list.map((one) => one.name)); // prettier-ignore
  return found;
}
