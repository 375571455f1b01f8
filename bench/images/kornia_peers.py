"""Kornia's ops on the inputs of chiasm's ops, eager and as ONNX files.

python -m bench.images.kornia_peers -> build/bench-images/kornia/OP.HASH.onnx, and OP.HASH.txt: empty, or the
reason why there is none
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import logging
import signal
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import onnxscript  # noqa: F401  here, so that it does not count as export
import torch
import torch._dynamo

from ..machine import ROOT
from .data import FOLDER, SIZES
from .ops import OPS, Op

sys.path.append(str(ROOT / ".deps" / "kornia"))
import kornia

FILES = FOLDER / "kornia"
#: the most seconds of this process's CPU time for the export of one op
LIMIT = 60


class Module(torch.nn.Module):
    """The op with its values bound."""

    def __init__(self, op: Op) -> None:
        super().__init__()
        self.function = op.kornia
        self.values = {name: torch.tensor(v) if isinstance(v, list) else v for name, v in op.values.items()}

    def forward(self, *images: torch.Tensor) -> object:
        return self.function(kornia, self.values, *images)


class One(Module):
    """With a named argument, as torch.export requires for dynamic sizes."""

    def forward(self, image: torch.Tensor) -> object:
        return super().forward(image)


class Two(Module):
    def forward(self, image: torch.Tensor, other: torch.Tensor) -> object:
        return super().forward(image, other)


def images(inputs: dict[str, np.ndarray]) -> list[np.ndarray]:
    """The inputs for Kornia: the images, as float32 in [0, 1]."""
    return [x if x.dtype == np.float32 else x / np.float32(255) for x in inputs.values() if x.ndim == 4]


def eager(op: Op, inputs: dict[str, np.ndarray]) -> Callable[[], object]:
    module, tensors = Module(op), [torch.from_numpy(x) for x in images(inputs)]

    def call() -> object:
        with torch.inference_mode():
            return module(*tensors)

    return call


def onnx_file(op: Op, size: tuple[int, int, int]) -> Path | str:
    """The op's file, for any size or for this one, or the reason why there is none."""
    for path in (file_of(op, ".onnx"), file_of(op, f".{size[1]}.onnx")):
        if path.exists():
            return path
    return file_of(op, ".txt").read_text()


def file_of(op: Op, ending: str) -> Path:
    """The name contains a hash of everything that determines the content, so an existing file is never
    exported again."""
    code = op.kornia.__code__
    made_of = op.values, code.co_code, code.co_consts, code.co_names, torch.__version__, kornia.__version__
    return FILES / f"{op.bundle}.{hashlib.sha256(repr(made_of).encode()).hexdigest()[:8]}{ending}"


def export(op: Op) -> None:
    """Export for any size if possible, else for each measured size."""
    problem = attempt(op, (2, 48, 64), file_of(op, ".onnx"), dynamic=True)
    if problem:
        problem = next(
            filter(
                None, (attempt(op, size, file_of(op, f".{size[1]}.onnx"), dynamic=False) for size in SIZES)
            ),
            "",
        )
    file_of(op, ".txt").write_text(problem)


def attempt(op: Op, size: tuple[int, int, int], path: Path, dynamic: bool) -> str:
    """The reason of the failure, or an empty string."""
    count = 2 if op.bundle == "enhance.add_weighted" else 1
    generator = torch.Generator().manual_seed(1)
    arguments = tuple(torch.rand(size[0], 3, *size[1:], generator=generator) for _ in range(count))
    sizes = {0: torch.export.Dim("B"), 2: torch.export.Dim("H", min=16), 3: torch.export.Dim("W", min=16)}
    signal.signal(signal.SIGPROF, _too_long)
    signal.setitimer(signal.ITIMER_PROF, LIMIT)
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            module = (One if count == 1 else Two)(op).eval()
            program = torch.onnx.export(
                module,
                arguments,
                dynamo=True,
                verbose=False,
                dynamic_shapes=(sizes,) * count if dynamic else None,
            )
            if dynamic and any(
                isinstance(d, int)
                for t in program.model.graph.inputs
                for i, d in enumerate(t.shape)
                if i != 1
            ):
                return "the export made the sizes of the example constants"
            program.save(path)
    except Exception as error:
        return _cause(error)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return ""


def _too_long(number: int, frame: object) -> None:
    raise TimeoutError(f"not exported within {LIMIT} s")


def _cause(error: BaseException) -> str:
    """The first line of the innermost error."""
    while error.__cause__ is not None:
        error = error.__cause__
    return f"{type(error).__name__}: {str(error).strip().splitlines()[0]}"[:160]


def main() -> int:
    warnings.simplefilter("ignore")
    logging.disable(logging.WARNING)
    FILES.mkdir(parents=True, exist_ok=True)
    for op in OPS:
        if op.kornia and not file_of(op, ".txt").exists():
            export(op)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
