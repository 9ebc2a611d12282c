# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the files around the code say about it."""

import ast
import json
import pkgutil
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml
from helpers.import_statements import import_statements
from helpers.quick_end import QUICK_END

from cpr_core.command_line.command import command_parser
from cpr_core.model.assessment import MEASURES
from cpr_ros.settings.parameter_table import PARAMETERS

ROOT = Path(__file__).parents[2]
#: Python packages as Debian and rosdep call them.
KEYS = {
    "hypothesis": "python3-hypothesis",
    "jsonschema": "python3-jsonschema",
    "matplotlib": "python3-matplotlib",
    "mpl_toolkits": "python3-matplotlib",
    "numba": "python3-numba",
    "numpy": "python3-numpy",
    "pytest": "python3-pytest",
    "scipy": "python3-scipy",
    "threadpoolctl": "python3-threadpoolctl",
    "tqdm": "python3-tqdm",
    "yaml": "python3-yaml",
}
#: Of these what rosdep has no key for (rosdistro, 2026-08): a key that is missing ends it.
WITHOUT_KEY = "python3-threadpoolctl"

#: What is imported only where it is used, and comes with an extra of setup.py: rosdep has no key for it.
OPTIONAL = {"PIL": "pillow", "rich": "rich", "viser": "viser", "xarray": "xarray"}


def imported(*folders):
    """Top-level packages that Python files need, but for the standard library and our own."""
    found = set()
    for folder in folders:
        for path in (ROOT / folder).rglob("*.py"):
            for node in import_statements(path.read_text()):
                if isinstance(node, ast.Import):
                    found |= {name.name.split(".")[0] for name in node.names}
                elif not node.level:
                    found.add(node.module.split(".")[0])
    return found - set(sys.stdlib_module_names) - {"cpr_core", "cpr_ros"} - {*OPTIONAL}


def test_optional_packages_are_extras_and_not_imported_at_the_start():
    setup = (ROOT / "setup.py").read_text()
    for name in OPTIONAL.values():
        assert re.search(rf'extras_require=.*"{name}[">]', setup, re.DOTALL)
    script = "import sys, cpr_core, cpr_core.workspace; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", QUICK_END + script], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not {*OPTIONAL} & set(loaded)


def declared(kinds):
    root = ElementTree.parse(ROOT / "package.xml").getroot()
    return {element.text for kind in kinds for element in root.iter(kind)}


def test_package_xml_names_everything_that_is_imported():
    packages = {KEYS.get(name, name) for name in imported("cpr_core", "cpr_ros", "launch")}
    assert packages <= declared(["depend", "exec_depend"])


def test_package_xml_names_nothing_else():
    packages = {KEYS.get(name, name) for name in imported("cpr_core", "cpr_ros", "launch")}
    # rviz is started, not imported; what is generated from interfaces is not, either.
    assert declared(["depend"]) <= packages | {"lifecycle_msgs"}


def test_rosdep_and_colcon_are_told_of_the_nested_package():
    """Both look no farther below a package that they meet."""
    page = (ROOT / "docs/building.md").read_text()
    lines = re.findall(r"(?m)^(?:rosdep|colcon) .* --(?:from|base)-paths ((?:src\S* ?)+)", page)
    assert [line.split() for line in lines] == 2 * [["src/cpr_ros", "src/cpr_ros/msg_defs"]]


def test_what_rosdep_has_no_key_for_is_installed_beside_it():
    page = (ROOT / "docs/building.md").read_text()
    assert WITHOUT_KEY in declared(["depend"])
    assert re.search(rf"(?m)^sudo apt install {WITHOUT_KEY}$", page)
    assert re.search(rf"(?m)^rosdep install .* --skip-keys {WITHOUT_KEY}$", page)


def test_the_quality_declaration_names_the_packages_of_setup():
    """Those of users: what only tests import is left out."""
    call = ast.parse((ROOT / "setup.py").read_text()).body[-1].value
    given = {keyword.arg: keyword.value for keyword in call.keywords}
    extras = given["extras_require"]
    lists = {key.value: value for key, value in zip(extras.keys, extras.values, strict=True)}
    lines = [given["install_requires"], *(lists[name] for name in ("maps", "view", "verify"))]
    needed = {re.match(r"[\w-]+", item.value)[0] for line in lines for item in line.elts}
    page = (ROOT / "QUALITY_DECLARATION.md").read_text()
    row = re.search(r"(?m)^\| 5 dependencies \| (.*?)\): none has", page)[1]
    named = {name.lower() for name in re.findall(r"[\w-]+", row)}
    assert named - {"and", "in", "extras"} == needed


def test_both_packages_have_the_same_version_and_licence():
    texts = [(ROOT / name).read_text() for name in ("package.xml", "msg_defs/package.xml")]
    for tag in ("version", "license"):
        assert len({re.search(rf"<{tag}>(.*)</{tag}>", text)[1] for text in texts}) == 1
    assert "Apache License" in (ROOT / "LICENSE").read_text()
    assert 'license="Apache-2.0"' in (ROOT / "setup.py").read_text()


@pytest.mark.parametrize(
    "tool", ["api_section", "interface_page", "option_section", "parameter_section"]
)
def test_what_is_generated_in_the_docs_is_current(tool):
    done = subprocess.run(
        [sys.executable, ROOT / f"tools/{tool}.py", "--check"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("page", ["interface", "api"])
def test_no_field_or_constant_is_without_a_meaning(page):
    rows = re.findall(r"(?m)^\| `.*\|$", (ROOT / f"docs/{page}.md").read_text())
    assert len(rows) > 50
    assert [row for row in rows if not row.removesuffix("|").rpartition("|")[2].strip()] == []


def test_every_shipped_robot_is_in_the_docs_with_a_picture():
    """Small ones: a page with all of them is to open at once."""
    from cpr_core.description.description_file import shipped_robots

    text = (ROOT / "docs/description.md").read_text()
    for name in shipped_robots():
        assert f"[{name}](../config/{name}.yaml)" in text
        assert f'src="images/robots/{name}.png"' in text
        assert (ROOT / f"docs/images/robots/{name}.png").stat().st_size < 60_000


def test_pictures_of_the_docs_exist_and_are_shown():
    shown = set()
    for page in [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]:
        for name in re.findall(r'!\[[^\]]*\]\(([^)]+)\)|src="([^"]+)"', page.read_text()):
            file = (page.parent / "".join(name)).resolve()
            assert file.is_file(), f"{page}: {name}"
            shown.add(file)
    assert set((ROOT / "docs/images").rglob("*.png")) <= shown


def test_the_docs_list_the_parameters_of_the_node_and_no_others():
    """Read here, not by the tool that writes them."""
    text = (ROOT / "docs/node.md").read_text()
    rows = re.findall(r"^\| `(\w+)` \| (\w+) \| .* \| `(\S+)` \| (live|read-only) \|", text, re.M)
    listed = {name: (kind, yaml.safe_load(shown), changes) for name, kind, shown, changes in rows}
    types = {bool: "bool", int: "integer", float: "double", str: "string"}
    assert listed == {
        parameter.name: (
            types[type(parameter.default)],
            parameter.default,
            "live" if parameter.live else "read-only",
        )
        for parameter in PARAMETERS
    }
    assert len(rows) == len(listed) >= 28


def test_every_measure_has_its_meaning_on_the_page_of_the_node():
    section = (
        (ROOT / "docs/node.md").read_text().partition("### Thresholds")[2].partition("\n## ")[0]
    )
    assert re.findall(r"^\| `(\w+)` \| \w", section, re.MULTILINE) == [*MEASURES]


def named_in_the_docs(pattern):
    """Pages, and what a pattern finds on them."""
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
    return [
        (page, name)
        for page in pages
        for name in re.findall(pattern, page.read_text(encoding="utf-8"))
    ]


def test_modules_and_what_is_in_them_are_called_in_the_docs_as_in_the_code():
    names = named_in_the_docs(r"\b(?:cpr_core|cpr_ros)(?:\.\w+)+")
    assert len(names) > 50
    for page, name in names:
        try:
            pkgutil.resolve_name(name)
        except (ImportError, AttributeError) as error:
            pytest.fail(f"{page.name}: {name}: {error}")


def test_files_of_python_that_the_docs_name_exist():
    """From the root, from the page, or from the top of a package; without a folder, wherever."""
    known = {file.name for file in ROOT.glob("[a-z]*/**/*.py")}
    files = named_in_the_docs(r"[`(]([\w./]+\.py)[`)]")
    assert len(files) > 150
    for page, name in files:
        tops = (ROOT, page.parent, ROOT / "cpr_core", ROOT / "cpr_ros")
        found = any((top / name).is_file() for top in tops) if "/" in name else name in known
        assert found, (page.name, name)


def test_what_the_docs_say_a_file_has_is_in_it():
    """As "`load_robot("six_rfs")` (`solving/load_robot.py`)" or "`Pose` in `model/shape.py`"."""
    said = named_in_the_docs(r"`(\w+)(?:\([^`]*\))?` (?:\(|in )`([\w./]+\.py)`")
    assert len(said) >= 10
    tops = [ROOT, ROOT / "cpr_core", ROOT / "cpr_ros", *(ROOT / "test" / "cpr_core").iterdir()]
    for page, (name, file) in said:
        [code] = [(top / file).read_text() for top in tops if (top / file).is_file()]
        assert re.search(rf"^(def|class) {name}\b|^{name}\b", code, re.MULTILINE), (page.name, name)


def helped(arguments, capsys):
    """What the command line prints as help."""
    with pytest.raises(SystemExit):
        command_parser().parse_args([*arguments, "--help"])
    return capsys.readouterr().out


def test_the_docs_list_the_options_of_every_command_and_no_others(capsys):
    """Read from the help, not by the tool that writes them."""
    _, shared, *parts = (ROOT / "docs/command_line.md").read_text().split("\n### ")
    common = dict(re.findall(r"^\| `(--[a-z-]+)\b.* \| (.*) \|$", shared, re.MULTILINE))
    assert {"--modes", "--gravity", "--wrench", "--json"} == {*common}
    commands = re.findall(r"^    (\w+)", helped([], capsys), re.MULTILINE)
    assert [re.match(r"`cpr (\w+)`\n", part)[1] for part in parts] == commands
    for name, part in zip(commands, parts, strict=True):
        rows = re.findall(r"^\| `(--[a-z-]+)\b", part, re.MULTILINE)
        rows += [option for option, others in common.items() if f"`{name}`" not in others]
        options = re.findall(r"^  (--[a-z-]+)", helped([name], capsys), re.MULTILINE)
        assert sorted(rows) == sorted(options), name


def test_every_field_of_the_stability_stream_has_its_meaning_and_unit():
    lines = (ROOT / "msg_defs/msg/StabilityMetrics.msg").read_text().splitlines()
    fields = [line for line in lines if re.match(r"(float64|int32|int8|uint8|bool)\S* \w+ ", line)]
    assert len(fields) > 20
    without = [line for line in fields if line.startswith("float64") and "#" not in line]
    assert not without
    for line in fields:
        if line.startswith("float64"):
            comment = line.split("#")[1]
            assert re.search(r"\[.+\]", comment) or "row-major" in comment, line


def test_every_error_code_has_its_meaning_and_is_on_the_page_of_the_node():
    lines = (ROOT / "msg_defs/msg/ErrorCode.msg").read_text().splitlines()
    codes = [re.match(r"int32 ([A-Z_]+)=(-?\d+) +# \w", line) for line in lines if "=" in line]
    page = (ROOT / "docs/node.md").read_text()
    rows = dict(re.findall(r"^\| (-?\d+) \| `([A-Z_]+)` \|", page, re.MULTILINE))
    assert all(codes) and len(codes) > 10
    meant = {code[2]: code[1] for code in codes if code[1] != "UNDEFINED"}
    assert rows == meant


@pytest.mark.parametrize("service", ["SolveForward", "SolveInverse"])
def test_every_field_of_what_is_asked_for_is_on_the_page_of_the_node(service):
    request, answer = (ROOT / f"msg_defs/srv/{service}.srv").read_text().split("---\n")
    page = (ROOT / "docs/node.md").read_text()
    asked, answered = re.search(
        r"(?s)\nFields of `solve_forward`(.*?)\nThe answer holds(.*?)\n`error_code` is", page
    ).groups()
    for part, told in ((request, asked), (answer, answered)):
        fields = re.findall(r"(?m)^[\w/]+(?:\[[<=\d]*\])? (\w+)(?: |$)", part)
        assert len(fields) > 2
        assert [name for name in fields if f"`{name}`" not in told] == []


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs"])
def test_parameter_files_name_parameters_of_the_node(name):
    parameters = yaml.safe_load((ROOT / f"config/node/{name}.yaml").read_text())
    given = parameters["/**"]["ros__parameters"]
    assert given["robot"] == name
    declared = {parameter.name: parameter for parameter in PARAMETERS}
    assert {key for key, parameter in declared.items() if parameter.live} <= set(given)
    for key, value in given.items():
        assert type(value) is type(declared[key].default), key
        low, high = declared[key].limits or (value, value)
        assert low <= value <= high, key


def test_the_view_shows_topics_the_node_has():
    view = yaml.safe_load((ROOT / "rviz/cpr.rviz").read_text())
    topics = {
        display["Topic"]["Value"]
        for display in view["Visualization Manager"]["Displays"]
        if "Topic" in display
    }
    assert topics == {"cpr_node/leg_markers", "cpr_node/platform_pose"}


def test_the_schema_and_the_robots_are_no_parameter_files():
    from cpr_core.description.description_file import shipped_robots

    assert all(path.parent.name == "config" for path in shipped_robots().values())
    json.loads((ROOT / "cpr_core/description/description.schema.json").read_text())
