"""HID report descriptors: the layout of a device's reports (USB HID 1.11, section 6.2.2).

A device describes its own reports. Parsing that description, instead of keeping a table of byte
positions per model, supports unlisted devices, whichever report holds their axes. The parser is
strict where a wrong guess would be dangerous (sizes, nesting, counts) and skips items that do not
change the layout (strings, designators).
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
    """Type of a report: from the device, to it, or configuration."""

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
        0 if the device does not number its reports.
    bit, size : int
        Offset in bits after the report id, and width in bits.
    page, usage : int
        HID usage; of an array, the page and the lowest usage.
    application : int
        Page and usage (``page << 16 | usage``) of the enclosing application collection.
    low, high : int
        Logical range. `high` of an unsigned field is read as unsigned.
    physical_low, physical_high : int
        Physical range; the logical one if the device gives none.
    unit, exponent : int
        HID unit code and power of ten.
    variable, relative, constant : bool
        Flags; an array (not variable) holds indices of usages.
    last_usage : int
        For an array, the usage of its highest index; else `usage`.
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
        """True if the bits are a two's complement number."""
        return self.low < 0


@dataclass(frozen=True)
class ReportDescriptor:
    """A parsed descriptor.

    Attributes
    ----------
    fields : tuple of Field
        In the order of declaration, without padding.
    applications : tuple of int
        Page and usage of every application collection, ``page << 16 | usage``.
    numbered : bool
        True if reports begin with their id.
    bits : dict
        Length in bits of every (kind, report id), without the id byte.
    """

    fields: tuple[Field, ...]
    applications: tuple[int, ...]
    numbered: bool
    bits: dict[tuple[Kind, int], int]

    def inputs_in(self, applications: tuple[int, ...]) -> tuple[Field, ...]:
        """Input fields in application collections of these pages and usages."""
        return tuple(
            f for f in self.fields if f.kind is Kind.INPUT and f.application in applications
        )

    def size(self, kind: Kind, report_id: int) -> int:
        """Length of a report in bytes, without its id; 0 if it is not declared."""
        return (self.bits.get((kind, report_id), 0) + 7) // 8


@dataclass
class _Globals:
    """Values of the global items, which hold until they are set again."""

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
    """State of the parser: global items, local items, and what has been declared so far."""

    settings: _Globals = field(default_factory=_Globals)
    stack: list[_Globals] = field(default_factory=list)
    collections: list[int] = field(default_factory=list)  # the application of each open one
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
        If it is empty, longer than 4096 bytes, truncated, wrongly nested, or declares impossible
        reports.
    """
    if not 0 < len(data) <= _MAX_BYTES:
        raise DeviceError(
            "report descriptor has {n} bytes; expected 1 to {most}",
            n=len(data),
            most=_MAX_BYTES,
        )
    state = _State()
    for at, tag, payload in _items(data):
        try:
            _apply(state, tag, payload)
        except DeviceError as cause:
            raise DeviceError("report descriptor, byte {at}: {cause}", at=at, cause=cause) from None
    if state.collections:
        raise DeviceError("report descriptor: {n} collections never end", n=len(state.collections))
    return ReportDescriptor(
        tuple(state.fields), tuple(state.applications), state.numbered, state.bits
    )


def _items(data: bytes) -> Iterator[tuple[int, int, bytes]]:
    """Yield offset, tag with type, and payload of every item; long items are skipped."""
    at = 0
    while at < len(data):
        prefix = data[at]
        if prefix == _LONG:
            size = 2 + (data[at + 1] if at + 1 < len(data) else 0)
        else:
            size = (0, 1, 2, 4)[prefix & 3]
        end = at + 1 + size
        if end > len(data):
            raise DeviceError("report descriptor is cut short in the item at byte {at}", at=at)
        if prefix != _LONG:
            yield at, prefix & 0xFC, data[at + 1 : end]
        at = end


def _apply(state: _State, tag: int, payload: bytes) -> None:
    """Apply one item to the parser's state."""
    value = int.from_bytes(payload, "little", signed=tag in _SIGNED)
    kind = {_INPUT: Kind.INPUT, _OUTPUT: Kind.OUTPUT, _FEATURE: Kind.FEATURE}.get(tag)
    if kind is not None:
        _add_fields(state, kind, value)
    elif tag == _COLLECTION:
        if len(state.collections) >= _MAX_DEPTH:
            raise DeviceError("collections nested deeper than {most}", most=_MAX_DEPTH)
        application = state.collections[-1] if state.collections else 0
        if value == _APPLICATION:
            application = state.usages[0][0] if state.usages else 0
            state.applications.append(application)
        state.collections.append(application)
    elif tag == _END:
        if not state.collections:
            raise DeviceError("a collection ends that never began")
        state.collections.pop()
    elif tag & 0x0C == 0x08:  # type bits 2: a local item
        _set_local(state, tag, value, len(payload))
        return
    else:
        _set_global(state, tag, value, payload)
        return
    state.usages.clear()  # a main item ends the validity of local ones
    state.lowest = None


def _set_local(state: _State, tag: int, value: int, size: int) -> None:
    full = value if size == 4 else state.settings.page << 16 | value  # four bytes hold the page
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
        raise DeviceError("more than {most} usages", most=_MAX_FIELDS)


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
            raise DeviceError("report id {value}; expected 1 to 255", value=value)
        state.numbered = True
    elif tag == _PUSH:
        if len(state.stack) >= _MAX_DEPTH:
            raise DeviceError("pushes nested deeper than {most}", most=_MAX_DEPTH)
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
        raise DeviceError(
            "report {report} is longer than {most} bytes",
            report=s.report_id,
            most=_MAX_REPORT_BITS // 8,
        )
    if s.size and s.count:
        state.bits[key] = start + s.size * s.count
    constant, variable, relative = bool(flags & 1), bool(flags & 2), bool(flags & 4)
    if (constant and not state.usages) or not s.size:
        return
    if len(state.fields) + s.count > _MAX_FIELDS:
        raise DeviceError("more than {most} fields", most=_MAX_FIELDS)
    high = s.high
    if s.low >= 0 and high < s.low and s.high_bits:
        high &= (1 << s.high_bits) - 1  # 25 ff is 255, not -1, if the minimum is not negative
    stated = (s.physical_low, s.physical_high)
    physical_low, physical_high = stated if stated != (0, 0) else (s.low, high)
    for i, (first, last) in zip(range(s.count), _usages_of(state, variable), strict=False):
        state.fields.append(
            Field(
                kind=kind,
                report_id=s.report_id,
                bit=start + i * s.size,
                size=s.size,
                page=first >> 16,
                usage=first & 0xFFFF,
                application=state.collections[-1] if state.collections else 0,
                low=s.low,
                high=high,
                physical_low=physical_low,
                physical_high=physical_high,
                unit=s.unit,
                exponent=s.exponent,
                variable=variable,
                relative=relative,
                constant=constant,
                last_usage=last & 0xFFFF,
            )
        )


def _usages_of(state: _State, variable: bool) -> Iterator[tuple[int, int]]:
    """Yield, without end, the first and last usage of each field.

    Variables have one usage each, the last one repeated; an array has the whole range.
    """
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


def split_report(descriptor: ReportDescriptor, data: bytes) -> tuple[int, bytes]:
    """Split an input report into its id (0 if reports are not numbered) and its body.

    Some systems pad every report to the longest one; bytes beyond the declared length are cut off.

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
        raise DeviceError(
            "report id {report} is not among the device's input reports",
            report=report_id,
        )
    if len(body) < size:
        raise DeviceError(
            "report {report} has {n} bytes; expected {size}",
            report=report_id,
            n=len(body),
            size=size,
        )
    return report_id, body[:size]


def extract(field: Field, body: bytes) -> int:
    """Extract one field's number from a report's body (without its id).

    Numbers may start at any bit and cross bytes; the lowest bit comes first.
    """
    first, last = field.bit // 8, (field.bit + field.size + 7) // 8
    value = int.from_bytes(body[first:last], "little") >> (field.bit % 8)
    value &= (1 << field.size) - 1
    if field.signed and value >> (field.size - 1):
        value -= 1 << field.size
    return value


def scaled(field: Field, value: int) -> float | None:
    """Scale a value from its logical range to 0 to 1; None outside of it (HID: no value)."""
    if field.high <= field.low or not field.low <= value <= field.high:
        return None
    return (value - field.low) / (field.high - field.low)


def pack_report(
    descriptor: ReportDescriptor, kind: Kind, report_id: int, values: Mapping[Field, int]
) -> bytes:
    """Pack an output or feature report, with its id byte (0 if reports are not numbered).

    Raises
    ------
    DeviceError
        If the report is not declared or a value does not fit its field.
    """
    size = descriptor.size(kind, report_id)
    if not size:
        raise DeviceError(
            "the device has no {kind} report {report}",
            kind=kind.value,
            report=report_id,
        )
    bits = 0
    for part, value in values.items():
        span = 1 << (part.size - part.signed)
        low, high = (-span if part.signed else 0), span - 1
        if part.kind is not kind or part.report_id != report_id or not low <= value <= high:
            raise DeviceError(
                "{value} does not fit the {n_bits} bits of {usage:#x}",
                value=value,
                n_bits=part.size,
                usage=part.usage,
            )
        bits |= (value & ((1 << part.size) - 1)) << part.bit
    return bytes([report_id]) + bits.to_bytes(size, "little")


def pressed(fields: Iterable[Field], body: bytes, first_usage: int = 1) -> int:
    """Collect pressed buttons in a bit field, whose bit 0 is `first_usage`."""
    buttons = 0
    for part in fields:
        value = extract(part, body)
        if part.variable:
            usage, is_down = part.usage, bool(value)
        else:  # an array lists the buttons that are down
            usage, is_down = part.usage + value - part.low, part.low <= value <= part.high
            is_down = is_down and usage > 0
        bit = usage - first_usage
        if is_down and 0 <= bit < 31:
            buttons |= 1 << bit
    return buttons
