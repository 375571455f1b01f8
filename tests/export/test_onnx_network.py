"""Bundles within torch networks, exported to ONNX as single nodes."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
import torch
from torch import Tensor, nn
from torch.export import Dim

import chiasm.onnx
from chiasm.export.manifest import BundleError
from chiasm.filters import sobel
from chiasm.pipelines import preprocess

from .conftest import SPEC, scaled_difference


class Classifier(nn.Module):
    """A bundle, then a small network."""

    def __init__(self, prepare: nn.Module) -> None:
        super().__init__()
        torch.manual_seed(0)
        self.prepare, self.conv, self.linear = prepare, nn.Conv2d(3, 8, 3, stride=2), nn.Linear(8, 5)

    def forward(self, frame: Tensor) -> Tensor:
        return self.linear(self.conv(self.prepare(frame)).relu().mean((2, 3)))


def photo() -> Tensor:
    import skimage

    return torch.from_numpy(np.ascontiguousarray(skimage.data.astronaut()[::2, ::3, ::-1]))


def run(model: onnx.ModelProto, *inputs: Tensor) -> list[np.ndarray]:
    session = onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
    return session.run(None, {i.name: x.numpy() for i, x in zip(session.get_inputs(), inputs, strict=True)})


@pytest.mark.parametrize(
    "options", [{}, {"opset_version": 18}, {"opset_version": 21}], ids=["default", "18", "21"]
)
def test_a_network_exports_with_the_bundle_as_one_node(
    light: Callable[[str], Path], tmp_path: Path, options: dict
) -> None:
    network = Classifier(chiasm.onnx.Node(light("pipelines.preprocess"))).eval()
    frame = photo()
    with torch.no_grad():
        expected = network(frame)
        torch.testing.assert_close(
            expected,
            Classifier(nn.Module()).linear(network.conv(preprocess(frame)).relu().mean((2, 3))),
            atol=1e-5,
            rtol=1e-4,
        )
    shapes = {"frame": {0: Dim("H", min=8, max=4096), 1: Dim("W", min=8, max=4096)}}
    model = chiasm.onnx.export(
        network,
        (torch.zeros(40, 56, 3, dtype=torch.uint8),),
        tmp_path / "net.onnx",
        dynamic_shapes=shapes,
        **options,
    )
    onnx.checker.check_model(model, full_check=True)
    assert onnx.load(tmp_path / "net.onnx") == model
    assert [n.op_type for n in model.graph.node if n.domain == "chiasm"] == ["pipelines_preprocess"]
    assert [f.name for f in model.functions] == ["pipelines_preprocess"] and len(model.graph.node) < 8
    assert {o.domain: o.version for o in model.opset_import}["chiasm"] == 1
    np.testing.assert_allclose(run(model, frame)[0], expected.numpy(), atol=1e-5, rtol=1e-4)


def test_what_torch_exports_is_completed_by_embed(light: Callable[[str], Path]) -> None:
    network = Classifier(chiasm.onnx.Node(light("filters.sobel"))).eval()
    x = torch.rand(1, 3, 30, 40)
    program = torch.onnx.export(network, (x,), dynamo=True, verbose=False)
    assert program is not None
    with pytest.raises(ValueError, match="chiasm::filters_sobel, which none"):
        chiasm.onnx.embed(program.model_proto)
    with pytest.raises(
        ValueError, match=r"does not call chiasm::pipelines_preprocess; it calls filters_sobel"
    ):
        chiasm.onnx.embed(program.model_proto, light("pipelines.preprocess"))
    model = chiasm.onnx.embed(program.model_proto, light("filters.sobel"))
    with torch.no_grad():
        np.testing.assert_allclose(run(model, x)[0], network(x).numpy(), atol=1e-5, rtol=1e-4)


def test_embedding_in_another_dtype(light: Callable[[str], Path]) -> None:
    x = torch.rand(1, 3, 30, 40, dtype=torch.float64)
    program = torch.onnx.export(
        chiasm.onnx.Node(light("filters.sobel"), dtype="float64"), (x,), dynamo=True, verbose=False
    )
    assert program is not None
    model = chiasm.onnx.embed(program.model_proto, light("filters.sobel"), dtype="float64")
    np.testing.assert_allclose(run(model, x)[0], sobel(x).numpy(), atol=1e-9)
    with pytest.raises(BundleError, match="got 'float16'"):
        chiasm.onnx.embed(program.model_proto, light("filters.sobel"), dtype="float16")


def test_symbolic_sizes_go_through_the_manifests_expressions(light: Callable[[str], Path]) -> None:
    """The output has one row less, and the next layer depends on its size."""

    class Rows(nn.Module):
        def __init__(self, node: nn.Module) -> None:
            super().__init__()
            self.node = node

        def forward(self, x: Tensor, gain: Tensor) -> Tensor:
            y = self.node(x, gain)
            return y.reshape(y.shape[0], y.shape[2], -1).mean(-1)

    network = Rows(chiasm.onnx.Node(light(SPEC.name)))
    batch, height = Dim("batch", min=1, max=64), Dim("height", min=4, max=4096)
    shapes = {"x": {0: batch, 2: height}, "gain": {0: batch}}
    model = chiasm.onnx.export(network, (torch.rand(2, 3, 12, 17), torch.rand(2)), dynamic_shapes=shapes)
    assert sum(n.domain == "chiasm" for n in model.graph.node) == 1
    x, gain = torch.rand(5, 3, 31, 17), torch.rand(5) + 0.5
    expected = scaled_difference(x, gain, 2.0).reshape(5, 30, -1).mean(-1)
    np.testing.assert_allclose(run(model, x, gain)[0], expected.numpy(), atol=1e-5)


def test_a_node_is_the_op_in_eager_mode_gradient_included(light: Callable[[str], Path]) -> None:
    node = chiasm.onnx.Node(light("filters.sobel"))
    x = torch.rand(2, 3, 12, 15, requires_grad=True)
    torch.testing.assert_close(node(x), sobel(x))
    [got], [want] = (torch.autograd.grad(f(x).sum(), x) for f in (node, sobel))
    torch.testing.assert_close(got, want)
    assert "chiasm::filters_sobel" in repr(node)


def test_a_node_without_torchscript_has_values_and_no_gradient(light: Callable[[str], Path]) -> None:
    vjp = chiasm.onnx.Node(light("filters.sobel"), "vjp")
    x, seed = torch.rand(1, 2, 12, 15), torch.rand(1, 2, 12, 15)
    leaf = x.clone().requires_grad_()
    torch.testing.assert_close(
        vjp(x, seed), torch.autograd.grad(sobel(leaf), leaf, seed)[0], atol=1e-5, rtol=1e-4
    )
    with pytest.raises(RuntimeError, match="no gradient"):
        vjp(leaf, seed)
    model = chiasm.onnx.export(vjp, (x, seed))
    assert [f.name for f in model.functions] == ["filters_sobel_vjp"]
    np.testing.assert_allclose(run(model, x, seed)[0], vjp(x, seed).numpy(), atol=1e-6)


def test_wrong_inputs_and_other_exports_are_refused(light: Callable[[str], Path]) -> None:
    node = chiasm.onnx.Node(light(SPEC.name))
    x, gain = torch.rand(2, 3, 12, 15), torch.rand(2)
    for inputs, kind, words in [
        ((x,), TypeError, "expected 2 inputs .input, gain., got 1"),
        ((x.double(), gain), TypeError, "'input': expected float32, got torch.float64"),
        ((x[0], gain), ValueError, r"'input': expected shape .B, C, H, W., got .3, 12, 15."),
        ((x, torch.rand(3)), ValueError, "'gain': expected shape .B., got .3,."),
        ((x[:, :, :2], gain), ValueError, r"'input': .*, got .2, 3, 2, 15.: H must be from 4 to 4096$"),
        ((torch.zeros(1, 1, 4, 4097), gain[:1]), ValueError, "W must be from 4 to 4096"),
    ]:
        with pytest.raises(kind, match=words):
            node(*inputs)
    # A size that is open in the exported model is not limited by the check
    free = {"inputs": ({2: Dim("height", min=1, max=99999)}, None)}
    model = chiasm.onnx.export(node, (x, gain), dynamic_shapes=free)
    assert model.graph.input[0].type.tensor_type.shape.dim[2].dim_param
    with pytest.raises(RuntimeError, match="exported to ONNX only"):
        torch.export.export(node, (x, gain))
    with pytest.raises(ValueError, match="dynamo"):
        chiasm.onnx.export(node, (x, gain), dynamo=False)


def test_two_dtypes_of_one_op_cannot_share_a_model(light: Callable[[str], Path]) -> None:
    class Both(nn.Module):
        def __init__(self, bundle: Path) -> None:
            super().__init__()
            self.single, self.double_ = chiasm.onnx.Node(bundle), chiasm.onnx.Node(bundle, dtype="float64")

        def forward(self, x: Tensor) -> Tensor:
            return self.single(x) + self.double_(x.double()).float()

    with pytest.raises(ValueError, match="another function chiasm::filters_sobel"):
        chiasm.onnx.export(Both(light("filters.sobel")), (torch.rand(1, 3, 12, 15),))
