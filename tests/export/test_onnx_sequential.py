"""Models and bundles in a row: one model, whose results are those of ONNX Runtime one after the other."""

import resource
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


@pytest.mark.filterwarnings("ignore:.*runs as standard operators")
def test_models_of_a_newer_opset_stand_anywhere_too(light: Callable[[str], Path]) -> None:
    sobel = light("filters.sobel")
    old, new = images("old", "output = Sqrt(input)"), images("new", "output = Neg(input)", opset=21, ir=10)
    x = RANDOM.random((1, 3, 21, 34), np.float32)
    for parts in ((sobel, new), (old, sobel, new), (new, sobel, old)):
        whole = chiasm.onnx.ONNXSequential(*parts)
        (expected,) = [x]
        for part in parts:
            (expected,) = chiasm.onnx.ONNXSequential(part)(expected)
        np.testing.assert_allclose(whole(x)[0], expected, atol=1e-5)
        assert sorted((o.domain, o.version) for o in whole.model.opset_import) == [("", 21), ("chiasm", 1)]
    whole = chiasm.onnx.prepend(sobel, old)
    with pytest.raises(ValueError, match=r"the model imports opset 18 and has functions, new needs opset 21"):
        chiasm.onnx.ONNXSequential(whole, new)


@pytest.mark.filterwarnings("ignore:.*runs as standard operators")
def test_a_bundle_has_the_dtype_of_its_neighbour(light: Callable[[str], Path]) -> None:
    sobel, x = light("filters.sobel"), RANDOM.random((1, 3, 21, 34))
    double = model("double (double[N, 3, H, W] x) => (double[N, 3, H, W] y) { y = Neg(x) }")
    (edges,) = chiasm.onnx.session(sobel, dtype="float64", fused=False).run(None, {"input": x})
    for joints in (None, [[("output", "x")]]):
        (found,) = chiasm.onnx.ONNXSequential(sobel, double, io_maps=joints)(x)
        np.testing.assert_allclose(found, -edges, atol=1e-12)
    text = "{ half = Cast<to=1>(x) y = Neg(half) }"
    byte = model(f"byte (uint8[N, 3, H, W] x) => (float[N, 3, H, W] y) {text}")
    for parts in ((sobel, byte), (double, byte)):
        with pytest.raises(ValueError, match=r"is float.* input 'x' is uint8 .*: the dtypes differ"):
            chiasm.onnx.ONNXSequential(*parts)


@pytest.mark.filterwarnings("ignore:.*runs as standard operators")
def test_functions_of_bundles_keep_their_names(light: Callable[[str], Path], tmp_path: Path) -> None:
    """By them the plug-in knows what it serves; other functions are renamed if they have to be."""
    sobel, x = light("filters.sobel"), RANDOM.random((1, 3, 21, 34), np.float32)
    after = chiasm.onnx.append(images("one", "output = Sqrt(input)"), sobel)
    own = onnx.parser.parse_model(
        '<ir_version: 8, opset_import: ["": 18, "own": 1]> own (float[N, 3, H, W] input) =>'
        " (float[N, 3, H, W] output) { output = own.twice(input) }"
        '<domain: "own", opset_import: ["": 18]> twice (x) => (y) { y = Add(x, x) }'
    )
    thrice = onnx.ModelProto()
    thrice.CopyFrom(own)
    thrice.functions[0].node[0].op_type = "Mul"
    parts = (after, after, own, thrice, sobel)
    whole = chiasm.onnx.ONNXSequential(*parts)
    found = [f"{f.domain}::{f.name}" for f in whole.model.functions]
    assert found == ["chiasm::filters_sobel", "own::twice", "own::own_5_twice"], found
    assert len({o.domain for o in whole.model.opset_import}) == len(whole.model.opset_import) == 3
    assert {n.op_type for n in whole.model.graph.node if n.domain == "chiasm"} == {"filters_sobel"}
    expected = x
    for part in parts:
        (expected,) = chiasm.onnx.ONNXSequential(part)(expected)
    np.testing.assert_allclose(whole(x)[0], expected, rtol=1e-4, atol=1e-4)
    other = onnx.ModelProto()
    other.CopyFrom(after)
    other.functions[0].doc_string = "another"
    with pytest.raises(ValueError, match="one and one have different functions chiasm::filters_sobel"):
        chiasm.onnx.ONNXSequential(after, other)


def test_a_model_is_written_whole(tmp_path: Path) -> None:
    chain, file = chiasm.onnx.ONNXSequential(images("one", "output = Neg(input)")), tmp_path / "model.onnx"
    file.write_bytes(b"mine")
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, limit[1]))  # as on a full disk
    try:
        with pytest.raises(OSError, match=r"model\.onnx"):
            chain.export(file)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    assert [f.read_bytes() for f in tmp_path.iterdir()] == [b"mine"]
    for name in ("model.onnx", "model.json", "model.textproto"):
        chain.export(tmp_path / name)
        assert onnx.load(tmp_path / name) == chain.model


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
