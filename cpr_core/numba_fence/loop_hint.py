# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numba's compiler, told to leave the loops of kernels as they are written.

Kernels unroll by hand where it pays. What the compiler unrolls on top of that makes them several times
as long: a Newton step no longer fits the instruction cache, which cost a tenth of a solve and a third of
compiling. LLVM takes a hint where a loop jumps back; numba has no option for it.
"""

from __future__ import annotations

from typing import Any

from numba.core import cgutils
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import BaseNativeLowering, NativeLowering

__all__ = ["KernelCompiler"]

ir = cgutils.ir  # llvmlite's, as numba brings it


class _KernelLower(Lower):
    """From numba's form of a function to LLVM's, with the hint where a block jumps back."""

    def post_lower(self) -> None:
        super().post_lower()
        place = {block: number for number, block in enumerate(self.function.blocks)}
        hint = None
        for block, number in place.items():
            jump = block.terminator
            if jump is None:
                continue
            if any(place.get(target, number + 1) <= number for target in jump.operands):
                hint = hint or self._leave_loop()
                jump.set_metadata("llvm.loop", hint)

    def _leave_loop(self) -> Any:
        """The hint: a node that names itself first, as LLVM wants it."""
        wish = self.module.add_metadata(["llvm.loop.unroll.disable"])
        node = ir.MDValue(self.module, [wish], name=str(len(self.module.metadata)))
        node.operands = (node, wish)
        return node


@register_pass(mutates_CFG=True, analysis_only=False)
class _KernelLowering(BaseNativeLowering):
    _name = "kernel_lowering"

    @property
    def lowering_class(self) -> type:
        return _KernelLower


class KernelCompiler(CompilerBase):
    """To be given to ``numba.njit`` as ``pipeline_class``."""

    def define_pipelines(self) -> list[Any]:
        """Numba's own passes, but for one."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.passes = [
            (_KernelLowering if step is NativeLowering else step, name)
            for step, name in passes.passes
        ]
        passes.finalize()
        return [passes]
