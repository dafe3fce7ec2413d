"""Force feedback at 1 kHz beside a busy program: period of the servo, and time from pose to force.

A virtual stylus in a process of its own sends its reports by the clock and times the answers. It is
timed against an echo first, which is what the cable, two wake-ups and the stylus itself cost.
"""

from __future__ import annotations

import multiprocessing
import select
import socket
import time
from multiprocessing.synchronize import Event

import numpy as np
from numpy.typing import NDArray

from paint3d.bench.result import Check, Result
from paint3d.bench.strokes import refined_surface
from paint3d.bench.virtual_stylus import Felt, VirtualStylus
from paint3d.brush.presets import load_brush
from paint3d.core.arrays import AnyArray
from paint3d.device.force.force_port import SocketForcePort
from paint3d.device.force.haptic_stylus import decode_numbers, encode_force
from paint3d.errors import Paint3DError
from paint3d.files.load import load_mesh
from paint3d.haptics.realtime import ask_for_speed
from paint3d.haptics.servo import ForceFeedback, ServoStatus
from paint3d.haptics.settings import HapticSettings
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["measure"]

_SECONDS = 30.0
_VERTICES = 500_000  # and twice as many triangles
_PRIORITY = 50  # of the device's process: a real device waits for nobody
_ECHO_SHARE = 0.2
_MOST_PERIOD_US, _MOST_LATE, _MOST_TRIP_US = 1200.0, 0.002, 300.0
_PERCENTILES = (50.0, 99.0, 99.9)


def measure(scale: float = 1.0) -> Result:
    """Period, lateness and round trip of the servo on a bowl of a million triangles.

    Raises
    ------
    Paint3DError
        If the servo fails.
    """
    bowl = refined_surface(load_mesh("bowl"), max(100, int(_VERTICES * scale)))
    vertices, faces, normals, _ = bowl.export_arrays(None)
    mesh = TriangleMesh(vertices, faces, normals=normals)
    surface = PaintedSurface(mesh, resolution=None)
    poses = _slide(max(1.0, _SECONDS * scale))
    echo = _time_echo(poses[: max(500, int(len(poses) * _ECHO_SHARE))])
    felt, status, n_taken = _time_servo(surface, poses)
    rows = [["echo, busy program", *[None] * 3, *_trip(echo)]]
    late = status.late / max(status.steps, 1)
    rows.append(
        [
            "servo, busy program",
            status.period_p50_us,
            status.period_p99_us,
            100.0 * late,
            *_trip(felt),
        ]
    )
    strongest = float(np.nanmax(np.linalg.norm(felt.force, axis=1)))
    return Result(
        f"Force feedback at 1 kHz, {len(mesh.faces):,} triangles, {len(poses) / 1000:.0f} s",
        ["what", "period p50 us", "p99 us", "late %", "trip p50 us", "p99 us", "p99.9 us"],
        rows,
        [
            Check("period p99", status.period_p99_us, _MOST_PERIOD_US, unit="us"),
            Check("later than 2 ms", 100.0 * late, 100.0 * _MOST_LATE, unit="%"),
            Check("pose to force and back, p99", _trip(felt)[1], _MOST_TRIP_US, unit="us"),
            Check("samples lost", float(len(poses) - n_taken), 0.0),
            Check("strongest force", strongest, 7.9, unit="N"),
        ],
        [
            f"Scheduled as {status.schedule}; the virtual stylus itself was late by "
            f"{np.nanpercentile(felt.sent_late_us, 99):.0f} us at p99.",
            f"Inside the servo a step took {status.step_p99_us:.0f} us at p99, "
            f"{status.worst_step_us:.0f} us at worst. The trips are those of the whole machine, "
            "whatever else it was doing; the echo's are the stylus' and the cable's own share.",
            f"Stiffness left to it: {status.softening:.0%}.",
        ],
    )


def _slide(seconds: float) -> NDArray[np.float64]:
    """Make the root's path (N, 7): down into the bowl and round its floor, pressed and eased."""
    t = np.arange(round(1000 * seconds)) * 1e-3
    poses = np.zeros((len(t), 7))
    poses[:, 3] = 1.0
    poses[:, 0], poses[:, 1] = 22.0 * np.cos(4.0 * t), 22.0 * np.sin(4.0 * t)
    depth = 6.0 + 5.0 * np.sin(2.0 * t)
    poses[:, 2] = np.where(t < 0.5, 60.0, 45.5 - depth * np.clip(4.0 * (t - 0.5), 0.0, 1.0))
    return poses


def _trip(felt: Felt) -> list[float]:
    answered = felt.round_trip_us[np.isfinite(felt.round_trip_us)]
    if len(answered) == 0:
        raise Paint3DError("the virtual stylus felt nothing")
    return [float(p) for p in np.percentile(answered, _PERCENTILES)]


def _work(until: float) -> float:
    """Keep a core busy with arithmetic until a time."""
    x = 1.0
    while time.perf_counter() < until:
        for _ in range(1000):
            x = x * 1.0000001 + 1e-9
    return x


def _time_echo(poses: AnyArray) -> Felt:
    with VirtualStylus(poses, priority=_PRIORITY) as stylus:
        context = multiprocessing.get_context("spawn")
        ready = context.Event()
        process = context.Process(target=_echo, args=(stylus.plug, ready), daemon=True)
        process.start()
        ready.wait(60.0)
        stylus.start()
        while stylus.is_playing():
            _work(time.perf_counter() + 0.03)
        felt = stylus.felt()
        process.join(5.0)
    return felt


def _echo(cable: socket.socket, ready: Event) -> None:
    """Answer every pose at once with zero force."""
    ask_for_speed()
    ready.set()
    while select.select([cable], [], [], 5.0)[0]:
        try:
            report = cable.recv(64)
            if not report:
                return
            cable.send(encode_force((0.0, 0.0, 0.0), decode_numbers(report).sequence))
        except OSError:
            return


def _time_servo(surface: PaintedSurface, poses: AnyArray) -> tuple[Felt, ServoStatus, int]:
    settings = HapticSettings.for_brush(load_brush("full"))
    with (
        VirtualStylus(poses, priority=_PRIORITY) as stylus,
        ForceFeedback(SocketForcePort(stylus.plug), surface.contact_tree, settings) as feedback,
    ):
        stylus.start()
        n_taken = 0
        while stylus.is_playing():  # a window of 30 frames a second that has no time to spare
            _work(time.perf_counter() + 1.0 / 30.0)
            feedback.publish()
            n_taken += len(feedback.take())
        n_taken += len(feedback.take())
        return stylus.felt(), feedback.status(), n_taken
