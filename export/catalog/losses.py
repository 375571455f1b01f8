"""Losses."""

from ..spec import Spec, TensorSpec, image
from . import add

add(Spec(
    "losses.ssim_loss",
    [image("img1"), image("img2")],
    [TensorSpec("loss", description="mean of (1 - SSIM) / 2")],
    config={"window_size": 11, "max_val": 1.0},
    symbols={"H": (16, 32768), "W": (16, 32768)},
    reference="scikit-image structural_similarity (gaussian weights)",
))
