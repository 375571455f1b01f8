"""Bundles before and after existing models: one more node, the same numbers, and a clear message if they do
not fit."""

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime
import pytest
import torch
import torch.nn.functional as F
from onnx import TensorProto, helper, numpy_helper

import chiasm.onnx
from chiasm.export import export
from chiasm.export.manifest import BundleError, sha256
from chiasm.export.spec import Spec, TensorSpec, image
from chiasm.pipelines import preprocess

from .conftest import SPEC, scaled_difference

RANDOM = np.random.default_rng(7)
WEIGHT, BIAS = (
    RANDOM.standard_normal((8, 3, 3, 3)).astype(np.float32) / 5,
    RANDOM.standard_normal(8).astype(np.float32),
)


def classifier(
    opset: int = 18, ir: int = 8, shape: tuple = ("N", 3, 224, 224), name: str = "images"
) -> onnx.ModelProto:
    """A small network as exported by others: convolution, ReLU, mean over the picture."""
    nodes = [
        helper.make_node("Conv", [name, "weight", "bias"], ["convolved"], strides=[2, 2]),
        helper.make_node("Relu", ["convolved"], ["positive"]),
        helper.make_node("GlobalAveragePool", ["positive"], ["pooled"]),
        helper.make_node("Flatten", ["pooled"], ["scores"]),
    ]
    graph = helper.make_graph(
        nodes,
        "classifier",
        [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape)],
        [helper.make_tensor_value_info("scores", TensorProto.FLOAT, [shape[0], 8])],
        [numpy_helper.from_array(WEIGHT, "weight"), numpy_helper.from_array(BIAS, "bias")],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", opset)], ir_version=ir)
    model.metadata_props.add(key="author", value="somebody else")
    return model


CELLS = RANDOM.standard_normal((6, 3, 8, 8)).astype(np.float32) / 10
OFFSETS = np.array([80, 80, 60, 60, 0, 0], np.float32)


def detector() -> onnx.ModelProto:
    """A network with the output of YOLO v8: a box and two scores for each cell of 8 x 8 pixels."""
    constants = {
        "weight": CELLS,
        "scale": np.float32(30),
        "shift": OFFSETS[:, None],
        "shape": np.array([0, 6, -1]),
    }
    nodes = [
        helper.make_node("Conv", ["images", "weight"], ["convolved"], strides=[8, 8]),
        helper.make_node("Reshape", ["convolved", "shape"], ["rows"]),
        helper.make_node("Mul", ["rows", "scale"], ["scaled"]),
        helper.make_node("Add", ["scaled", "shift"], ["output0"]),
    ]
    graph = helper.make_graph(
        nodes,
        "detector",
        [helper.make_tensor_value_info("images", TensorProto.FLOAT, ["N", 3, 640, 640])],
        [helper.make_tensor_value_info("output0", TensorProto.FLOAT, ["N", 6, 6400])],
        [numpy_helper.from_array(np.asarray(value), name) for name, value in constants.items()],
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=8)


def negative(kind: int = TensorProto.FLOAT) -> onnx.ModelProto:
    """A model that takes any four-dimensional tensor."""
    x, y = (helper.make_tensor_value_info(name, kind, [None] * 4) for name in ("x", "low"))
    graph = helper.make_graph([helper.make_node("Neg", ["x"], ["low"])], "negative", [x], [y])
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=8)


def reference(images: torch.Tensor) -> np.ndarray:
    return (
        F.conv2d(images, torch.from_numpy(WEIGHT), torch.from_numpy(BIAS), stride=2)
        .relu()
        .mean((2, 3))
        .numpy()
    )


def run(model: onnx.ModelProto, **inputs: np.ndarray) -> list[np.ndarray]:
    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3
    return onnxruntime.InferenceSession(
        model.SerializeToString(), options, providers=["CPUExecutionProvider"]
    ).run(None, inputs)


def sizes(value: onnx.ValueInfoProto) -> list[int | str]:
    return [d.dim_value if d.HasField("dim_value") else d.dim_param for d in value.type.tensor_type.shape.dim]


@pytest.fixture(scope="module")
def photo() -> np.ndarray:
    """A camera frame: a photograph, BGR."""
    import skimage

    return np.ascontiguousarray(skimage.data.astronaut()[100:421, :, ::-1])


@pytest.mark.parametrize(("opset", "ir"), [(11, 4), (13, 7), (18, 8), (20, 9), (23, 11)])
def test_preprocessing_before_a_network(
    light: Callable[[str], Path], photo: np.ndarray, tmp_path: Path, opset: int, ir: int
) -> None:
    model = classifier(opset, ir)
    before = model.SerializeToString(deterministic=True)
    onnx.save(model, tmp_path / "classifier.onnx")
    merged = chiasm.onnx.prepend(light("pipelines.preprocess"), tmp_path / "classifier.onnx")
    assert chiasm.onnx.prepend(light("pipelines.preprocess"), model).SerializeToString(
        deterministic=True
    ) == merged.SerializeToString(deterministic=True)
    assert model.SerializeToString(deterministic=True) == before
    assert next((n.domain, n.op_type) for n in merged.graph.node) == ("chiasm", "pipelines_preprocess")
    assert len(merged.graph.node) == 5 and [f.name for f in merged.functions] == ["pipelines_preprocess"]
    assert {o.domain: o.version for o in merged.opset_import} == {"": max(opset, 18), "chiasm": 1}
    assert merged.functions[0].opset_import[0].version == max(opset, 18)
    assert [v.name for v in merged.graph.input] == ["frame"] and sizes(merged.graph.input[0]) == ["H", "W", 3]
    assert {p.key: p.value for p in merged.metadata_props} == {"author": "somebody else"}
    expected = reference(preprocess(torch.from_numpy(photo)))
    np.testing.assert_allclose(run(merged, frame=photo)[0], expected, atol=1e-5, rtol=1e-4)


def test_names_and_sizes_of_both_are_kept_apart_and_joined(light: Callable[[str], Path]) -> None:
    merged = chiasm.onnx.prepend(light("filters.sobel"), classifier(name="input", shape=("N", 3, 60, 80)))
    [value] = merged.graph.input
    assert value.name == "filters_sobel_input" and sizes(value) == ["N", 3, 60, 80]
    x = RANDOM.random((2, 3, 60, 80), np.float32)
    from chiasm.filters import sobel

    np.testing.assert_allclose(
        run(merged, filters_sobel_input=x)[0], reference(sobel(torch.from_numpy(x))), atol=1e-4, rtol=1e-4
    )
    # H of the bundle is not H of the model, which is its width
    swapped = chiasm.onnx.prepend(light(SPEC.name), classifier(shape=("B", "C", "X", "H")))
    assert sizes(swapped.graph.input[0]) == ["B", "C", "test_scaled_difference_H", "H"]


def test_the_dtype_follows_the_model(light: Callable[[str], Path]) -> None:
    merged = chiasm.onnx.prepend(light("filters.sobel"), negative(TensorProto.DOUBLE))
    assert merged.graph.input[0].type.tensor_type.elem_type == TensorProto.DOUBLE
    assert run(merged, input=RANDOM.random((1, 3, 30, 40)))[0].dtype == np.float64
    with pytest.raises(
        ValueError, match=r"output 'output' is float32 .*input 'x' is float64 .*dtypes differ"
    ):
        chiasm.onnx.prepend(light("filters.sobel"), negative(TensorProto.DOUBLE), dtype="float32")


def test_two_bundles_and_one_bundle_twice(light: Callable[[str], Path]) -> None:
    add = helper.make_graph(
        [helper.make_node("Add", ["left", "right"], ["sum"])],
        "add",
        [
            helper.make_tensor_value_info(n, TensorProto.FLOAT, ["B", "C", "H", "W"])
            for n in ("left", "right")
        ],
        [helper.make_tensor_value_info("sum", TensorProto.FLOAT, ["B", "C", "H", "W"])],
    )
    model = helper.make_model(add, opset_imports=[helper.make_opsetid("", 18)], ir_version=8)
    x, y = (RANDOM.random((2, 3, 20, 30), np.float32) for _ in range(2))
    sobel, normalize = light("filters.sobel"), light("enhance.normalize")
    from chiasm.filters import sobel as eager

    edges = [eager(torch.from_numpy(v)).numpy() for v in (x, y)]
    both = chiasm.onnx.prepend(
        normalize, chiasm.onnx.prepend(sobel, model, connect={"output": "left"}), connect={"output": "right"}
    )
    assert [f.name for f in both.functions] == ["filters_sobel", "enhance_normalize"]
    mean, std = np.array([0.1, 0.2, 0.3], np.float32), np.array([0.5, 0.6, 0.7], np.float32)
    got = run(both, input=x, data=y, mean=mean, std=std)[0]
    np.testing.assert_allclose(got, edges[0] + (y - mean[:, None, None]) / std[:, None, None], atol=1e-5)
    twice = chiasm.onnx.prepend(
        sobel, chiasm.onnx.prepend(sobel, model, connect={"output": "left"}), connect={"output": "right"}
    )
    assert [f.name for f in twice.functions] == ["filters_sobel"]
    assert [v.name for v in twice.graph.input] == ["filters_sobel_input", "input"]
    np.testing.assert_allclose(run(twice, filters_sobel_input=y, input=x)[0], edges[0] + edges[1], atol=1e-5)
    chain = chiasm.onnx.prepend(sobel, chiasm.onnx.prepend(sobel, classifier()))
    assert len(chain.functions) == 1 and [v.name for v in chain.graph.input] == ["filters_sobel_input"]


def test_outputs_that_go_nowhere_are_left_out(tmp_path: Path) -> None:
    def extremes(input: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        return input.amin(1, keepdim=True), input.amax(1, keepdim=True)

    made = export(
        extremes,
        Spec("test.extremes", [image()], [TensorSpec("low"), TensorSpec("high")], gradients=()),
        tmp_path,
        formats=["onnx"],
    )
    model = negative()
    with pytest.raises(ValueError, match=r"outputs low, high, the model the inputs x: .*connect="):
        chiasm.onnx.prepend(made, model)
    merged = chiasm.onnx.prepend(made, model, connect={"high": "x"})
    x = RANDOM.random((1, 3, 9, 9), np.float32)
    [got] = run(merged, input=x)
    assert np.array_equal(got, -x.max(1, keepdims=True))


def test_models_of_other_vendors_operators_and_without_shapes(light: Callable[[str], Path]) -> None:
    """ONNX's checker rejects an output without a shape; ONNX Runtime accepts it."""
    nodes = [
        helper.make_node("FastGelu", ["x"], ["g"], domain="com.microsoft"),
        helper.make_node("ReduceMean", ["g"], ["y"], axes=[2, 3]),
    ]
    x, y = (
        helper.make_tensor_value_info("x", TensorProto.FLOAT, ["N", 3, 224, 224]),
        helper.make_tensor_value_info("y", TensorProto.FLOAT, None),
    )
    opsets = [helper.make_opsetid("", 13), helper.make_opsetid("com.microsoft", 1)]
    merged = chiasm.onnx.prepend(
        light("pipelines.preprocess"),
        helper.make_model(helper.make_graph(nodes, "g", [x], [y]), opset_imports=opsets, ir_version=7),
    )
    assert {o.domain: o.version for o in merged.opset_import} == {"": 18, "com.microsoft": 1, "chiasm": 1}
    assert run(merged, frame=np.zeros((30, 40, 3), np.uint8))[0].shape == (1, 3, 1, 1)


def test_what_does_not_fit_is_said(light: Callable[[str], Path]) -> None:
    preprocess_, sobel = light("pipelines.preprocess"), light("filters.sobel")
    with pytest.raises(
        ValueError,
        match=(
            r"float32 \(1, 3, 224, 224\), the model's input 'images' is float32 \(N, 3, 256, 256\): 224 is"
            r" not 256"
        ),
    ):
        chiasm.onnx.prepend(preprocess_, classifier(shape=("N", 3, 256, 256)))
    with pytest.raises(ValueError, match=r"\(N, 3, 224\): the numbers of dimensions differ"):
        chiasm.onnx.prepend(preprocess_, classifier(shape=("N", 3, 224)))
    with pytest.raises(ValueError, match="takes H from 8 to 32768"):
        chiasm.onnx.prepend(sobel, classifier(shape=(1, 3, 5, 30)))
    with pytest.raises(ValueError, match=r"no output 'result': it has output"):
        chiasm.onnx.prepend(sobel, classifier(), connect={"result": "images"})
    with pytest.raises(ValueError, match=r"no input 'weight': it has images"):
        chiasm.onnx.prepend(sobel, classifier(), connect={"output": "weight"})
    with pytest.raises(ValueError, match="at least one pair"):
        chiasm.onnx.prepend(sobel, classifier(), connect={})


def test_functions_and_domains_that_cannot_share_a_model(
    light: Callable[[str], Path], tmp_path: Path
) -> None:
    model = chiasm.onnx.prepend(light(SPEC.name), classifier(shape=("B", 3, "h", "w")))
    from dataclasses import replace

    spec = replace(SPEC, name="test.other", gradients=())
    newer = export(scaled_difference, replace(spec, version="2.0.0"), tmp_path / "newer", formats=["onnx"])
    with pytest.raises(ValueError, match=r"version 2\.0\.0 .*holds version 1 of the domain"):
        chiasm.onnx.prepend(newer, model, connect={"output": "input"})
    cubic = export(
        scaled_difference,
        replace(SPEC, config={"power": 3.0}, gradients=()),
        tmp_path / "cubic",
        formats=["onnx"],
    )
    with pytest.raises(ValueError, match="another function chiasm::test_scaled_difference"):
        chiasm.onnx.prepend(cubic, model, connect={"output": "input"})
    old = classifier(opset=13)
    old.functions.add(domain="mine", name="f", input=["x"], output=["y"]).node.append(
        helper.make_node("Relu", ["x"], ["y"])
    )
    with pytest.raises(ValueError, match=r"imports opset 13 and has functions.*opset 18 or later"):
        chiasm.onnx.prepend(light(SPEC.name), old)


def test_a_chain_from_frame_to_boxes(light: Callable[[str], Path], photo: np.ndarray) -> None:
    """Letterbox, network, decoder, and the map back to the frame, which goes from the letterbox past the
    network."""
    model = chiasm.onnx.prepend(light("pipelines.letterbox"), detector(), connect={"output": "images"})
    model = chiasm.onnx.append(model, light("ops.decode_yolov8"))
    assert [v.name for v in model.graph.output] == ["boxes", "scores", "labels", "found"]
    link = {"pipelines_letterbox_to_frame": "trans_mat", "boxes": "boxes"}
    model = chiasm.onnx.append(model, light("geometry.bbox.transform_bbox.xyxy"), connect=link)
    assert [v.name for v in model.graph.input] == ["frame"]
    assert [v.name for v in model.graph.output] == ["scores", "labels", "found", "boxes_out"]
    assert [f.name for f in model.functions] == [
        "pipelines_letterbox",
        "ops_decode_yolov8",
        "geometry_bbox_transform_bbox_xyxy",
    ]

    from chiasm.geometry.bbox import transform_bbox
    from chiasm.ops import decode_yolov8
    from chiasm.pipelines import letterbox

    image, to_frame = letterbox(torch.from_numpy(photo)[None])
    raw = F.conv2d(image, torch.from_numpy(CELLS), stride=8).flatten(2) * 30
    boxes, *others = decode_yolov8(raw + torch.from_numpy(OFFSETS)[:, None])
    got = run(model, frame=photo[None])
    assert others[2].sum() > 3
    for actual, expected in zip(got, [*others, transform_bbox(to_frame, boxes)]):
        np.testing.assert_allclose(actual, expected.numpy(), atol=1e-3, rtol=1e-4)


def test_inputs_of_an_appended_bundle_that_nothing_gives(light: Callable[[str], Path]) -> None:
    model = chiasm.onnx.append(negative(), light(SPEC.name), connect={"low": "input"})
    assert [v.name for v in model.graph.input] == ["x", "gain"]
    assert sizes(model.graph.output[0]) == ["B", "C", "", "W"]  # one row less than H
    x, gain = RANDOM.random((2, 3, 9, 8), np.float32), np.array([1.0, 2.0], np.float32)
    [got] = run(model, x=x, gain=gain)
    np.testing.assert_allclose(got, (np.diff(-x, axis=2) * gain[:, None, None, None]) ** 2, rtol=1e-5)


def test_one_bundle_before_and_after(light: Callable[[str], Path]) -> None:
    """One function, called twice; the second call's output has its own name."""
    sobel = light("filters.sobel")
    model = chiasm.onnx.append(chiasm.onnx.prepend(sobel, negative()), sobel)
    assert [n.op_type for n in model.graph.node] == ["filters_sobel", "Neg", "filters_sobel"]
    assert len(model.functions) == 1 and len({n.name for n in model.graph.node if n.domain == "chiasm"}) == 2
    x = RANDOM.random((1, 3, 20, 24), np.float32)
    from chiasm.filters import sobel as eager

    expected = eager(-eager(torch.from_numpy(x))).numpy()
    np.testing.assert_allclose(run(model, input=x)[0], expected, atol=1e-5)
    double = chiasm.onnx.append(negative(TensorProto.DOUBLE), sobel)
    assert double.graph.output[0].type.tensor_type.elem_type == TensorProto.DOUBLE


def test_what_does_not_fit_after_a_model_is_said(light: Callable[[str], Path]) -> None:
    sobel, decode = light("filters.sobel"), light("geometry.bbox.transform_bbox.xyxy")
    with pytest.raises(
        ValueError,
        match=r"input 'input' is float32 .*output 'scores' is float32 \(N, 8\): the numbers of dim",
    ):
        chiasm.onnx.append(classifier(), sobel)
    with pytest.raises(ValueError, match=r"outputs scores, .* the inputs .*: say which goes where: connect="):
        chiasm.onnx.append(classifier(), decode)
    with pytest.raises(ValueError, match=r"no value 'low': its outputs are scores"):
        chiasm.onnx.append(classifier(), sobel, connect={"low": "input"})
    with pytest.raises(ValueError, match=r"no input 'image': it has input"):
        chiasm.onnx.append(classifier(), sobel, connect={"scores": "image"})
    with pytest.raises(ValueError, match="an input of the bundle is named twice"):
        chiasm.onnx.append(classifier(), sobel, connect={"scores": "input", "pooled": "input"})
    with pytest.raises(ValueError, match=r"the dtypes differ"):
        chiasm.onnx.append(negative(TensorProto.DOUBLE), sobel, dtype="float32")


@pytest.mark.filterwarnings("ignore:The onnxtxt format is experimental")
def test_what_is_no_model_is_said(light: Callable[[str], Path], tmp_path: Path) -> None:
    bundle, junk, empty = light("filters.sobel"), tmp_path / "junk.onnx", tmp_path / "empty.onnx"
    junk.write_bytes(b"\xff" * 100)
    empty.touch()
    with pytest.raises(
        ValueError, match=r"^model: expected an ONNX file, got the folder .*sobel.*bundle first"
    ):
        chiasm.onnx.prepend(bundle, bundle)
    for file in (junk, empty):
        with pytest.raises(ValueError, match=rf"^model: expected an ONNX file, got .*{file.name}"):
            chiasm.onnx.append(file, bundle)
    for suffix, text in (("json", "{"), ("textproto", "zz {"), ("onnxtxt", "<bad")):
        (file := tmp_path / f"text.{suffix}").write_text(text)
        with pytest.raises(ValueError, match=rf"^model: expected an ONNX file, got .*text\.{suffix}: "):
            chiasm.onnx.append(file, bundle)
    with pytest.raises(TypeError, match=r"^model: expected an onnx\.ModelProto or a file, got NoneType"):
        chiasm.onnx.append(None, bundle)
    with pytest.raises(TypeError, match=r"^connect: expected a dict of names, got list"):
        chiasm.onnx.prepend(bundle, classifier(), connect=[1])


def damaged(bundle: Path, folder: Path, change: Callable[[onnx.ModelProto], bytes | None]) -> Path:
    """A copy of a bundle with other ONNX models, whose hashes are those of its manifest."""
    copy = Path(shutil.copytree(bundle, folder / bundle.name))
    manifest = json.loads((copy / "manifest.json").read_text())
    for artifact in manifest["methods"]["forward"]["artifacts"]:
        if artifact["format"] == "onnx":
            model = onnx.load(copy / artifact["file"])
            data = change(model) or model.SerializeToString()
            (copy / artifact["file"]).write_bytes(data)
            artifact |= {"size": len(data), "sha256": sha256(data)}
    (copy / "manifest.json").write_text(json.dumps(manifest))
    return copy


def rename_outputs(model: onnx.ModelProto) -> None:
    for value in model.graph.output:
        value.name = "other"


def outside() -> TensorProto:
    tensor = TensorProto(name="secret", data_type=1, dims=[1], data_location=TensorProto.EXTERNAL)
    tensor.external_data.add(key="location", value="/etc/passwd")
    return tensor


def sparse_outside() -> onnx.SparseTensorProto:
    indices = numpy_helper.from_array(np.array([0]), "indices")
    return onnx.SparseTensorProto(dims=[3], values=outside(), indices=indices)


def add_constant(model: onnx.ModelProto, **value: Any) -> None:
    nodes = model.functions[0].node if model.functions else model.graph.node
    nodes.insert(0, helper.make_node("Constant", [], ["unused"], **value))


def add_tensor_outside(model: onnx.ModelProto) -> None:
    add_constant(model, value=outside())


def add_sparse_tensor_outside(model: onnx.ModelProto) -> None:
    add_constant(model, sparse_value=sparse_outside())


def add_sparse_initializer_outside(model: onnx.ModelProto) -> None:
    model.graph.sparse_initializer.append(sparse_outside())


def add_sparse_initializer_of_a_branch(model: onnx.ModelProto) -> None:
    branch = onnx.GraphProto(name="branch", sparse_initializer=[sparse_outside()])
    add_constant(model, then_branch=branch)


def add_default_outside(model: onnx.ModelProto) -> None:
    if model.functions:
        model.functions[0].attribute_proto.append(helper.make_attribute("unused", outside()))
    else:
        add_tensor_outside(model)


def add_function(model: onnx.ModelProto) -> None:
    model.functions.add(domain="chiasm", name="another")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda model: b"\xff" * 100, "expected an ONNX model: "),
        (rename_outputs, "has the outputs other, the manifest says output"),
        (add_tensor_outside, "the tensor 'secret' is in another file"),
        (add_sparse_tensor_outside, "the tensor 'secret' is in another file"),
        (add_sparse_initializer_outside, "the tensor 'secret' is in another file"),
        (add_sparse_initializer_of_a_branch, "the tensor 'secret' is in another file"),
        (add_default_outside, "the tensor 'secret' is in another file"),
        (add_function, "defines the functions .*another, the manifest says"),
    ],
)
def test_a_bundle_whose_models_are_not_those_of_its_manifest(
    change: Callable, message: str, light: Callable[[str], Path], tmp_path: Path
) -> None:
    bundle = damaged(light("filters.sobel"), tmp_path, change)
    for use in (
        lambda: chiasm.onnx.prepend(bundle, classifier()),
        lambda: chiasm.onnx.append(negative(), bundle),
        lambda: chiasm.onnx.session(bundle, fused=False),
        lambda: chiasm.onnx.Node(bundle),
    ):
        with pytest.raises(BundleError, match=rf"filters\.sobel\.chiasm/forward\.float32.*\.onnx: {message}"):
            use()


def test_models_whose_tensors_are_in_other_files(light: Callable[[str], Path], tmp_path: Path) -> None:
    bundle, whole, part = light("filters.sobel"), tmp_path / "whole.onnx", tmp_path / "whole.bin"
    onnx.save(classifier(), whole, save_as_external_data=True, location=part.name, size_threshold=0)
    x = RANDOM.random((1, 3, 224, 224), np.float32)
    with_part = run(chiasm.onnx.prepend(bundle, whole), input=x)
    np.testing.assert_array_equal(with_part, run(chiasm.onnx.prepend(bundle, classifier()), input=x))
    part.unlink()
    with pytest.raises(ValueError, match=r"^model: expected an ONNX file, got .*whole\.onnx: .*whole\.bin"):
        chiasm.onnx.prepend(bundle, whole)
    # onnx itself checks these numbers only while it reads
    tensor = onnx.TensorProto(name="w", data_type=1, dims=[1], data_location=onnx.TensorProto.EXTERNAL)
    part.write_bytes(bytes(64))
    for key, value in (("offset", "-1"), ("offset", "x"), ("length", "99999999999")):
        del tensor.external_data[:]
        tensor.external_data.add(key="location", value=part.name)
        tensor.external_data.add(key=key, value=value)
        model = classifier()
        model.graph.initializer.append(tensor)
        whole.write_bytes(model.SerializeToString())
        with pytest.raises(ValueError, match=r"^model: expected an ONNX file, got .*whole\.onnx: "):
            chiasm.onnx.prepend(bundle, whole)


def test_a_model_without_an_end(light: Callable[[str], Path], tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.onnx")
    for file in (tmp_path / "pipe.onnx", "/dev/zero"):
        with pytest.raises(ValueError, match=r"^model: expected an ONNX file, got the pipe or device"):
            chiasm.onnx.append(file, light("filters.sobel"))


def test_wrong_arguments_are_named(light: Callable[[str], Path], tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to("loop")
    sobel, model = light("filters.sobel"), classifier()
    odd, empty = classifier(), classifier(shape=(1, 3, 0, 30))
    odd.graph.input[0].type.tensor_type.elem_type = 77
    nameless = classifier()
    nameless.graph.input[0].name = ""
    call = helper.make_node("filters_sobel", ["images", "images"], ["twice"], domain="chiasm")
    calling = classifier()
    calling.graph.node.append(call)
    calling.opset_import.add(domain="chiasm", version=1)
    options = onnxruntime.SessionOptions()
    for use, kind, message in (
        (lambda: chiasm.onnx.prepend(None, model), TypeError, "bundle: expected the path of a folder"),
        (lambda: chiasm.onnx.prepend(sobel, model, method=["forward"]), TypeError, "method: expected a name"),
        (lambda: chiasm.onnx.prepend(sobel, model, connect={"output": []}), TypeError, r"connect: .*\[\]"),
        (lambda: chiasm.onnx.prepend(sobel, odd), ValueError, "'images' is element type 77"),
        (lambda: chiasm.onnx.prepend(sobel, nameless), ValueError, "connect: expected names, got an empty"),
        (lambda: chiasm.onnx.prepend(sobel, empty), ValueError, "takes H from 8 to 32768"),
        (lambda: chiasm.onnx.embed("model.onnx", sobel), TypeError, "model: expected an onnx.ModelProto"),
        (lambda: chiasm.onnx.embed(calling, sobel), ValueError, "with 2 inputs and 1 outputs, it has 1 and"),
        (lambda: chiasm.onnx.register(None, sobel), TypeError, "options: expected onnxruntime.SessionOpt"),
        (
            lambda: chiasm.onnx.register(options, tmp_path / "loop"),
            BundleError,
            "loop/manifest.json: Too many",
        ),
        (
            lambda: chiasm.onnx.register(options, [sobel] * 500),
            ValueError,
            "500 paths of .* are too many",
        ),
        (lambda: chiasm.onnx.register(options, 5), TypeError, "bundles: expected paths of folders, got int"),
        (lambda: chiasm.onnx.session(sobel, providers="CPU"), TypeError, "providers: expected a list of nam"),
    ):
        with pytest.raises(kind, match=message):
            use()
