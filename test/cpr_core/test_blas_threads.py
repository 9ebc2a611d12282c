# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Dense matrices are decomposed on one thread, and BLAS has all of its threads again afterwards."""

import json
import os
import subprocess
import sys
import threading

import pytest
from helpers.blas_limit import blas_threads_limited
from helpers.quick_end import QUICK_END
from threadpoolctl import threadpool_info

import cpr_core
from cpr_core.blas_threads import on_one_blas_thread, on_one_numpy_thread
from cpr_core.model import dense_response, stability


def blas_threads(package=""):
    """Threads of BLAS: of what a package brings with it, or of all where it brings none."""
    found = [library for library in threadpool_info() if library["user_api"] == "blas"]
    own = [library for library in found if f"{package}.libs" in library["filepath"]]
    return [library["num_threads"] for library in own or found]


@pytest.fixture
def before():
    """Threads of BLAS outside: where a machine or a worker has one only there is nothing to see."""
    threads = blas_threads()
    if max(threads) == 1:
        with blas_threads_limited(2):
            yield blas_threads()
    else:
        yield threads


def test_a_call_has_one_thread_and_gives_the_others_back(before):
    assert max(before) > 1
    assert set(on_one_blas_thread(blas_threads)()) == {1}
    assert blas_threads() == before


def test_an_error_gives_them_back(before):
    @on_one_blas_thread
    def fail():
        raise ValueError

    with pytest.raises(ValueError):
        fail()
    assert blas_threads() == before


def test_calls_that_overlap_give_them_back_when_the_last_one_ends(before):
    entered, leave = threading.Event(), threading.Event()

    @on_one_blas_thread
    def wait():
        entered.set()
        assert leave.wait(10.0)

    other = threading.Thread(target=wait)
    other.start()
    assert entered.wait(10.0)
    assert set(on_one_blas_thread(blas_threads)()) == {1}
    assert set(blas_threads()) == {1}
    leave.set()
    other.join()
    assert blas_threads() == before


def test_spectra_and_the_dense_response_are_computed_on_one_thread(before, monkeypatch):
    found = cpr_core.solve_forward(cpr_core.load_robot("rfrfr"), [2.6, 0.6])
    seen = []

    def watch(package, name):
        function = getattr(package.linalg, name)

        def call(*args, **kwargs):
            seen.append((name, set(blas_threads(package.__name__))))
            return function(*args, **kwargs)

        monkeypatch.setattr(package.linalg, name, call)

    watch(stability.np, "eigh")
    watch(stability.np, "eigvalsh")
    watch(stability.scipy, "qr")
    watch(dense_response.scipy, "solve")
    spectrum = cpr_core.spectrum(found)
    assert spectrum.eigenvalues.size == spectrum.motions.shape[1] > 0
    assert found.dense_response.moved.size
    assert {name for name, _ in seen} == {"eigh", "eigvalsh", "qr", "solve"}
    assert all(threads == {1} for _, threads in seen)


def test_scipy_is_limited_within_a_call_that_began_with_numpy_alone(before):
    seen = []

    @on_one_numpy_thread
    def with_numpy():
        seen.append(on_one_blas_thread(blas_threads)())
        seen.append(blas_threads())

    with_numpy()
    assert [set(threads) for threads in seen] == [{1}, {1}]
    assert blas_threads() == before


#: In a process of its own, as scipy is imported by these tests. Threads of all of BLAS, one by one.
NUMPY_ALONE = """
import json, sys
from threadpoolctl import threadpool_info
from cpr_core.blas_threads import on_one_blas_thread, on_one_numpy_thread
def threads():
    return sorted(library["num_threads"] for library in threadpool_info())
seen = []
@on_one_blas_thread
def with_scipy():
    seen.append([threads(), "scipy.linalg" in sys.modules])
@on_one_numpy_thread
def with_numpy():
    seen.append([threads(), "scipy.linalg" in sys.modules])
    with_scipy()
    seen.append([threads(), "scipy.linalg" in sys.modules])
with_numpy()
seen.append([threads(), "scipy.linalg" in sys.modules])
print(json.dumps(seen))
"""


def test_scipy_is_not_imported_for_numpy_and_limited_when_it_comes():
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "2"}
    done = subprocess.run(
        [sys.executable, "-c", QUICK_END + NUMPY_ALONE],
        env=environment,
        stdout=subprocess.PIPE,
        check=True,
    )
    alone, within, still, after = json.loads(done.stdout)
    assert set(alone[0]) == set(within[0]) == set(still[0]) == {1}
    assert set(after[0]) == {2}
    assert not alone[1]
    assert all(imported for _, imported in (within, still, after))
