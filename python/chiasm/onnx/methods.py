"""A method of a bundle, as its manifest describes it, for one dtype."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import chiasm.runtime
from chiasm.export.manifest import BundleError, manifest_text, parse_manifest, read_file

Artifact = dict[str, Any]


@dataclass(frozen=True)
class Method:
    """`dtype` is the value of T; None if no tensor of the bundle has type T."""

    folder: Path
    manifest: dict[str, Any]
    name: str
    dtype: str | None

    @classmethod
    def open(cls, bundle: str | os.PathLike[str], name: str, dtype: str | None) -> Method:
        """Read the manifest. The default dtype is float32, else the first that the bundle has.

        Raises:
            BundleError: there is no bundle, no such method, or no such dtype.
            ChiasmError: the trust policy rejects the bundle.
        """
        for argument, value, kinds in (("bundle", bundle, (str, os.PathLike)), ("method", name, (str,))):
            if not isinstance(value, kinds):
                expected = "the path of a folder" if argument == "bundle" else "a name"
                raise TypeError(f"{argument}: expected {expected}, got {type(value).__name__}")
        folder = Path(bundle)
        manifest = parse_manifest(folder, _trusted_text(folder))
        if name not in manifest["methods"]:
            raise BundleError(f"{folder}: has no method {name!r}: it has {', '.join(manifest['methods'])}")
        dtypes = manifest["dtypes"]
        if dtype is not None and dtype not in dtypes:
            raise BundleError(
                f"{folder}: expected a dtype of {', '.join(dtypes) or 'its own (no tensor is generic)'}, got"
                f" {dtype!r}"
            )
        if dtypes and dtype is None:
            dtype = "float32" if "float32" in dtypes else dtypes[0]
        return cls(folder, manifest, name, dtype)

    @property
    def inputs(self) -> list[dict[str, Any]]:
        """The manifest's descriptions of the inputs."""
        return self.manifest["methods"][self.name]["inputs"]

    @property
    def outputs(self) -> list[dict[str, Any]]:
        """The manifest's descriptions of the outputs."""
        return self.manifest["methods"][self.name]["outputs"]

    def artifacts(self) -> list[Artifact]:
        """The artifacts for this dtype."""
        listed = self.manifest["methods"][self.name]["artifacts"]
        return [a for a in listed if self.dtype is None or self.dtype in a["dtypes"]]

    def flat(self) -> Artifact | None:
        """The ONNX artifact of standard operators."""
        return next((a for a in self.artifacts() if a["format"] == "onnx" and "function" not in a), None)

    def fused(self) -> Artifact | None:
        """The ONNX artifact that is one function call."""
        return next((a for a in self.artifacts() if a["format"] == "onnx" and "function" in a), None)

    def has_native(self) -> bool:
        """Whether there is code for the CPU that needs no engine."""
        return any(a["backend"] == "native" and a["device"] != "cuda" for a in self.artifacts())

    def read(self, artifact: Artifact | None, what: str = "ONNX artifact") -> bytes:
        """The artifact's bytes, checked against the manifest."""
        if artifact is None:
            dtype = f" in {self.dtype}" if self.dtype else ""
            raise BundleError(
                f"{self.folder}: method {self.name!r}{dtype} has no {what}: export the bundle with the format"
                " onnx"
            )
        return read_file(self.folder, artifact)

    def dtype_of(self, tensor: dict[str, Any]) -> str:
        """A tensor's dtype, T resolved."""
        return self.dtype if tensor["dtype"] == "T" and self.dtype else tensor["dtype"]


def _trusted_text(folder: Path) -> bytes:
    """The manifest's bytes, by the trust policy of the process: those whose signature was checked. They name
    the hash of every other file."""
    text = manifest_text(folder)
    if chiasm.runtime.get_trust() == "signed":
        return chiasm.runtime.Bundle(folder)._handle.manifest.encode()
    return text
