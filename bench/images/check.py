"""Checks that the results of OpenCV (Debian's and the wheel), Kornia and its ONNX files equal chiasm's,
within the tolerances in ops.py.

python -m bench.images.check [OP...] -> build/bench-images/check.json; fails if a peer's results differ
"""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import onnxruntime

from ..machine import bundle_path, program
from ..opencv import opencv
from ..wheel import onnx_options
from . import kornia_peers
from .chiasm_ops import measured, native
from .data import FOLDER, SIZES, bench_arguments
from .ops import Agreement, Op

SIZE = SIZES[0]
REPORT = FOLDER / "check.json"


def main(names: list[str]) -> int:
    warnings.simplefilter("ignore")
    report, failed = {}, 0
    for op in measured(names):
        report[op.bundle] = compare(op)
        for peer, row in report[op.bundle].items():
            failed += not row["ok"]
            print(f"{op.bundle:28} {peer:12} {'ok' if row['ok'] else 'DIFFERS':8} {row['text']}", flush=True)
    if not names:
        REPORT.write_text(json.dumps(report, indent=1))
    print(f"check: {failed} peers exceed their tolerances")
    return 1 if failed else 0


def compare(op: Op) -> dict[str, dict]:
    made = native(op, SIZE)
    ours = made.outputs[op.output]

    def from_opencv(x: np.ndarray) -> np.ndarray:
        planes = np.ascontiguousarray(x.transpose(0, 3, 1, 2))
        return op.aligned(planes.reshape(SIZE[0], -1, *planes.shape[2:]))

    def wheel() -> np.ndarray:
        peer = opencv(op.bundle, list(made.inputs.values()))
        peer.call()
        return from_opencv(peer.results())

    peers = {"debian": lambda: from_opencv(debian(op)), "wheel": wheel}
    report = {name: row(ours, peer, op.opencv_agrees) for name, peer in peers.items()}
    if op.kornia:
        scale = 255 if ours.dtype == np.uint8 else 1
        eager = _output(op, kornia_peers.eager(op, made.inputs)())
        report["kornia"] = row(ours, lambda: eager * scale, op.kornia_agrees)
        file = kornia_peers.onnx_file(op, SIZE)
        if isinstance(file, Path):
            report["kornia ONNX"] = row(
                eager,
                lambda: _output(op, run_onnx(file, made.inputs)),
                Agreement(1e-3, 0.999, op.kornia_agrees.relative),
            )
    return report


def debian(op: Op) -> np.ndarray:
    path = FOLDER / "results.raw"
    kind = program("results", bundle_path(op.bundle), *bench_arguments(op, SIZE), path)
    return np.fromfile(path, kind["dtype"]).reshape(kind["shape"])


def run_onnx(file: Path, inputs: dict[str, np.ndarray]) -> list[np.ndarray]:
    session = onnxruntime.InferenceSession(str(file), onnx_options(1), providers=["CPUExecutionProvider"])
    return session.run(
        None, {t.name: x for t, x in zip(session.get_inputs(), kornia_peers.images(inputs), strict=True)}
    )


def _output(op: Op, result: object) -> np.ndarray:
    return np.asarray(result[op.output] if isinstance(result, (tuple, list)) else result)


def row(ours: np.ndarray, peer: Callable[[], np.ndarray], agreement: Agreement) -> dict:
    """Compares `ours` with the peer's result."""
    try:
        theirs = peer()
    except Exception as error:
        return {"ok": False, "text": f"{type(error).__name__}: {str(error)[:200]}"}
    if ours.shape != theirs.shape:
        return {"ok": False, "text": f"shape {ours.shape} and {theirs.shape}"}
    if agreement.edge:
        inside = (..., *(slice(agreement.edge, -agreement.edge),) * 2)
        ours, theirs = ours[inside], theirs[inside]
    difference = np.abs(ours.astype(np.float64) - theirs)
    if agreement.relative:
        difference /= np.abs(theirs).max()
    share = float(np.mean(difference <= agreement.tolerance))
    greatest = float(difference.max())
    part = f"{share:.2%}" if share < 0.9999 else "all but a few"
    near = f"within {agreement.tolerance:g}" if agreement.tolerance else "equal"
    text = f"{part} {near}" if share < 1 else f"at most {greatest:.1g}" if greatest else "equal"
    return {
        "ok": share >= agreement.share,
        "text": text + (" of the greatest value" if agreement.relative else ""),
    }


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
