"""A network in int8, as ONNX Runtime's quantization writes it, between two bundles."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
from onnxruntime.quantization import CalibrationDataReader, QuantFormat, QuantType, quantize_static

import chiasm.onnx

RANDOM = np.random.default_rng(5)


class Samples(CalibrationDataReader):
    def __init__(self) -> None:
        self.left = [RANDOM.standard_normal((1, 3, 224, 224)).astype(np.float32) for _ in range(3)]

    def get_next(self) -> dict[str, np.ndarray] | None:
        return {"images": self.left.pop()} if self.left else None


def quantized(folder: Path, form: QuantFormat) -> onnx.ModelProto:
    """A convolution and ReLU."""
    model = onnx.parser.parse_model(
        '<ir_version: 8, opset_import: ["": 18]> network (float[N, 3, 224, 224] images) =>'
        " (float[N, 8, 112, 112] maps)"
        " { convolved = Conv<strides = [2, 2], pads = [1, 1, 1, 1]>(images, weight) maps = Relu(convolved) }"
    )
    weight = RANDOM.standard_normal((8, 3, 3, 3)).astype(np.float32) / 5
    model.graph.initializer.append(onnx.numpy_helper.from_array(weight, "weight"))
    onnx.save(model, folder / "float.onnx")
    quantize_static(folder / "float.onnx", folder / "int8.onnx", Samples(), form, weight_type=QuantType.QInt8)
    return onnx.load(folder / "int8.onnx")


def run(model: onnx.ModelProto | Path, inputs: dict[str, np.ndarray]) -> np.ndarray:
    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3
    data = model.SerializeToString() if isinstance(model, onnx.ModelProto) else model.read_bytes()
    session = onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
    return np.asarray(session.run(None, inputs)[0])


@pytest.mark.parametrize("form", [QuantFormat.QDQ, QuantFormat.QOperator])
def test_an_int8_network_between_bundles(
    form: QuantFormat, light: Callable[[str], Path], tmp_path: Path
) -> None:
    network = quantized(tmp_path, form)
    assert any(i.data_type == onnx.TensorProto.INT8 for i in network.graph.initializer)
    before, after = light("pipelines.preprocess"), light("filters.box_blur")
    merged = chiasm.onnx.append(chiasm.onnx.prepend(before, network), after)
    frame = RANDOM.integers(0, 256, (300, 400, 3), dtype=np.uint8)
    images = run(before / "forward.onnx", {"frame": frame})
    maps = run(network, {"images": images})
    expected = run(after / "forward.float32.onnx", {"input": maps})
    assert np.ptp(expected) > 0.5
    np.testing.assert_array_equal(run(merged, {"frame": frame}), expected)
