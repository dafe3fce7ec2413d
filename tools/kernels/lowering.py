"""From kernels to LLVM's language: every function inferred and lowered once by numba.

numba, left alone, optimises a function, and turns it into machine code with wrappers for calls from
Python and C, before it lowers the one that calls it: ten times over where calls are ten deep. Here
it does none of this: what is lowered is kept as it is, and optimised when all is there.

Every entry is a function of C, ``int kernel(const int64_t *takes, int64_t *gives)``: what a kernel
takes and gives stands in rows of eight bytes each, an array as the place of its first element and
its shape.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from paint3d.core.numba_kernels import llvm_name
from tools.kernels.processors import own_least
from tools.kernels.table import TABLE, Array, Entry, Number, Row, TableError, dtype_of, resolve

os.environ["PAINT3D_KERNELS"] = "numba"
os.environ["NUMBA_CPU_NAME"] = llvm_name(own_least())  # says nothing yet: see `optimising`
os.environ["NUMBA_CPU_FEATURES"] = ""

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir
from numba.core.errors import NumbaError
from numba.np.numpy_support import from_dtype

from tools.kernels.numba_inside import (
    Dispatcher,
    cgutils,
    libraries_called,
    lower_only,
    make_quick,
    module_of,
    target,
    types,
)

__all__ = ["Lowered", "Unit", "lower"]

_INT32, _INT64, _DOUBLE = ir.IntType(32), ir.IntType(64), ir.DoubleType()


@dataclass
class Unit:
    """One function that numba has lowered, with what it needs beside it."""

    module: llvm.ModuleRef
    calls: list[int]  # places of the units whose functions it calls
    is_elementwise: bool  # of single hairs: its loops become vector instructions


@dataclass
class Lowered:
    """All that belongs to some entries."""

    units: list[Unit]  # those that are called come before those that call them
    entries: llvm.ModuleRef  # the functions of C
    gives: dict[str, tuple[str, int]]  # by their names: specification and number of slots


def lower(entries: dict[str, Entry], say: Callable[[], None] = lambda: None) -> Lowered:
    """Lower entries and all that they call. A process can do so once.

    Parameters
    ----------
    entries : dict
        By the names of their functions of C.
    say : callable
        Called after each.
    """
    make_quick()
    lower_only()
    context = target()
    own = ir.Module("entries")
    own.triple, own.data_layout = llvm.get_process_triple(), context.codegen()._data_layout
    libraries, gives = [], {}
    for symbol, entry in entries.items():
        called = resolve(f"{entry.module}.{entry.name}")
        signature = tuple(_numba_type(part) for part in entry.takes.values())
        try:
            called.compile(signature)
        except NumbaError as error:
            what = f"{TABLE.name}:{entry.line}: {entry.kernel} cannot be compiled for these types"
            raise TableError(f"{what}: {error}") from None
        result = called.overloads[signature]
        libraries.append(result.library)
        gives[symbol] = _build_entry(context, own, symbol, result)
        say()
    return Lowered(_in_order(libraries), llvm.parse_assembly(str(own)), gives)


def _numba_type(part: Number | Array | Row) -> types.Type:
    if isinstance(part, Number):
        return from_dtype(np.dtype(part.code))
    if isinstance(part, Array):
        return types.Array(from_dtype(dtype_of(part)), part.axes, "C")
    parts = [_numba_type(inner) for inner in part.parts]
    if not part.of:
        return types.Tuple(parts)
    return types.BaseTuple.from_types(parts, resolve(part.of))


def letter(dtype: np.dtype) -> str:
    """How a specification names a type of numbers: see caller.c."""
    return chr(ord("A") + dtype.num)


class _Slots:
    """A row of eight-byte places, one after another."""

    def __init__(self, builder: ir.IRBuilder, base: ir.Value) -> None:
        self._builder, self._base, self.count = builder, base, 0

    def _next(self, of: ir.Type) -> ir.Value:
        place = self._builder.gep(self._base, [ir.Constant(_INT64, self.count)])
        self.count += 1
        return self._builder.bitcast(place, of.as_pointer())

    def load(self, of: ir.Type = _INT64) -> ir.Value:
        return self._builder.load(self._next(of))

    def store(self, value: ir.Value) -> None:
        self._builder.store(value, self._next(value.type))


def _build_entry(context: Any, module: ir.Module, symbol: str, result: Any) -> tuple[str, int]:
    """Build the function of C around a kernel; what it gives, and in how many slots."""
    signature, described = result.signature, result.fndesc
    context.declare_function(module, described)
    row = _INT64.as_pointer()
    function = ir.Function(module, ir.FunctionType(_INT32, [row, row]), symbol)
    builder = ir.IRBuilder(function.append_basic_block())
    slots = _Slots(builder, function.args[0])
    takes = [_read(context, builder, slots, part) for part in signature.args]
    callee = module.globals[described.llvm_func_name]
    status, value = context.call_conv.call_function(
        builder, callee, signature.return_type, signature.args, takes
    )
    with builder.if_else(status.is_ok, likely=True) as (went_well, failed):
        with went_well:
            gives = _Slots(builder, function.args[1])
            given = _write(context, builder, gives, signature.return_type, value)
        with failed, builder.if_then(status.is_user_exc):
            error = builder.load(status.excinfoptr)
            told = _Slots(builder, function.args[1])
            told.store(builder.ptrtoint(builder.extract_value(error, 0), _INT64))
            told.store(builder.sext(builder.extract_value(error, 1), _INT64))
    builder.ret(status.code)
    return given, max(gives.count, told.count)


def _read(context: Any, builder: ir.IRBuilder, slots: _Slots, of: types.Type) -> ir.Value:
    """Read a value of a numba type from slots."""
    if isinstance(of, types.Array):
        return _read_array(context, builder, slots, of)
    if isinstance(of, types.BaseTuple):
        parts = [_read(context, builder, slots, part) for part in of.types]
        return context.make_tuple(builder, of, parts)
    if isinstance(of, types.Float):
        value = slots.load(_DOUBLE)
        return value if of.bitwidth == 64 else builder.fptrunc(value, ir.FloatType())
    if isinstance(of, types.Boolean):
        return builder.trunc(slots.load(), ir.IntType(1))
    assert of == types.int64, of
    return slots.load()


def _read_array(context: Any, builder: ir.IRBuilder, slots: _Slots, of: types.Array) -> ir.Value:
    array = context.make_array(of)(context, builder)
    data, shape = slots.load(), [slots.load() for _ in range(of.ndim)]
    item = ir.Constant(_INT64, context.get_abi_sizeof(context.get_data_type(of.dtype)))
    strides, stride, count = [], item, ir.Constant(_INT64, 1)
    for n in reversed(shape):
        strides.insert(0, stride)
        stride, count = builder.mul(stride, n), builder.mul(count, n)
    array.data = builder.inttoptr(data, array.data.type)
    array.shape = cgutils.pack_array(builder, shape, _INT64)
    array.strides = cgutils.pack_array(builder, strides, _INT64)
    array.itemsize, array.nitems = item, count
    array.meminfo = cgutils.get_null_value(array.meminfo.type)  # whoever calls holds it
    array.parent = cgutils.get_null_value(array.parent.type)
    return array._getvalue()


def _write(
    context: Any, builder: ir.IRBuilder, slots: _Slots, of: types.Type, value: ir.Value
) -> str:
    """Write a value into slots; what it is, as `specification` says it."""
    if isinstance(of, types.NoneType):
        return "n"
    if isinstance(of, types.BaseAnonymousTuple):
        parts = (
            _write(context, builder, slots, part, builder.extract_value(value, k))
            for k, part in enumerate(of.types)
        )
        return f"({''.join(parts)})"
    if isinstance(of, types.Array):
        assert of.layout == "C", of
        array = context.make_array(of)(context, builder, value=value)
        slots.store(builder.ptrtoint(array.data, _INT64))
        for axis in range(of.ndim):
            slots.store(builder.extract_value(array.shape, axis))
        slots.store(builder.ptrtoint(array.meminfo, _INT64))
        return f"[{letter(np.dtype(of.dtype.name))}{of.ndim}"
    if isinstance(of, types.Float):
        slots.store(value if of.bitwidth == 64 else builder.fpext(value, _DOUBLE))
        return "d"
    if isinstance(of, types.Boolean):
        slots.store(builder.zext(value, _INT64))
        return "b"
    assert isinstance(of, types.Integer), of
    if of.bitwidth < 64:
        value = (builder.sext if of.signed else builder.zext)(value, _INT64)
    slots.store(value)
    return "i" if of.signed or of.bitwidth < 64 else "u"


def _in_order(libraries: list[Any]) -> list[Unit]:
    """All libraries that are reached, what is called before what calls it."""
    elementwise = {
        id(result.library)
        for module in list(sys.modules.values())
        if module.__name__.startswith("paint3d.")
        for kernel in vars(module).values()
        if isinstance(kernel, Dispatcher) and kernel.targetoptions.get("fastmath")
        for result in kernel.overloads.values()
    }
    units: list[Unit] = []
    place: dict[int, int] = {}

    def visit(library: Any) -> None:
        if id(library) in place:
            return
        place[id(library)] = -1
        for other in libraries_called(library):
            visit(other)
        place[id(library)] = len(units)
        calls = [place[id(other)] for other in libraries_called(library)]
        units.append(Unit(module_of(library), calls, id(library) in elementwise))

    sys.setrecursionlimit(10_000)
    for library in libraries:
        visit(library)
    return units
