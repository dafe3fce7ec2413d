"""3D Systems Touch and Phantom devices through OpenHaptics' HD library.

NOT TRIED ON HARDWARE: written against the public HD interface (OpenHaptics 3) and tested against a
mock library.

The library calls us back a thousand times a second from its own thread. Its frame has x to the
right, y up and z towards the user, lengths in mm; the stylus' z axis runs up the handle, as ours.
`WORLD_FROM_OPENHAPTICS` turns it into x right, y away, z up.
"""

from __future__ import annotations

import ctypes
import math
import threading
import time
from dataclasses import dataclass, field
from typing import Any

from paint3d.device.force.force_port import ForceLoop
from paint3d.device.force.haptic_stylus import PoseNumbers
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.errors import DeviceError, Message

__all__ = ["WORLD_FROM_OPENHAPTICS", "OpenHapticsPort"]

WORLD_FROM_OPENHAPTICS = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
"""Rotation for a `DeviceCalibration`: a quarter turn about x."""

_BUTTONS, _TRANSFORM, _MAX_FORCE, _FORCE = 0x2000, 0x2052, 0x2603, 0x2700
_MAX_STIFFNESS = 0x2602
_FORCE_OUTPUT, _FORCE_CLAMPING = 0x4000, 0x4001
_NO_DEVICE = 0xFFFFFFFF
_MOST_ERRORS = 64
_DONE, _GO_ON = 0, 1
_PRIORITY = 0xFFFF
_POLL_S = 0.05
_SILENCE_NS = 1_000_000_000
_Callback = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_void_p)


class _Error(ctypes.Structure):
    _fields_ = (
        ("code", ctypes.c_uint),
        ("internal", ctypes.c_int),
        ("device", ctypes.c_uint),
    )


@dataclass(frozen=True)
class OpenHapticsPort:
    """A force port of the HD library.

    Parameters
    ----------
    name : str
        As configured in the maker's setup program; empty for the default device.
    library : str
        The shared library.
    """

    name: str = ""
    library: str = "libHD.so"

    def is_installed(self) -> bool:
        """Return whether the library can be loaded."""
        try:
            _load(self.library)
        except DeviceError:
            return False
        return True

    def read_limits(self) -> tuple[float, float | None]:
        """Open the device for a moment to read its limits.

        Returns
        -------
        (float, float or None)
            Its greatest force, N, and greatest stable stiffness, N/mm, if it states one.

        Raises
        ------
        DeviceError
            If the library is missing, or the device cannot be opened.
        """
        hd = _load(self.library)
        handle = self._open(hd)
        try:
            most = _greatest_force(hd)
            stiffest = (ctypes.c_double * 1)()
            hd.hdGetDoublev(_MAX_STIFFNESS, stiffest)
        finally:
            hd.hdDisableDevice(handle)
        return most, stiffest[0] if 0.01 <= stiffest[0] <= 20.0 else None

    def _open(self, hd: ctypes.CDLL) -> int:
        for _ in range(_MOST_ERRORS):  # the library queues errors; drop old ones
            if not hd.hdGetError().code:
                break
        handle: int = hd.hdInitDevice(self.name.encode() or None)
        if handle == _NO_DEVICE or (code := hd.hdGetError().code):
            reason = "" if handle == _NO_DEVICE else Message(" (error {code:#x})", code=code)
            raise DeviceError(
                "OpenHaptics cannot open {name}{reason}; expected one that is plugged in, awake, "
                "and set up in the maker's Touch Setup",
                name=self.name or Message("the device"),
                reason=reason,
            )
        return handle

    def run(self, loop: ForceLoop) -> None:
        """See `paint3d.device.force.force_port.ForcePort`.

        Raises
        ------
        DeviceError
            If the library is missing, the device cannot be opened, or it fails.
        """
        hd = _load(self.library)
        handle = self._open(hd)
        session = _Session(hd, handle, loop)
        callback = _Callback(session.call)
        try:
            hd.hdEnable(_FORCE_OUTPUT)
            hd.hdEnable(_FORCE_CLAMPING)
            session.read_limit()
            ticket = hd.hdScheduleAsynchronous(callback, None, _PRIORITY)
            hd.hdStartScheduler()
            while not session.over.wait(_POLL_S):
                session.check_alive()
            hd.hdStopScheduler()
            hd.hdUnschedule(ticket)
        finally:
            hd.hdDisable(_FORCE_OUTPUT)
            hd.hdDisableDevice(handle)
        if session.failure is not None:
            raise session.failure


@dataclass
class _Session:
    """State of the callback, which allocates nothing itself."""

    hd: ctypes.CDLL
    handle: int
    loop: ForceLoop
    over: threading.Event = field(default_factory=threading.Event)
    failure: DeviceError | None = None
    limit: float = 0.0
    called_ns: int = 0

    def __post_init__(self) -> None:
        self._transform = (ctypes.c_double * 16)()
        self._force = (ctypes.c_double * 3)()
        self._held = (ctypes.c_int * 1)()

    def read_limit(self) -> None:
        """Read the device's greatest force, N."""
        self.limit = _greatest_force(self.hd)
        self.called_ns = time.monotonic_ns()

    def check_alive(self) -> None:
        """End the session if the library has stopped calling, as nothing else would."""
        if time.monotonic_ns() - self.called_ns > _SILENCE_NS:
            self.failure = DeviceError("OpenHaptics has stopped calling: the device has gone")
            self.over.set()

    def call(self, _: int | None) -> int:
        """Run one servo tick; no exception may reach the library."""
        hd = self.hd
        self.called_ns = now_ns = time.monotonic_ns()
        hd.hdBeginFrame(self.handle)
        force, go_on = (0.0, 0.0, 0.0), _DONE
        try:
            if not self.loop.stopped():
                hd.hdGetDoublev(_TRANSFORM, self._transform)
                hd.hdGetIntegerv(_BUTTONS, self._held)
                pose = _pose(self._transform, self._held[0], now_ns)
                force, go_on = self._bounded(self.loop.step(pose, now_ns)), _GO_ON
        except Exception as cause:
            self.failure = DeviceError("the servo failed: {cause}", cause=repr(cause))
            force, go_on = (0.0, 0.0, 0.0), _DONE
        self._force[:] = list(force)
        hd.hdSetDoublev(_FORCE, self._force)
        hd.hdEndFrame(self.handle)
        if go_on == _GO_ON and (code := hd.hdGetError().code):
            self.failure, go_on = (
                DeviceError("OpenHaptics reports error {code:#x}", code=code),
                _DONE,
            )
        if go_on == _GO_ON:
            self.loop.sent()
        else:
            self.over.set()
        return go_on

    def _bounded(self, force: tuple[float, float, float]) -> tuple[float, float, float]:
        size = math.hypot(*force)
        if not math.isfinite(size):
            raise DeviceError("a force that is not finite")
        scale = min(1.0, self.limit / size) if size > 0.0 else 1.0
        return force[0] * scale, force[1] * scale, force[2] * scale


def _greatest_force(hd: ctypes.CDLL) -> float:
    """Greatest force of the open device, N, at most `MAX_FORCE_N`."""
    most = (ctypes.c_double * 1)()
    hd.hdGetDoublev(_MAX_FORCE, most)
    if not 0.0 < most[0] <= 1000.0:
        raise DeviceError(
            "OpenHaptics reports a greatest force of {first} N; expected 0 to 1000", first=most[0]
        )
    return min(most[0], MAX_FORCE_N)


def _pose(matrix: Any, buttons: int, time_ns: int) -> PoseNumbers:
    """Convert a column-major 4 x 4 matrix to position and quaternion."""
    m = [[matrix[4 * column + row] for column in range(3)] for row in range(3)]
    trace = m[0][0] + m[1][1] + m[2][2]
    if trace > 0.0:
        w = 0.5 * math.sqrt(1.0 + trace)
        q = (
            w,
            (m[2][1] - m[1][2]) / (4.0 * w),
            (m[0][2] - m[2][0]) / (4.0 * w),
            (m[1][0] - m[0][1]) / (4.0 * w),
        )
    else:
        i = max(range(3), key=lambda k: m[k][k])
        j, k = (i + 1) % 3, (i + 2) % 3
        big = 0.5 * math.sqrt(max(0.0, 1.0 + m[i][i] - m[j][j] - m[k][k]))
        parts = [0.0] * 3
        parts[i] = big
        parts[j] = (m[j][i] + m[i][j]) / (4.0 * big)
        parts[k] = (m[k][i] + m[i][k]) / (4.0 * big)
        q = ((m[k][j] - m[j][k]) / (4.0 * big), *parts)
    length = math.hypot(*q)
    unit = (q[0] / length, q[1] / length, q[2] / length, q[3] / length)
    return PoseNumbers(time_ns, (matrix[12], matrix[13], matrix[14]), unit, buttons & 0xFF, 0)


def _load(library: str) -> ctypes.CDLL:
    try:
        hd = ctypes.CDLL(library)
    except OSError as cause:
        raise DeviceError(
            "OpenHaptics' library {library} cannot be loaded ({cause}); it comes with the maker's "
            "driver: install 3D Systems' OpenHaptics and Touch Device Driver",
            hint="or say where it is: --stylus openhaptics=/PATH/libHD.so",
            library=library,
            cause=repr(cause),
        ) from None
    doubles, unsigned = ctypes.POINTER(ctypes.c_double), ctypes.c_uint
    for name, result, arguments in (
        ("hdInitDevice", unsigned, [ctypes.c_char_p]),
        ("hdDisableDevice", None, [unsigned]),
        ("hdEnable", None, [unsigned]),
        ("hdDisable", None, [unsigned]),
        ("hdBeginFrame", None, [unsigned]),
        ("hdEndFrame", None, [unsigned]),
        ("hdGetDoublev", None, [unsigned, doubles]),
        ("hdSetDoublev", None, [unsigned, doubles]),
        ("hdGetIntegerv", None, [unsigned, ctypes.POINTER(ctypes.c_int)]),
        ("hdGetError", _Error, []),
        ("hdStartScheduler", None, []),
        ("hdStopScheduler", None, []),
        (
            "hdScheduleAsynchronous",
            ctypes.c_ulong,
            [_Callback, ctypes.c_void_p, ctypes.c_ushort],
        ),
        ("hdUnschedule", None, [ctypes.c_ulong]),
    ):
        try:
            function = getattr(hd, name)
        except AttributeError:
            raise DeviceError(
                "{library} has no {name}: not OpenHaptics' HD library",
                library=library,
                name=name,
            ) from None
        function.restype, function.argtypes = result, arguments
    return hd
