"""The fused form of an ONNX artifact: one node, one function, and the numbers of the flat form."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnx.inliner
import onnxruntime
import pytest
import torch
from onnx import TensorProto, helper

from chiasm.export import example_inputs, export
from chiasm.export.catalog import catalog
from chiasm.export.comparison import difference
from chiasm.export.job import run_eager, with_cotangents
from chiasm.export.manifest import read_file, read_manifest
from chiasm.export.onnx_function import domain_version, function_name, fuse
from chiasm.export.spec import Spec, TensorSpec
from chiasm.export.tracing.gradient import vjp_module
from chiasm.export.tracing.module import bind_spec

from .conftest import SPEC, scaled_difference

OPS = (
    "test.scaled_difference",
    "color.rgb_to_grayscale",
    "enhance.normalize",
    "filters.sobel",
    "geometry.transform.resize.nearest",
    "pipelines.preprocess",
)


def op_of(name: str) -> tuple[Callable, Spec]:
    if name == SPEC.name:
        return scaled_difference, SPEC
    entry = catalog()[name]
    return entry.function(), entry.spec


def methods(bundle: Path) -> list[tuple[str, dict[str, Any], dict[str, Any], dict[str, Any]]]:
    """(method, its signature, flat artifact, fused artifact), one row per dtype."""
    rows = []
    for name, method in read_manifest(bundle)["methods"].items():
        flat = [a for a in method["artifacts"] if a["format"] == "onnx" and "function" not in a]
        fused = [a for a in method["artifacts"] if a["format"] == "onnx" and "function" in a]
        assert [a["dtypes"] for a in flat] == [a["dtypes"] for a in fused]
        rows += [(name, method, a, b) for a, b in zip(flat, fused, strict=True)]
    return rows


def run(model: onnx.ModelProto, inputs: dict[str, np.ndarray]) -> list[np.ndarray]:
    session = onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
    return session.run(None, inputs)


@pytest.mark.parametrize("name", OPS)
def test_the_model_is_one_call_with_the_manifests_inputs_and_outputs(
    light: Callable[[str], Path], name: str
) -> None:
    bundle = light(name)
    rows = methods(bundle)
    assert rows
    for method, signature, flat, fused in rows:
        assert fused["file"] == flat["file"].removesuffix(".onnx") + ".fused.onnx"
        for key in ("backend", "format", "dtypes", "device", "opset", "ir_version"):
            assert fused[key] == flat[key]
        whole, plain = (onnx.load_from_string(read_file(bundle, a)) for a in (fused, flat))
        onnx.checker.check_model(whole, full_check=True)
        inputs, outputs = ([t["name"] for t in signature[k]] for k in ("inputs", "outputs"))
        expected = name.replace(".", "_") + ("" if method == "forward" else "_vjp")
        [function], [node] = whole.functions, whole.graph.node
        assert fused["function"] == function.name == node.op_type == expected
        assert (function.domain, node.domain) == ("chiasm", "chiasm")
        assert list(node.input) == list(function.input) == [v.name for v in whole.graph.input] == inputs
        assert list(node.output) == list(function.output) == [v.name for v in whole.graph.output] == outputs
        assert [(o.domain, o.version) for o in whole.opset_import] == [("", 18), ("chiasm", 1)]
        assert [(o.domain, o.version) for o in function.opset_import] == [("", 18)]
        assert whole.ir_version == 8 and not function.value_info and not whole.graph.initializer
        assert list(whole.graph.input) == list(plain.graph.input) and list(whole.graph.output) == list(
            plain.graph.output
        )
        assert list(whole.metadata_props) == list(plain.metadata_props)
        assert fused["size"] < flat["size"], "nothing is stored twice"


@pytest.mark.parametrize("name", OPS)
def test_flat_and_fused_agree_with_eager_at_other_sizes(light: Callable[[str], Path], name: str) -> None:
    bundle = light(name)
    fn, spec = op_of(name)
    op = bind_spec(fn, spec)
    outputs = [
        TensorSpec(t["name"], tuple(t["shape"]), t["dtype"])
        for t in read_manifest(bundle)["methods"]["forward"]["outputs"]
    ]
    for method, signature, flat, fused in methods(bundle):
        eager = op if method == "forward" else vjp_module(op, spec, outputs)
        assert eager is not None
        variant = next(iter(flat["dtypes"]), None)
        tensors = [TensorSpec(t["name"], tuple(t["shape"]), t["dtype"]) for t in signature["inputs"]]
        for sizes in example_inputs.TESTS[:2]:
            inputs = with_cotangents(op, spec, example_inputs.fit(spec, sizes), variant, tensors)
            arrays = {n: t.numpy() for n, t in inputs.items()}
            a, b = (
                run(onnx.load_from_string(read_file(bundle, artifact)), arrays) for artifact in (flat, fused)
            )
            for tensor, x, y, want in zip(signature["outputs"], a, b, run_eager(eager, inputs), strict=True):
                assert np.array_equal(x, y, equal_nan=True), f"{method} {tensor['name']}: the forms differ"
                tolerance = signature["tolerances"].get(str(want.dtype).removeprefix("torch."))
                assert difference(torch.from_numpy(y), want, tolerance)[1] == ""


@pytest.mark.parametrize("name", ["test.scaled_difference", "filters.sobel", "pipelines.preprocess"])
def test_inlining_gives_a_flat_model_of_the_same_numbers(light: Callable[[str], Path], name: str) -> None:
    bundle = light(name)
    _, spec = op_of(name)
    inputs = {
        n: t.numpy()
        for n, t in example_inputs.make(
            spec, example_inputs.fit(spec, example_inputs.TESTS[1]), spec.variants()[0]
        ).items()
    }
    _, _, flat, fused = methods(bundle)[0]
    inlined = onnx.inliner.inline_local_functions(onnx.load_from_string(read_file(bundle, fused)))
    onnx.checker.check_model(inlined, full_check=True)
    assert not inlined.functions and {n.domain for n in inlined.graph.node} == {""}
    for x, y in zip(
        run(inlined, inputs), run(onnx.load_from_string(read_file(bundle, flat)), inputs), strict=True
    ):
        assert np.array_equal(x, y)


def test_exporting_again_gives_the_same_bytes(light: Callable[[str], Path], tmp_path: Path) -> None:
    again = export(scaled_difference, SPEC, tmp_path, formats=["onnx"])
    for _, _, flat, fused in methods(light(SPEC.name)):
        for artifact in (flat, fused):
            assert (again / artifact["file"]).read_bytes() == (
                light(SPEC.name) / artifact["file"]
            ).read_bytes()


def test_the_domains_version_is_the_specs_major_number(tmp_path: Path) -> None:
    made = export(scaled_difference, replace(SPEC, version="3.1.4", gradients=()), tmp_path, formats=["onnx"])
    [(_, _, _, fused)] = methods(made)
    assert [(o.domain, o.version) for o in onnx.load(made / fused["file"]).opset_import] == [
        ("", 18),
        ("chiasm", 3),
    ]
    assert domain_version("0.4.0") == 1
    assert function_name("a.b.c_d", "vjp") == "a_b_c_d_vjp"


def nested() -> onnx.ModelProto:
    """y = x + bias where flag, else (x * gain) + 1 repeated 3 times: subgraphs with their own constants and
    with outer values."""
    make = helper.make_node
    value = helper.make_tensor_value_info

    def scalar(name: str, data: float | bool | int, kind: int = TensorProto.FLOAT) -> onnx.TensorProto:
        return helper.make_tensor(name, kind, [], [data])

    body = helper.make_graph(
        [make("Identity", ["again"], ["keep"]), make("Add", ["state", "one"], ["next"])],
        "body",
        [
            value("step", TensorProto.INT64, []),
            value("again", TensorProto.BOOL, []),
            value("state", TensorProto.FLOAT, None),
        ],
        [value("keep", TensorProto.BOOL, []), value("next", TensorProto.FLOAT, None)],
        [scalar("one", 1.0)],
        value_info=[value("keep", TensorProto.BOOL, [])],
    )
    otherwise = helper.make_graph(
        [
            make("Mul", ["x", "gain"], ["scaled"]),
            make("Loop", ["count", "true", "scaled"], ["other"], body=body),
        ],
        "else",
        [],
        [value("other", TensorProto.FLOAT, None)],
        [scalar("count", 3, TensorProto.INT64), scalar("true", True, TensorProto.BOOL)],
    )
    then = helper.make_graph(
        [make("Add", ["x", "bias"], ["sum"])], "then", [], [value("sum", TensorProto.FLOAT, None)]
    )
    graph = helper.make_graph(
        [make("If", ["flag"], ["y"], then_branch=then, else_branch=otherwise)],
        "nested",
        [
            value("x", TensorProto.FLOAT, ["N"]),
            value("flag", TensorProto.BOOL, []),
            value("unread", TensorProto.FLOAT, ["M"]),
        ],
        [value("y", TensorProto.FLOAT, ["N"])],
        [scalar("bias", 5.0), scalar("gain", 2.0)],
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=8)


@pytest.mark.parametrize("flag", [True, False])
def test_subgraphs_and_inputs_that_are_not_read(flag: bool) -> None:
    flat = nested()
    before = flat.SerializeToString(deterministic=True)
    fused = fuse(flat, "nested", 1)
    assert flat.SerializeToString(deterministic=True) == before
    onnx.checker.check_model(fused, full_check=True)
    inputs = {
        "x": np.array([1, -2, 3], np.float32),
        "flag": np.array(flag),
        "unread": np.zeros(2, np.float32),
    }
    expected = inputs["x"] + 5 if flag else inputs["x"] * 2 + 3
    for model in (flat, fused, onnx.inliner.inline_local_functions(fused)):
        assert np.array_equal(run(model, inputs)[0], expected)


def test_what_cannot_be_fused_is_refused() -> None:
    fused = fuse(nested(), "nested", 1)
    with pytest.raises(ValueError, match="functions already: nested"):
        fuse(fused, "again", 1)
    outside = nested()
    outside.graph.initializer[0].data_location = TensorProto.EXTERNAL
    with pytest.raises(ValueError, match=r"bias.*outside"):
        fuse(outside, "outside", 1)
