"""Messages for errors that an engine does not explain: they name the operator and an alternative."""

from __future__ import annotations

import errno
import json
import os
import runpy
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest
import torch
import torch.nn.functional as F
from torch import Tensor

import chiasm.runtime
from chiasm.export import ExportError, Spec, TensorSpec, documents, export, image


def enlarged(input: Tensor) -> Tensor:
    return F.interpolate(input, scale_factor=1.3)


def inverted(input: Tensor) -> Tensor:
    return torch.linalg.inv(input)


def solved(input: Tensor) -> Tensor:
    return torch.linalg.solve(input, input * 2.0)


MATRICES = TensorSpec("input", ("B", 3, 3))


@pytest.mark.parametrize(
    ("fn", "tensor", "message"),
    [
        (enlarged, image(), r"operator aten.upsample_nearest2d.*\n.*1.3.*H.*\n.*another input"),
        (inverted, MATRICES, r"operator aten.linalg_inv_ex\n.*\n.*leave ONNX out"),
        (solved, MATRICES, r"operator aten._linalg_solve_ex\n.*\n.*leave ONNX out"),
    ],
)
def test_operators_are_named(fn, tensor: TensorSpec, message: str, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match=message):
        export(fn, Spec(f"test.{fn.__name__}", [tensor]), tmp_path, formats=["onnx"], methods=["forward"])


def test_a_stub_of_a_package_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests and builds of documentation put modules without a spec into sys.modules."""
    monkeypatch.setitem(sys.modules, "cv2", ModuleType("cv2"))
    assert "ExportError" in runpy.run_module("chiasm.export.errors")


def test_a_full_disk_at_the_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> bytes:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(documents, "_sources", full)
    with pytest.raises(ExportError, match=r"No space left on device\n  instead: make room on the disk"):
        export(torch.sigmoid, Spec("test.full", [image()]), tmp_path, formats=["onnx"], methods=["forward"])
    assert not list(tmp_path.iterdir())


def of_a_row(input: Tensor) -> Tensor:
    if input.shape[2] < 3:
        raise NotImplementedError("expected at least 3 rows, got fewer")
    return input * 2


def test_what_an_op_raises_is_one_line(light: Callable[[str], Path], tmp_path: Path) -> None:
    """In TorchScript, whose own message is a stack with source lines."""
    other = Spec("test.rows", [image()], symbols={"H": (3, 64)})
    for made, inputs in (
        (light("filters.gaussian_blur2d"), [torch.zeros(1, 1, 1, 9), torch.ones(1, 2)]),
        (export(of_a_row, other, tmp_path, formats=["torchscript"]), [torch.zeros(1, 1, 1, 9)]),
    ):
        bundle = Path(shutil.copytree(made, tmp_path / "copy" / made.name))
        manifest = json.loads((bundle / "manifest.json").read_text())
        manifest["symbols"]["H"]["min"] = 1
        (bundle / "manifest.json").write_text(json.dumps(manifest))
        method = chiasm.runtime.open(bundle).method(backend="torch")
        with pytest.raises(
            chiasm.runtime.ChiasmError, match=r"failed: [^\n]*expected at least 3 rows[^\n]*\Z"
        ):
            method(*inputs)
