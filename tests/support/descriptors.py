"""Report descriptors for the tests: one captured from a device, the others built item by item."""

from __future__ import annotations

# SpaceNavigator (046d:c626), from public captures.
SPACENAVIGATOR = bytes.fromhex(
    "05010908a101a100850116a2fe265e013688fa467805550c65110930093109327510950381"
    "06c0a10085020933093409357510950381 06c0a1028503050105091901290215002501350045"
    "017501950281 02950e8103c0a102850405080 94b15002501950175019102950175079103c0"
    "0600ff0901a10215 80257f7508093aa102850509209501b102c0a102850609219501b102c0a1"
    "02850709229501b102c0a102850809239507b102c0a102850909249507b102c0a102850a0925"
    "9507b102c0a102850b09269501b102c0a1028513092e9501b102c0c0c0".replace(" ", "")
)


def item(tag: int, value: int, signed: bool = False) -> bytes:
    """Encode a short item with the smallest payload that holds the value."""
    for code, n in ((1, 1), (2, 2), (3, 4)):
        try:
            return bytes([tag | code]) + value.to_bytes(n, "little", signed=signed)
        except OverflowError:
            continue
    raise AssertionError(value)


def field(
    page: int,
    usages: list[int],
    size: int,
    low: int,
    high: int,
    *,
    flags: int = 2,
    main: int = 0x80,
    count: int | None = None,
) -> bytes:
    """Globals, usages and a main item."""
    out = item(0x04, page) + item(0x14, low, True) + item(0x24, high, True)
    out += item(0x74, size) + item(0x94, len(usages) if count is None else count)
    for usage in usages:
        out += item(0x08, usage)
    return out + item(main, flags)


def collection(page: int, usage: int, body: bytes, kind: int = 1) -> bytes:
    return item(0x04, page) + item(0x08, usage) + item(0xA0, kind) + body + b"\xc0"


def report_id(number: int) -> bytes:
    return item(0x84, number)


AXES = [0x30, 0x31, 0x32, 0x33, 0x34, 0x35]
LIGHT = (
    report_id(4)
    + field(8, [0x4B], 1, 0, 1, main=0x90)
    + field(8, [], 7, 0, 1, flags=3, main=0x90, count=1)
)


def buttons(n: int, padded_to: int) -> bytes:
    spare = padded_to - n
    out = field(9, list(range(1, n + 1)), 1, 0, 1)
    return out + (field(9, [], spare, 0, 1, flags=3, count=1) if spare else b"")


def split_mouse(n_buttons: int = 15) -> bytes:
    """Describe a mouse of an older model: translation in report 1, rotation in report 2."""
    body = report_id(1) + field(1, AXES[:3], 16, -350, 350)
    body += report_id(2) + field(1, AXES[3:], 16, -350, 350)
    return collection(1, 8, body + report_id(3) + buttons(n_buttons, 32) + LIGHT)


def combined_mouse(n_buttons: int = 31) -> bytes:
    """Describe a mouse of a newer model: all six axes in report 1."""
    body = report_id(1) + field(1, AXES, 16, -350, 350)
    return collection(1, 8, body + report_id(3) + buttons(n_buttons, 32) + LIGHT)


def pen(page: int = 0x0D) -> bytes:
    """A tablet of 200 x 100 mm with tilt, twist, eraser, two buttons and hover height."""
    cm = item(0x64, 0x11) + item(0x54, 0x0D)  # 10^-3 cm
    none = item(0x64, 0) + item(0x54, 0)
    length = cm + item(0x34, 0, True) + item(0x44, 20000, True) + field(1, [0x30], 16, 0, 20000)
    height = item(0x44, 10000, True) + field(1, [0x31], 16, 0, 10000)
    hover = item(0x44, 1000, True) + field(page, [0x3F], 16, 0, 1000)
    reset = none + item(0x34, 0, True) + item(0x44, 0, True)
    flags = field(page, [0x42, 0x44, 0x5A, 0x45, 0x3C, 0x32], 1, 0, 1)
    flags += field(page, [], 2, 0, 1, flags=3, count=1)
    degrees = field(page, [0x3D, 0x3E], 8, -60, 60) + field(page, [0x41], 16, 0, 359)
    force = field(page, [0x30], 16, 0, 8191)
    body = report_id(7) + flags + length + height + hover + reset + force + degrees
    return collection(page, 2, body)
