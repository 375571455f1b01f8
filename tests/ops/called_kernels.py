"""The kernels' operators with values: they call the C functions that compiled ops call, in the libraries that
artifacts are linked with, on tensors in guarded memory (tests/kernels/for_python.cpp)."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import POINTER, byref, c_char_p, c_double, c_int32, c_int64, c_void_p
from functools import partial
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from chiasm.primitives.kernels.declarations import KERNELS
from chiasm.primitives.kernels.operators import declared_result
from chiasm.primitives.kernels.schema import Argument, Kernel

LIBRARY = Path(__file__).resolve().parents[2] / "build/release/lib/libkernels_for_python.so"


class View(ctypes.Structure):
    """chiasm_kernel_view."""

    _fields_ = (("dtype", c_char_p), ("dims", c_int64), ("sizes", POINTER(c_int64)), ("data", c_void_p))


@contextmanager
def computing_kernels() -> Iterator[None]:
    """Within this context, the kernels' operators compute."""
    assert LIBRARY.is_file(), f"there is no {LIBRARY}: run `make build`"
    library = ctypes.CDLL(str(LIBRARY))
    library.chiasm_kernel_function.restype = library.chiasm_kernel_tensor.restype = c_void_p
    library.chiasm_kernel_error.restype = c_char_p
    library.chiasm_kernel_look.restype = View
    with torch.library._scoped_library("chiasm", "IMPL") as operators:
        for kernel in KERNELS.values():
            operators.impl(kernel.name, partial(_call, library, kernel), "CPU")
        yield


def _call(library: ctypes.CDLL, kernel: Kernel, *values: Any) -> Tensor:
    function = ctypes.CFUNCTYPE(c_int32)(library.chiasm_kernel_function(kernel.name.encode()))
    passed = [_passed(library, *pair) for pair in zip(kernel.arguments, values, strict=True)]
    result = c_void_p()
    failed = function(*passed, byref(result))
    for tensor in (p for p in passed if isinstance(p, c_void_p)):
        assert not library.chiasm_kernel_free(tensor), f"{kernel.name} has written outside an argument"
    if failed:
        raise ValueError(library.chiasm_kernel_error().decode())
    view, made = library.chiasm_kernel_look(result), declared_result(kernel, *values)
    assert (view.sizes[: view.dims], view.dtype.decode()) == (list(made.shape), _name(made.dtype))
    ctypes.memmove(made.data_ptr(), view.data, made.nbytes)
    assert not library.chiasm_kernel_free(result), f"{kernel.name} has written outside its result"
    return made


def _passed(library: ctypes.CDLL, argument: Argument, value: Any) -> Any:
    """An argument as the C function takes it; a tensor is dense, as kernels have it."""
    if argument.shape is None:
        return {"float": c_double, "bool": c_int32}.get(argument.type, c_int64)(value)
    dense = value.contiguous()
    sizes = (c_int64 * dense.dim())(*dense.shape)
    dtype = _name(dense.dtype).encode()
    tensor = c_void_p(library.chiasm_kernel_tensor(dtype, c_int64(dense.dim()), sizes))
    ctypes.memmove(library.chiasm_kernel_look(tensor).data, dense.data_ptr(), dense.nbytes)
    return tensor


def _name(dtype: torch.dtype) -> str:
    return str(dtype).removeprefix("torch.")
