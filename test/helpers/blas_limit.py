# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A number of threads of BLAS for a while, for a whole process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Thread

import scipy.linalg  # noqa: F401  brings its own BLAS, which has to be there to be found
from threadpoolctl import ThreadpoolController


@contextmanager
def blas_threads_limited(count: int) -> Iterator[None]:
    """Set by a thread that ends: while one lives that has set it, threadpoolctl lets no other do so."""
    controller, limits = ThreadpoolController(), []
    _in_a_thread(lambda: limits.append(controller.limit(limits=count, user_api="blas")))
    try:
        yield
    finally:
        _in_a_thread(limits[0].restore_original_limits)


def _in_a_thread(call) -> None:
    thread = Thread(target=call)
    thread.start()
    thread.join()
