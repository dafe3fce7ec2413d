"""Optimise what was lowered, once, and turn it into machine code for kinds of processors.

The order of things decides how fast the code is:

1. Every function is tidied by itself: a kernel that is handed a hundred arrays comes as many
   thousand instructions, of which one in six is left. That is the same for an architecture.
2. For a processor, every function is optimised by itself; only then may one be put into another.
   Inlined at once, a solid tuft paints a fifth slower; and loops that become vector instructions
   only when they are part of a large function become none: single hairs take a sixth longer.
3. Kernels of single hairs (those with ``fastmath``) are optimised each with all it calls. As part
   of a large function ten thousand hairs take two and a half times as long.
4. These are put in their places, and what a group of entries calls is optimised once more.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import llvmlite.binding as llvm

from paint3d.core.numba_kernels import llvm_name
from tools.kernels.lowering import Lowered
from tools.kernels.processors import ARCHITECTURES, architecture_of

__all__ = ["Prepared", "emit", "optimise_for", "prepare"]

# LLVM takes look-ups by eight for dear on these kinds, and leaves loops scalar that have one; and
# of vectors of 512 bits it uses half
_FEATURES = {"x86-64-v3": "+fast-gather", "x86-64-v4": "+fast-gather,-prefer-256-bit"}
# Without relaxed SIMD, whose results differ between machines.
_WASM_FEATURES = "+simd128,+bulk-memory,+sign-ext,+nontrapping-fptoint,+mutable-globals"


@dataclass
class Prepared:
    """Entries and all that they call, in LLVM's bitcode."""

    plain: bytes  # all but single hairs
    elementwise: list[list[bytes]]  # of single hairs, as lowered: each, and then what it calls


def prepare(lowered: Lowered, processor: str) -> Prepared:
    """Do all that is the same for an architecture and every group: every function is tidied.

    Parameters
    ----------
    lowered : Lowered
    processor : str
        Any of the architecture.
    """
    machine = _machine(ARCHITECTURES[architecture_of(processor)][0])
    for module in (lowered.entries, *(unit.module for unit in lowered.units)):
        module.triple, module.data_layout = machine.triple, str(machine.target_data)
    elementwise = [k for k, unit in enumerate(lowered.units) if unit.is_elementwise]
    parts = [
        [lowered.units[n].module.as_bitcode() for n in (k, *_called(lowered, k))]
        for k in elementwise
    ]
    plain = [_shared(unit.module) for unit in lowered.units if not unit.is_elementwise]
    whole = _linked([lowered.entries, *plain])
    _keep_inside(whole, lowered.gives)
    _tidy(whole, machine)
    return Prepared(whole.as_bitcode(), parts)


def optimise_for(processor: str, prepared: Prepared) -> Prepared:
    """Do what is the same for every group of entries: every function is optimised by itself."""
    whole = llvm.parse_bitcode(prepared.plain)
    _optimise_alone(whole, _machine(processor))
    return Prepared(whole.as_bitcode(), prepared.elementwise)


def emit(prepared: Prepared, entries: Iterable[str], processor: str) -> bytes:
    """Return the object file, position-independent, with some of the entries.

    Parameters
    ----------
    prepared : Prepared
        Optimised for the processor.
    entries : iterable of str
        Names of functions of C.
    processor : str
        Such as ``x86-64-v3``.
    """
    machine = _machine(processor)
    whole = llvm.parse_bitcode(prepared.plain)
    for thing in (*whole.functions, *whole.global_variables):
        if not thing.is_declaration and thing.linkage == llvm.Linkage.internal:
            thing.linkage = llvm.Linkage.weak_odr  # single hairs call it
    alone = []
    for parts in prepared.elementwise:
        module = _linked([_shared(llvm.parse_bitcode(part)) for part in parts])
        _tidy(module, machine)
        _optimise(module, machine)
        alone.append(module)
    whole = _linked([whole, *alone])
    _keep_inside(whole, entries)
    _see_that_all_is_there(whole)
    _optimise(whole, machine)
    return machine.emit_object(whole)


def _machine(processor: str) -> llvm.TargetMachine:
    """What makes code for a processor, on whatever other one."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    if architecture_of(processor) == "wasm32":
        target = llvm.Target.from_triple("wasm32-unknown-wasi")
        return target.create_target_machine(
            cpu="generic", features=_WASM_FEATURES, opt=3, reloc="static", codemodel="default"
        )
    target = llvm.Target.from_triple(f"{architecture_of(processor)}-unknown-linux-gnu")
    return target.create_target_machine(
        cpu=llvm_name(processor),
        features=_FEATURES.get(processor, ""),
        opt=3,
        reloc="pic",
        codemodel="default",
    )


_SEEN = {
    llvm.Linkage.external,
    llvm.Linkage.linkonce_odr,
    llvm.Linkage.linkonce_any,
    llvm.Linkage.weak_any,
    llvm.Linkage.common,
}


def _shared(module: llvm.ModuleRef) -> llvm.ModuleRef:
    """Have it stay, whoever asks for it and when."""
    for thing in (*module.functions, *module.global_variables):
        if not thing.is_declaration and thing.linkage in _SEEN:
            thing.linkage = llvm.Linkage.weak_odr
    return module


def _linked(modules: list[llvm.ModuleRef]) -> llvm.ModuleRef:
    """Put all into the first, in their order.

    Neighbours are joined, and again, for whatever is put into a module all of that is looked at:
    one after another would look at the first ones hundreds of times.
    """
    while len(modules) > 1:
        for first, second in zip(modules[::2], modules[1::2], strict=False):
            first.link_in(second)
        modules = modules[::2]
    return modules[0]


def _keep_inside(module: llvm.ModuleRef, entries: Iterable[str]) -> None:
    """Show nothing but the entries."""
    shown = set(entries)
    for thing in (*module.functions, *module.global_variables):
        if not thing.is_declaration and thing.name not in shown:
            thing.linkage = llvm.Linkage.internal


def _see_that_all_is_there(module: llvm.ModuleRef) -> None:
    lacking = [f.name for f in module.functions if f.is_declaration and f.name.startswith("_ZN")]
    if lacking:
        raise RuntimeError(f"not lowered: {lacking[:4]}")


def _called(lowered: Lowered, k: int) -> list[int]:
    """All that a unit calls, at any depth."""
    found: set[int] = set()
    waiting = [*lowered.units[k].calls]
    while waiting:
        other = waiting.pop()
        if other not in found:
            found.add(other)
            waiting.extend(lowered.units[other].calls)
    return sorted(found)


def _tidy(module: llvm.ModuleRef, machine: llvm.TargetMachine) -> None:
    """Leave of every function what it is about; then bring counts of references together."""
    passes = llvm.create_new_module_pass_manager()
    passes.add_dead_code_elimination_pass()
    passes.add_instruction_combine_pass()
    passes.add_sroa_pass()
    passes.add_instruction_combine_pass()
    passes.add_simplify_cfg_pass()
    passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))
    tuning = llvm.create_pipeline_tuning_options(speed_level=0)
    tuning.loop_vectorization = tuning.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, tuning)
    passes = builder.getModulePassManager()
    passes.add_loop_rotate_pass()
    passes.add_instruction_combine_pass()
    passes.add_jump_threading_pass()
    passes.add_refprune_pass()
    passes.run(module, builder)


def _optimise_alone(module: llvm.ModuleRef, machine: llvm.TargetMachine) -> None:
    """Optimise every function without putting any into another."""
    held = [
        function.name
        for function in module.functions
        if function.linkage == llvm.Linkage.internal
        and not any(b"alwaysinline" in attributes for attributes in function.attributes)
    ]
    for name in held:  # as if another might take its place: nobody may rely on what it does
        module.get_function(name).linkage = llvm.Linkage.weak_any
    _optimise(module, machine)
    for name in held:
        module.get_function(name).linkage = llvm.Linkage.internal


def _optimise(module: llvm.ModuleRef, machine: llvm.TargetMachine) -> None:
    """Run all of LLVM's passes, as numba does."""
    tuning = llvm.create_pipeline_tuning_options(speed_level=3)
    tuning.loop_vectorization, tuning.slp_vectorization = True, False
    builder = llvm.create_pass_builder(machine, tuning)
    passes = builder.getModulePassManager()
    passes.add_refprune_pass()
    passes.run(module, builder)
