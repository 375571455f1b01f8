"""The nn.Module classes: every op of the catalog has one, it scripts, and it does what the function does."""

import importlib
import inspect

import numpy as np
import pytest
import torch
from test_catalog import arguments, assert_same

from chiasm import enhance
from chiasm.export.catalog import Entry, catalog
from chiasm.filters import BilateralBlur, GaussianBlur2d
from chiasm.primitives.core.modules import class_name

SIZES = {"B": 2, "C": 3, "H": 19, "W": 22, "N": 9, "OH": 8, "OW": 11}


def family(entry: Entry) -> str:
    """The package in which the op is a public function, or ""."""
    function = entry.function()
    package = function.__module__.rpartition(".")[0]
    public = getattr(importlib.import_module(package), "__all__", ())
    return (
        package
        if function.__name__ in public and hasattr(importlib.import_module(package), "__getattr__")
        else ""
    )


# Kornia's Affine takes angles and factors, not a matrix: test_geometry_modules.py; its KMeans has a fit
# method: test_switching.py
OWN_CLASS = {"contrib.kmeans", "geometry.transform.affine"}
# A form for frames belongs to the same class.
OPS = {name: entry for name, entry in catalog().items() if not entry.spec.interleaved}
WITH_TWIN = {name: entry for name, entry in OPS.items() if family(entry) and name not in OWN_CLASS}


def given_to(entry: Entry) -> dict[str, object]:
    """The function's arguments from the spec's inputs."""
    given: dict[str, object] = {}
    for tensor, value in zip(entry.spec.inputs, arguments(entry, SIZES, "float32"), strict=True):
        if len(tensor.sizes) == 1:
            given[tensor.sizes[0]] = tuple(value.shape)
        elif tensor.sizes:
            given |= dict(zip(tensor.sizes, value.shape, strict=True))
        else:
            given[tensor.name] = value
    return given


@pytest.mark.parametrize("entry", WITH_TWIN.values(), ids=WITH_TWIN)
def test_module_scripts_and_equals_the_function(entry: Entry) -> None:
    function = entry.function()
    given = given_to(entry)
    made = getattr(importlib.import_module(family(entry)), class_name(function.__name__))
    tensors = list(inspect.signature(made.forward).parameters)[1:]
    settings = entry.spec.config | {n: v for n, v in given.items() if n not in tensors}
    module = made(**{made.form.names.get(n, n): v for n, v in settings.items()})
    forward = [given[n] for n in tensors]
    expected = function(**{**made.form.defaults, **given, **entry.spec.config})
    assert_same(module(*forward), expected, 0.0)
    assert_same(torch.jit.script(module)(*forward), expected, 1e-5)


def test_no_op_on_images_is_without() -> None:
    families = ("color.", "enhance.", "filters.", "morphology.")
    assert [name for name in OPS if name.startswith(families) and name not in WITH_TWIN] == []


def test_constructor_looks_like_the_function() -> None:
    assert list(inspect.signature(GaussianBlur2d).parameters) == [
        "kernel_size",
        "sigma",
        "border_type",
        "separable",
    ]
    assert GaussianBlur2d.__module__ == "chiasm.filters"
    with pytest.raises(TypeError, match="sigma"):
        GaussianBlur2d((3, 3))


def test_whole_numbers_stand_for_floats() -> None:
    blur = torch.jit.script(GaussianBlur2d(3, (1, 2)))
    assert blur(torch.ones(1, 2, 5, 6)).shape == (1, 2, 5, 6)


def test_a_tensor_setting_moves_with_the_module() -> None:
    blur = BilateralBlur(3, torch.tensor([0.1]), (1.0, 1.0)).double()
    assert blur.sigma_color.dtype == torch.float64
    assert not blur.state_dict()


def test_a_learned_setting_is_a_parameter() -> None:
    blur = BilateralBlur(3, torch.nn.Parameter(torch.tensor([0.1])), (1.0, 1.0))
    assert [name for name, _ in blur.named_parameters()] == ["sigma_color"]


def test_unknown_class() -> None:
    with pytest.raises(ImportError, match="Sobell"):
        from chiasm.filters import Sobell  # noqa: F401


def test_a_module_that_multiplies() -> None:
    x = torch.rand(2, 3, dtype=torch.float64)
    for factor in (0.3, torch.tensor(0.3)):
        module = enhance.Rescale(factor)
        np.testing.assert_allclose(torch.jit.script(module)(x), x.numpy() * float(factor), rtol=1e-12)
    assert enhance.Rescale(0.5)(torch.tensor([3], dtype=torch.uint8)).item() == 1.5
    assert enhance.Rescale(torch.tensor(0.5)).to(torch.float16).factor.dtype == torch.float16
    with pytest.raises(ValueError, match=r"^factor: expected a tensor without dimensions, got \[1\]"):
        enhance.Rescale(torch.ones(1))
    with pytest.raises(TypeError, match=r"^factor: expected a number or a tensor, got str"):
        enhance.Rescale("2")  # pyright: ignore[reportArgumentType]
