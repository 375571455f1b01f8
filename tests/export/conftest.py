"""Small bundles that the tests of the exporter share.

If a file of tests and what it tests have not changed since the base, only every sixth such file runs; `make
test-all` runs all.
"""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image
from torch import Tensor

from chiasm.export import Spec, TensorSpec, export, image
from chiasm.export.catalog import catalog
from tests.changes import leave_out
from tests.stages import runs


def scaled_difference(input: Tensor, gain: Tensor, power: float = 1.0) -> Tensor:
    """Differences of neighbouring rows, scaled per image."""
    difference = input[:, :, 1:] - input[:, :, :-1]
    return (difference * gain[:, None, None, None]).abs() ** power


SPEC = Spec(
    "test.scaled_difference",
    [image(), TensorSpec("gain", ("B",), range=(0.5, 2.0))],
    [TensorSpec("output", layout="NCHW")],
    config={"power": 2.0},
    symbols={"H": (4, 4096), "W": (4, 4096)},
)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    leave_out(config, items, Path(__file__).parent, runs)


@pytest.fixture(scope="session")
def bundle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bundle of a user's own function, in every format."""
    torch.manual_seed(0)
    return export(scaled_difference, SPEC, tmp_path_factory.mktemp("bundles"))


@pytest.fixture(scope="session")
def light(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Bundles by name, of the function above or of the catalog, exported at their first use, without native
    code."""
    folder = tmp_path_factory.mktemp("light")
    made: dict[str, Path] = {}

    def get(name: str) -> Path:
        if name not in made:
            fn, spec = (
                (scaled_difference, SPEC)
                if name == SPEC.name
                else (catalog()[name].function(), catalog()[name].spec)
            )
            made[name] = export(fn, spec, folder, formats=["torchscript", "onnx"])
        return made[name]

    return get


@pytest.fixture(scope="session")
def photo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("photo") / "photo.png"
    values = np.random.default_rng(0).integers(0, 256, (24, 31, 3), np.uint8)
    Image.fromarray(values).save(path)
    return path


@pytest.fixture
def sobel(light: Callable[[str], Path], tmp_path: Path) -> Path:
    """A copy of a bundle that a test may damage."""
    return Path(shutil.copytree(light("filters.sobel"), tmp_path / "copy" / "filters.sobel.chiasm"))
