"""A small bundle, with a TorchScript and an ONNX artifact, that tests of the runtime write themselves."""

import hashlib
import io
import json
from pathlib import Path

import numpy as np
import onnx
import torch
from safetensors.numpy import save
from torch import Tensor, nn

BACKENDS = ("torch", "onnx")


class Scale(nn.Module):
    def forward(self, x: Tensor, scale: Tensor, keep: Tensor) -> tuple[Tensor, Tensor]:
        y = torch.where(keep, x * scale, torch.zeros_like(x))
        return y, torch.logical_not(keep)


def scale_onnx(dtype: int) -> bytes:
    make, info = onnx.helper.make_node, onnx.helper.make_tensor_value_info
    nodes = [
        make("Mul", ["x", "scale"], ["scaled"]),
        make("Sub", ["x", "x"], ["zero"]),
        make("Where", ["keep", "scaled", "zero"], ["y"]),
        make("Not", ["keep"], ["dropped"]),
    ]
    shape, mask = ["H", "W"], onnx.TensorProto.BOOL
    graph = onnx.helper.make_graph(
        nodes,
        "scale",
        [info("x", dtype, shape), info("scale", dtype, []), info("keep", mask, shape)],
        [info("y", dtype, shape), info("dropped", mask, shape)],
    )
    model = onnx.helper.make_model(graph, opset_imports=[onnx.helper.make_opsetid("", 18)], ir_version=10)
    return model.SerializeToString()


def scripted(module: nn.Module) -> bytes:
    buffer = io.BytesIO()
    torch.jit.save(torch.jit.script(module), buffer)
    return buffer.getvalue()


def tensor(name: str, dtype: str, shape: list) -> dict:
    return {
        "name": name,
        "dtype": dtype,
        "shape": shape,
        "description": "",
        "layout": "",
        "color": "",
        "range": None,
    }


def artifact(backend: str, form: str, file: str, data: bytes, dtypes: list[str], **more) -> dict:
    sha256 = hashlib.sha256(data).hexdigest()
    entry = {"backend": backend, "format": form, "file": file, "size": len(data), "sha256": sha256}
    return entry | {"dtypes": dtypes, "device": "any"} | more


TOLERANCES = {d: {"atol": 1e-6, "rtol": 1e-6} for d in ("float32", "float64")}


def write_bundle(
    folder: Path, name: str, methods: dict, files: dict[str, bytes], golden: dict, cases: list[dict]
) -> Path:
    path = folder / f"{name}.chiasm"
    path.mkdir()
    files = files | {"golden.safetensors": save(golden)}
    for file, data in files.items():
        (path / file).write_bytes(data)
    data = files["golden.safetensors"]
    manifest = {
        "schema_version": 1,
        "name": name,
        "version": "1.2.3",
        "summary": "for tests",
        "reference": "NumPy",
        "created": "2025-01-01T00:00:00Z",
        "producer": {},
        "config": {"answer": 42},
        "symbols": {"H": {"min": 1, "max": 4096}, "W": {"min": 1, "max": 4096}},
        "dtypes": ["float32", "float64"],
        "methods": {name: {"tolerances": TOLERANCES} | method for name, method in methods.items()},
        "golden": {
            "file": "golden.safetensors",
            "size": len(data),
            "sha256": hashlib.sha256(data).hexdigest(),
            "cases": cases,
        },
    }
    (path / "manifest.json").write_text(json.dumps(manifest))
    return path


def write_scale(folder: Path, golden_offset: float = 0.0) -> Path:
    script = scripted(Scale())
    single, double = scale_onnx(onnx.TensorProto.FLOAT), scale_onnx(onnx.TensorProto.DOUBLE)
    kinds = ["float32", "float64"]
    shape = ["H", "W"]
    inputs = [tensor("x", "T", shape), tensor("scale", "T", []), tensor("keep", "bool", shape)]
    methods = {
        "forward": {
            "inputs": inputs,
            "outputs": [tensor("y", "T", shape), tensor("dropped", "bool", shape)],
            "artifacts": [
                artifact("torch", "torchscript", "scale.pt", script, kinds),
                artifact("onnx", "onnx", "scale32.onnx", single, ["float32"], opset=18),
                artifact("onnx", "onnx", "scale64.onnx", double, ["float64"], opset=18),
            ],
        },
        "vjp": {
            "inputs": [*inputs, tensor("grad_y", "T", shape)],
            "outputs": [tensor("grad_x", "T", shape), tensor("grad_scale", "T", [])],
            "artifacts": [artifact("torch", "torchscript", "scale.pt", script, kinds, autograd=True)],
        },
    }
    x, keep = (
        np.arange(6, dtype=np.float32).reshape(2, 3),
        np.array([[True, False, True], [False, True, True]]),
    )
    golden = {"a/x": x, "a/scale": np.array(3, np.float32), "a/keep": keep}
    golden |= {
        "a/y": np.where(keep, x * 3, 0).astype(np.float32) + np.float32(golden_offset),
        "a/dropped": ~keep,
    }
    files = {"scale.pt": script, "scale32.onnx": single, "scale64.onnx": double}
    return write_bundle(
        folder,
        "test.scale",
        methods,
        files,
        golden,
        [{"prefix": "a", "method": "forward", "dtype": "float32"}],
    )


def example(dtype: type = np.float32) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    generator = np.random.default_rng(0)
    return generator.random((5, 7)).astype(dtype), np.asarray(2, dtype), generator.random((5, 7)) > 0.5
