"""HID report descriptors: what each bit of a report means (USB HID 1.11, section 6.2.2).

A device describes its own reports. Reading that description, instead of a table of byte
positions per model, makes devices work that nobody has listed, on whatever report they put their
axes. The parser is strict where a wrong guess would be dangerous (sizes, nesting, counts) and
passes over what does not change the layout (strings, designators, units). Then numbers come out
of reports by pure functions, from bytes and a field to a value.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum

from paint3d.errors import DeviceError

__all__ = [
    "Field",
    "Kind",
    "ReportDescriptor",
    "extract",
    "pack_report",
    "parse_descriptor",
    "pressed",
    "scaled",
    "split_report",
]

_MAX_BYTES = 4096  # HID_MAX_DESCRIPTOR_SIZE of Linux; no device may send more
_MAX_FIELDS = 4096
_MAX_REPORT_BITS = 8 * 4096
_MAX_DEPTH = 16

# Item tags with their type, as in the table of section 6.2.2.
_INPUT, _OUTPUT, _COLLECTION, _FEATURE, _END = 0x80, 0x90, 0xA0, 0xB0, 0xC0
_PAGE, _LOGICAL_LOW, _LOGICAL_HIGH, _PHYSICAL_LOW, _PHYSICAL_HIGH = 0x04, 0x14, 0x24, 0x34, 0x44
_EXPONENT, _UNIT, _SIZE, _ID, _COUNT, _PUSH, _POP = 0x54, 0x64, 0x74, 0x84, 0x94, 0xA4, 0xB4
_USAGE, _USAGE_LOW, _USAGE_HIGH = 0x08, 0x18, 0x28
_LONG = 0xFE
_APPLICATION = 1
_SIGNED = {_LOGICAL_LOW, _LOGICAL_HIGH, _PHYSICAL_LOW, _PHYSICAL_HIGH}


class Kind(Enum):
    """Which way a report goes."""

    INPUT = "input"
    OUTPUT = "output"
    FEATURE = "feature"


@dataclass(frozen=True, slots=True)
class Field:
    """One number in a report.

    Attributes
    ----------
    kind : Kind
    report_id : int
        0 where the device numbers no reports.
    bit, size : int
        Offset in bits after the report id, and width in bits.
    page, usage : int
        HID usage; of an array, the page and the lowest usage.
    application : int
        Page and usage (``page << 16 | usage``) of the application collection around it.
    low, high : int
        Logical range. `high` of an unsigned field is read as unsigned.
    physical_low, physical_high : int
        Physical range; equal to the logical one where the device gives none.
    unit, exponent : int
        HID unit code and power of ten.
    variable, relative, constant : bool
        Flags; an array (not variable) holds indices of usages.
    last_usage : int
        Of an array, the usage of its highest index; else `usage`.
    """

    kind: Kind
    report_id: int
    bit: int
    size: int
    page: int
    usage: int
    application: int
    low: int
    high: int
    physical_low: int
    physical_high: int
    unit: int
    exponent: int
    variable: bool
    relative: bool
    constant: bool
    last_usage: int

    @property
    def signed(self) -> bool:
        """Whether the bits are a two's complement number."""
        return self.low < 0


@dataclass(frozen=True)
class ReportDescriptor:
    """A parsed descriptor.

    Attributes
    ----------
    fields : tuple of Field
        In the order in which they were declared, padding left out.
    applications : tuple of int
        Page and usage of every application collection, ``page << 16 | usage``.
    numbered : bool
        Whether reports begin with their id.
    bits : dict
        Length in bits of every (kind, report id), without the id byte.
    """

    fields: tuple[Field, ...]
    applications: tuple[int, ...]
    numbered: bool
    bits: dict[tuple[Kind, int], int]

    def inputs_in(self, applications: tuple[int, ...]) -> tuple[Field, ...]:
        """Input fields within application collections of these page and usage numbers."""
        return tuple(
            f for f in self.fields if f.kind is Kind.INPUT and f.application in applications
        )

    def size(self, kind: Kind, report_id: int) -> int:
        """Bytes of a report without its id; 0 for one that is not declared."""
        return (self.bits.get((kind, report_id), 0) + 7) // 8


@dataclass
class _Globals:
    page: int = 0
    low: int = 0
    high: int = 0
    high_bits: int = 0
    physical_low: int = 0
    physical_high: int = 0
    unit: int = 0
    exponent: int = 0
    size: int = 0
    count: int = 0
    report_id: int = 0


@dataclass
class _State:
    settings: _Globals = field(default_factory=_Globals)
    stack: list[_Globals] = field(default_factory=list)
    collections: list[int] = field(default_factory=list)  # application each one lies in
    usages: list[tuple[int, int]] = field(default_factory=list)  # (first, last), with page
    lowest: int | None = None
    fields: list[Field] = field(default_factory=list)
    applications: list[int] = field(default_factory=list)
    bits: dict[tuple[Kind, int], int] = field(default_factory=dict)
    numbered: bool = False


def parse_descriptor(data: bytes) -> ReportDescriptor:
    """Parse a report descriptor.

    Raises
    ------
    DeviceError
        If it is empty, longer than 4096 bytes, cut short, wrongly nested, or declares reports
        that cannot be.
    """
    if not 0 < len(data) <= _MAX_BYTES:
        raise DeviceError(f"report descriptor has {len(data)} bytes; expected 1 to {_MAX_BYTES}")
    state = _State()
    for at, tag, payload in _items(data):
        try:
            _apply(state, tag, payload)
        except DeviceError as cause:
            raise DeviceError(f"report descriptor, byte {at}: {cause}") from None
    if state.collections:
        raise DeviceError(f"report descriptor: {len(state.collections)} collections never end")
    return ReportDescriptor(
        tuple(state.fields), tuple(state.applications), state.numbered, state.bits
    )


def _items(data: bytes) -> Iterator[tuple[int, int, bytes]]:
    """Offset, tag with type, and payload of every item; long items are passed over."""
    at = 0
    while at < len(data):
        prefix = data[at]
        if prefix == _LONG:
            size = 2 + (data[at + 1] if at + 1 < len(data) else 0)
        else:
            size = (0, 1, 2, 4)[prefix & 3]
        end = at + 1 + size
        if end > len(data):
            raise DeviceError(f"report descriptor is cut short in the item at byte {at}")
        if prefix != _LONG:
            yield at, prefix & 0xFC, data[at + 1 : end]
        at = end


def _apply(state: _State, tag: int, payload: bytes) -> None:
    value = int.from_bytes(payload, "little", signed=tag in _SIGNED)
    kind = {_INPUT: Kind.INPUT, _OUTPUT: Kind.OUTPUT, _FEATURE: Kind.FEATURE}.get(tag)
    if kind is not None:
        _add_fields(state, kind, value)
    elif tag == _COLLECTION:
        _open_collection(state, value)
    elif tag == _END:
        if not state.collections:
            raise DeviceError("a collection ends that never began")
        state.collections.pop()
    elif tag & 0x0C == 0x08:
        _set_local(state, tag, value, len(payload))
        return
    else:
        _set_global(state, tag, value, payload)
        return
    state.usages.clear()
    state.lowest = None


def _open_collection(state: _State, value: int) -> None:
    if len(state.collections) >= _MAX_DEPTH:
        raise DeviceError(f"collections nested deeper than {_MAX_DEPTH}")
    inside = state.collections[-1] if state.collections else 0
    if value == _APPLICATION:
        inside = state.usages[0][0] if state.usages else 0
        state.applications.append(inside)
    state.collections.append(inside)


def _set_local(state: _State, tag: int, value: int, size: int) -> None:
    full = value if size == 4 else state.settings.page << 16 | value
    if tag == _USAGE:
        state.usages.append((full, full))
    elif tag == _USAGE_LOW:
        state.lowest = full
    elif tag == _USAGE_HIGH:
        if state.lowest is None or full < state.lowest:
            raise DeviceError("a usage maximum without a minimum below it")
        state.usages.append((state.lowest, full))
        state.lowest = None
    if len(state.usages) > _MAX_FIELDS:
        raise DeviceError(f"more than {_MAX_FIELDS} usages")


def _set_global(state: _State, tag: int, value: int, payload: bytes) -> None:
    settings = state.settings
    names = {
        _PAGE: "page",
        _LOGICAL_LOW: "low",
        _LOGICAL_HIGH: "high",
        _PHYSICAL_LOW: "physical_low",
        _PHYSICAL_HIGH: "physical_high",
        _UNIT: "unit",
        _SIZE: "size",
        _COUNT: "count",
        _ID: "report_id",
    }
    if tag in names:
        setattr(settings, names[tag], value)
    if tag == _LOGICAL_HIGH:
        settings.high_bits = 8 * len(payload)
    elif tag == _EXPONENT:
        settings.exponent = (value & 0xF) - 16 if value & 8 else value & 0xF  # a signed nibble
    elif tag == _ID:
        if not 1 <= value <= 255:
            raise DeviceError(f"report id {value}; expected 1 to 255")
        state.numbered = True
    elif tag == _PUSH:
        if len(state.stack) >= _MAX_DEPTH:
            raise DeviceError(f"pushes nested deeper than {_MAX_DEPTH}")
        state.stack.append(_Globals(**vars(settings)))
    elif tag == _POP:
        if not state.stack:
            raise DeviceError("a pop without a push")
        state.settings = state.stack.pop()


def _add_fields(state: _State, kind: Kind, flags: int) -> None:
    s = state.settings
    key = (kind, s.report_id)
    start = state.bits.get(key, 0)
    if s.size * s.count > _MAX_REPORT_BITS - start:
        raise DeviceError(f"report {s.report_id} is longer than {_MAX_REPORT_BITS // 8} bytes")
    if s.size and s.count:
        state.bits[key] = start + s.size * s.count
    constant, variable = bool(flags & 1), bool(flags & 2)
    if (constant and not state.usages) or not s.size:
        return
    if len(state.fields) + s.count > _MAX_FIELDS:
        raise DeviceError(f"more than {_MAX_FIELDS} fields")
    for i, (first, last) in zip(range(s.count), _spread(state, variable), strict=False):
        state.fields.append(_make_field(state, kind, flags, start + i * s.size, first, last))


def _spread(state: _State, variable: bool) -> Iterator[tuple[int, int]]:
    """First and last usage of each number: one each; the last one holds for the rest."""
    usages = state.usages or [(0, 0)]
    if not variable:
        low, high = usages[0][0], usages[-1][1]
        while True:
            yield low, high
    for first, last in usages:
        for usage in range(first, min(last, first + _MAX_FIELDS) + 1):
            yield usage, usage
    while True:
        yield usages[-1][1], usages[-1][1]


def _make_field(
    state: _State, kind: Kind, flags: int, bit: int, usage: int, last_usage: int
) -> Field:
    s = state.settings
    high = s.high
    if s.low >= 0 and high < s.low and s.high_bits:
        high &= (1 << s.high_bits) - 1  # 25 ff: 255, not -1, where nothing is negative
    given = (s.physical_low, s.physical_high)
    physical = given if given != (0, 0) else (s.low, high)
    return Field(
        kind,
        s.report_id,
        bit,
        s.size,
        usage >> 16,
        usage & 0xFFFF,
        state.collections[-1] if state.collections else 0,
        s.low,
        high,
        *physical,
        s.unit,
        s.exponent,
        bool(flags & 2),
        bool(flags & 4),
        bool(flags & 1),
        last_usage & 0xFFFF,
    )


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
    for part, value in values.items():
        low, high = _bounds(part)
        if part.kind is not kind or part.report_id != report_id or not low <= value <= high:
            raise DeviceError(f"{value} does not fit the {part.size} bits of {part.usage:#x}")
        bits |= (value & ((1 << part.size) - 1)) << part.bit
    return bytes([report_id]) + bits.to_bytes(size, "little")


def pressed(fields: Iterable[Field], body: bytes, first_usage: int = 1) -> int:
    """Bit field of held buttons: bit 0 stands for `first_usage`; arrays list what is held."""
    buttons = 0
    for part in fields:
        value = extract(part, body)
        if part.variable:
            usage, held = part.usage, bool(value)
        else:
            usage, held = part.usage + value - part.low, part.low <= value <= part.high
            held = held and usage > 0
        place = usage - first_usage
        if held and 0 <= place < 31:
            buttons |= 1 << place
    return buttons


def _bounds(field: Field) -> tuple[int, int]:
    if field.signed:
        return -(1 << (field.size - 1)), (1 << (field.size - 1)) - 1
    return 0, (1 << field.size) - 1
