#!/usr/bin/env python3
"""A minute of painting with both virtual hands: no sample may be lost, and nothing may drift.

The left hand swings the object about its axis with a 6-DOF mouse and lets go now and then; the
right hand follows one ring on the object with a haptic stylus, as if the object stood still.
Everything goes the way of real devices: report bytes, decoders, filters, merging, painting, force.
If anything drifted, the ring painted in the object's frame would not close on itself.

    ./scripts/two_hands_minute.py                     in simulated time, as fast as it goes
    ./scripts/two_hands_minute.py --live              by the clock: servo process, virtual devices
    ./scripts/two_hands_minute.py --seconds 10
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import struct
import sys
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.bench.virtual_stylus import VirtualStylus
from paint3d.brush.presets import load_brush
from paint3d.core.quaternion import rotate
from paint3d.device.catalogue import find_mouse_quirks
from paint3d.device.descriptor import parse_descriptor
from paint3d.device.device_log import PlaybackLink
from paint3d.device.force.force_port import SocketForcePort
from paint3d.device.force.haptic_stylus import decode_pose, encode_pose
from paint3d.device.hid_nodes import HidNode
from paint3d.device.report_timing import ReportClock, stamp
from paint3d.device.sample import StylusReading
from paint3d.device.six_dof import MouseReading, find_mouse_layout
from paint3d.device.space_mouse import DeflectionSettings, SpaceMouse, deflection
from paint3d.haptics.servo import ForceFeedback
from paint3d.haptics.settings import HapticSettings
from paint3d.painter.painter import Painter
from paint3d.pose.steering import ObjectPose, SteeringOptions
from paint3d.pose.two_hands import TwoHands
from paint3d.surface.painted_surface import PaintedSurface
from scripts.solids import make_bowl
from tests.support.force_model import ForceModel

MS = 1_000_000
MOUSE_PERIOD_MS = 8
FRAME_MS = 16
SWING_S, REST_S = 4.0, 1.0
RING_S, RING_MM = 3.0, 22.0
ROOT_MM = 38.0  # the tuft's root above the bowl's foot: pressed some 6 mm
QUIRKS = find_mouse_quirks(0x046D, 0xC626)
FILTER = DeflectionSettings()
STEERING = SteeringOptions()
# X, Y, Z in report 1, Rx, Ry, Rz in report 2, as the older 6-DOF mice have them.
MOUSE = bytes.fromhex(
    "05010908a101" + "8501" + "16a2fe265e01" + "093009310932" + "751095038102"
    "8502" + "093309340935" + "8102" + "c0"
)


@dataclass(frozen=True)
class Outcome:
    """Results of the minute.

    Attributes
    ----------
    sent, painted, late : int
        Stylus reports sent, samples painted, samples whose time had to be bent.
    ring_error_mm : float
        Farthest that the root strayed from the ring, in the object's frame.
    last_second_error_mm : float
        The same over the last second alone: what would have drifted by then.
    turn_error : float
        Of the object at the end, rad, against the integral of what the hand did.
    ink_error : float
        Ledger: loaded against brush, surface and spilled, as a share.
    strongest_n : float
    """

    sent: int
    painted: int
    late: int
    ring_error_mm: float
    last_second_error_mm: float
    turn_error: float
    ink_error: float
    strongest_n: float


def counts_at(t: float) -> int | None:
    """Return the cap's turn about z at time t, counts; None while the hand is off."""
    phase = t % (SWING_S + REST_S)
    if phase >= SWING_S:
        return None
    return round(300.0 * math.sin(2.0 * math.pi * phase / SWING_S))


def mouse_report(counts: int) -> bytes:
    """Encode report 2 of a cap that is turned about z."""
    return struct.pack("<B3h", 2, 0, 0, counts)


def turns(n_ms: int) -> NDArray[np.float64]:
    """Integrate the object's angle at every millisecond, independently of the program."""
    rate = np.zeros(n_ms)
    for ms in range(0, n_ms, MOUSE_PERIOD_MS):
        counts = counts_at(ms * 1e-3)
        if counts is None:
            continue
        share = deflection([0, 0, 0, 0, 0, counts], QUIRKS, FILTER)[5]
        held = MOUSE_PERIOD_MS if counts_at((ms + MOUSE_PERIOD_MS) * 1e-3) is not None else 150
        rate[ms : ms + held] = share * STEERING.turn_rad_s
    return np.concatenate([[0.0], np.cumsum(rate * 1e-3)])[:n_ms]


def ring(n_ms: int) -> NDArray[np.float64]:
    """The root's way in the object's frame (n_ms, 3), mm."""
    angle = 2.0 * math.pi * np.arange(n_ms) * 1e-3 / RING_S
    down = np.clip(np.arange(n_ms) / 300.0, 0.0, 1.0)
    return np.stack(
        [RING_MM * np.cos(angle), RING_MM * np.sin(angle), 60.0 - (60.0 - ROOT_MM) * down], axis=1
    )


def hand_poses(n_ms: int) -> NDArray[np.float64]:
    """The stylus in the world (n_ms, 7): the ring, carried along by the object."""
    angle = turns(n_ms)
    q = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=1)
    return np.concatenate([rotate(q, ring(n_ms)), q], axis=1)


class Judge:
    """Looks at every sample in the object's frame."""

    def __init__(self, n_ms: int) -> None:
        self._ring = ring(n_ms)
        self._errors: list[NDArray] = []

    def look(self, samples: list) -> None:
        """Measure samples against the ring: none may be missing, or all that follow are off."""
        if not samples:
            return
        done = sum(map(len, self._errors))
        q = np.array([s.object_orientation for s in samples]) * [1, -1, -1, -1]
        place = np.array([s.position - s.object_position for s in samples])
        wanted = self._ring[done : done + len(samples)]
        self._errors.append(np.linalg.norm(rotate(q, place) - wanted, axis=1))

    def errors(self) -> NDArray[np.float64]:
        """Distance of every sample from the ring, mm."""
        return np.concatenate(self._errors)


def simulate(seconds: float, resolution: float | None = 0.8) -> Outcome:
    """Both hands, painting and force in simulated time: report bytes in, no clock anywhere."""
    n = round(1000 * seconds)
    surface, painter = _prepare(resolution)
    force = ForceModel(surface.contact_tree, HapticSettings.for_brush(load_brush("full")))
    layout, reading = find_mouse_layout(parse_descriptor(MOUSE)), MouseReading()
    clock = ReportClock(MS)
    hands = TwoHands(steering=STEERING, time_ns=MS)
    judge, painted, strongest = Judge(n), 0, 0.0
    start = 10 * MS
    for ms, pose in enumerate(hand_poses(n)):
        now = start + ms * MS
        counts = counts_at(ms * 1e-3)
        if ms % MOUSE_PERIOD_MS == 0 and counts is not None:
            reading = layout.decode(mouse_report(counts), reading)
            hands.add_deflection(now, deflection(reading.axes, QUIRKS, FILTER))
        said, number = decode_pose(encode_pose(pose[:3], pose[3:], 0, ms), now)
        at, clock = stamp(clock, now, number)
        hands.add_stylus([StylusReading(at, said.position, said.orientation, None)])
        strongest = max(strongest, _feel(force, said, hands.object_pose))
        if ms % FRAME_MS == 0 or ms == n - 1:
            painted += _paint(hands, painter, judge, now)
    return _conclude(painter, hands, judge, n, painted, strongest)


def live(seconds: float, resolution: float | None = 0.8) -> Outcome:
    """The same by the clock: servo, stylus and mouse on their own, 60 frames a second."""
    simulate(0.4)  # what is loaded on first use would hang the program, and the force with it
    n = round(1000 * seconds)
    surface, painter = _prepare(resolution)
    settings = HapticSettings.for_brush(load_brush("full"))
    judge, painted, strongest = Judge(n), 0, 0.0
    with (
        VirtualStylus(hand_poses(n), priority=50) as stylus,
        ForceFeedback(SocketForcePort(stylus.plug), surface.contact_tree, settings) as feedback,
    ):
        stylus.start()
        while not (sent := stylus.felt().sent_ns)[0]:
            time.sleep(0.001)
            feedback.publish()
        start = int(sent[0])
        mouse = _play_mouse(n, start)
        hands = TwoHands(steering=STEERING, time_ns=start - MS)
        while stylus.is_playing():
            time.sleep(FRAME_MS * 1e-3)
            now = time.monotonic_ns()
            for event in mouse.take():
                hands.add_deflection(event.time_ns, event.deflection)
            hands.add_stylus(feedback.take())
            painted += _paint(hands, painter, judge, now - 5 * MS)
            pose = hands.object_pose
            feedback.publish(np.concatenate([pose.position, pose.orientation]))
        hands.add_stylus(feedback.take())
        painted += _paint(hands, painter, judge, time.monotonic_ns())
        felt = stylus.felt()
        mouse.stop()
    strongest = float(np.nanmax(np.linalg.norm(felt.force, axis=1)))
    return _conclude(painter, hands, judge, n, painted, strongest)


def _prepare(resolution: float | None) -> tuple[PaintedSurface, Painter]:
    surface = PaintedSurface(make_bowl(), resolution=resolution)
    return surface, Painter(surface, brush="full")


def _play_mouse(n_ms: int, start_ns: int) -> SpaceMouse:
    entries = [
        (ms * MS, mouse_report(counts))
        for ms in range(0, n_ms, MOUSE_PERIOD_MS)
        if (counts := counts_at(ms * 1e-3)) is not None
    ]
    node = HidNode("virtual", "log", 0x046D, 0xC626, "virtual mouse", "", 1, 8, "mouse")
    link = PlaybackLink(node, MOUSE, entries)
    link.start(start_ns, 0)
    return SpaceMouse(link, QUIRKS, FILTER)


def _feel(force: ForceModel, said: StylusReading, thing: ObjectPose) -> float:
    target = np.concatenate([thing.position, thing.orientation])
    step = force.step(said.position, said.orientation, object_pose=target)
    return float(np.linalg.norm(step.force))


def _paint(hands: TwoHands, painter: Painter, judge: Judge, until: int) -> int:
    samples = hands.take(until)
    judge.look(samples)
    if samples:
        painter.advance(samples)
    return len(samples)


def _conclude(
    painter: Painter,
    hands: TwoHands,
    judge: Judge,
    n: int,
    painted: int,
    strongest: float,
) -> Outcome:
    painter.finish()
    errors = judge.errors()
    angle = turns(n)
    q = hands.object_pose.orientation
    turned = 2.0 * math.atan2(q[3], q[0])
    ledger = painter.ledger()
    kept = sum(value for name, value in ledger.items() if name != "loaded")
    return Outcome(
        n,
        painted,
        hands.late,
        float(errors.max()),
        float(errors[-1000:].max()),
        abs(math.remainder(turned - angle[-1], 2.0 * math.pi)),
        abs(kept - ledger["loaded"]) / ledger["loaded"],
        strongest,
    )


def main() -> int:
    """Run and print the results; return 1 if a sample was lost or something drifted."""
    parser = argparse.ArgumentParser(description="both virtual hands, for a minute")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--live", action="store_true", help="by the clock, in processes")
    options = parser.parse_args()
    outcome = (live if options.live else simulate)(options.seconds)
    for name, value in dataclasses.asdict(outcome).items():
        sys.stdout.write(f"{name:22}{value:.6g}\n")
    most_mm = 0.5 if options.live else 0.005
    bad = outcome.painted != outcome.sent or outcome.last_second_error_mm > most_mm
    return int(bad or outcome.ink_error > 1e-6)


if __name__ == "__main__":
    sys.exit(main())
