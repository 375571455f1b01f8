"""Run exported bundles, on any backend that is present, without importing torch.

A *bundle* is a folder ``NAME.chiasm`` that the exporter wrote; a *method* is an entry point of it; a
*backend* (native, torch, onnx, or another plug-in) runs it.

Examples
--------
>>> import numpy as np
>>> import chiasm.runtime
>>> bundle = chiasm.runtime.open("build/bundles/filters.sobel.chiasm")
>>> sobel = bundle.method("forward")
>>> edges = sobel(np.zeros((1, 3, 32, 48), np.float32))
>>> edges.shape
(1, 3, 32, 48)
"""

import ctypes
import json
import operator
import os
import re
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .interpreter import subinterpreter

if subinterpreter():
    raise ImportError(
        "chiasm's runtime works in a process's main interpreter only, and this is subinterpreter"
        f" {subinterpreter()}; with mod_wsgi, set `WSGIApplicationGroup %{{GLOBAL}}`"
    )
try:
    from chiasm import _runtime
except ImportError as error:
    raise ImportError(
        "chiasm's runtime is not built for this Python: in a source tree run `make build`, elsewhere"
        f" `pip install chiasm` ({error})"
    ) from error
from chiasm._runtime import BackendInfo, ChiasmError, Code, Method, Output, SelfTestRow, TensorInfo

__all__ = [
    "BackendInfo",
    "Bundle",
    "ChiasmError",
    "Code",
    "Method",
    "Output",
    "SelfTestRow",
    "TensorInfo",
    "backends",
    "get_num_threads",
    "get_trust",
    "open",
    "set_num_threads",
    "set_trust",
]


def __dir__() -> list[str]:
    return __all__


class Bundle:
    """An opened bundle: its description and its methods. `open` returns it."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._handle = _runtime.Bundle.open(_text("path", os.fsdecode(path)))
        self._info: dict[str, Any] | None = None

    @property
    def info(self) -> dict[str, Any]:
        """The manifest, whole."""
        info = self._info
        if info is None:
            info = self._info = json.loads(self._handle.manifest)
        return info

    @property
    def name(self) -> str:
        """The op's name, e.g. ``"filters.sobel"``."""
        return self._handle.name

    @property
    def version(self) -> str:
        """The op's semantic version."""
        return self._handle.version

    @property
    def methods(self) -> list[str]:
        """The names of the methods."""
        return self._handle.methods

    def signature(self, name: str = "forward") -> tuple[list[TensorInfo], list[TensorInfo]]:
        """The inputs and the outputs of a method, without loading it.

        Examples
        --------
        >>> import chiasm.runtime
        >>> inputs, outputs = chiasm.runtime.open("build/bundles/filters.sobel.chiasm").signature()
        >>> len(inputs), len(outputs)
        (1, 1)
        """
        return self._handle.signature(_text("name", name))

    def method(
        self,
        name: str = "forward",
        backend: str = "auto",
        device: str = "cpu",
        dtype: Any = None,
        allow_native_code: bool = True,
        fused: bool = True,
        warm_up: bool = False,
        num_threads: int = 0,
        options: Mapping[str, str] | None = None,
    ) -> Method:
        """Load a method.

        Parameters
        ----------
        name
            One of `methods`.
        backend
            The name of one of `backends`, or "auto": the first of them that can run the method here.
        device
            "cpu", "cuda" or "cuda:1"; a ``torch.device`` will do.
        dtype
            For a method that accepts several dtypes, the one to load, as a name, a NumPy dtype or a torch
            dtype; by default float32, else the first available.
        allow_native_code
            The native and torch artifacts are programs. False allows only artifacts that are data (ONNX, or
            what a backend declares as data): use it for bundles whose author you do not trust.
        fused
            The onnx backend on the CPU: run the method's native code as one node inside ONNX Runtime, if the
            bundle has some for this machine. False runs the graph of standard operators.
        warm_up
            Run once on the smallest valid input, so that the first real run is not the slow one.
        num_threads
            How many threads a run of this method may use; 0: as many as the process may use
            (`set_num_threads`), which is also the upper limit. A server that runs several methods at once
            gives each 1.
        options
            Options of the backend named in `backend`.

        Raises
        ------
        ChiasmError
            If there is no such method, or no backend that can run it here; the message says what is missing.

        Examples
        --------
        >>> import chiasm.runtime
        >>> bundle = chiasm.runtime.open("build/bundles/filters.sobel.chiasm")
        >>> bundle.method("forward", backend="onnx").backend
        'onnx'
        """
        if backend == "torch" or (backend == "auto" and _torch_is_elsewhere()):
            _open_libtorch()
        load = _load_options(backend, device, allow_native_code)
        load.fused, load.warm_up = _bool("fused", fused), _bool("warm_up", warm_up)
        load.num_threads = _number("num_threads", num_threads)
        if dtype is not None:
            load.with_dtype(_text("dtype", _dtype_name(dtype)))
        if not isinstance(options, Mapping | None):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise TypeError(f"options: expected a dict of texts, got {options!r}")
        for key, value in (options or {}).items():
            load.with_option(_text("options", key), _text("options", str(value)))
        return self._handle.method(_text("name", name), load)

    def self_test(
        self, backend: str = "auto", device: str = "cpu", allow_native_code: bool = True
    ) -> list[SelfTestRow]:
        """Replay the golden vectors on this machine: a row for each golden case and backend.

        The backend "auto" means every backend that is present. A row's ``passed`` is True, False, or None if
        it was not run.

        Examples
        --------
        >>> import chiasm.runtime
        >>> rows = chiasm.runtime.open("build/bundles/filters.sobel.chiasm").self_test()
        >>> [row for row in rows if row.passed is False]
        []
        """
        if backend in ("auto", "torch"):
            _open_libtorch()
        return self._handle.self_test(_load_options(backend, device, allow_native_code))

    def __repr__(self) -> str:
        return f"<chiasm bundle {self.name} {self.version}: {', '.join(self.methods)}>"


def open(path: str | os.PathLike[str]) -> Bundle:
    """Open a bundle. Loads no engine.

    Parameters
    ----------
    path
        The folder ``NAME.chiasm``; or an op's name, e.g. ``"filters.sobel"``, of a bundle that a Python
        package has installed (``chiasm list --installed`` shows them). A folder of that name comes first.

    Raises
    ------
    ChiasmError
        If there is no bundle or it is damaged; the message names the file.
    OSError
        If it is a name, and the list of what an installed Python package brings cannot be read.

    Examples
    --------
    >>> import chiasm.runtime
    >>> chiasm.runtime.open("build/bundles/filters.sobel.chiasm").name
    'filters.sobel'
    """
    name = _text("path", os.fsdecode(path))
    if os.path.exists(name):
        return Bundle(name)
    from .. import packs  # importlib.metadata takes longer to import than all of this

    named = packs.is_name(name)
    installed = packs.find(name) if named else None
    try:
        return Bundle(installed or name)
    except RuntimeError as error:
        if named and installed is None:
            error.args = (f"{error}; nor is it the name of an installed one: `chiasm list --installed`",)
        raise


def backends() -> list[BackendInfo]:
    """The backends, in the order in which "auto" tries them. Loads the engines of all that are present.

    Examples
    --------
    >>> import chiasm.runtime
    >>> [backend.name for backend in chiasm.runtime.backends()]
    ['native', 'torch', 'onnx']
    """
    _open_libtorch()
    return _runtime.backends()


def set_num_threads(count: int) -> None:
    """Set how many threads a run may use, for every backend.

    A number from 0 to 1024; 0, the default, means all cores of this process. Call it before the first method
    is loaded. The torch backend sets torch's own thread count to it.

    Raises
    ------
    ChiasmError
        INVALID_ARGUMENT if the number is not from 0 to 1024, FAILED_PRECONDITION after the first load.
    """
    _runtime.set_num_threads(_number("count", count))


def get_num_threads() -> int:
    """How many threads a run may use.

    Examples
    --------
    >>> import chiasm.runtime
    >>> chiasm.runtime.get_num_threads() > 0
    True
    """
    return _runtime.get_num_threads()


def set_trust(policy: str, keys: Sequence[str | os.PathLike[str]] = ()) -> None:
    """Set which bundles this process runs. This replaces ``CHIASM_TRUST_POLICY`` and ``CHIASM_TRUSTED_KEYS``.

    Call it before the first method is loaded. docs/signing.md says how bundles are signed.

    Parameters
    ----------
    policy
        "any"; "signed": bundles that a trusted key has signed; "data_only": any, but only artifacts that are
        data (ONNX, or what a backend declares as data), never a program.
    keys
        For "signed": minisign public keys, each as its 56 characters or as the path of a file.

    Raises
    ------
    ChiasmError
        INVALID_ARGUMENT for an unknown policy, a key that is none, or "signed" without a key;
        FAILED_PRECONDITION after the first load.
    """
    if isinstance(keys, (str, bytes, os.PathLike)):
        raise TypeError(f"keys: expected a list of keys, got {keys!r}")
    _runtime.set_trust(_text("policy", policy), [_text("keys", os.fsdecode(key)) for key in keys])


def get_trust() -> str:
    """The trust policy of this process.

    Examples
    --------
    >>> import chiasm.runtime
    >>> chiasm.runtime.get_trust()
    'any'
    """
    return _runtime.get_trust()


def _parse_device(device: Any) -> tuple[int, int]:
    found = re.fullmatch("(cpu|cuda)(?::([0-9]{1,9}))?", str(device))
    if not found:
        raise ValueError(f"device: expected 'cpu', 'cuda' or 'cuda:N', got {device!r}")
    return int(found[1] == "cuda"), int(found[2] or 0)


def _number(argument: str, value: Any) -> int:
    """A 32-bit integer of any type; the core checks its value."""
    if not hasattr(value, "__index__"):
        raise TypeError(f"{argument}: expected a whole number, got {value!r}")
    number = operator.index(value)
    if not -(2**31) <= number < 2**31:
        raise ValueError(f"{argument}: expected a number from 0 to {2**31 - 1}, got {value!r}")
    return number


def _text(argument: str, value: Any) -> str:
    """Text that C++ receives completely: C++ uses UTF-8, and ends text at a NUL."""
    if not isinstance(value, str):
        raise TypeError(f"{argument}: expected a str, got {value!r}")
    if "\0" in value or any("\ud800" <= c <= "\udfff" for c in value):
        raise ValueError(f"{argument}: expected text without NUL, in UTF-8, got {value!r}")
    return value


def _bool(argument: str, value: Any) -> bool:
    """A truth value of any type, NumPy's too; texts and containers are none."""
    if not hasattr(value, "__bool__"):
        raise TypeError(f"{argument}: expected a bool, got {value!r}")
    return bool(value)


def _load_options(backend: str, device: Any, allow_native_code: bool) -> _runtime.LoadOptions:
    options = _runtime.LoadOptions.make()
    options.backend = _text("backend", backend)
    options.allow_native_code = _bool("allow_native_code", allow_native_code)
    options.with_device(*_parse_device(device))
    return options


def _dtype_name(dtype: Any) -> str:
    if isinstance(dtype, str):
        return dtype
    text = str(dtype)
    if text.startswith("torch."):
        return text.removeprefix("torch.")
    # numpy.float32 is a class, numpy.dtype("float32") prints its name
    return getattr(dtype, "__name__", text)


def _package_folder(package: str) -> Path | None:
    """The folder of an installed package, without importing it."""
    try:
        spec = find_spec(package)
    except ValueError:  # a stub in sys.modules, as tests and builds of documentation put there
        return None
    if spec is None or not spec.submodule_search_locations:
        return None
    return Path(next(iter(spec.submodule_search_locations)))


def _point_to_onnxruntime() -> None:
    """Tell the onnx plug-in where the wheel's ONNX Runtime is; the plug-in opens it at its first use."""
    if os.environ.get("CHIASM_ONNXRUNTIME_LIBRARY"):
        return
    folder = _package_folder("onnxruntime")
    libraries = sorted((folder / "capi").glob("libonnxruntime.so*")) if folder else []
    if libraries:
        os.environ["CHIASM_ONNXRUNTIME_LIBRARY"] = str(libraries[0])


def _torch_is_elsewhere() -> bool:
    """Whether the torch plug-in of a wheel does not find torch by itself, because torch is not installed
    beside it."""
    package = Path(_runtime.__file__).parent
    return (package / "lib").is_dir() and not (package.parent / "torch" / "lib").is_dir()


def _open_libtorch() -> None:
    """Open the installed libtorch, so that the linker finds it by name when it opens the torch plug-in."""
    if "torch" in sys.modules or _libtorch:
        return
    folder = _package_folder("torch")
    library = folder / "lib" / "libtorch_cpu.so" if folder else None
    if library and library.exists():
        with suppress(OSError):  # the plug-in fails likewise, and the core reports it
            os.getcwd()  # MKL, in libtorch, ends the process if it is opened in a folder that was deleted
            _libtorch.append(ctypes.CDLL(str(library), mode=os.RTLD_NOW))


_libtorch: list[ctypes.CDLL] = []
_point_to_onnxruntime()
