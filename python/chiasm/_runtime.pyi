# What C++ binds (runtime/python/module.cpp); tests/export/test_stubs.py compares the names.
"""
The runtime of chiasm. Use chiasm.runtime.
"""

from __future__ import annotations

import collections.abc
import enum
import typing

__all__: list[str] = [
    "BackendInfo",
    "Bundle",
    "ChiasmError",
    "Code",
    "LoadOptions",
    "Method",
    "Output",
    "SelfTestRow",
    "TensorInfo",
    "backends",
    "dtypes",
    "get_num_threads",
    "get_trust",
    "instruction_sets",
    "library_version",
    "set_num_threads",
    "set_trust",
    "sign",
    "verify_signature",
]

class Code(enum.IntEnum):
    """
    The kinds of problem; `ChiasmError.code` is one.
    """

    OK = 0
    INVALID_ARGUMENT = 1
    FAILED_PRECONDITION = 2
    NOT_FOUND = 16
    CORRUPT = 17
    VERSION_MISMATCH = 18
    UNTRUSTED = 19
    UNAVAILABLE = 32
    OUT_OF_MEMORY = 33
    IO_ERROR = 34
    INTERNAL = 48

class ChiasmError(RuntimeError):
    """
    What the runtime could not do, in words; `code` is the kind of problem, a `Code`.
    """

    code: Code

class TensorInfo:
    """
    One input or output in a method's signature.
    """
    def __repr__(self) -> str: ...
    @property
    def color(self) -> str:
        """
        'RGB', 'BGR', 'GRAY', 'HSV' or ''
        """
    @property
    def description(self) -> str: ...
    @property
    def dtypes(self) -> list[str]:
        """
        The dtypes accepted, by name.
        """
    @property
    def layout(self) -> str:
        """
        'NCHW', 'HWC', ... or ''
        """
    @property
    def name(self) -> str: ...
    @property
    def range(self) -> tuple[float, float] | None:
        """
        Nominal (min, max) of the values, or None.
        """
    @property
    def shape(self) -> list[str]:
        """
        One expression for each dimension: '3', 'H', '2*H'.
        """

class Output:
    """
    An output of a run, for any library that speaks DLPack.
    """
    def __dlpack__(
        self,
        *,
        stream: typing.Any = None,
        max_version: typing.Any = None,
        dl_device: typing.Any = None,
        copy: typing.Any = None,
    ) -> typing.Any:
        """
        A DLPack capsule over the output's memory. On CUDA, use it on the stream that the method ran on.
        """
    def __dlpack_device__(self) -> tuple: ...
    @property
    def dtype(self) -> str: ...
    @property
    def shape(self) -> tuple: ...

class Method:
    """
    An entry point of a bundle, loaded on one backend: call it with arrays.

    Inputs are NumPy arrays, torch tensors, or anything else with ``__dlpack__`` or the buffer protocol, and
    are read where they are. On the CPU rows and elements may have gaps between them, on CUDA they may not.
    Python numbers stand for 0-d inputs. Outputs are torch tensors if any input was one, else NumPy arrays;
    one output is returned as itself, several as a tuple. The GIL is released while the method runs, and one
    method may run in many threads at once.
    """
    def __call__(self, *args, **kwargs) -> typing.Any:
        """
        Run on inputs given by position or by name.
        """
    def __repr__(self) -> str: ...
    def output_shapes(self, *args, **kwargs) -> list[tuple[tuple, str]]:
        """
        A (shape, dtype) for each output that these inputs would give.
        """
    def run(self, inputs: typing.Any, *, returns: typing.Any = None, stream: typing.Any = None) -> typing.Any:
        """
        Run on a sequence of inputs, or a dict of them by name, or the only input itself.

        Parameters
        ----------
        returns : {"numpy", "torch", "dlpack"}, optional
            What the outputs are; by default as the inputs. "dlpack" gives objects with ``__dlpack__``.
        stream : int or torch.cuda.Stream, optional
            On CUDA, the stream to enqueue on: the call returns when the work is enqueued. By default torch's
            current stream for torch tensors, else the default stream.
        """
    def run_each(self, inputs: typing.Any, outputs: typing.Any, *, stream: typing.Any = None) -> None:
        """
        Several runs in one call, several at once: item i of `inputs` and of `outputs` is what `run_into`
        takes for run i. Images may differ in their sizes, and become one batch where the outputs are its
        parts. Load the method with ``num_threads=1``, and each core takes runs of its own. If some fail, the
        others are finished, and the first error is raised, with the run's number.
        """
    def run_into(self, inputs: typing.Any, outputs: typing.Any, *, stream: typing.Any = None) -> None:
        """
        Run into arrays of the caller, each given as in `run`. They must be writable, on CUDA dense,
        have the shapes and dtypes of `output_shapes`, and overlap neither the inputs nor each other.
        """
    @property
    def artifact(self) -> str:
        """
        The file's name inside the bundle.
        """
    @property
    def backend(self) -> str:
        """
        'native', 'torch', 'onnx', or the name of another plug-in
        """
    @property
    def inputs(self) -> list[TensorInfo]: ...
    @property
    def name(self) -> str: ...
    @property
    def outputs(self) -> list[TensorInfo]: ...

class SelfTestRow:
    """
    A golden case replayed on one backend.
    """
    def __repr__(self) -> str: ...
    @property
    def artifact(self) -> str: ...
    @property
    def backend(self) -> str: ...
    @property
    def dtype(self) -> str: ...
    @property
    def max_error(self) -> float: ...
    @property
    def message(self) -> str: ...
    @property
    def method(self) -> str: ...
    @property
    def passed(self) -> bool | None:
        """
        True, False, or None where it was not run: `message` says why.
        """
    @property
    def tolerance(self) -> float: ...

class LoadOptions:
    """
    How to load a method; the members are those of chiasm.hpp.
    """

    allow_native_code: bool
    backend: str
    fused: bool
    warm_up: bool
    @staticmethod
    def make() -> LoadOptions: ...
    def with_device(
        self,
        type: typing.SupportsInt | typing.SupportsIndex,
        index: typing.SupportsInt | typing.SupportsIndex,
    ) -> None: ...
    def with_dtype(self, name: str) -> None: ...
    def with_option(self, key: str, value: str) -> None: ...
    @property
    def num_threads(self) -> int: ...
    @num_threads.setter
    def num_threads(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...

class Bundle:
    @staticmethod
    def open(path: str) -> Bundle: ...
    def method(self, name: str, options: LoadOptions) -> Method: ...
    def self_test(self, options: LoadOptions) -> list[SelfTestRow]: ...
    def signature(self, name: str) -> tuple[list[TensorInfo], list[TensorInfo]]: ...
    @property
    def manifest(self) -> str: ...
    @property
    def methods(self) -> list[str]: ...
    @property
    def name(self) -> str: ...
    @property
    def path(self) -> str: ...
    @property
    def summary(self) -> str: ...
    @property
    def version(self) -> str: ...

class BackendInfo:
    """
    Whether a backend can be used in this process, and if not, why and what to do.
    """
    def __repr__(self) -> str: ...
    @property
    def available(self) -> bool: ...
    @property
    def engine_version(self) -> str: ...
    @property
    def has_cuda(self) -> bool: ...
    @property
    def name(self) -> str: ...
    @property
    def problem(self) -> str: ...

def backends() -> list[BackendInfo]: ...
def dtypes() -> list[str]: ...
def get_num_threads() -> int: ...
def get_trust() -> str: ...
def instruction_sets() -> list[str]: ...
def library_version() -> str: ...
def set_num_threads(count: typing.SupportsInt | typing.SupportsIndex) -> None: ...
def set_trust(policy: str, keys: collections.abc.Sequence[str]) -> None: ...
def sign(message: bytes, secret_key: bytes) -> bytes: ...
def verify_signature(message: bytes, signature: bytes, key: str, origin: str, key_origin: str) -> bytes: ...
