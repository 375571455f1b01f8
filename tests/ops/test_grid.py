"""Grids of coordinates against numpy.meshgrid and torch's own affine_grid."""

import numpy as np
import pytest
import torch
from torch import Tensor
from torch.nn import functional

from chiasm.geometry.grid import create_meshgrid, create_meshgrid3d

SIZES = [(4, 7), (1, 5), (5, 1), (1, 1)]


@pytest.mark.parametrize(("height", "width"), SIZES)
def test_pixels(height: int, width: int) -> None:
    expected = np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1)[None]
    for align_corners in (True, False):
        made = create_meshgrid(height, width, False, dtype=torch.float64, align_corners=align_corners)
        np.testing.assert_array_equal(made, expected)


@pytest.mark.parametrize("align_corners", [True, False])
@pytest.mark.parametrize(("height", "width"), SIZES)
def test_normalised_is_affine_grid_of_the_identity(height: int, width: int, align_corners: bool) -> None:
    eye = torch.eye(2, 3, dtype=torch.float64)[None]
    expected = functional.affine_grid(eye, [1, 1, height, width], align_corners)
    made = create_meshgrid(height, width, dtype=torch.float64, align_corners=align_corners)
    torch.testing.assert_close(made, expected, rtol=0, atol=1e-15)


def test_volume() -> None:
    z, x, y = np.arange(2), np.arange(4), np.arange(3)
    expected = np.stack(np.meshgrid(z, y, x, indexing="ij"), -1)[..., [0, 2, 1]][None]
    np.testing.assert_array_equal(create_meshgrid3d(2, 3, 4, False), expected)
    np.testing.assert_allclose(
        create_meshgrid3d(2, 3, 4, dtype=torch.float64), 2.0 * expected / [1, 3, 2] - 1.0, atol=1e-15
    )
    assert create_meshgrid3d(1, 1, 1).tolist() == [[[[[0.0, 0.0, 0.0]]]]]


def test_dtype() -> None:
    assert create_meshgrid(2, 3).dtype == torch.float32
    assert create_meshgrid3d(2, 3, 4, dtype=torch.float16).dtype == torch.float16


def test_scripts() -> None:
    torch.testing.assert_close(
        torch.jit.script(create_meshgrid)(4, 5, True, None, torch.float64, False),
        create_meshgrid(4, 5, dtype=torch.float64, align_corners=False),
    )
    torch.testing.assert_close(torch.jit.script(create_meshgrid3d)(2, 4, 5), create_meshgrid3d(2, 4, 5))


class Grids(torch.nn.Module):
    """An op that makes a grid of its image's size."""

    def forward(self, image: Tensor) -> Tensor:
        height, width = image.size(0), image.size(1)
        return create_meshgrid(height, width) * create_meshgrid(
            height, width, align_corners=False
        ) + create_meshgrid(height, width, False)


def test_sizes_stay_symbolic() -> None:
    dims = {"image": {0: torch.export.Dim("H", min=1, max=999), 1: torch.export.Dim("W", min=1, max=999)}}
    exported = torch.export.export(Grids(), (torch.zeros(7, 5),), dynamic_shapes=dims).module()
    for shape in ((7, 5), (20, 3), (1, 1), (1, 30)):
        torch.testing.assert_close(exported(torch.zeros(shape)), Grids()(torch.zeros(shape)))


def test_errors() -> None:
    with pytest.raises(ValueError, match=r"height, width: expected positive sizes, got \(0, 3\)"):
        create_meshgrid(0, 3)
    with pytest.raises(ValueError, match=r"depth, height, width: expected positive sizes, got \(2, 3, 0\)"):
        create_meshgrid3d(2, 3, 0)
