/** The scratch arrays of the kernels that place and paint: `paint3d/brush_engine/scratch.py`. */

import { NDArray, type Records } from "../core/arrays";
import type { Argument, Kernels } from "../core/kernels";
import type { PaintMesh } from "../mesh/refined_mesh";

/** Sizes that Python's modules name. */
export interface Sizes {
  block: number;
  counters: number;
  rows: number;
  cursor: number;
  disc_rows: number;
  tuft_scratch: number;
  outline: number;
  chords: { points: number[]; flanks: number[]; grids: number[]; cuts: number[]; sums: number[];
    nodes: number[]; lines: number[]; bands: number[] };
  lines: number;
  profile_cells: number;
}

export interface Stamp {
  [name: string]: Argument;
  values: Records;
  half_widths: NDArray<"f8">;
  lines: NDArray<"f4">;
}

/** Where the stroke stands, so that painting can be taken up again. */
export interface Progress {
  [name: string]: Argument;
  at: NDArray<"i8">;
  before: Stamp;
  after: Stamp;
  noted: NDArray<"f8">;
}

export interface Scratch {
  [name: string]: Argument;
  counters: NDArray<"i8">;
  warm: NDArray<"f8">;
  part: NDArray<"f8">;
  taken: NDArray<"f8">;
  found: { [name: string]: NDArray };
}

export function makeStamp(kernels: Kernels, sizes: Sizes): Stamp {
  return {
    values: kernels.records("brush_engine.footprint.GEOMETRY"),
    half_widths: kernels.zeros("f8", sizes.profile_cells + 2),
    lines: kernels.zeros("f4", 2, sizes.profile_cells),
  };
}

export function makeProgress(kernels: Kernels, sizes: Sizes): Progress {
  return {
    at: kernels.zeros("i8", 3),
    before: makeStamp(kernels, sizes),
    after: makeStamp(kernels, sizes),
    noted: kernels.zeros("f8", 8),
  };
}

export function makeScratch(
  kernels: Kernels, sizes: Sizes, mesh: PaintMesh, nPigments: number,
): Scratch {
  const { nSheets: sheets, nCells: cells, nBlocks: blocks } = mesh;
  const n = sizes.block;
  const chords = sizes.chords;
  const zeros = kernels.zeros.bind(kernels);
  return {
    counters: zeros("i8", sizes.counters),
    pose: zeros("f8", 9),
    foot: zeros("f8", 6),
    warm: zeros("f8", 5),
    vector: zeros("f8", 3),
    drag: zeros("f8", 3),
    held: zeros("f8", 3),
    tuft: zeros("f8", sizes.tuft_scratch),
    reach: zeros("f8", sizes.outline),
    half_width: zeros("f8", sizes.outline),
    sweep: kernels.records("brush_engine.footprint.SWEEP"),
    chords: {
      points: zeros("f8", ...chords.points),
      flanks: zeros("f8", ...chords.flanks),
      grids: zeros("f8", ...chords.grids),
      cuts: zeros("f8", ...chords.cuts),
      sums: zeros("f8", ...chords.sums),
      nodes: zeros("f8", ...chords.nodes),
      lines: zeros("u4", ...chords.lines),
      bands: zeros("f4", ...chords.bands),
    },
    part: zeros("f8", nPigments),
    taken: zeros("f8", nPigments),
    patch: {
      tick: zeros("i8", 1),
      count: zeros("i8", 1),
      sheets: zeros("i4", sheets),
      ticks: zeros("i8", sheets),
    },
    query: {
      tick: zeros("i8", 1),
      cell_ticks: zeros("i8", cells),
      cells: zeros("i4", sheets),
      slopes: zeros("f4", sheets),
      discs: zeros("f4", sizes.disc_rows, Math.max(sheets, blocks)),
      fates: zeros("u1", sheets),
      block_fates: zeros("u1", blocks),
      runs: zeros("i4", cells + blocks, 3),
      cursor: zeros("i8", sizes.cursor),
    },
    block: {
      stretch: zeros("f4", n),
      rows: zeros("f4", sizes.rows, n),
      work: zeros("f4", sizes.rows, n),
      near: zeros("i4", 2, n),
    },
    found: makeFound(kernels, mesh),
    gains: zeros("f4", 2, sizes.lines),
  };
}

/** The same scratch, for a mesh that has grown or a pigment more; what was begun goes on. */
export function growScratch(
  kernels: Kernels, scratch: Scratch, mesh: PaintMesh, nPigments: number,
): Scratch {
  for (const array of [...Object.values(scratch.found), scratch.part, scratch.taken]) array.free();
  return {
    ...scratch,
    found: makeFound(kernels, mesh),
    part: kernels.zeros("f8", nPigments),
    taken: kernels.zeros("f8", nPigments),
  };
}

function makeFound(kernels: Kernels, mesh: PaintMesh): { [name: string]: NDArray } {
  const n = mesh.capacity + 1;
  const single = (): NDArray => kernels.zeros("f4", n);
  return {
    count: kernels.zeros("i8", 1),
    runs: kernels.zeros("i4", mesh.nCells + 2 * mesh.nBlocks + 1, 2),
    ids: kernels.zeros("i4", n),
    ahead: single(),
    aside: single(),
    fraction: single(),
    cover: single(),
    lanes: kernels.zeros("i2", n),
    under: single(),
    area: single(),
    take: single(),
    px: single(),
    py: single(),
    pz: single(),
    covered: single(),
    coats: single(),
    heights: single(),
    lacks: single(),
    brings: single(),
  };
}
