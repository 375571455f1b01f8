"""The parts of a repository: bundles, and networks in ONNX files, with the tensors of each."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ..export.files import MOST_OF_FILE, read_regular
from ..export.manifest import SUFFIX, BundleError, read_manifest, schema
from ..export.signing import check_files
from ..packs import located

#: A model's name is a folder's name, and part of URLs.
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9._-]{0,254}")  # a folder's name has at most 255 bytes
#: Element types of bundles, which Triton has too: numbers, and no strings
_DTYPE = re.compile(schema()["$defs"]["dtype"]["pattern"])


class RepositoryError(BundleError):
    """A model repository cannot be written as it was asked for."""


@dataclass(frozen=True)
class Tensor:
    """An input or output of a model, as in a config.pbtxt: all dimensions, -1 for those that differ between
    requests."""

    name: str
    type: str
    dims: tuple[int, ...]

    def fits(self, other: Tensor) -> bool:
        """Whether this tensor can be passed as ``other``."""
        return (
            self.type == other.type
            and len(self.dims) == len(other.dims)
            and all(a == b or -1 in (a, b) for a, b in zip(self.dims, other.dims, strict=True))
        )

    def __str__(self) -> str:
        return f"'{self.name}' {self.type.lower()} {list(self.dims)}"


@dataclass(frozen=True)
class Part:
    """A model: its name in the repository, and the bundle (a folder ``*.chiasm``) or network (``*.onnx``)
    that it runs.

    Raises
    ------
    RepositoryError
        If the name is not valid for a model, or the path is neither of the two.
    """

    name: str
    path: Path

    def __post_init__(self) -> None:
        self.check_name(self.name)
        if not self.is_network and not self.path.is_dir():
            raise RepositoryError(f"{self.path}: expected a bundle (a folder NAME{SUFFIX}) or a *.onnx file")

    @staticmethod
    def check_name(name: str) -> str:
        """The name, if it is valid for a model."""
        if not _NAME.fullmatch(name):
            raise RepositoryError(
                f"{name!r} cannot be a model's name: expected up to 255 letters, digits, '_', '.' and '-'"
            )
        return name

    @classmethod
    def parse(cls, text: str) -> Part:
        """``NAME=PATH``, or ``PATH``, whose file name without the suffix becomes the model's name. A path may
        also be the name of an installed bundle."""
        name, separator, path = text.partition("=")
        if not separator or "/" in name:
            name, path = "", text
        if not path:  # an unset shell variable: pathlib reads it as '.'
            raise RepositoryError(f"{text!r}: expected [NAME=]BUNDLE, got an empty path")
        path = located(path)
        # Resolved, because `.` has a name too; not by Path, which raises an error of its own for a loop
        file = os.path.basename(os.path.realpath(path))
        return cls(name or re.sub(r"\.(chiasm|onnx)$", "", file), Path(path))

    @property
    def is_network(self) -> bool:
        return self.path.suffix == ".onnx"

    @cached_property
    def tensors(self) -> tuple[list[Tensor], list[Tensor]]:
        """The inputs and the outputs."""
        return _of_network(self.path) if self.is_network else _of_bundle(self.path)


def _type(dtype: str) -> str:
    """Triton's name of an element type."""
    return dtype.upper().replace("BFLOAT", "BF").replace("FLOAT", "FP")


def _of_bundle(bundle: Path) -> tuple[list[Tensor], list[Tensor]]:
    manifest = read_manifest(bundle)
    check_files(bundle, manifest)
    method = manifest["methods"].get("forward")
    if method is None:
        raise RepositoryError(f"{bundle}: has no method 'forward'; it has {', '.join(manifest['methods'])}")
    dtypes: list[str] = manifest["dtypes"]
    generic = "float32" if "float32" in dtypes else (dtypes[:1] or [""])[0]  # as the runtime chooses it

    def tensor(entry: dict[str, Any]) -> Tensor:
        dtype: str = generic if entry["dtype"] == "T" else entry["dtype"]
        dims = tuple(d if isinstance(d, int) else -1 for d in entry["shape"])
        return Tensor(entry["name"], _type(dtype), dims or (1,))

    return [tensor(t) for t in method["inputs"]], [tensor(t) for t in method["outputs"]]


def _of_network(file: Path) -> tuple[list[Tensor], list[Tensor]]:
    import onnx
    from google.protobuf.message import DecodeError

    from ..export.onnx_function import external_tensors

    try:
        model = onnx.load_from_string(read_regular(file, MOST_OF_FILE))
    except DecodeError as error:
        raise RepositoryError(f"{file}: not an ONNX model: {error}") from error
    except OSError as error:
        raise RepositoryError(f"{file}: {error.strerror}") from error
    graph = model.graph
    if not graph.output:  # so is an empty file
        raise RepositoryError(f"{file}: not an ONNX model: it has no outputs")
    for outside in external_tensors(model):
        raise RepositoryError(
            f"{file}: the tensor {outside.name!r} is in another file: save it as one (onnx.save_model)"
        )

    def tensor(value: Any) -> Tensor:
        kind = value.type.tensor_type
        known = kind.elem_type in onnx.helper.get_all_tensor_dtypes()
        dtype = onnx.helper.tensor_dtype_to_np_dtype(kind.elem_type).name if known else ""
        if not kind.HasField("shape") or not _DTYPE.fullmatch(dtype):
            raise RepositoryError(f"{file}: '{value.name}' is no tensor of a known rank and type of numbers")
        dims = tuple(d.dim_value if d.dim_value > 0 else -1 for d in kind.shape.dim)
        if not dims:
            raise RepositoryError(
                f"{file}: '{value.name}' has no dimensions, which Triton's tensors must have"
            )
        return Tensor(value.name, _type(dtype), dims)

    constants = {each.name for each in graph.initializer}
    inputs = [tensor(value) for value in graph.input if value.name not in constants]
    return inputs, [tensor(value) for value in graph.output]
