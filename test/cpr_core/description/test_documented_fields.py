# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Fields of docs/description.md have the unit, the default and the extremes that the schema says."""

import re
from pathlib import Path

import pytest

from cpr_core.description.description_schema import description_schema

ROOT = Path(__file__).parents[3]
SCHEMA = description_schema()
#: How what stands above a table begins, the fields it is about, and their kinds where it is about some.
TABLES = {
    "Whole robot:": (SCHEMA, ()),
    "`rod` (": (SCHEMA["$defs"]["rod"], ()),
    "`strain` (": (SCHEMA["$defs"]["strain"], ()),
    "`legs[]`:": (SCHEMA["$defs"]["leg"], ()),
    "#### Revolute and prismatic joints": (SCHEMA["$defs"]["chain_element"], ("joint",)),
    "#### Universal joint": (SCHEMA["$defs"]["chain_element"], ("joint",)),
    "#### Link": (SCHEMA["$defs"]["chain_element"], ("link",)),
    "#### Rod": (SCHEMA["$defs"]["chain_element"], ("rod",)),
    "`loads`;": (SCHEMA["properties"]["loads"], ()),
    "`tracker`:": (SCHEMA["properties"]["tracker"], ()),
    "`home` (": (SCHEMA["$defs"]["home"], ()),
}
#: Kinds of joints that a table is not about.
OTHERS = {
    "#### Revolute and prismatic joints": {"universal"},
    "#### Universal joint": {"revolute", "prismatic"},
}
UNIT = re.compile(r"\[((?:[\w/^]|(?<=\w) (?=\w))+)\]")
EXTREMES = re.compile(r"\b(?:largest|smallest|least|most|lower|upper|increasing|outermost)\b")


def resolved(node):
    """A node with what its reference says; its own description counts."""
    while "$ref" in node:
        meant = SCHEMA
        for step in node["$ref"].split("/")[1:]:
            meant = meant[step]
        node = meant | {key: value for key, value in node.items() if key != "$ref"}
    return node


def fields_of(node, kinds=(), others=frozenset()):
    """Pairs of what the schema says of a field and whether it is required, by name."""
    found = {}
    node = resolved(node)
    for name, below in node.get("properties", {}).items():
        if isinstance(below, dict) and "not" not in below:
            pair = resolved(below), name in node.get("required", ())
            found.setdefault(name, []).append(pair)
    for branch in node.get("allOf", ()):
        named = branch["if"]
        constants = {value["const"] for value in named.get("properties", {}).values()}
        if constants & {*others} or (kinds and not constants and named["required"] != [*kinds]):
            continue
        then = fields_of(branch["then"], others=others)
        for name, pairs in then.items():
            chosen = kinds and [name] == named["required"]
            found.setdefault(name, []).extend(
                (below, required or bool(chosen)) for below, required in pairs
            )
    for below in (*filter(None, [node.get("items")]), *node.get("anyOf", ())):
        for name, pairs in fields_of(below).items():
            found.setdefault(name, []).extend(pairs)
    return found


def units_of(node):
    """Units that the description of a node names."""
    return {
        unit for text in UNIT.findall(node.get("description", "")) for unit in text.split(" or ")
    }


def default_of(node, required, above):
    """What the table is to say of a field that is left out, of a part that may be left out, or not."""
    if required:
        return f"required in {above}" if above else "required"
    text = node.get("description", "").split("; a pair: ")[0]
    told = re.search(r"(?:^|; )(?:default (.*)|(required unless .*))$", text)
    return told[1] or told[2] if told else ""


def rows():
    """Table, names, meaning, unit and default of every row."""
    text = (ROOT / "docs/description.md").read_text(encoding="utf-8")
    for begin in TABLES:
        _, *parts = re.split(rf"^{re.escape(begin)}", text, flags=re.MULTILINE)
        table = parts[-1].split("\n| field | meaning | unit | default |\n|---|---|---|---|\n")[1]
        for line in table.split("\n\n")[0].splitlines():
            names, meaning, unit, default = (
                cell.strip()
                for cell in re.fullmatch(r"\| (.*?) \| (.*?)\| (.*?)\| (.*?)\|", line).groups()
            )
            yield begin, re.findall(r"`([^`]+)`", names), meaning, unit, default


def each(cell, count):
    """What a cell says of every one of some fields, in code or not."""
    cell = cell.replace("`", "").replace("²", "^2").replace("³", "^3")
    for mark in (";", ","):
        if count > 1 and cell.count(mark) == count - 1:
            return [part.strip() for part in cell.split(mark)]
    return [cell] * count


ROWS = list(rows())


def named_in(table):
    """Fields that have a row in a table."""
    return {name for begin, names, *_ in ROWS for name in names if begin == table}


@pytest.mark.parametrize(
    ("table", "names", "meaning", "unit", "default"),
    ROWS,
    ids=[f"{begin} {', '.join(names)}" for begin, names, *_ in ROWS],
)
def test_a_field_in_the_docs_is_as_in_the_schema(table, names, meaning, unit, default):
    node, kinds = TABLES[table]
    told = set(re.findall(r"`(\w+)`", meaning))
    for name, own_unit, own_default in zip(
        names, each(unit, len(names)), each(default, len(names)), strict=True
    ):
        *above, last = name.removesuffix("[]").split(".")
        beside = fields_of(node, kinds, OTHERS.get(table, frozenset()))
        optional = ""
        for step in above:
            optional = optional if any(required for _, required in beside[step]) else step
            beside = merged(beside[step])
        pairs = beside[last]
        below = merged(pairs)
        if any("enum" in field for field, _ in pairs):  # it says which others there are
            below |= {
                word: others
                for word, others in beside.items()
                if ".".join([*above, word]) not in named_in(table)
            }
        units = set().union(*(units_of(field) for field, _ in pairs))
        for word in told & {*below} - {last}:
            units |= set().union(*(units_of(field) for field, _ in below[word]))
        assert {*filter(None, own_unit.split(", "))} == units
        assert {own_default} == {default_of(field, required, optional) for field, required in pairs}
        for field, _ in pairs:
            assert {*EXTREMES.findall(field.get("description", ""))} <= {*EXTREMES.findall(meaning)}


def merged(pairs):
    """Fields of all that a field may be."""
    found = {}
    for field, _ in pairs:
        for name, below in fields_of(field).items():
            found.setdefault(name, []).extend(below)
    return found


def test_every_table_of_fields_is_looked_at():
    text = (ROOT / "docs/description.md").read_text(encoding="utf-8")
    assert text.count("\n| field | ") == len(TABLES)
    assert len(ROWS) > 60
