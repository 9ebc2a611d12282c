# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The file of the last state on a disk that others use: made whole, removed, linked, full."""

import errno
import fcntl
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from helpers.kept_states import ROBOT, at, changed_bytes

from cpr_ros.operation.kept_state import KeptState
from cpr_ros.operation.locked_file import link_to_nowhere


def test_a_file_has_its_name_when_it_is_whole_or_not_at_all(file, monkeypatch):
    """Half of one would be a damaged one."""

    def killed(_file, content, place):
        assert not file.exists()
        os_pwrite(_file, content[:100], place)
        raise KeyboardInterrupt

    os_pwrite = os.pwrite
    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr(os, "pwrite", killed)
        KeptState(file, ROBOT)
    assert not file.exists()
    kept = KeptState(file, ROBOT)
    assert kept.last() is None and not kept.damage
    assert list(file.parent.iterdir()) == [file]
    kept.close()


def test_where_no_links_are_possible_there_is_a_file_too(file, monkeypatch):
    def impossible(*_):
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "link", impossible)
    for _ in range(2):
        kept = KeptState(file, ROBOT)
        assert kept.last() is None and not kept.damage
        kept.close()
    assert list(file.parent.iterdir()) == [file]


def overtaken(call, faster):
    """A call before which somebody does something, once; they may call it too."""
    done = []

    def overtaken_call(*arguments):
        if not done:
            done.append(True)
            faster()
        return call(*arguments)

    return overtaken_call


def test_of_two_nodes_that_make_a_file_at_once_one_is_refused(file, monkeypatch):
    """A renaming would have taken away the file of the first."""
    others = []
    faster = overtaken(os.link, lambda: others.append(KeptState(file, ROBOT)))
    monkeypatch.setattr(os, "link", faster)
    with pytest.raises(BlockingIOError, match="another node of this name"):
        KeptState(file, ROBOT)
    assert not others[0].mend()
    assert list(file.parent.iterdir()) == [file]
    others[0].close()


def test_a_file_that_lost_its_name_before_it_was_locked_is_not_taken(file, monkeypatch):
    """Its lock would keep nobody away."""
    KeptState(file, ROBOT).close()
    others = []

    def make_it_anew():
        file.unlink()
        others.append(KeptState(file, ROBOT))

    monkeypatch.setattr(fcntl, "flock", overtaken(fcntl.flock, make_it_anew))
    with pytest.raises(BlockingIOError, match="another node of this name"):
        KeptState(file, ROBOT)
    others[0].close()


def remove(file):
    file.unlink()


def truncate(file):
    file.write_bytes(b"")


def replace(file):
    other = file.with_name("other")
    other.write_bytes(file.read_bytes())
    other.rename(file)


def remove_folder(file):
    shutil.rmtree(file.parent)


def move(file):
    file.rename(file.with_name("moved"))


def spoil_slot(file):
    file.write_bytes(changed_bytes(file.read_bytes(), [300, 700], lambda byte: byte ^ 1))


OTHERS = [remove, truncate, replace, remove_folder, move, spoil_slot]


@pytest.mark.parametrize("change", OTHERS)
@pytest.mark.parametrize("then_kept", [0, 1, 2])
def test_what_others_do_to_the_file_is_noticed_and_mended(file, change, then_kept):
    """It ended the process with SIGBUS at the next step, or nothing was known afterwards."""
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.3), at(0.3).motors)
    assert not kept.mend()
    change(file)
    for fraction in (0.6, 0.9)[:then_kept]:
        kept.keep(at(fraction), at(fraction).motors)
    assert kept.mend() or (change is spoil_slot and then_kept == 2)
    assert not kept.mend()
    opened = [place.resolve() for place in Path("/proc/self/fd").iterdir()]
    assert sum(file.parent in place.parents for place in opened) == 1  # the one before is closed
    with pytest.raises(BlockingIOError):  # the lock is that of the file that is there
        KeptState(file, ROBOT)
    kept.close()
    kept = KeptState(file, ROBOT)
    expected = at((0.3, 0.6, 0.9)[then_kept]).motors
    np.testing.assert_array_equal(kept.last().motors, expected)
    kept.close()


@pytest.mark.parametrize("linked", ["file", "folder"])
def test_where_a_link_leads_the_file_is_made_anew_too(file, linked):
    """It was another node's for ever: the link itself had the name."""
    disk = file.parent.with_name("disk")
    disk.mkdir()
    if linked == "folder":
        file.parent.symlink_to(disk)
    else:
        KeptState(disk / file.name, ROBOT).close()
        file.parent.mkdir()
        file.symlink_to(disk / file.name)
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.3), at(0.3).motors)
    (disk / file.name).unlink()
    assert kept.mend() and not kept.mend()
    kept.close()
    assert file.is_symlink() is (linked == "file")
    kept = KeptState(file, ROBOT)
    np.testing.assert_array_equal(kept.last().motors, at(0.3).motors)
    kept.close()


@pytest.mark.parametrize("linked", ["file", "folder"])
def test_a_link_that_is_led_elsewhere_is_followed(file, linked):
    """The disk is replaced, say: the next start looks where the link leads then."""
    disks = [file.parent.with_name(name) for name in ("first", "second")]
    for disk in disks:
        disk.mkdir()
        KeptState(disk / file.name, ROBOT).close()
    link = file.parent if linked == "folder" else file
    targets = [disk if linked == "folder" else disk / file.name for disk in disks]
    link.parent.mkdir(exist_ok=True)
    link.symlink_to(targets[0])
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.3), at(0.3).motors)
    link.unlink()
    link.symlink_to(targets[1])
    kept.keep(at(0.6), at(0.6).motors)
    assert kept.mend() and not kept.mend()
    kept.close()
    kept = KeptState(file, ROBOT)
    np.testing.assert_array_equal(kept.last().motors, at(0.6).motors)
    kept.close()


@pytest.mark.parametrize("linked", ["file", "folder", "above"])
def test_a_link_that_leads_nowhere_is_no_new_file(tmp_path, linked):
    """What it leads to may be away for now, and know where the robot is."""
    file = tmp_path / "above" / "folder" / "node.state"
    link = {"file": file, "folder": file.parent, "above": file.parent.parent}[linked]
    link.parent.mkdir(parents=True, exist_ok=True)
    link.symlink_to(tmp_path / "away" / "state")
    assert link_to_nowhere(file) == link
    with pytest.raises(FileNotFoundError, match="a link that leads nowhere") as caught:
        KeptState(file, ROBOT)
    assert caught.value.filename == str(link)
    assert not (tmp_path / "away").exists()


def test_links_that_go_in_a_circle_are_no_new_file_either(file):
    file.parent.mkdir()
    file.symlink_to(file)
    assert link_to_nowhere(file) is None
    with pytest.raises(OSError, match="levels of symbolic links"):
        KeptState(file, ROBOT)


@pytest.mark.parametrize("then_kept", [1, 2])
def test_a_node_killed_after_its_file_was_truncated_is_not_one_that_knows_nothing(file, then_kept):
    """Before it was mended."""
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.3), at(0.3).motors)
    truncate(file)
    for fraction in (0.6, 0.9)[:then_kept]:
        kept.keep(at(fraction), at(fraction).motors)
    kept.close()
    kept = KeptState(file, ROBOT)
    assert "does not begin as a file of this version" in kept.damage
    kept.close()


def test_a_removed_file_that_another_node_has_made_again_is_left_to_it(file):
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.3), at(0.3).motors)
    file.unlink()
    other = KeptState(file, ROBOT)
    with pytest.raises(BlockingIOError, match="another node of this name"):
        kept.mend()
    kept.keep(at(0.6), at(0.6).motors)  # to nobody's harm
    assert other.last() is None
    other.close()
    assert kept.mend()
    kept.close()
    kept = KeptState(file, ROBOT)
    np.testing.assert_array_equal(kept.last().motors, at(0.6).motors)
    kept.close()


@pytest.mark.parametrize("written", [None, 0, 30])
def test_what_could_not_be_written_is_an_error_and_is_written_later(file, monkeypatch, written):
    """With a memory map it was SIGBUS."""
    os_pwrite = os.pwrite

    def full(target, content, place):
        if written is None:
            raise OSError(errno.ENOSPC, "No space left on device")
        return os_pwrite(target, content[:written], place) if written else 0

    kept = KeptState(file, ROBOT)
    kept.keep(at(0.3), at(0.3).motors)
    with monkeypatch.context() as patched:
        patched.setattr(os, "pwrite", full)
        for _ in range(3):
            with pytest.raises(OSError, match="No space left"):
                kept.keep(at(0.6), at(0.6).motors)
        with pytest.raises(OSError, match="No space left"):
            kept.mend()
    assert kept.mend()
    kept.close()
    kept = KeptState(file, ROBOT)
    np.testing.assert_array_equal(kept.last().motors, at(0.6).motors)
    kept.close()


def test_a_disk_that_is_full_is_told_before_anything_is_written(tmp_path, monkeypatch):
    """Also where there is a file: it may have holes."""
    kept = KeptState(tmp_path / "whole.state", ROBOT)
    kept.close()
    whole = (tmp_path / "whole.state").stat()
    assert 512 * whole.st_blocks >= whole.st_size > 0

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", full)
    for name in ("whole.state", "other.state"):
        with pytest.raises(OSError, match="No space left"):
            KeptState(tmp_path / name, ROBOT)
    assert [file.name for file in tmp_path.iterdir()] == ["whole.state"]
