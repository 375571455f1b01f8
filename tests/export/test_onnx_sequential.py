"""Models and bundles in a row: one model, whose results are those of ONNX Runtime one after the other."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime
import pytest

import chiasm.onnx

RANDOM = np.random.default_rng(3)


def model(body: str, opset: int = 18, ir: int = 8) -> onnx.ModelProto:
    return onnx.parser.parse_model(f'<ir_version: {ir}, opset_import: ["": {opset}]> {body}')


def images(name: str, body: str, **versions: int) -> onnx.ModelProto:
    """A model of one image, ``input``, and one result, ``output``."""
    signature = "(float[N, 3, H, W] input) => (float[N, 3, H, W] output)"
    return model(f"{name} {signature} {{ {body} }}", **versions)


def run(given: onnx.ModelProto, *inputs: np.ndarray) -> list[Any]:
    session = onnxruntime.InferenceSession(given.SerializeToString(), providers=["CPUExecutionProvider"])
    return session.run(None, {value.name: each for value, each in zip(session.get_inputs(), inputs)})


def test_models_of_several_opsets_run_one_after_the_other(tmp_path: Path) -> None:
    parts = [
        images("first", "half = Add(input, input) output = Sin(half)"),
        images("second", "half = Mul(input, input) output = Cos(half)", opset=13, ir=7),
        images("third", "output = Neg(input)", opset=17),
    ]
    file = tmp_path / "second.onnx"
    onnx.save(parts[1], file)
    x = RANDOM.random((2, 3, 5, 7), np.float32)
    chain = chiasm.onnx.ONNXSequential(parts[0], file, parts[2])
    expected = -np.cos(np.square(np.sin(2 * x.astype(np.float64))))
    (found,) = chain(x)
    np.testing.assert_allclose(found, expected, atol=1e-6)
    chain.export(tmp_path / "all.onnx")
    assert np.array_equal(run(onnx.load(tmp_path / "all.onnx"), x)[0], found)
    assert parts[0].opset_import[0].version == 18 and len(parts[0].graph.node) == 2  # unchanged


def test_joints_name_what_goes_where() -> None:
    two = model("two (float[N] x, float[N] y) => (float[N] s, float[N] d) { s = Add(x, y) d = Sub(x, y) }")
    x, y = RANDOM.random((2, 4), np.float32)
    chain = chiasm.onnx.ONNXSequential(two, two, io_maps=[[("s", "y"), ("d", "x")]])
    s, d = x + y, x - y
    for found, expected in zip(chain(x, y), (d + s, d - s)):
        np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_an_output_goes_to_several_inputs() -> None:
    one = model("one (float[N] x) => (float[N] y) { y = Neg(x) }")
    two = model("two (float[N] a, float[N] b) => (float[N] s) { s = Mul(a, b) }")
    x = RANDOM.random(4, np.float32)
    (found,) = chiasm.onnx.ONNXSequential(one, two, io_maps=[iter([("y", "a"), ("y", "b")])])(x)
    np.testing.assert_allclose(found, x * x, rtol=1e-6)


@pytest.mark.filterwarnings("ignore:.*runs as standard operators")
def test_bundles_stand_anywhere(light: Callable[[str], Path]) -> None:
    sobel, relu = light("filters.sobel"), images("limit", "output = Sqrt(input)")
    x = RANDOM.random((1, 3, 21, 34), np.float32)
    edges = chiasm.onnx.session(sobel, fused=False)
    (first,) = edges.run(None, {"input": x})
    (both,) = edges.run(None, {"input": first})
    for parts, expected in {
        (sobel,): first,
        (sobel, sobel): both,
    }.items():
        (found,) = chiasm.onnx.ONNXSequential(*parts)(x)
        np.testing.assert_allclose(found, expected, atol=1e-5)
    (found,) = chiasm.onnx.ONNXSequential(relu, str(sobel), relu, sobel)(x)
    (once,) = edges.run(None, {"input": np.sqrt(x)})
    (twice,) = edges.run(None, {"input": np.sqrt(once)})
    np.testing.assert_allclose(found, twice, atol=1e-4)


def test_tensors_are_inputs_too() -> None:
    torch = pytest.importorskip("torch")
    (found,) = chiasm.onnx.ONNXSequential(images("one", "output = Neg(input)"))(torch.ones(1, 3, 2, 2))
    assert np.array_equal(found, -np.ones((1, 3, 2, 2), np.float32))


def test_what_is_refused(tmp_path: Path) -> None:
    one = images("one", "output = Neg(input)")
    two = model("two (float[N] x, float[N] y) => (float[N] s) { s = Add(x, y) }")
    number: Any = 3
    sequential = chiasm.onnx.ONNXSequential
    text_file = tmp_path / "text.onnx"
    text_file.write_text("no model")
    pair = model("pair (float[N] x) => (float[N] y, float[N] z) { y = Neg(x) z = Abs(x) }")
    for message, call in {
        "io_maps: expected an input of the second once, got": lambda: sequential(
            pair, pair, io_maps=[[("y", "x"), ("z", "x")]]
        ),
        "args: expected at least one model": lambda: sequential(),
        "io_maps: expected 1 joints, for 2 models, got 2": lambda: sequential(one, one, io_maps=[[], []]),
        "inputs: expected 2: x, y; got 1": lambda: sequential(two)(np.zeros(2, np.float32)),
        "one has the outputs output, two the inputs x, y: say": lambda: sequential(one, two),
        "io_maps: expected some of output, got 'z'": lambda: sequential(one, one, io_maps=[[("z", "input")]]),
        "io_maps: expected some of input, got 'z'": lambda: sequential(one, one, io_maps=[[("output", "z")]]),
        "model: expected an ONNX file": lambda: sequential(text_file),
    }.items():
        with pytest.raises(ValueError, match=message):
            call()
    with pytest.raises(TypeError, match=r"model: expected an onnx\.ModelProto or a file, got int"):
        sequential(number)
    text: Any = "CPUExecutionProvider"
    with pytest.raises(TypeError, match="providers: expected a list of names"):
        sequential(one, providers=text)
