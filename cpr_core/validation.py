"""Checks of what users hand in."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InvalidRequest, NonFiniteInput

__all__ = ["checked_vector"]


def checked_vector(
    name: str, value: ArrayLike, size: int, meaning: str = ""
) -> NDArray[np.float64]:
    """A read-only float vector of a given length.

    Raises:
        InvalidRequest: Not numbers, or not ``size`` of them.
        NonFiniteInput: A NaN or an infinity among them.
    """
    expected = f"expected {size} numbers" + (f" ({meaning})" if meaning else "")
    try:
        given = np.asarray(value)
        if given.dtype.kind in "SUbc":  # words and truth values are no numbers
            raise TypeError
        vector = given.astype(float)
    except (TypeError, ValueError, OverflowError):
        raise InvalidRequest(name, f"{expected}, got {value!r:.200}") from None
    if vector.shape != (size,):
        count = vector.size if vector.ndim == 1 else f"an array of shape {vector.shape}"
        raise InvalidRequest(name, f"{expected}, got {count}")
    if not np.isfinite(vector).all():
        raise NonFiniteInput(name, f"{expected}, all finite, got {vector.tolist()}")
    vector.flags.writeable = False
    return vector
