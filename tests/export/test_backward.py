"""Gradients of parts of tensors: joined in the exported graph, with the values of eager ones."""

import pytest
import torch
from torch import Tensor

from chiasm.export import samples
from chiasm.export.job import with_cotangents
from chiasm.export.spec import Spec, TensorSpec
from chiasm.export.tracing.gradient import trace_vjp, vjp_module, vjp_signature
from chiasm.export.tracing.graph import output_specs, trace
from chiasm.export.tracing.module import bind


def components(x: Tensor) -> Tensor:
    return torch.stack([x[..., 0] * x[..., 2], x[..., 1] + 2.0 * x[..., -1]], -1)


def overlapping(x: Tensor) -> Tensor:
    """Slices of which some overlap, a gap, and all of x."""
    return (x[..., :2] * x[..., 1:3]).sum(-1) + x[..., 4] * x[:, 0, 4:5] + (x * x).sum(-1)


def along_rows(x: Tensor) -> Tensor:
    return x[:, 0] * x[:, 3] - x[:, 1, :]


def of_a_part(x: Tensor) -> Tensor:
    """What comes back for a part is joined itself."""
    y = x[..., :3]
    return y[..., 0] * y[..., 1] * y[..., 2] + x[..., 3]


@pytest.mark.parametrize(
    ("function", "shape"),
    [(components, ("N", 4)), (overlapping, ("N", 3, 5)), (along_rows, ("N", 4, "M")), (of_a_part, ("N", 4))],
)
def test_parts_are_joined(function, shape) -> None:
    spec = Spec("test.parts", [TensorSpec("x", shape, range=(-1, 1))], symbols={"N": (2, 100), "M": (2, 100)})
    op = bind(function, {"x": "x=x"}, {}, spec.name)
    example = samples.make(spec, samples.fit(spec, samples.EXAMPLE), "float32")
    outputs = output_specs(trace(op, spec, list(spec.inputs), example, "onnx"), spec, "float32")
    tensors, _ = vjp_signature(spec, outputs)
    pullback = vjp_module(op, spec, outputs)
    program = trace_vjp(
        pullback,
        spec,
        tensors,
        with_cotangents(op, spec, samples.fit(spec, samples.EXAMPLE), "float32", tensors),
    )
    targets = [n.target for n in program.graph.nodes]
    assert torch.ops.aten.cat.default in targets
    assert torch.ops.aten.select_backward.default not in targets
    other = with_cotangents(op, spec, samples.fit(spec, samples.GOLDEN), "float32", tensors)
    expected = pullback(*other.values())
    actual = program.module()(*other.values())
    for a, e in zip(actual, expected, strict=True):
        torch.testing.assert_close(a, e)
