"""All that the compiler of kernels uses of numba's inside, where numba promises nothing.

Written for numba 0.68.1, which ``pyproject.toml`` pins for it (``compiler``). numba compiles one
function while its user waits; here it lowers four hundred, each once, and does no more
(`lower_only`), in half the time (`make_quick`): what it does over and over is done once. Neither
changes what is lowered. The functions of numba that are replaced are named in `REPLACED`, and each
replacement says what numba's own does. There is no way back for the process.

When numba changes: raise the pin; `tests/tools/test_numba_inside.py` names the functions that are
other ones now. Read what changed in each, carry it over to what stands in its place here (or drop
that: all of `make_quick` may go, for twice the time), and put the new digests into `REPLACED`. Then
build (``scripts/install``) and see that ``python -m tests.golden.hashes`` finds the same bytes.
"""

from __future__ import annotations

import hashlib
import inspect
from pkgutil import resolve_name
from typing import Any

import llvmlite.binding as llvm
from llvmlite.ir import types as ir_types
from numba import _dynfunc, njit
from numba.core import (
    callconv,
    cgutils,
    codegen,
    compiler_machinery,
    dispatcher,
    postproc,
    transforms,
    types,
)
from numba.core import ir as numba_ir
from numba.core.dispatcher import Dispatcher
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys
from numba.core.runtime.nrtdynmod import compile_nrt_functions
from numba.core.targetconfig import ConfigStack, TargetConfig
from numba.core.types import functions as function_types
from numba.extending import overload
from numba.np import arrayobj

from paint3d.core import kernel
from paint3d.core.numba_kernels import APART

__all__ = [
    "REPLACED",
    "Dispatcher",
    "cgutils",
    "digest_of",
    "libraries_called",
    "lower_only",
    "make_quick",
    "module_of",
    "target",
    "types",
]

REPLACED = {
    "numba.core.codegen:JITCodeLibrary._optimize_functions": "9439219fa946",
    "numba.core.codegen:JITCodeLibrary.finalize": "4b4c34b83488",
    "numba.core.codegen:JITCodeLibrary._get_module_for_linking": "56dde0e0555b",
    "numba.core.cpu:CPUContext.get_executable": "3892c8a654a2",
    "numba.core.dispatcher:_FunctionCompiler._customize_flags": "93779230cbca",
    "numba.core.callconv:CPUCallConv.build_excinfo_struct": "237fba740707",
    "numba.core.targetconfig:TargetConfig.__eq__": "6d8774572d07",
    "numba.core.targetconfig:TargetConfig.__hash__": "4d15a6c75137",
    "numba.core.types:Type.__hash__": "6d17f2083d7a",
    "numba.core.types:Type.__eq__": "0f3c6ac792e7",
    "numba.core.types.functions:BaseFunction.get_call_type": "6559c167bfc0",
    "llvmlite.ir.types:Type._get_ll_global_value_type": "2df13077775f",
    "numba.core.ir:Inst._rec_list_vars": "054700e9100b",
    "numba.core.postproc:PostProcessor.run": "e1a8e77d6f17",
    "numba.core.compiler_machinery:PassManager._runPass": "ecb83032771b",
    "numba.np.arrayobj:raise_with_shape_context": "66f2596b5fc6",
}
"""numba's functions that are replaced, and the digests of their sources (`digest_of`)."""


def digest_of(name: str) -> str:
    """The digest of the source of a function, by its name as `pkgutil.resolve_name` takes it."""
    return hashlib.sha256(inspect.getsource(resolve_name(name)).encode()).hexdigest()[:12]


# ---- Lowering alone ------------------------------------------------------------------------------


def target() -> Any:
    """numba's context of this processor: how types lie in memory, how functions are called."""
    return cpu_target.target_context


def module_of(library: Any) -> llvm.ModuleRef:
    """What was lowered of a function."""
    return library._get_module_for_linking()


def libraries_called(library: Any) -> list[Any]:
    """The libraries of the functions that a function calls."""
    return list(library._linking_libraries)


class _ThinLibrary(codegen.JITCodeLibrary):
    """Functions as they were lowered.

    numba's own optimises each function, then all with those that it calls, and makes machine code.
    """

    def _optimize_functions(self, ll_module: llvm.ModuleRef) -> None:
        ll_module.data_layout = self._codegen._data_layout

    def finalize(self) -> None:
        self._raise_if_finalized()
        self._finalized = True

    def _get_module_for_linking(self) -> llvm.ModuleRef:
        return self._final_module


def lower_only() -> None:
    """Have numba lower, and do no more."""
    context = target()
    context.refresh()
    context.codegen()._library_class = _ThinLibrary
    rtsys._library = compile_nrt_functions(context)  # as lowered, not for this very machine
    context.get_executable = _stand_in

    # numba's own sets the flags of a dispatcher's options: without wrappers for Python and C, and
    # with the one that `njit` has no option for
    customized = dispatcher._FunctionCompiler._customize_flags
    apart: set[Any] = set()

    def customize(self: Any, flags: Any) -> Any:
        flags = customized(self, flags)
        flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
        flags.noalias = self.py_func in apart
        return flags

    def compile_with_numba(function: Any, options: dict[str, Any]) -> Any:
        if options.get(APART):
            apart.add(function)
        told = {name: value for name, value in options.items() if name != APART}
        return njit(nogil=True, **told)(function)

    dispatcher._FunctionCompiler._customize_flags = customize
    kernel.compile_with_numba = compile_with_numba

    # numba's own puts the file and line of a ``raise`` into the code
    described = callconv.CPUCallConv.build_excinfo_struct

    def without_place(self: Any, exc: Any, args: Any, loc: Any, name: Any) -> Any:
        return described(self, exc, args, None, name)  # no path of this machine

    callconv.CPUCallConv.build_excinfo_struct = without_place


def _stand_in(library: Any, described: Any, env: Any) -> Any:
    """What numba knows a lowered function by; numba's own finds its machine code, here is none."""
    name = described.qualname.rpartition(".")[2]
    return _dynfunc.make_function(described.lookup_module(), name, "", 0, env, (library,))


# ---- In less time --------------------------------------------------------------------------------


def make_quick() -> None:
    """Change numba for the rest of this process."""
    _compare_flags_at_once()
    _hash_types_once()
    _find_calls_once()
    _measure_types_once()
    _find_variables_by_kind()
    _run_passes_plainly()
    _say_nothing_of_sizes()


def _compare_flags_at_once() -> None:
    """Flags are compared half a million times, by numba's own option by option."""
    defaults: dict[type, dict[str, Any]] = {}

    def all_of(flags: Any) -> dict[str, Any]:
        kind = type(flags)
        if kind not in defaults:
            defaults[kind] = {name: option.default for name, option in kind.options.items()}
        return defaults[kind] | flags._values

    def is_same(self: Any, other: Any) -> bool:
        return self is other or (
            isinstance(other, TargetConfig)
            and (self._values == other._values or all_of(self) == all_of(other))
        )

    TargetConfig.__eq__ = is_same
    TargetConfig.__hash__ = lambda self: hash(type(self))


def _hash_types_once() -> None:
    """The hash of a type: numba's own makes that of a tuple of a hundred arrays of as many."""

    def known_hash(self: Any) -> int:
        try:
            return self._hash
        except AttributeError:
            self._hash = hash(self.key)
            return self._hash

    def is_same(self: Any, other: Any) -> bool:
        return self is other or (self.__class__ is other.__class__ and self.key == other.key)

    types.Type.__hash__, types.Type.__eq__ = known_hash, is_same


def _find_calls_once() -> None:
    """Which function is called for ``a + b``: numba's own tries some thirty ways, each time."""
    find = function_types.BaseFunction.get_call_type
    known: dict[Any, Any] = {}

    def find_once(self: Any, context: Any, args: Any, kws: Any) -> Any:
        if not all(part.is_precise() for part in (*args, *kws.values())):
            return find(self, context, args, kws)
        asked = (id(self), args, tuple(kws.items()), ConfigStack.top_or_none())
        if asked not in known:
            signature = find(self, context, args, kws)
            known[asked] = signature, self._impl_keys[signature.args], self
        signature, self._impl_keys[signature.args], _ = known[asked]
        return signature

    function_types.BaseFunction.get_call_type = find_once


def _measure_types_once() -> None:
    """The size of a type: llvmlite's own makes a module and reads it, each time."""
    find = ir_types.Type._get_ll_global_value_type
    known: dict[str, Any] = {}

    def find_once(self: Any, target_data: Any, context: Any = None) -> Any:
        name = str(self)
        if name not in known:
            known[name] = find(self, target_data, context)
        return known[name]

    ir_types.Type._get_ll_global_value_type = find_once


def _find_variables_by_kind() -> None:
    """The variables of an instruction: numba's own looks at all that it holds.

    Most of that is no variable, and known to be none by its type.
    """

    def variables_in(self: Any, value: Any) -> list[numba_ir.Var]:
        kind = type(value)
        if kind is numba_ir.Var:
            return [value]
        if kind in (str, int, numba_ir.Loc, type(None), bool, float):
            return []
        if kind is list or kind is tuple:
            return [found for part in value for found in variables_in(self, part)]
        if kind is dict:
            return [found for part in value.values() for found in variables_in(self, part)]
        return value.list_vars() if isinstance(value, numba_ir.Inst) else []

    numba_ir.Inst._rec_list_vars = variables_in


def _run_passes_plainly() -> None:
    """Run passes: numba's own times each of thirty, tells listeners, and analyses lifetimes.

    Lifetimes are asked for once, before a function is lowered.
    """
    finish = postproc.PostProcessor.run
    registry = compiler_machinery._pass_registry

    def finish_where_asked(self: Any, emit_dels: bool = False, **options: Any) -> None:
        if emit_dels or self.func_ir.is_generator:
            finish(self, emit_dels, **options)
            return
        self.func_ir.blocks = transforms.canonicalize_cfg(self.func_ir.blocks)
        self.func_ir.variable_lifetime = postproc.VariableLifetime(self.func_ir.blocks)
        self.func_ir.generator_info = None

    def run_pass(self: Any, index: int, step: Any, state: Any) -> None:
        step.analysis = self._analysis
        has_changed = step.run_initialization(state)
        has_changed |= step.run_pass(state)
        has_changed |= step.run_finalizer(state)
        if registry.get(step.__class__).mutates_CFG:
            if has_changed:
                finish_where_asked(postproc.PostProcessor(state.func_ir))
            else:
                state.func_ir.blocks = transforms.canonicalize_cfg(state.func_ir.blocks)

    postproc.PostProcessor.run = finish_where_asked
    compiler_machinery.PassManager._runPass = run_pass


def _say_nothing_of_sizes() -> None:
    """Where arrays of different sizes meet: numba's own says both sizes in a text.

    That would need a hundred functions more.
    """

    def say_unequal(source: Any, target: Any) -> None:
        raise NotImplementedError

    @overload(say_unequal)
    def _(source: Any, target: Any) -> Any:
        def say(source: Any, target: Any) -> None:
            raise ValueError("cannot assign slice from input of different size")

        return say

    arrayobj.raise_with_shape_context = say_unequal
