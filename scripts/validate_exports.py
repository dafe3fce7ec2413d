"""Hold every kind of exported file to the judgement of other people's programs.

    python scripts/validate_exports.py [--keep DIR]

Paints the demo on the bowl, writes it in every format and variant, and runs what is installed of:
Khronos' gltf-validator (node, ``npm install -g gltf-validator``), lib3mf in its strict mode, the
validators of USD, trimesh and Open3D on PLY and OBJ, the viewer's tests in Chromium,
and the independent checker of ``../shared``, where it lies beside the checkout. Exit status 1 if
one finds something.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import numpy as np

import paint3d

ROOT = Path(__file__).resolve().parents[1]
CHECKER = ROOT.parent / "shared" / "formats" / "check_export.py"
VALIDATE = """
const fs = require('fs'), validator = require('gltf-validator');
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])))
  .then((report) => console.log(JSON.stringify(report.issues)));
"""
VARIANTS = {
    "painting.ply": {},
    "painting.obj": {},
    "painting.glb": {},
    "unlit.glb": {"unlit": True},
    "texture.glb": {"texture": 1024},
    "filaments.glb": {"filaments": 3},
    "painting.3mf": {},
    "filaments.3mf": {"filaments": 3},
    "painting.usdz": {},
    "inches.usdz": {"unit": "in", "up_axis": "z"},
}


class MissingToolError(Exception):
    """A program that is not installed here."""


def write_variants(surface: object, folder: Path) -> None:
    """Write all variants, and what the checker expects of them."""
    for name, options in VARIANTS.items():
        paint3d.export(surface, folder / name, paint3d.ExportOptions(**options))
    vertices, faces, normals, srgb = surface.export_arrays()
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    np.savez(folder / "expected.npz", vertices=vertices, faces=faces, normals=normals, srgb=srgb)


def gltf_validator(folder: Path) -> list[str]:
    """List errors, warnings and hints of Khronos' validator."""
    if shutil.which("node") is None:
        raise MissingToolError("node")
    faults = []
    for path in sorted(folder.glob("*.glb")):
        done = subprocess.run(
            ["node", "-e", VALIDATE, str(path)],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "NODE_PATH": _node_path()},
        )
        if "Cannot find module" in done.stderr:
            raise MissingToolError("npm install -g gltf-validator, or NODE_PATH")
        issues = json.loads(done.stdout)["messages"]
        faults += [f"{path.name}: {one['code']} {one['message']}" for one in issues]
    return [line for line in faults if "IMAGE_NPOT_DIMENSIONS" not in line]  # allowed since 2.0


def _node_path() -> str:
    done = subprocess.run(["npm", "root", "-g"], capture_output=True, text=True, check=False)
    return os.pathsep.join(filter(None, (os.environ.get("NODE_PATH"), done.stdout.strip())))


def lib3mf(folder: Path) -> list[str]:
    """List warnings of lib3mf's strict reader, and solids that are not closed.

    What is for slicers has an attribute of theirs without a namespace, of which it may warn.
    """
    try:
        import lib3mf as library
    except ImportError:
        raise MissingToolError("pip install lib3mf") from None
    faults = []
    for path in sorted(folder.glob("*.3mf")):
        model = library.get_wrapper().CreateModel()
        reader = model.QueryReader("3mf")
        is_for_slicers = path.name == "filaments.3mf"
        reader.SetStrictModeActive(not is_for_slicers)
        reader.ReadFromFile(str(path))
        warnings = [reader.GetWarning(k) for k in range(reader.GetWarningCount())]
        faults += [
            f"{path.name}: {warning}"
            for warning in warnings
            if not (is_for_slicers and "Invalid Attribute in namespace" in str(warning))
        ]
        solids = model.GetMeshObjects()
        while solids.MoveNext():
            solid = solids.GetCurrentMeshObject()
            if not solid.IsManifoldAndOriented():
                faults.append(f"{path.name}: it is not closed")
    return faults


def usd(folder: Path) -> list[str]:
    """List the errors of all validators that come with USD."""
    try:
        from pxr import Usd, UsdValidation
    except ImportError:
        raise MissingToolError("pip install usd-core") from None
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    faults = []
    for path in sorted(folder.glob("*.usdz")):
        stage = Usd.Stage.Open(str(path))
        errors = UsdValidation.ValidationContext(validators).Validate(stage)
        faults += [f"{path.name}: {error.GetName()} {error.GetMessage()}" for error in errors]
    return faults


def readers(folder: Path) -> list[str]:
    """List the files whose colours trimesh or Open3D read differently."""
    import open3d
    import trimesh

    expected = np.load(folder / "expected.npz")
    wanted, faults = expected["srgb"][expected["faces"]], []
    for name in ("painting.ply", "painting.obj"):
        one = trimesh.load(folder / name, process=False)
        other = open3d.io.read_triangle_mesh(str(folder / name))
        codes = np.rint(255.0 * np.asarray(other.vertex_colors)).astype(int)
        for who, seen in (
            ("trimesh", one.visual.vertex_colors[one.faces][..., :3]),
            ("Open3D", codes[np.asarray(other.triangles)]),
        ):
            if seen.shape != wanted.shape or np.abs(seen.astype(int) - wanted).max() > 0:
                faults.append(f"{name}: {who} sees other colours")
    return faults


def chromium(folder: Path) -> list[str]:
    """Run the tests of the page that shows an object; list their last lines if they fail."""
    if not any(map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))):
        raise MissingToolError("chromium")
    command = [sys.executable, "-m", "pytest", "-q", "tests/e2e/test_viewer.py"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return [] if done.returncode == 0 else done.stdout.strip().splitlines()[-5:]


def checker(folder: Path) -> list[str]:
    """Run the independent checker, with all of its readers that are installed."""
    if not CHECKER.is_file():
        raise MissingToolError(str(CHECKER))
    faults = []
    for suffix in ("ply", "obj", "3mf", "glb"):
        command = [sys.executable, str(CHECKER), str(folder / f"painting.{suffix}")]
        command.append(str(folder / "expected.npz"))
        if suffix == "glb":
            command += ["--axis", "zup2yup", "--scale", "0.001"]
        if suffix != "3mf":
            command += ["--readers", "plain,open3d"]
        else:
            command += ["--readers", "plain,lib3mf"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            faults += [f"{suffix}: {line}" for line in (done.stdout + done.stderr).splitlines()]
    return faults


CHECKS: dict[str, Callable[[Path], list[str]]] = {
    "gltf-validator": gltf_validator,
    "lib3mf": lib3mf,
    "usd": usd,
    "readers": readers,
    "checker": checker,
    "chromium": chromium,
}


def paint_demo() -> object:
    """Paint the demo's recording on the bowl."""
    recording = paint3d.load_recording(str(files("paint3d.calligraphy") / "data" / "demo.jsonl.gz"))
    surface = paint3d.PaintedSurface(paint3d.load_mesh("bowl"), resolution=0.2)
    header = recording.header
    painter = paint3d.Painter(
        surface, brush=header["brush"], ink=header["ink"], azimuth=header["azimuth"]
    )
    painter.replay(recording)
    return surface


def main() -> int:
    """Write, check, and print a line for each check."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", metavar="DIR", type=Path, help="leave the files here")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        write_variants(paint_demo(), folder)
        failed = False
        for name, check in CHECKS.items():
            try:
                faults = check(folder)
            except MissingToolError as missing:
                print(f"SKIP {name}: not here: {missing}")
                continue
            failed |= bool(faults)
            print(f"{'FAIL' if faults else 'PASS'} {name}", *faults, sep="\n     ")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
