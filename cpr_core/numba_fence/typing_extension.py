# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What types of our own are made with: numba's low-level extension interface, and what it rests on."""

import numba

try:
    from numba.core import cgutils, types
    from numba.core.typing.templates import (
        AbstractTemplate,
        AttributeTemplate,
        infer_global,
        signature,
    )
    from numba.extending import (
        NativeValue,
        infer_getattr,
        intrinsic,
        lower_builtin,
        lower_getattr_generic,
        models,
        register_model,
        unbox,
    )
    from numba.np import arrayobj
except ImportError as error:
    raise ImportError(
        f"numba {numba.__version__} lacks what types of kernels are made with ({error}); "
        "setup.py names the versions that have it"
    ) from error

__all__ = [
    "AbstractTemplate",
    "AttributeTemplate",
    "NativeValue",
    "arrayobj",
    "cgutils",
    "infer_getattr",
    "infer_global",
    "intrinsic",
    "ir",
    "lower_builtin",
    "lower_getattr_generic",
    "models",
    "register_model",
    "signature",
    "types",
    "unbox",
]

ir = cgutils.ir  # llvmlite's, as numba brings it
