"""SSIM against scikit-image."""

import numpy as np
import pytest
import torch
from photos import photo
from skimage.metrics import structural_similarity

from chiasm.losses import ssim_loss
from chiasm.metrics import ssim


@pytest.mark.parametrize("channels", [1, 3, 5])
@pytest.mark.parametrize("max_val", [1.0, 255.0])
def test_equals_skimage(channels: int, max_val: float) -> None:
    x = photo(2, channels, 40, 51, torch.float64) * max_val
    y = x.roll(1, 3) * 0.9 + 0.03 * max_val
    actual = ssim(x, y, 11, max_val)
    for b in range(2):
        for c in range(channels):
            _, expected = structural_similarity(
                x[b, c].numpy(),
                y[b, c].numpy(),
                data_range=max_val,
                gaussian_weights=True,
                sigma=1.5,
                use_sample_covariance=False,
                full=True,
            )
            # scikit-image repeats the edge pixel, chiasm reflects about it; inside, the windows are the same.
            np.testing.assert_allclose(actual[b, c, 5:-5, 5:-5], expected[5:-5, 5:-5], atol=1e-9)
    assert torch.equal(ssim(x, y, 11, max_val, padding="valid"), actual[:, :, 5:-5, 5:-5])


def test_loss_reductions() -> None:
    x = photo(2, 3, 20, 21, torch.float64)
    y = 1.0 - x
    expected = ((1.0 - ssim(x, y, 5)) / 2.0).clamp(0.0, 1.0)
    torch.testing.assert_close(ssim_loss(x, y, 5, reduction="none"), expected)
    torch.testing.assert_close(ssim_loss(x, y, 5), expected.mean())
    torch.testing.assert_close(ssim_loss(x, y, 5, reduction="sum"), expected.sum())
    assert ssim_loss(x, x, 5).item() == pytest.approx(0.0, abs=1e-7)  # eps
    assert expected.max() <= 1.0 and expected.mean() > 0.3
