"""Gradients of parts of tensors: they are joined in the exported graph, and equal eager gradients."""

import pytest
import torch
from torch import Tensor

from chiasm.export import example_inputs
from chiasm.export.job import with_cotangents
from chiasm.export.spec import Spec, TensorSpec, image
from chiasm.export.tracing.gradient import trace_vjp, vjp_module, vjp_signature
from chiasm.export.tracing.graph import output_specs, trace
from chiasm.export.tracing.module import bind
from chiasm.geometry.transform import rescale
from tests.export.native_source import written


def components(x: Tensor) -> Tensor:
    return torch.stack([x[..., 0] * x[..., 2], x[..., 1] + 2.0 * x[..., -1]], -1)


def overlapping(x: Tensor) -> Tensor:
    """Slices with overlaps and a gap, and all of x."""
    return (x[..., :2] * x[..., 1:3]).sum(-1) + x[..., 4] * x[:, 0, 4:5] + (x * x).sum(-1)


def along_rows(x: Tensor) -> Tensor:
    return x[:, 0] * x[:, 3] - x[:, 1, :]


def of_a_part(x: Tensor) -> Tensor:
    """The gradient of a part is itself joined from parts."""
    y = x[..., :3]
    return y[..., 0] * y[..., 1] * y[..., 2] + x[..., 3]


def rescaled(input: Tensor) -> Tensor:
    return rescale(input, (1.5, 0.7), antialias=True)


def traced(function, spec: Spec):
    """A function's eager vjp, its traced vjp, and inputs of other sizes than in the trace."""
    op = bind(function, {t.name: f"{t.name}={t.name}" for t in spec.inputs}, {}, spec.name)
    example = example_inputs.make(spec, example_inputs.fit(spec, example_inputs.EXAMPLE), "float32")
    outputs = output_specs(trace(op, spec, list(spec.inputs), example, "onnx"), spec, "float32")
    tensors, _ = vjp_signature(spec, outputs)
    pullback = vjp_module(op, spec, outputs)
    sizes = example_inputs.fit(spec, example_inputs.EXAMPLE)
    program = trace_vjp(pullback, spec, tensors, with_cotangents(op, spec, sizes, "float32", tensors))
    other = with_cotangents(op, spec, example_inputs.fit(spec, example_inputs.GOLDEN), "float32", tensors)
    return pullback, program, other


@pytest.mark.parametrize(
    ("function", "shape"),
    [(components, ("N", 4)), (overlapping, ("N", 3, 5)), (along_rows, ("N", 4, "M")), (of_a_part, ("N", 4))],
)
def test_parts_are_joined(function, shape) -> None:
    spec = Spec("test.parts", [TensorSpec("x", shape, range=(-1, 1))], symbols={"N": (2, 100), "M": (2, 100)})
    pullback, program, other = traced(function, spec)
    targets = [n.target for n in program.graph.nodes]
    assert torch.ops.aten.cat.default in targets
    assert torch.ops.aten.select_backward.default not in targets
    expected = pullback(*other.values())
    actual = program.module()(*other.values())
    for a, e in zip(actual, expected, strict=True):
        torch.testing.assert_close(a, e)


def turned(x: Tensor) -> Tensor:
    """Planes; each step uses each of them twice."""
    red, green, blue = x.select(-3, 0), x.select(-3, 1), x.select(-3, 2)
    most = torch.maximum(torch.maximum(red, green), blue)
    for _ in range(3):
        red, green, blue = (
            torch.where(most == red, red * green, blue),
            torch.where(most == green, green * blue, red),
            torch.where(most == blue, blue * red, green),
        )
    return torch.stack([red, green, blue], -3)


def test_weighted_sums_whose_number_of_terms_is_symbolic() -> None:
    """The size of the result is made of the image's alone, so the tracer must prove what it assumes of it."""
    spec = Spec("test.rescaled", [image()], symbols={"H": (8, 4096), "W": (8, 4096)})
    pullback, program, other = traced(rescaled, spec)
    for actual, expected in zip(program.module()(*other.values()), pullback(*other.values()), strict=True):
        torch.testing.assert_close(actual, expected)


def test_native_loops_of_planes_are_short(monkeypatch) -> None:
    symbols = {"B": (1, 100), "H": (2, 1000), "W": (2, 1000)}
    spec = Spec("test.planes", [TensorSpec("x", ("B", 3, "H", "W"))], symbols=symbols)
    _, program, _ = traced(turned, spec)
    source = written(program, spec, monkeypatch, gradient=True)
    assert "transpose_mxn" not in source  # planes are stored as planes
    assert len(source) < 100_000
