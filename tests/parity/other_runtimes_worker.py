"""Replays golden vectors on the ONNX artifacts of bundles, in an environment that has NumPy, safetensors and
one engine.

    .deps/ENGINE/bin/python tests/parity/other_runtimes_worker.py onnxruntime|openvino PLUGIN BUNDLE ...

PLUGIN is the path of libchiasm_ort.so: in ONNX Runtime a fused artifact runs as its body, and again as native
code. Prints a line of JSON for each artifact and golden case; other_runtimes.py reads them.
"""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from safetensors import safe_open

Runner = Callable[[list[np.ndarray]], list[np.ndarray]]


def by_onnxruntime(file: Path, names: list[str], plugin: str | None) -> Runner:
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3
    if plugin is not None:
        options.add_session_config_entry("chiasm.bundles", str(file.parent))
        options.register_custom_ops_library(plugin)
    session = onnxruntime.InferenceSession(str(file), options, providers=["CPUExecutionProvider"])
    return lambda inputs: session.run(None, dict(zip(names, inputs)))


def by_openvino(file: Path, names: list[str], plugin: None) -> Runner:
    import openvino

    core = openvino.Core()
    core.set_property("CPU", {"INFERENCE_PRECISION_HINT": "f32"})  # otherwise bfloat16 on CPUs that have it
    model = core.compile_model(str(file), "CPU")
    # By position: an input that is followed by a cast to its own dtype also has the cast's name, and
    # get_any_name() may return that.
    return lambda inputs: [np.array(x) for x in model(inputs).values()]


ENGINES = {"onnxruntime": by_onnxruntime, "openvino": by_openvino}


def forms(engine: str, artifact: dict[str, Any], method: dict[str, Any]) -> list[str]:
    """How the engine runs an ONNX artifact: "flat", or a fused one as its "body" and as "native" code."""
    if "function" not in artifact:
        return ["flat"]
    has_native = any(
        a["backend"] == "native" and a["dtypes"] == artifact["dtypes"] for a in method["artifacts"]
    )
    return ["body", "native"] if engine == "onnxruntime" and has_native else ["body"]


def replay(engine: str, plugin: str, bundle: Path) -> list[dict[str, Any]]:
    manifest = json.loads((bundle / "manifest.json").read_text())
    rows = []
    with safe_open(str(bundle / manifest["golden"]["file"]), "numpy") as golden:
        for case in manifest["golden"]["cases"]:
            method = manifest["methods"][case["method"]]
            for artifact in method["artifacts"]:
                serves = artifact["format"] == "onnx" and (
                    case["dtype"] is None or case["dtype"] in artifact["dtypes"]
                )
                if not serves:
                    continue
                inputs, expected = (
                    [golden.get_tensor(f"{case['prefix']}/{t['name']}") for t in method[k]]
                    for k in ("inputs", "outputs")
                )
                for form in forms(engine, artifact, method):
                    started = time.perf_counter()
                    try:
                        run = ENGINES[engine](
                            bundle / artifact["file"],
                            [t["name"] for t in method["inputs"]],
                            plugin if form == "native" else None,
                        )
                        error, message = compare(run(inputs), expected, method)
                    except Exception as failure:  # any exception of the engine is a result
                        error, message = float("inf"), f"refused: {' '.join(str(failure).split())}"
                    row = {
                        "op": manifest["name"],
                        "file": artifact["file"],
                        "form": form,
                        "error": error,
                        "message": message,
                    }
                    rows.append(row | {"seconds": time.perf_counter() - started})
    return rows


def compare(
    results: list[np.ndarray], expected: list[np.ndarray], method: dict[str, Any]
) -> tuple[float, str]:
    """The largest absolute difference, and "" or what is wrong."""
    worst, message = 0.0, ""
    for tensor, result, want in zip(method["outputs"], results, expected, strict=True):
        if result.shape != want.shape or result.dtype != want.dtype:
            return (
                float("inf"),
                (
                    f"output {tensor['name']!r}: expected {want.shape} {want.dtype}, got {result.shape}"
                    f" {result.dtype}"
                ),
            )
        tolerance = method["tolerances"].get(str(want.dtype), {"atol": 0.0, "rtol": 0.0})
        a, b = result.astype(np.float64), want.astype(np.float64)
        same = (a == b) | (np.isnan(a) & np.isnan(b))
        gap = np.where(same, 0.0, np.nan_to_num(np.abs(a - b), nan=np.inf))
        wrong = int((gap > tolerance["atol"] + tolerance["rtol"] * np.abs(np.nan_to_num(b))).sum())
        worst = max(worst, float(gap.max(initial=0.0)))
        if wrong and not message:
            message = f"output {tensor['name']!r}: {wrong} of {b.size} values differ by up to {gap.max():.3g}"
    return worst, message


if __name__ == "__main__":
    for path in sys.argv[3:]:
        for line in replay(sys.argv[1], sys.argv[2], Path(path)):
            print(json.dumps(line), flush=True)
