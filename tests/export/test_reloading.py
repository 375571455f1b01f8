"""A native artifact frees everything when it is closed, including its own copy of libstdc++'s reserve for
exceptions."""

import ctypes
from pathlib import Path

import chiasm.runtime

BUNDLE = Path(__file__).resolve().parents[2] / "build" / "bundles" / "filters.sobel.chiasm"
LOADS = 50


class Allocated(ctypes.Structure):
    """glibc's `struct mallinfo2`; its eighth number is the bytes in use."""

    _fields_ = (("numbers", ctypes.c_size_t * 10),)


def test_loading_again_and_again() -> None:
    libc = ctypes.CDLL(None)
    libc.mallinfo2.restype = Allocated
    bundle = chiasm.runtime.open(BUNDLE)

    def load() -> None:
        for _ in range(LOADS):
            assert bundle.method(backend="native").backend == "native"

    load()
    before = libc.mallinfo2().numbers[7]
    load()
    assert libc.mallinfo2().numbers[7] - before < LOADS * 1000
