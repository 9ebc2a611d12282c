# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""References are to agree with the strain-mode model, not to be it: what they take of it is named."""

from pathlib import Path

import pytest
from helpers.package_imports import imports_of

ROOT = Path(__file__).resolve().parents[3]
REFERENCE = "cpr_core.reference"
#: What any reference may use: nothing of it computes how a rod bends.
GROUND = (
    "cpr_core.blas_threads",
    "cpr_core.description",
    "cpr_core.errors",
    "cpr_core.lie",
    "cpr_core.numba_fence",
    "cpr_core.validation",
)
#: What they may use of the model and what solves it, and what for.
ALLOWED = {
    ("cpr_core.kernels.kernel_sources", "read_sources"),  # when to compile again
    ("cpr_core.kernels.kernel_sources", "stamp_of"),
    ("cpr_core.kernels.natural_units", "LONGEST_STEP"),  # numbers that they are to have in common
    ("cpr_core.kernels.square_problem", "RESIDUAL_TOLERANCE"),
    ("cpr_core.model.robot", "Robot"),  # a description with its motors, axes and units numbered
    (
        "cpr_core.model.equilibrium",
        "Equilibrium",
    ),  # where they begin, and what they are compared with
    ("cpr_core.solving.not_reached", "NoForwardSolution"),  # what they raise
    ("cpr_core.solving.not_reached", "NoInverseSolution"),
}


def lies_in(module, floors):
    return any(module == floor or module.startswith(f"{floor}.") for floor in floors)


def shared(root):
    """What modules of the references import from elsewhere, and where."""
    return [
        (found.place, (found.imported, found.name))
        for found in imports_of(root)
        if lies_in(found.importer, [REFERENCE])
        and not lies_in(found.imported, [REFERENCE, *GROUND])
        and (found.imported, found.name) not in ALLOWED
    ]


def test_references_take_nothing_of_the_model_but_what_is_named():
    assert shared(ROOT) == []


def test_nothing_is_named_that_no_reference_takes():
    references = [found for found in imports_of(ROOT) if lies_in(found.importer, [REFERENCE])]
    assert len({found.importer for found in references}) > 15
    assert {(found.imported, found.name) for found in references} >= ALLOWED
    for floor in GROUND:
        assert any(lies_in(found.imported, [floor]) for found in references), floor


def test_the_kernels_of_what_any_reference_may_use_are_rotations():
    imports, reached, further = imports_of(ROOT), set(), set(GROUND)
    while not further <= reached:
        reached |= further
        further = {
            found.imported
            for found in imports
            if lies_in(found.importer, reached)
            and not lies_in(found.importer, ["cpr_core.kernels"])
        }
    kernels = {module for module in reached if lies_in(module, ["cpr_core.kernels"])}
    assert kernels == {"cpr_core.kernels.rotation_matrices"}
    assert not any(lies_in(module, ["cpr_core.model", "cpr_core.solving"]) for module in reached)


@pytest.mark.parametrize(
    ("line", "taken"),
    [
        ("from ..kernels import stiffness_kernel", ("cpr_core.kernels.stiffness_kernel", "")),
        (
            "from ..model.linearisation import tangent",
            ("cpr_core.model.linearisation", "tangent"),
        ),
        ("from ..model.robot import Grid", ("cpr_core.model.robot", "Grid")),
        ("import cpr_core.model.robot", ("cpr_core.model.robot", "")),
        ("def late():\n    from .. import solve_forward", ("cpr_core", "solve_forward")),
    ],
)
def test_what_else_is_taken_is_found(tmp_path, line, taken):
    modules = ("kernels/stiffness_kernel", "model/linearisation", "model/robot", "reference/rods")
    for module in modules:
        file = tmp_path / "cpr_core" / f"{module}.py"
        file.parent.mkdir(parents=True, exist_ok=True)
        (file.parent / "__init__.py").touch()
        file.touch()
    (tmp_path / "cpr_core/__init__.py").touch()
    (tmp_path / "cpr_core/reference/rods.py").write_text(line)
    [found] = shared(tmp_path)
    assert found == (f"cpr_core/reference/rods.py:{line.count(chr(10)) + 1}", taken)
