"""Means, standard deviations, extrema and their positions."""

import cv2
import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm.enhance import MeanStdDev, mean_std_dev, min_max_loc
from chiasm.primitives.numbers.reductions import extreme_indices


def noise(dtype: str, channels: int = 3, size: tuple[int, int] = (37, 53)) -> np.ndarray:
    rng = np.random.default_rng(5)
    shape = (2, channels, *size)
    return (
        rng.integers(0, 256, shape, np.uint8) if dtype == "uint8" else rng.normal(3, 2, shape).astype(dtype)
    )


def frames(x: Tensor) -> Tensor:
    """The same images, stored pixel by pixel."""
    return x.contiguous(memory_format=torch.channels_last)


@pytest.mark.parametrize("stored", [torch.Tensor.contiguous, frames])
@pytest.mark.parametrize("dtype", ["uint8", "float32", "float64"])
def test_means_and_deviations_are_opencv_s(dtype: str, stored) -> None:
    x = noise(dtype)
    mean, std = mean_std_dev(stored(torch.from_numpy(x)))
    for b in range(len(x)):
        wanted = cv2.meanStdDev(x[b].transpose(1, 2, 0).copy())
        # bytes and doubles are exact
        close = {"rtol": 2e-6 if dtype == "float32" else 1e-12}
        np.testing.assert_allclose(mean[b], wanted[0][:, 0], **close)
        np.testing.assert_allclose(std[b], wanted[1][:, 0], **close)


def test_a_deviation_far_below_the_mean() -> None:
    x = 1e6 + noise("float64")
    np.testing.assert_allclose(mean_std_dev(torch.from_numpy(x))[1], x.std((2, 3)), rtol=1e-9)
    white = torch.full((1, 1, 300, 400), 255, dtype=torch.uint8)
    assert mean_std_dev(white)[0].tolist() == [[255.0]] and mean_std_dev(white)[1].tolist() == [[0.0]]
    assert MeanStdDev()(white)[0].dtype == torch.float64


def test_gradient_of_a_constant_plane_is_zero_as_torch_s() -> None:
    x = torch.from_numpy(noise("float64"))
    x[0, 1], x[1, 2] = 0.5, 0.0
    x.requires_grad_(True)
    weights = torch.tensor([[1.0, 2.0, 3.0], [-1.0, 5.0, 7.0]], dtype=torch.float64)
    (actual,) = torch.autograd.grad((mean_std_dev(x)[1] * weights).sum(), x)
    (wanted,) = torch.autograd.grad((x.std((2, 3), correction=0) * weights).sum(), x)
    assert not actual[0, 1].any() and not actual[1, 2].any()
    np.testing.assert_allclose(actual, wanted, rtol=1e-9, atol=1e-15)
    nan = torch.tensor([[[[float("nan"), 1.0]]]], requires_grad=True)
    assert torch.autograd.grad(mean_std_dev(nan)[1].sum(), nan)[0].isnan().all()


@pytest.mark.parametrize("stored", [torch.Tensor.contiguous, frames])
@pytest.mark.parametrize("dtype", ["uint8", "float32", "float64"])
def test_extremes_and_places_are_opencv_s(dtype: str, stored) -> None:
    x = noise(dtype)  # in bytes, the extrema occur several times
    least, greatest, least_at, greatest_at = min_max_loc(stored(torch.from_numpy(x)))
    for b, c in np.ndindex(x.shape[:2]):
        wanted = cv2.minMaxLoc(x[b, c])
        assert (least[b, c].item(), greatest[b, c].item()) == wanted[:2]
        assert (tuple(least_at[b, c].tolist()), tuple(greatest_at[b, c].tolist())) == wanted[2:]


def test_nan_is_passed_over() -> None:
    nan, inf = float("nan"), float("inf")
    x = torch.tensor([[nan, 2.0, 2.0, -1.0], [nan, nan, nan, nan], [nan, inf, inf, inf]]).reshape(1, 3, 2, 2)
    least, greatest, least_at, greatest_at = min_max_loc(x)
    assert (least[0, 0].item(), greatest[0, 0].item()) == (-1.0, 2.0)
    assert (least_at[0, 0].tolist(), greatest_at[0, 0].tolist()) == ([1, 1], [1, 0])
    assert least[0, 1].isnan() and greatest[0, 1].isnan() and least_at[0, 1].tolist() == [0, 0]
    assert (least[0, 2].item(), greatest[0, 2].item()) == (inf, inf)
    assert least_at[0, 2].tolist() == greatest_at[0, 2].tolist() == [1, 0]
    mean, std = mean_std_dev(x)
    assert mean.isnan().tolist() == [[True, True, True]] and std.isnan().all()


def test_images_without_pixels() -> None:
    for op in (mean_std_dev, min_max_loc):
        with pytest.raises(ValueError, match=r"image: expected sizes of at least 1, got \[1, 3, 0, 4\]"):
            op(torch.zeros(1, 3, 0, 4))
        with pytest.raises(TypeError, match="image"):
            op(torch.zeros(1, 3, 2, 2, dtype=torch.int64))


@pytest.mark.parametrize("dtype", [np.uint8, np.int16, np.uint16])
def test_where_extremes_of_integers_are(dtype: type) -> None:
    x = np.random.default_rng(6).integers(0, 40, (2, 3, 8, 9)).astype(dtype)
    x[0, 0, 3, 4] = np.iinfo(dtype).max
    expected = np.stack([x.reshape(2, 3, -1).argmin(2), x.reshape(2, 3, -1).argmax(2)], 2)
    np.testing.assert_array_equal(extreme_indices(torch.from_numpy(x)), expected)
