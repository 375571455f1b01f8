"""Bundles on disk: writing one whole or not at all, and reading its golden vectors."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import jsonschema
import torch
from safetensors.torch import load_file, save

from .manifest import SUFFIX, read_file, schema, sha256


@dataclass
class Golden:
    """Inputs and eager outputs of one method, for one value of T."""

    method: str
    variant: str | None
    tensors: dict[str, torch.Tensor]


@dataclass
class Writer:
    """Collects a bundle's files and writes the folder at once."""

    manifest: dict[str, Any]
    files: dict[str, bytes] = field(default_factory=dict)

    def artifact(self, method: str, file: str, data: bytes, **entry: Any) -> None:
        """Add a file that a backend loads; a file that serves two methods is stored once."""
        self.files[file] = data
        self.manifest["methods"][method]["artifacts"].append({"file": file, "size": len(data), "sha256": sha256(data), **entry})

    def golden(self, cases: list[Golden]) -> None:
        """Add the golden vectors."""
        tensors, listed = {}, []
        for case in cases:
            prefix = f"{case.method}.{case.variant}" if case.variant else case.method
            # cloned: a gradient may be a view of a cotangent, and what shares memory is not saved
            tensors |= {f"{prefix}/{name}": t.clone(memory_format=torch.contiguous_format) for name, t in case.tensors.items()}
            listed.append({"prefix": prefix, "method": case.method, "dtype": case.variant})
        data = save(tensors)
        self.files["golden.safetensors"] = data
        self.manifest["golden"] = {"file": "golden.safetensors", "size": len(data), "sha256": sha256(data), "cases": listed}

    def write(self, folder: Path) -> Path:
        """Write `folder`/NAME.chiasm, replacing one that is there; returns its path."""
        self.manifest["created"] = datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
        jsonschema.validate(self.manifest, schema())
        target = folder / f"{self.manifest['name']}{SUFFIX}"
        folder.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(dir=folder, prefix=".writing-"))
        for name, data in self.files.items():
            (scratch / name).write_bytes(data)
        (scratch / "manifest.json").write_text(json.dumps(self.manifest, indent=1) + "\n")
        scratch.chmod(0o755)
        if target.exists():
            shutil.rmtree(target)
        os.rename(scratch, target)
        return target


def read_golden(bundle: Path, manifest: dict[str, Any]) -> dict[str, torch.Tensor]:
    """The golden vectors by name."""
    read_file(bundle, manifest["golden"])
    return load_file(bundle / manifest["golden"]["file"])
