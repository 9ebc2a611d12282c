# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where maps may be written, and what is said of other places."""

import os
from pathlib import Path
from types import SimpleNamespace

import pytest
from cpr_msgs.msg import ErrorCode

from cpr_core import CprError, InvalidRequest
from cpr_ros.error_codes import error_code
from cpr_ros.maps.map_folder import MapFolder


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "maps"


def refusal(maps, name):
    with pytest.raises(InvalidRequest) as refused:
        maps.file(name)
    code = error_code(refused.value)
    assert code.val == ErrorCode.INVALID_FILE
    return code.message


@pytest.mark.parametrize("anywhere", [False, True])
@pytest.mark.parametrize("name", ["map.nc", "a/../map.nc", "a/map.nc"])
def test_a_name_means_a_file_in_the_folder_which_is_made_for_it(folder, name, anywhere):
    assert MapFolder(folder, anywhere).file(name) == folder / name
    assert list(folder.iterdir()) == []


def test_a_home_is_meant_only_where_other_places_are_allowed(folder):
    assert MapFolder(folder, True).file("~/map.nc") == Path.home() / "map.nc"
    assert not folder.exists()
    assert MapFolder(folder, False).file("~/map.nc") == folder / "~/map.nc"


@pytest.mark.parametrize("name", ["../map.nc", "/map.nc", "../maps2/map.nc", "away/map.nc"])
def test_names_that_lead_out_are_refused_unless_other_places_are_allowed(folder, tmp_path, name):
    folder.mkdir()
    (folder / "away").symlink_to(tmp_path)
    told = refusal(MapFolder(folder, False), name)
    assert f"expected a file in {folder} (parameter map_directory), got {name!r}" in told
    assert "allowed by the parameter map_anywhere" in told
    assert MapFolder(folder, True).file(name) == folder / name


@pytest.mark.parametrize("name", ["", "long" * 100_000, "nul\0.nc", "../map.nc", "/map.nc"])
def test_a_name_that_is_refused_leaves_no_folder_behind(folder, name):
    assert refusal(MapFolder(folder, False), name).startswith("file: expected ")
    assert not folder.exists()


@pytest.mark.parametrize("name", ["~nobody-at-all/map.nc", "nul\0.nc", "long" * 1000])
def test_names_of_no_file_are_told(folder, name):
    assert "expected a name of a file, got '" in refusal(MapFolder(folder, True), name)


def test_a_pipe_is_no_file_of_a_map(folder):
    """Whoever opens one waits until somebody else does."""
    folder.mkdir()
    os.mkfifo(folder / "map.nc")
    assert "expected an ordinary file" in refusal(MapFolder(folder, False), "map.nc")


def test_the_folder_is_that_of_the_parameters_or_beside_what_ros_keeps(monkeypatch, tmp_path):
    monkeypatch.setenv("ROS_HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    for given, expected in (
        ("", tmp_path),
        ("~/maps", Path.home() / "maps"),
        ("maps", tmp_path / "maps"),
    ):
        for anywhere in (False, True):
            parameters = SimpleNamespace(map_directory=given, map_anywhere=anywhere)
            found = MapFolder.of(parameters)
            assert found.anywhere == anywhere
            assert found.folder.is_absolute()
            assert found.folder.is_relative_to(expected)


def test_a_folder_that_nobody_knows_is_told():
    parameters = SimpleNamespace(map_directory="~nobody-at-all/maps", map_anywhere=False)
    with pytest.raises(
        CprError, match=r"^map_directory: expected a folder, got '~nobody-at-all/maps'"
    ):
        MapFolder.of(parameters)


def test_a_folder_that_cannot_be_made_is_told_and_not_the_name_of_the_file(tmp_path):
    (tmp_path / "file").write_text("")
    for folder, why in ((tmp_path / "file", "File exists"), (tmp_path / "file/maps", "Not a dir")):
        told = refusal(MapFolder(folder, False), "map.nc")
        assert told.startswith(f"file: {folder} (parameter map_directory) cannot be made: ")
        assert why in told
