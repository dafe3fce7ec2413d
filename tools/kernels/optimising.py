"""Optimise what was lowered, once, and turn it into machine code for a level of processor.

The order of things decides how fast it is:

1. Kernels of single hairs (those with ``fastmath``) are optimised first, each with all that it
   calls. Once they are part of a large function, their loops are no longer turned into vector
   instructions, and ten thousand hairs take two and a half times as long.
2. All is linked, and made known to nobody but the entries.
3. Every function is tidied by itself: a kernel that is handed a hundred arrays comes as many
   thousand instructions, of which one in six is left.
4. Every function is optimised by itself; only then may one be put into another, and all is
   optimised once more. Inlined at once, a solid tuft paints a fifth slower.
"""

from __future__ import annotations

import llvmlite.binding as llvm

from tools.kernels.lowering import Lowered

__all__ = ["emit"]


def emit(lowered: Lowered, level: str) -> bytes:
    """The object file, position-independent, for a level such as ``x86-64-v3``."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    machine = target.create_target_machine(cpu=level, opt=3, reloc="pic", codemodel="default")
    module = _link(lowered, machine)
    _tidy(module, machine)
    _optimise_alone(module, machine)
    _optimise(module, machine)
    return machine.emit_object(module)


def _link(lowered: Lowered, machine: llvm.TargetMachine) -> llvm.ModuleRef:
    """All in one module, in which only the entries are seen from outside."""
    done: dict[int, bytes] = {}
    plain = [unit.module.as_bitcode() for unit in lowered.units]

    def parsed(k: int) -> llvm.ModuleRef:
        module = llvm.parse_bitcode(done.get(k, plain[k]))
        for thing in (*module.functions, *module.global_variables):
            if not thing.is_declaration and thing.linkage in _SEEN:
                thing.linkage = llvm.Linkage.weak_odr  # stays, whoever asks for it and when
        return module

    for k, unit in enumerate(lowered.units):
        if unit.is_elementwise:
            module = parsed(k)
            for other in _called(lowered, k, done):
                module.link_in(parsed(other))
            _tidy(module, machine)
            _optimise(module, machine)
            done[k] = module.as_bitcode()
    whole = lowered.entries.clone()
    for k in range(len(lowered.units)):
        whole.link_in(parsed(k))
    entries = set(lowered.gives)
    for thing in (*whole.functions, *whole.global_variables):
        if not thing.is_declaration and thing.name not in entries:
            thing.linkage = llvm.Linkage.internal
    lacking = [f.name for f in whole.functions if f.is_declaration and f.name.startswith("_ZN")]
    if lacking:
        raise RuntimeError(f"not lowered: {lacking[:4]}")
    return whole


_SEEN = {
    llvm.Linkage.external,
    llvm.Linkage.linkonce_odr,
    llvm.Linkage.linkonce_any,
    llvm.Linkage.weak_any,
    llvm.Linkage.common,
}


def _called(lowered: Lowered, k: int, done: dict[int, bytes]) -> list[int]:
    """All that a unit calls, at any depth; not what units call that are done, and hold it."""
    found: set[int] = set()
    waiting = [*lowered.units[k].calls]
    while waiting:
        other = waiting.pop()
        if other not in found:
            found.add(other)
            if other not in done:
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
