"""Numbers out of reports: pure functions from bytes and a field to a value."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from paint3d.device.descriptor import Field, Kind, ReportDescriptor
from paint3d.errors import DeviceError

__all__ = ["extract", "pack_report", "pressed", "scaled", "split_report"]


def split_report(descriptor: ReportDescriptor, data: bytes) -> tuple[int, bytes]:
    """The id of an input report (0 where none are numbered) and what follows it.

    Some systems pad every report to the longest one; what lies beyond the declared length is cut
    off.

    Raises
    ------
    DeviceError
        If the report is empty, its id is not declared, or it is shorter than declared.
    """
    if not data:
        raise DeviceError("an empty report")
    report_id = data[0] if descriptor.numbered else 0
    body = data[1:] if descriptor.numbered else data
    size = descriptor.size(Kind.INPUT, report_id)
    if not size:
        raise DeviceError(f"report id {report_id} is not among the device's input reports")
    if len(body) < size:
        raise DeviceError(f"report {report_id} has {len(body)} bytes; expected {size}")
    return report_id, body[:size]


def extract(field: Field, body: bytes) -> int:
    """The number of one field in a report's body (without its id).

    Numbers may start at any bit and cross bytes; the lowest bit comes first.
    """
    first, last = field.bit // 8, (field.bit + field.size + 7) // 8
    value = int.from_bytes(body[first:last], "little") >> (field.bit % 8)
    value &= (1 << field.size) - 1
    if field.signed and value >> (field.size - 1):
        value -= 1 << field.size
    return value


def scaled(field: Field, value: int) -> float | None:
    """The value in its logical range as 0 to 1; None outside of it (HID: no value)."""
    if field.high <= field.low or not field.low <= value <= field.high:
        return None
    return (value - field.low) / (field.high - field.low)


def pack_report(
    descriptor: ReportDescriptor, kind: Kind, report_id: int, values: Mapping[Field, int]
) -> bytes:
    """An output or feature report with its id byte (0 where reports are not numbered).

    Raises
    ------
    DeviceError
        If the report is not declared or a value does not fit its field.
    """
    size = descriptor.size(kind, report_id)
    if not size:
        raise DeviceError(f"the device has no {kind.value} report {report_id}")
    bits = 0
    for field, value in values.items():
        low, high = _bounds(field)
        if field.kind is not kind or field.report_id != report_id or not low <= value <= high:
            raise DeviceError(f"{value} does not fit the {field.size} bits of {field.usage:#x}")
        bits |= (value & ((1 << field.size) - 1)) << field.bit
    return bytes([report_id]) + bits.to_bytes(size, "little")


def pressed(fields: Iterable[Field], body: bytes, first_usage: int = 1) -> int:
    """Bit field of held buttons: bit 0 stands for `first_usage`; arrays list what is held."""
    buttons = 0
    for field in fields:
        value = extract(field, body)
        if field.variable:
            usage, held = field.usage, bool(value)
        else:
            usage, held = field.usage + value - field.low, field.low <= value <= field.high
            held = held and usage > 0
        place = usage - first_usage
        if held and 0 <= place < 31:
            buttons |= 1 << place
    return buttons


def _bounds(field: Field) -> tuple[int, int]:
    if field.signed:
        return -(1 << (field.size - 1)), (1 << (field.size - 1)) - 1
    return 0, (1 << field.size) - 1
