# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a module takes of another one is in the ``__all__`` of that: the rest is free to change.

And it is made there: nothing is handed on but by packages.
"""

import ast
from pathlib import Path

import pytest
from helpers.package_imports import imports_of, modules_of

ROOT = Path(__file__).resolve().parents[2]
#: What hands on names of a library, and which.
HANDED_ON = {"cpr_core.numba_fence.typing_extension": "numba"}


def declared(tree):
    """Names in the ``__all__`` of a module."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return {*ast.literal_eval(node.value)}
    return set()


def defined(tree):
    """Names that a module makes, also below a condition or a ``try``."""
    names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and stored(node)}
    return names | {node.name for node in ast.walk(tree) if isinstance(node, NAMED)}


def stored(name):
    return isinstance(name.ctx, ast.Store)


NAMED = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def handed_on(root):
    """Names that a module, not a package, declares and does not make."""
    lines = []
    for name, file in modules_of(root).items():
        if file.name != "__init__.py" and name not in HANDED_ON:
            tree = ast.parse(file.read_text())
            lines += [f"{name}: {other}" for other in sorted(declared(tree) - defined(tree))]
    return lines


def attributes(tree):
    """What is asked of what in a module, (what, attribute, line)."""
    return [
        (ast.unparse(node.value), node.attr, node.lineno)
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name | ast.Attribute)
    ]


def undeclared(root):
    """Places where a module takes a name that the one it is from does not declare."""
    modules = modules_of(root)
    trees = {name: ast.parse(file.read_text()) for name, file in modules.items()}
    public = {name: declared(tree) for name, tree in trees.items()}
    asked = {name: attributes(tree) for name, tree in trees.items()}
    lines = []
    for importer, imported, name, bound, place in imports_of(root):
        taken = [(place, name)]
        if not name:
            file = place.rpartition(":")[0]
            taken = [
                (f"{file}:{line}", name)
                for what, name, line in asked[importer]
                if what == bound and f"{imported}.{name}" not in modules
            ]
        lines += [
            f"{where}: {name} is not in __all__ of {imported}"
            for where, name in taken
            if name not in public[imported] and not (name[:2] == name[-2:] == "__")
        ]
    return [*dict.fromkeys(lines)]


def test_modules_take_of_each_other_what_is_declared():
    assert len(modules_of(ROOT)) > 300
    assert undeclared(ROOT) == []


def test_names_are_declared_where_they_are_made():
    assert set(HANDED_ON) <= set(modules_of(ROOT))
    assert handed_on(ROOT) == []


def test_a_name_that_is_handed_on_is_found(tmp_path):
    folder = tmp_path / "cpr_core"
    folder.mkdir()
    (folder / "__init__.py").write_text('from .shape import tips\n__all__ = ["tips"]\n')
    text = "from .rods import rods, tips\n__all__ = ['shapes', 'tips']\nshapes = rods"
    (folder / "shape.py").write_text(text)
    assert handed_on(tmp_path) == ["cpr_core.shape: tips"]


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("from .shape import shapes", ""),
        ("from . import shape\nshape.shapes()", ""),
        ("from cpr_core import model\nmodel.shape.shapes()", ""),
        ("from .shape import __doc__ as purpose", ""),
        ("from .shape import tips", "tips"),
        ("from .shape import *", "*"),
        ("def late():\n    from cpr_core.model.shape import _tips as tips", "_tips"),
        ("from . import shape as other\nother.tips()", "tips"),
        ("import cpr_core.model.shape\ncpr_core.model.shape.tips()", "tips"),
    ],
)
def test_a_name_that_is_not_declared_is_found(tmp_path, text, name):
    folder = tmp_path / "cpr_core/model"
    folder.mkdir(parents=True)
    for file in ("../__init__", "__init__"):
        (folder / f"{file}.py").touch()
    (folder / "shape.py").write_text(
        '__all__ = ["shapes"]\nshapes, tips, _tips = print, print, print'
    )
    (folder / "robot.py").write_text(text)
    line = len(text.splitlines())
    says = f"cpr_core/model/robot.py:{line}: {name} is not in __all__ of cpr_core.model.shape"
    assert undeclared(tmp_path) == ([says] if name else [])
