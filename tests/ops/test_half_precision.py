"""Losses and similarities of float16 and bfloat16, of images as large as those of training, are what float64
gives for the same numbers, rounded once."""

import inspect
from collections.abc import Callable

import pytest
import torch
from torch import Tensor

from chiasm import losses, metrics

SIZE = 300
#: Twice what rounding the result changes.
DTYPES = {torch.float16: 1e-3, torch.bfloat16: 8e-3}


def rand(*shape: int, seed: int = 0) -> Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


PLANES = (rand(1, 1, SIZE, SIZE), rand(1, 1, SIZE, SIZE, seed=1))
BRIGHT = tuple(255.0 * plane for plane in PLANES)
#: Neighbours of float16: the squares of their differences are below its least number.
DARK = (PLANES[0] / 16.0, PLANES[0] / 16.0 + 2.0**-14)
VOLUMES = tuple(255.0 * rand(1, 1, 6, SIZE, SIZE, seed=seed) for seed in (2, 3))
#: Many of the numbers are near the least of float16, and some are below it.
HEATMAPS = tuple(2.0 * plane**4 / (SIZE * SIZE) for plane in PLANES)
LOGITS = 6.0 * rand(1, 3, SIZE, SIZE, seed=4) - 3.0
LABELS = torch.randint(0, 3, (1, SIZE, SIZE), generator=torch.Generator().manual_seed(5))
MARKS = losses.one_hot(LABELS, 3, dtype=torch.int64)

CASES: dict[str, tuple[Callable[..., Tensor], tuple[Tensor, ...]]] = {
    "binary_focal_loss_with_logits": (
        lambda p: losses.binary_focal_loss_with_logits(p, MARKS, reduction="mean"),
        (LOGITS,),
    ),
    "cauchy_loss": (losses.cauchy_loss, BRIGHT),
    "charbonnier_loss": (losses.charbonnier_loss, BRIGHT),
    "dice_loss": (lambda p: losses.dice_loss(p, LABELS), (LOGITS,)),
    "dice_loss macro": (lambda p: losses.dice_loss(p, LABELS, "macro"), (LOGITS,)),
    "focal_loss": (lambda p: losses.focal_loss(p, LABELS, 0.25, reduction="mean"), (LOGITS,)),
    "focal_loss none": (lambda p: losses.focal_loss(p, LABELS, 0.25), (LOGITS,)),
    "geman_mcclure_loss": (losses.geman_mcclure_loss, BRIGHT),
    "hausdorff_er_loss": (lambda p: losses.hausdorff_er_loss(p, LABELS[:, None]), (LOGITS.softmax(1),)),
    "hausdorff_er_loss map": (
        lambda p: losses.hausdorff_er_loss(p, LABELS[:, None], reduction="none"),
        (LOGITS.softmax(1),),
    ),
    "hausdorff_er_loss3d": (
        lambda p: losses.hausdorff_er_loss3d(p, LABELS[:, None, None].expand(-1, -1, 6, -1, -1), k=4),
        (VOLUMES[0].expand(-1, 3, -1, -1, -1) / 255.0,),
    ),
    "inverse_depth_smoothness_loss": (losses.inverse_depth_smoothness_loss, PLANES),
    "js_div_loss_2d": (losses.js_div_loss_2d, HEATMAPS),
    "kl_div_loss_2d": (losses.kl_div_loss_2d, (HEATMAPS[0] + 2.0**-20, HEATMAPS[1])),
    "lovasz_hinge_loss": (lambda p: losses.lovasz_hinge_loss(p[:, :1], LABELS), (LOGITS,)),
    "lovasz_softmax_loss": (lambda p: losses.lovasz_softmax_loss(p, LABELS), (LOGITS,)),
    "ms_ssim_loss": (lambda p, q: losses.ms_ssim_loss(p, q, data_range=255.0), BRIGHT),
    "ms_ssim_loss map": (lambda p, q: losses.ms_ssim_loss(p, q, reduction="none"), PLANES),
    "mutual_information_loss": (
        lambda p, q: losses.mutual_information_loss(p.flatten(1), q.flatten(1)),
        PLANES,
    ),
    "mutual_information_loss_2d": (losses.mutual_information_loss_2d, PLANES),
    "mutual_information_loss_3d": (losses.mutual_information_loss_3d, VOLUMES),
    "normalized_mutual_information_loss": (
        lambda p, q: losses.normalized_mutual_information_loss(p.flatten(1), q.flatten(1)),
        PLANES,
    ),
    "normalized_mutual_information_loss_2d": (losses.normalized_mutual_information_loss_2d, PLANES),
    "normalized_mutual_information_loss_3d": (losses.normalized_mutual_information_loss_3d, VOLUMES),
    "psnr_loss": (lambda p, q: losses.psnr_loss(p, q, 1.0), DARK),
    "ssim3d_loss": (lambda p, q: losses.ssim3d_loss(p, q, 5, 255.0), VOLUMES),
    "ssim_loss": (lambda p, q: losses.ssim_loss(p, q, 11, 255.0), BRIGHT),
    "total_variation": (losses.total_variation, (PLANES[0] / 2.0,)),
    "tversky_loss": (lambda p: losses.tversky_loss(p, LABELS, 0.3, 0.7), (LOGITS,)),
    "tversky_loss micro": (lambda p: losses.tversky_loss(p, LABELS, 0.3, 0.7, average="micro"), (LOGITS,)),
    "welsch_loss": (losses.welsch_loss, PLANES),
    "metrics.psnr": (lambda p, q: metrics.psnr(p, q, 1.0), DARK),
    "metrics.ssim": (lambda p, q: metrics.ssim(p, q, 11, 255.0), BRIGHT),
    "metrics.ssim dark": (lambda p, q: metrics.ssim(p, q, 11), DARK),
    "metrics.ssim3d": (lambda p, q: metrics.ssim3d(p, q, 5, 255.0), VOLUMES),
}


def test_every_loss_is_here() -> None:
    functions = {name for name in losses.__all__ if inspect.isfunction(getattr(losses, name))}
    assert functions - {"one_hot"} == {name.partition(" ")[0] for name in CASES if "." not in name}


@pytest.mark.parametrize(("dtype", "tolerance"), DTYPES.items(), ids=str)
@pytest.mark.parametrize(("loss", "given"), CASES.values(), ids=CASES)
def test_half_precision_is_float64_rounded(
    loss: Callable[..., Tensor], given: tuple[Tensor, ...], dtype: torch.dtype, tolerance: float
) -> None:
    narrow = [value.to(dtype).requires_grad_() for value in given]
    exact = loss(*[value.detach().double() for value in narrow])
    actual = loss(*narrow)
    assert actual.dtype == dtype
    torch.testing.assert_close(actual.double(), exact, rtol=tolerance, atol=1e-6)
    actual.float().mean().backward()
    for value in narrow:
        assert torch.isfinite(value.grad).all()
