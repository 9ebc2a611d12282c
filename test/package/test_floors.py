# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Imports lead down only: every import of every module, also inside functions and for types."""

import ast
import re
from collections.abc import Iterable
from pathlib import Path

import pytest
from helpers.import_statements import import_statements
from helpers.package_imports import Import, imports_of

ROOT = Path(__file__).resolve().parents[2]

#: From the ground up. A module imports its own floor (without circles) and those below it.
FLOORS = (
    "cpr_core.version",
    "cpr_core.errors",
    "cpr_core.validation",
    "cpr_core.blas_threads",
    "cpr_core.numba_fence",
    "cpr_core.kernels",
    "cpr_core.lie",
    "cpr_core.description_part",
    "cpr_core.rods",
    "cpr_core.description",
    "cpr_core.model",
    "cpr_core.solving",
    "cpr_core.workspace",
    "cpr_core.identification",
    "cpr_core.reference",
    "cpr_core.drawing",
    "cpr_core.viewing",
    "cpr_core.kernel_warmup",
    "cpr_core.command_line",
    "cpr_core",
    "cpr_ros.error_codes",
    "cpr_ros.setpoint_topics",
    "cpr_ros.process",
    "cpr_ros.middleware",
    "cpr_ros.page",
    "cpr_ros.following",
    "cpr_ros.closed_loop",
    "cpr_ros.messages",
    "cpr_ros.settings",
    "cpr_ros.operation",
    "cpr_ros.maps",
    "cpr_ros.interface",
    "cpr_ros",
    "paper",
    "benchmarks",
    "verification",
)
#: Beside each other, although one has to be named first: neither imports the other.
APART = (
    ("cpr_core.workspace", "cpr_core.reference"),
    ("cpr_core.workspace", "cpr_core.identification"),
    ("cpr_core.identification", "cpr_core.reference"),
    *(("cpr_ros.page", floor) for floor in ("cpr_ros.following", "cpr_ros.messages")),
    ("cpr_ros", "paper"),
    ("cpr_ros", "verification"),
    ("paper", "verification"),
    ("benchmarks", "verification"),
)


@pytest.fixture(scope="module")
def imports() -> list[Import]:
    """Those of this tree."""
    return imports_of(ROOT)


def floor_of(module: str) -> str:
    """The most special floor a module lies on."""
    names = [name for name in FLOORS if module == name or module.startswith(f"{name}.")]
    return max(names, key=len)


def upward(imports: list[Import]) -> list[str]:
    """Places where a module imports a floor above its own, or one it is to be apart from."""
    height = {name: number for number, name in enumerate(FLOORS)}
    lines = []
    for importer, imported, *_, place in imports:
        own, other = floor_of(importer), floor_of(imported)
        if height[other] > height[own] or (other, own) in APART or (own, other) in APART:
            lines.append(f"{place}: {own} imports {other}")
    return [*dict.fromkeys(lines)]


def circles(imports: list[Import]) -> list[str]:
    """Imports that close a circle of modules: what cannot be peeled off from below or from above."""
    left = {(found.importer, found.imported) for found in imports}
    while True:
        importing = {importer for importer, _ in left}
        imported = {name for _, name in left}
        kept = {pair for pair in left if pair[1] in importing and pair[0] in imported}
        if kept == left:
            break
        left = kept
    places = [found.place for found in imports if (found.importer, found.imported) in left]
    return [*dict.fromkeys(places)]


def test_every_import_leads_down(imports):
    assert len(imports) > 500
    assert upward(imports) == []


def test_no_modules_import_each_other_in_a_circle(imports):
    assert circles(imports) == []


def drawn_graphs() -> list[dict[str, set[str]]]:
    """Graphs of docs/architecture.md: what every name in a box leads to, itself included."""
    graphs = []
    text = (ROOT / "docs/architecture.md").read_text()
    for graph in re.findall(r"```mermaid\n(.*?)```", text, re.DOTALL):
        boxes = dict(re.findall(r'(\w+)\["([^":]+)', graph))
        arrows = re.findall(r"(\w+)(?:\[[^]]*\])? --> ([^\[\n]+)", graph)
        below = {box: {box} for box in boxes}
        for _ in boxes:  # as long as the longest way at most
            for box, others in arrows:
                below[box] |= set().union(*(below[other] for other in others.split(" & ")))
        names = {box: set(label.split(", ")) for box, label in boxes.items()}
        graphs.append(
            {
                name: set().union(*(names[other] for other in below[box]))
                for box in boxes
                for name in names[box]
            }
        )
    return graphs


def test_the_arrows_of_the_architecture_lead_to_everything_that_is_imported(imports):
    library, node = drawn_graphs()
    missing = []
    for importer, imported, *_, place in imports:
        for package, graph in (("cpr_core", library), ("cpr_ros", node)):
            own, other = (
                name.split(".")[name.startswith(f"{package}.")] for name in (importer, imported)
            )
            if own in graph and other in graph and other not in graph[own]:
                missing.append(f"{place}: no arrow leads from {own} to {other}")
    assert missing == []


def imports_from(files: Iterable[Path], packages: set[str]) -> list[str]:
    """Places where files import one of these packages."""
    found = []
    for file in files:
        for node in import_statements(file.read_text()):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names = [node.module or ""]
            if packages & {name.partition(".")[0] for name in names}:
                found.append(f"{file.relative_to(ROOT)}:{node.lineno}")
    return found


def test_the_library_knows_no_ros():
    files = list((ROOT / "cpr_core").rglob("*.py"))
    assert len(files) > 200
    ros = {"rclpy", "cpr_msgs", "cpr_ros", "sensor_msgs", "geometry_msgs"}
    assert imports_from(files, ros) == []


def test_every_floor_says_what_it_is_for():
    for name in FLOORS:
        file = ROOT / Path(*name.split("."))
        file = file / "__init__.py" if file.is_dir() else file.with_suffix(".py")
        purpose = ast.get_docstring(ast.parse(file.read_text()))
        assert purpose and purpose.splitlines()[0].endswith("."), name


@pytest.mark.parametrize(
    "line",
    [
        "from ..solving.home import solve_home",
        "def late():\n    from ..solving.home import solve_home",
        "if TYPE_CHECKING:\n    from ..solving.home import solve_home",
        "import cpr_core.solving.home",
        "from .. import solving",
    ],
)
def test_an_upward_import_is_found_wherever_it_is(tmp_path, line):
    for module in ("model/robot", "solving/home"):
        file = tmp_path / "cpr_core" / f"{module}.py"
        file.parent.mkdir(parents=True)
        (file.parent / "__init__.py").touch()
        file.write_text("\n")
    (tmp_path / "cpr_core/__init__.py").touch()
    (tmp_path / "cpr_core/model/robot.py").write_text(line)
    [found] = upward(imports_of(tmp_path))
    assert found.startswith("cpr_core/model/robot.py:")
    assert "cpr_core.model imports cpr_core.solving" in found


def test_a_circle_is_found(tmp_path):
    folder = tmp_path / "cpr_core/model"
    folder.mkdir(parents=True)
    for file in ("../__init__", "__init__"):
        (folder / f"{file}.py").touch()
    (folder / "robot.py").write_text("from .shape import shapes")
    (folder / "shape.py").write_text("def shapes():\n    from . import robot")
    (folder / "user.py").write_text("from .robot import shapes")
    assert circles(imports_of(tmp_path)) == [
        "cpr_core/model/robot.py:1",
        "cpr_core/model/shape.py:2",
    ]
