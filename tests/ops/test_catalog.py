"""Properties of every op in the catalog, from its spec alone: it scripts, its forms for targets agree, its
gradient is right."""

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from chiasm.export import example_inputs
from chiasm.export.catalog import Entry, catalog
from chiasm.export.tracing.module import bind_spec
from chiasm.primitives.core.target import exporting

ENTRIES = catalog()
#: The entries, also with each of the variants that a spec defines.
VARIANTS = ENTRIES | {
    f"{name} {settings}": replace(entry, spec=replace(entry.spec, config=entry.spec.config | settings))
    for name, entry in ENTRIES.items()
    for settings in entry.spec.also
}
SIZES = (example_inputs.TESTS[0], {"B": 2, "C": 7, "H": 21, "W": 18, "N": 9, "OH": 8, "OW": 11})
SMALL = {"B": 2, "C": 3, "H": 9, "W": 8, "N": 5, "OH": 6, "OW": 7}
TARGETS = ("onnx", "native", "vjp")

every_op = pytest.mark.parametrize("entry", VARIANTS.values(), ids=VARIANTS)


def module(entry: Entry) -> torch.nn.Module:
    spec = entry.spec
    return bind_spec(entry.function(), spec)


def arguments(entry: Entry, sizes: dict[str, int], dtype: str) -> list[Tensor]:
    """The spec's inputs, in `dtype` if the op is generic."""
    made = example_inputs.make(entry.spec, example_inputs.fit(entry.spec, sizes), dtype)
    return list(made.values())


def outputs(result: object) -> tuple[Tensor, ...]:
    return (result,) if isinstance(result, Tensor) else tuple(result)


def assert_same(actual: object, expected: object, tolerance: float) -> None:
    for a, e in zip(outputs(actual), outputs(expected), strict=True):
        torch.testing.assert_close(a, e, rtol=tolerance, atol=tolerance, equal_nan=True)


@every_op
def test_script_equals_eager(entry: Entry) -> None:
    eager = module(entry)
    scripted = torch.jit.script(eager)
    for sizes in SIZES:
        inputs = arguments(entry, sizes, "float32")
        expected = eager(*inputs)
        for _ in range(2):  # the profiling executor specialises after the first run
            assert_same(scripted(*inputs), expected, 1e-5)


@every_op
def test_target_forms_equal_eager(entry: Entry) -> None:
    eager = module(entry)
    for sizes in SIZES:
        inputs = arguments(entry, sizes, "float64")
        expected = eager(*inputs)
        for target in TARGETS:
            with exporting(target):
                assert_same(eager(*inputs), expected, 1e-9)


DIFFERENTIABLE = {name: e for name, e in VARIANTS.items() if e.spec.differentiated()}


@pytest.mark.parametrize("entry", DIFFERENTIABLE.values(), ids=DIFFERENTIABLE)
def test_gradient(entry: Entry) -> None:
    eager, names = module(entry), [t.name for t in entry.spec.inputs]
    inputs = arguments(entry, SMALL, "float64")
    positions = [names.index(t) for t in entry.spec.differentiated()]

    def call(*active: Tensor) -> tuple[Tensor, ...]:
        full = list(inputs)
        for position, value in zip(positions, active, strict=True):
            full[position] = value
        return tuple(o for o in outputs(eager(*full)) if o.requires_grad)

    active = [inputs[p].clone().requires_grad_(True) for p in positions]
    assert torch.autograd.gradcheck(call, active, eps=1e-6, atol=1e-5, rtol=1e-3, fast_mode=True)


def is_of_images(entry: Entry) -> bool:
    """Whether an op takes and returns images of the type variable."""
    spec = entry.spec
    first, last = spec.inputs[0], spec.outputs[-1]
    return first.layout == "NCHW" and first.dtype == "T" and last.layout == "NCHW"


IMAGES = {name: e for name, e in VARIANTS.items() if is_of_images(e)}


@pytest.mark.parametrize("dtype", ["float64", "float16", "bfloat16"])
@pytest.mark.parametrize("entry", IMAGES.values(), ids=IMAGES)
def test_dtype_is_kept(entry: Entry, dtype: str) -> None:
    plain, result = (outputs(module(entry)(*arguments(entry, SMALL, d)))[-1] for d in ("float32", dtype))
    assert result.dtype == (getattr(torch, dtype) if plain.is_floating_point() else plain.dtype)
    assert torch.isfinite(result).all()
