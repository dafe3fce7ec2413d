"""Have numba lower the same functions in less time: what it does over and over is done once.

It was made to compile one function while its user waits, not four hundred, of which many are handed
a hundred arrays. Left alone it takes twice as long. Nothing here changes what is lowered.
"""

from __future__ import annotations

from typing import Any

from llvmlite.ir import types as ir_types
from numba.core import compiler_machinery, postproc, transforms, types
from numba.core import ir as numba_ir
from numba.core.targetconfig import ConfigStack, TargetConfig
from numba.core.types import functions as function_types
from numba.extending import overload
from numba.np import arrayobj

__all__ = ["make_quick"]


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
    """Flags are compared half a million times, option by option."""
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
    """The hash of a tuple of a hundred arrays is made of as many; types do not change."""

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
    """What is called for ``a + b`` is looked for among some thirty ways to add, each time."""
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
    """To tell the size of a type, a module is made and read."""
    find = ir_types.Type._get_ll_global_value_type
    known: dict[str, Any] = {}

    def find_once(self: Any, target_data: Any, context: Any = None) -> Any:
        name = str(self)
        if name not in known:
            known[name] = find(self, target_data, context)
        return known[name]

    ir_types.Type._get_ll_global_value_type = find_once


def _find_variables_by_kind() -> None:
    """Most of what an instruction holds is no variable, and known to be none by its type."""

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
    """Each of thirty passes is timed, told to listeners and followed by an analysis of lifetimes.

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
    """Where arrays of different sizes meet, say it without the sizes.

    Text would need a hundred functions more.
    """

    def say_unequal(source: Any, target: Any) -> None:
        raise NotImplementedError

    @overload(say_unequal)
    def _(source: Any, target: Any) -> Any:
        def say(source: Any, target: Any) -> None:
            raise ValueError("cannot assign slice from input of different size")

        return say

    arrayobj.raise_with_shape_context = say_unequal
