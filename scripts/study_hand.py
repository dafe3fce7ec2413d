"""Count what is lost of random strokes by a pen, through the studio's window, on any object.

python -m scripts.study_hand --strokes 200
python -m scripts.study_hand --strokes 40 bowl:in vase:out some/mesh.glb

For every object and side one line: how many of the strokes are inked on less than 98 % of their
way or jump more than 2 mm, the inked share of all of them together, and of the middle of the marks
how far off the way they lie. What of a way leads through the air, from an edge to what is seen
behind it, is not asked for; the last column tells how much that is. Every stroke leans by up to
--tilt degrees to any side, and is painted on a clean surface. Needs a display, and the folder of
meshes only where one is named.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

from paint3d.app.window.start import make_program
from paint3d.app.window.studio import StudioWindow
from paint3d.errors import Paint3DError
from paint3d.files.load import BUILT_IN_OBJECTS, load_mesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from tests.support.app.event_player import open_for
from tests.support.app.marks import inked_share, largest_jump, off_the_way, stations, stray
from tests.support.app.random_strokes import random_strokes
from tests.support.app.trials import try_strokes
from tests.support.app.windows import blind, pretend_saved

HALF_FOOTPRINT = 2.4  # mm: of the full brush at a quarter of its pressure
REACH = 10.0
SIDES = {"bowl": ("in", "out"), "vase": ("out",)}
SIZE_MM = 150.0
HEAD = (
    "object side strokes lost jumps inked off_p95_mm off_max_mm jump_max_mm stray_max_mm in_air_mm"
)


def prepared(path: str, folder: Path) -> str:
    """Scale a mesh to 150 mm, whatever its unit is; return a file of it."""
    import paint3d

    mesh = load_mesh(path)
    size = float(np.ptp(mesh.vertices, axis=0).max())
    target = folder / f"{Path(path).stem}.ply"
    paint3d.export(TriangleMesh(mesh.vertices * (SIZE_MM / size), mesh.faces), target)
    return str(target)


def study(window: StudioWindow, name: str, side: str, options: argparse.Namespace) -> np.ndarray:
    """Measure strokes, a row (6,) each, lengths in mm.

    The inked fraction, 95 % of the distance from the path, jump, stray, and the length of the path
    on the surface and through the air.
    """
    rng = np.random.default_rng(options.seed)
    rows = []
    strokes = random_strokes(window, rng, options.strokes, side, tilt_degrees=options.tilt)
    for stroke in strokes:
        for trial in try_strokes(window, stroke):
            parts = stations(trial.mark, trial.way, reach_mm=REACH)
            rows.append((
                inked_share(trial.mark, trial.way, HALF_FOOTPRINT),
                off_the_way(parts, 95.0, ends_mm=1.0),
                largest_jump(parts),
                stray(trial.mark, trial.way, HALF_FOOTPRINT),
                trial.way.length_mm - trial.way.in_the_air_mm,
                trial.way.in_the_air_mm,
            ))  # fmt: skip
            if options.each:
                print("   ", *(f"{value:.2f}" for value in rows[-1]), flush=True)
    return np.array(rows)


def main() -> int:
    """Study the objects, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("objects", nargs="*", help="names, name:side, or mesh files")
    parser.add_argument("--strokes", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tilt", type=float, default=50.0, help="the most, degrees")
    parser.add_argument("--resolution", type=float, default=1.0, help="mm")
    parser.add_argument("--each", action="store_true", help="print every stroke")
    options = parser.parse_args()
    wanted = options.objects or [
        f"{name}:{side}" for name in BUILT_IN_OBJECTS for side in SIDES.get(name, ("any",))
    ]
    lost = 0
    with tempfile.TemporaryDirectory() as folder:
        os.environ.update(XDG_CONFIG_HOME=folder, PAINT3D_STATE=f"{folder}/state")
        window = StudioWindow(make_program())
        window.show()
        print(HEAD)
        with blind(window):
            for one in wanted:
                name, _, side = one.partition(":")
                side = side or "any"
                try:
                    target = name if name in BUILT_IN_OBJECTS else prepared(name, Path(folder))
                    material = "xuan" if name == "plane" else "porcelain"
                    open_for(window, {"object": target, "material": material}, options.resolution)
                    rows = study(window, name, side, options)
                except (Paint3DError, AssertionError) as error:
                    print(f"{Path(name).name} {side}: {error}", flush=True)
                    continue
                share, off, jump, away, length, in_air = rows.T
                bad = int((share < 0.98).sum())
                jumps = int((jump > 2.0).sum())
                lost += bad + jumps
                total = float((share * length).sum() / length.sum())
                print(
                    f"{Path(name).name} {side} {len(rows)} {bad} {jumps} {total:.4f} "
                    f"{np.percentile(off, 95):.2f} {off.max():.2f} {jump.max():.2f} "
                    f"{away.max():.2f} {in_air.sum():.1f}", flush=True,
                )  # fmt: skip
        pretend_saved(window.stage.paint_thread)
        window.close()
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
