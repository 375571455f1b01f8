"""The plug-in for ONNX Runtime: where it is, and how a session gets it."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from chiasm.export.manifest import read_manifest

if TYPE_CHECKING:
    import onnxruntime

LIBRARY = "libchiasm_ort.so"
#: The session's configuration entry that tells the plug-in which bundles to serve. The plug-in reads it when
#: it is registered.
ENTRY = "chiasm.bundles"

BundlePath = str | os.PathLike[str]


def library() -> Path:
    """The path of chiasm's plug-in for ONNX Runtime.

    It is searched where the runtime finds its backends: in the folders of ``CHIASM_BACKEND_PATH``, beside the
    installed library, and in a source tree's ``build/release/lib``.

    Returns:
        The path of ``libchiasm_ort.so``.

    Raises:
        FileNotFoundError: it is in none of these places; the message lists them, and says how to get it.

    Example:
        >>> import chiasm.onnx
        >>> chiasm.onnx.library().name
        'libchiasm_ort.so'
    """
    folders = _folders()
    for folder in folders:
        if (folder / LIBRARY).is_file():
            return folder / LIBRARY
    raise FileNotFoundError(
        f"there is no {LIBRARY} in {', '.join(map(str, folders))}: run `make build` in the source tree,"
        ' run `pip install "chiasm[onnx]"`, or name its folder in CHIASM_BACKEND_PATH'
    )


def register(options: onnxruntime.SessionOptions, bundles: BundlePath | Iterable[BundlePath]) -> None:
    """Let sessions made with `options` run the functions of these bundles by native code.

    Do not move the bundles before the session is created.

    Args:
        options: is changed: a configuration entry and the plug-in are added.
        bundles: one bundle or several.

    Raises:
        FileNotFoundError: the plug-in is not there.
        BundleError: one of `bundles` is not a bundle.
        ValueError: the options have the plug-in already, or a path cannot be passed on.
        TypeError: an argument is something else.

    Example:
        >>> import chiasm.onnx, onnxruntime
        >>> options = onnxruntime.SessionOptions()
        >>> chiasm.onnx.register(options, "build/bundles/filters.sobel.chiasm")
        >>> session = onnxruntime.InferenceSession("detector.onnx", options)  # doctest: +SKIP
    """
    if not hasattr(options, "add_session_config_entry"):
        raise TypeError(f"options: expected onnxruntime.SessionOptions, got {type(options).__name__}")
    several = [bundles] if isinstance(bundles, (str, os.PathLike)) else bundles
    if not isinstance(several, Iterable) or isinstance(several, bytes):
        raise TypeError(f"bundles: expected paths of folders, got {type(bundles).__name__}")
    folders = [Path(os.path.realpath(b)) for b in several]
    if not folders:
        raise ValueError("bundles: expected at least one, got none")
    for folder in folders:
        read_manifest(folder)
        if ":" in str(folder):
            raise ValueError(
                f"{folder}: the path has a colon, which separates bundles in {ENTRY!r}: move or link the"
                " bundle"
            )
    before = _entry(options)
    if before is not None:
        raise ValueError(
            f"the options have {ENTRY!r} already ({before}), and the plug-in reads it once: register all"
            " bundles in one call, on options that no other session was given"
        )
    plugin = library()
    paths = ":".join(map(str, folders))
    try:
        options.add_session_config_entry(ENTRY, paths)
    except RuntimeError as error:  # ONNX Runtime limits the length
        raise ValueError(
            f"bundles: {len(folders)} paths of {len(paths)} characters are too many for ONNX Runtime"
            f" ({error}): register those that the model needs, or link them in a folder with a shorter name"
        ) from error
    options.register_custom_ops_library(str(plugin))


def _entry(options: onnxruntime.SessionOptions) -> str | None:
    try:
        return options.get_session_config_entry(ENTRY)
    except RuntimeError:  # ONNX Runtime's way to say that there is no such entry
        return None


def _folders() -> list[Path]:
    package = Path(__file__).resolve().parents[1]
    named = [Path(folder) for folder in os.environ.get("CHIASM_BACKEND_PATH", "").split(":") if folder]
    return [
        *named,
        package / "lib",
        package / "lib" / "chiasm",
        package.parents[1] / "build" / "release" / "lib",
    ]
