"""Record what a hand does in the studio: mouse, pen and keys, in its window, dialogs and menus.

python -m scripts.record_hand --out piece.jsonl --about "a scroll with a poem"
python -m scripts.record_hand --out piece.jsonl --pen 30,20   (a leaning pen in place of a mouse)

The studio begins as for somebody who has never used it, in the folder where this is called, from
which files are opened and in which they are saved. The recording ends with the window, or by Ctrl+C
in the terminal. `tests/support/app/window_player.py` plays it, and `tests/app/README.md` says what
is in it.
"""

from __future__ import annotations

import argparse
import os
import signal
import tempfile
from pathlib import Path


def main() -> int:
    """Open the studio and record until it is closed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="the recording, .jsonl")
    parser.add_argument("--about", default="", help="what is recorded")
    parser.add_argument("--window", default="1280x800", help="its size, pixels")
    parser.add_argument("--pen", metavar="X,Y", help="paint by a pen that leans so, degrees")
    given = parser.parse_args()
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    with tempfile.TemporaryDirectory() as home:
        os.environ.update(XDG_CONFIG_HOME=home, PAINT3D_STATE=f"{home}/state")
        from paint3d.app.window.start import make_program
        from paint3d.app.window.studio import StudioWindow
        from tests.support.app.window_recorder import PenOfMouse, WindowRecorder

        program = make_program()
        window = StudioWindow(program)
        window.resize(*(int(n) for n in given.window.split("x")))
        window.show()
        window.recent.show()
        recorder = WindowRecorder(window, given.out, given.about)
        if given.pen is not None:
            right, near = (float(n) for n in given.pen.split(","))
            PenOfMouse(recorder, window.canvas, (right, near))
        return program.exec()


if __name__ == "__main__":
    raise SystemExit(main())
