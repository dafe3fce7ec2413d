"""Paint live: from the hands' devices to the painter, and to a picture that is kept up to date.

Without a stylus or pen tablet a hand is played: the same loop, fed with a recorded line.
"""

import itertools
import sys
import time
from pathlib import Path

import paint3d
from paint3d.device.hot_plug import PluggedDevices
from paint3d.files.pictures import write_picture
from paint3d.pose.two_hands import TwoHands
from paint3d.view.shot import Shot

SETTLED_NS = 2_000_000  # what was measured so long ago has been read
FRAME_S = 1 / 30


def from_devices(devices, seconds):
    """Yield what both hands did, frame by frame: lists of DeviceSample."""
    hands = TwoHands(time_ns=time.monotonic_ns())
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        time.sleep(FRAME_S)
        for event in devices.take_mouse():  # the left hand turns the object
            hands.add_deflection(event.time_ns, event.deflection)
        hands.add_stylus(devices.take_stylus())  # the right hand holds the brush
        yield hands.take(time.monotonic_ns() - SETTLED_NS)


def from_a_recording(recording):
    """Yield a recording's samples as they came, frame by frame."""
    for _, frame in itertools.groupby(
        recording.samples(), lambda s: int(s.time_ns * 1e-9 / FRAME_S)
    ):
        time.sleep(FRAME_S)
        yield list(frame)


def main(out):
    """Paint, and write live.png and live.p3d."""
    surface = paint3d.PaintedSurface(paint3d.load_mesh("bowl"), resolution=0.6)
    painter = paint3d.Painter(surface, brush="full", ink="pine soot", azimuth="dragged")
    devices = PluggedDevices()
    try:
        if devices.styli():
            frames = from_devices(devices, seconds=20.0)
        else:
            print("no stylus is plugged in: a hand is played")
            other = paint3d.Painter(paint3d.PaintedSurface(surface.source, 2.0), azimuth="dragged")
            line = other.stroke([(0.4, 0.6), (0.6, 0.6)], pressure=(0.1, 0.5, 0.1), speed=80)
            frames = from_a_recording(line)
        for samples in frames:
            painter.advance(samples)  # paints all but the last two, which wait for the next
            changed = surface.refresh()  # vertices whose colours a live view would send on
            if len(changed):
                print(f"{len(changed):6} vertices changed")
    finally:
        devices.stop()
    painter.finish()
    write_picture(surface, out / "live.png", Shot(size=(640, 480)))
    paint3d.save_session(paint3d.Session(surface), out / "live.p3d")


if __name__ == "__main__":  # processes that feel force start with this file
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
    folder.mkdir(exist_ok=True)
    main(folder)
