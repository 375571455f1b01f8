"""A bundle opened in ONNX Runtime."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from .functions import read_model
from .methods import Method
from .plugin import library, register

if TYPE_CHECKING:
    import onnxruntime


def session(
    bundle: str | os.PathLike[str],
    method: str = "forward",
    dtype: str | None = None,
    *,
    fused: bool = True,
    options: onnxruntime.SessionOptions | None = None,
    providers: Sequence[str] | None = None,
) -> onnxruntime.InferenceSession:
    """Open a method of a bundle in ONNX Runtime.

    If native code cannot run (the plug-in is not installed, or the bundle has no code for the method), the
    standard operators run instead, and a warning says why.

    Args:
        bundle: the folder ``NAME.chiasm``.
        method: one of the bundle's methods.
        dtype: for a bundle of several dtypes, the one to open; by default float32, else the first available.
        fused: False opens the flat form and leaves the plug-in out.
        options: the session's options; they are changed by `register`, so give each session its own.
        providers: as ONNX Runtime takes them; the CPU by default.

    Returns:
        A session whose inputs and outputs are the method's.

    Raises:
        BundleError: the bundle is damaged, or has no such method, dtype or artifact.
        TypeError: an argument is something else.

    Warns:
        RuntimeWarning: the standard operators run, although `fused` is True.

    Example:
        >>> import chiasm.onnx
        >>> sobel = chiasm.onnx.session("build/bundles/filters.sobel.chiasm", dtype="float64", fused=False)
        >>> sobel.get_inputs()[0].type
        'tensor(double)'
    """
    import onnxruntime

    if isinstance(providers, str):
        raise TypeError(f"providers: expected a list of names, got the text {providers!r}")
    opened = Method.open(bundle, method, dtype)
    options = onnxruntime.SessionOptions() if options is None else options
    artifact = opened.flat()
    if fused and opened.fused() is not None:
        artifact = opened.fused()
    data, _ = read_model(opened, artifact)
    if fused:
        serve([opened], options)
    # the bytes that were checked, not the file again
    return onnxruntime.InferenceSession(data, options, providers=list(providers or ["CPUExecutionProvider"]))


def serve(methods: Sequence[Method], options: onnxruntime.SessionOptions) -> None:
    """Let a session run the methods as native code, where that can be; a warning says where not, and why."""
    served: list[Path] = []
    for opened in methods:
        problem = _problem(opened)
        if problem:
            warnings.warn(
                f"{opened.folder}: {opened.name} runs as standard operators, not as native code: {problem}",
                RuntimeWarning,
                stacklevel=3,
            )
        elif opened.folder not in served:
            served.append(opened.folder)
    if served:
        register(options, served)


def _problem(opened: Method) -> str:
    """Why the plug-in cannot serve the method; empty if it can."""
    if opened.fused() is None:
        return "the bundle has no fused ONNX form: export it again"
    if not opened.has_native():
        return "the bundle has no native artifact for it"
    try:
        library()
    except FileNotFoundError as error:
        return str(error)
    return ""
