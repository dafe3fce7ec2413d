"""A recording on an object: the shipped one, read from its file, with a progress bar."""

import sys
from importlib.resources import files
from pathlib import Path

import paint3d

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(exist_ok=True)


def show(share):
    """Draw a bar."""
    sys.stderr.write(f"\r[{'#' * round(30 * share):30}] {share:4.0%}")


recording = paint3d.load_recording(files("paint3d.calligraphy") / "data" / "demo.jsonl.gz")
surface = paint3d.PaintedSurface(paint3d.load_mesh("bowl"), resolution=1.0)
painter = paint3d.Painter(surface, recording.header["brush"], recording.header["ink"])
painter.replay(recording, show)
sys.stderr.write("\n")
for account, coats_mm2 in painter.ledger().items():  # no ink is lost
    print(f"{account:12} {coats_mm2:10.2f} coats x mm2")
paint3d.export(surface, out / "bowl.p3d.txt")
