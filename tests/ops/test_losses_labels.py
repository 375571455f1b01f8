"""Losses of segmentations against the papers' definitions in NumPy float64, PyTorch's cross entropies,
torchmetrics and SciPy."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import scipy.ndimage
import scipy.special
import torch
import torch.nn.functional as F
from torch import Tensor
from torchmetrics.functional.segmentation import dice_score

from chiasm import losses

SHAPES = [(1, 3, 17, 23), (3, 5, 13, 19), (1, 2, 31)]
X = torch.rand(1, 3, 4, 5)
Y = torch.ones(1, 4, 5, dtype=torch.int64)
IGNORED = -100

sizes = pytest.mark.parametrize("shape", SHAPES, ids=str)


def segmentation(shape: tuple[int, ...], ignored: float = 0.2) -> tuple[Tensor, Tensor, Tensor]:
    """Logits, labels, and weights of the classes."""
    generator = torch.Generator().manual_seed(shape[1])
    logits = 4.0 * torch.randn(shape, generator=generator, dtype=torch.float64)
    labels = torch.randint(0, shape[1], (shape[0], *shape[2:]), generator=generator)
    left_out = torch.rand(labels.shape, generator=generator) < ignored
    return (
        logits,
        torch.where(left_out, IGNORED, labels),
        0.5 + torch.rand(shape[1], generator=generator, dtype=torch.float64),
    )


def class_rows(logits: Tensor, labels: Tensor) -> list[tuple[np.ndarray, np.ndarray]]:
    """For each sample, the softmax (C, pixels) and the classes' masks at the pixels that count."""
    rows = []
    for z, t in zip(logits.flatten(2).numpy(), labels.flatten(1).numpy(), strict=True):
        kept = t != IGNORED
        rows.append((scipy.special.softmax(z, 0)[:, kept], t[kept] == np.arange(len(z))[:, None]))
    return rows


# --- what is ignored ----------------------------------------------------------------------------------------

IGNORING = {
    "dice": lambda p, t: losses.dice_loss(p, t),
    "dice macro": lambda p, t: losses.dice_loss(p, t, "macro"),
    "tversky": lambda p, t: losses.tversky_loss(p, t, 0.3, 0.7),
    "tversky micro": lambda p, t: losses.tversky_loss(p, t, 0.3, 0.7, average="micro"),
    "focal": lambda p, t: losses.focal_loss(p, t, 0.25, reduction="sum"),
    "binary focal": lambda p, t: losses.binary_focal_loss_with_logits(
        p, torch.where(t[:, None] == IGNORED, IGNORED, losses.one_hot(t, p.size(1))), reduction="sum"
    ),
}


@pytest.mark.parametrize("loss", IGNORING.values(), ids=IGNORING)
def test_ignored_pixels_change_nothing(loss: Callable[[Tensor, Tensor], Tensor]) -> None:
    pred, target, _ = segmentation((1, 4, 40))
    kept = target[0] != IGNORED
    wild = torch.where(
        kept, pred, torch.tensor([1e300, float("nan")], dtype=torch.float64).repeat(20)
    ).requires_grad_(True)
    few = pred[..., kept].clone().requires_grad_(True)
    actual, expected = loss(wild, target), loss(few, target[:, kept])
    torch.testing.assert_close(actual, expected)
    (whole,) = torch.autograd.grad(actual, wild)
    (part,) = torch.autograd.grad(expected, few)
    torch.testing.assert_close(whole[..., kept], part)
    assert torch.equal(whole[..., ~kept], torch.zeros_like(whole[..., ~kept]))


@pytest.mark.parametrize("loss", IGNORING.values(), ids=IGNORING)
def test_all_ignored_has_no_gradient(loss: Callable[[Tensor, Tensor], Tensor]) -> None:
    pred = torch.rand(2, 3, 7, requires_grad=True)
    value = loss(pred, torch.full((2, 7), IGNORED))
    value.backward()
    assert torch.isfinite(value)
    assert torch.equal(pred.grad, torch.zeros_like(pred))


def test_ignore_index_may_be_a_label_or_none() -> None:
    pred, target, _ = segmentation((1, 3, 30), ignored=0.0)
    for loss in (
        losses.dice_loss,
        lambda p, t, ignore_index: losses.focal_loss(p, t, None, reduction="mean", ignore_index=ignore_index),
    ):
        torch.testing.assert_close(
            loss(pred, target.to(torch.uint8), ignore_index=1),
            loss(pred, torch.where(target == 1, -100, target), ignore_index=-100),
        )
        torch.testing.assert_close(
            loss(pred, target, ignore_index=None), loss(pred, target.to(torch.uint8), ignore_index=-100)
        )
    # as a byte, -100 would be 156
    assert (
        losses.binary_focal_loss_with_logits(torch.zeros(1), torch.tensor([156], dtype=torch.uint8)).item()
        != 0.0
    )


# --- overlap ------------------------------------------------------------------------------------------------


@sizes
@pytest.mark.parametrize("weighted", [False, True])
def test_dice_equals_the_formula(shape: tuple[int, ...], weighted: bool) -> None:
    pred, target, weight = segmentation(shape)
    w = weight.numpy() if weighted else np.ones(shape[1])
    micro, macro = [], []
    for p, g in class_rows(pred, target):
        both, all = 2 * (p * g).sum(1), p.sum(1) + g.sum(1)
        micro.append(1 - (w * both).sum() / (w * all).sum())
        macro.append(1 - np.average(both / all, weights=w))
    given = weight if weighted else None
    assert losses.dice_loss(pred, target, weight=given).item() == pytest.approx(np.mean(micro), abs=1e-8)
    assert losses.dice_loss(pred, target, "macro", weight=given).item() == pytest.approx(
        np.mean(macro), abs=1e-8
    )
    assert losses.dice_loss(pred.float(), target, "macro", weight=given).item() == pytest.approx(
        np.mean(macro), abs=1e-6
    )


@sizes
def test_dice_of_sure_predictions_equals_torchmetrics(shape: tuple[int, ...]) -> None:
    pred, target, _ = segmentation(shape, ignored=0.0)
    found = pred.argmax(1)
    sure = 1e4 * losses.one_hot(found, shape[1], dtype=torch.float64)
    for average in ("micro", "macro"):
        planes = [losses.one_hot(t, shape[1], dtype=torch.int64) for t in (found, target)]
        expected = dice_score(
            *planes,
            num_classes=shape[1],
            average=average,
            input_format="one-hot",
            aggregation_level="samplewise",
        )
        assert losses.dice_loss(sure, target, average).item() == pytest.approx(
            1 - expected.mean().item(), abs=1e-6
        )


@sizes
def test_tversky_equals_the_formula(shape: tuple[int, ...]) -> None:
    pred, target, _ = segmentation(shape)
    macro = []
    for p, g in class_rows(pred, target):
        hit, false, missed = (p * g).sum(1), (p * ~g).sum(1), ((1 - p) * g).sum(1)
        macro.append(1 - (hit / (hit + 0.3 * false + 0.7 * missed)).mean())
    assert losses.tversky_loss(pred, target, 0.3, 0.7).item() == pytest.approx(np.mean(macro), abs=1e-8)
    for average in ("micro", "macro"):
        torch.testing.assert_close(
            losses.tversky_loss(pred, target, 0.5, 0.5, average=average),
            losses.dice_loss(pred, target, average),
        )


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float32, torch.float64])
@pytest.mark.parametrize("eps", [0.0, 1e-8])
@pytest.mark.parametrize("average", ["micro", "macro"])
def test_overlap_of_ignored_pixels_alone_is_a_loss_of_one(
    average: str, eps: float, dtype: torch.dtype
) -> None:
    target = torch.full((2, 4, 5), IGNORED)
    for loss in (
        lambda p: losses.dice_loss(p, target, average, eps),
        lambda p: losses.dice_loss(p, target, average, eps, torch.zeros(3)),
        lambda p: losses.tversky_loss(p, target, 0.3, 0.7, eps, average=average),
    ):
        pred = torch.ones(2, 3, 4, 5, dtype=dtype, requires_grad=True)
        value = loss(pred)
        value.backward()
        assert value.item() == 1.0 and value.dtype == dtype
        assert torch.equal(pred.grad, torch.zeros_like(pred))


def test_macro_leaves_absent_classes_out() -> None:
    pred = torch.randn(2, 4, 5, 6, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    target = torch.zeros(2, 5, 6, dtype=torch.int64)
    target[0, 2:], target[1] = 3, -100
    p = scipy.special.softmax(pred[0].numpy(), 0)
    dice, tversky = [], []
    for k in (0, 3):
        g = target[0].numpy() == k
        hit, false, missed = p[k][g].sum(), p[k][~g].sum(), (1 - p[k][g]).sum()
        dice.append(1 - 2 * hit / (p[k].sum() + g.sum()))
        tversky.append(1 - hit / (hit + 0.3 * false + 0.7 * missed))
    # no pixel of the second sample has a label
    assert losses.dice_loss(pred, target, "macro").item() == pytest.approx((np.mean(dice) + 1) / 2, abs=1e-8)
    loss = losses.tversky_loss(pred, target, 0.3, 0.7, eps=0.0)
    assert loss.item() == pytest.approx((np.mean(tversky) + 1) / 2, abs=1e-8)


# --- focal --------------------------------------------------------------------------------------------------


@sizes
@pytest.mark.parametrize(("alpha", "gamma"), [(0.25, 2.0), (None, 1.5), (0.7, 0.0)])
def test_focal_equals_the_formula(shape: tuple[int, ...], alpha: float | None, gamma: float) -> None:
    pred, target, weight = segmentation(shape)
    p = scipy.special.softmax(pred.numpy(), 1)
    expected = np.zeros(pred.shape)
    for at in np.ndindex(*target.shape):
        label = target[at].item()
        if label != IGNORED:
            plane = (at[0], label, *at[1:])
            balance = 1.0 if alpha is None else alpha if label > 0 else 1 - alpha
            expected[plane] = -balance * weight[label].item() * (1 - p[plane]) ** gamma * np.log(p[plane])
    np.testing.assert_allclose(
        losses.focal_loss(pred, target, alpha, gamma, weight=weight), expected, rtol=1e-8, atol=1e-12
    )
    assert losses.focal_loss(pred, target, alpha, gamma, "mean", weight).item() == pytest.approx(
        expected.mean()  # ignored pixels count, as in Kornia
    )
    assert losses.focal_loss(pred, target, alpha, gamma, "sum", weight).item() == pytest.approx(
        expected.sum()
    )
    np.testing.assert_allclose(
        losses.focal_loss(pred.float(), target, alpha, gamma, weight=weight), expected, rtol=1e-4, atol=1e-6
    )


@sizes
def test_focal_without_focus_is_cross_entropy(shape: tuple[int, ...]) -> None:
    pred, target, _ = segmentation(shape)
    torch.testing.assert_close(
        losses.focal_loss(pred, target, None, 0.0).sum(1), F.cross_entropy(pred, target, reduction="none")
    )
    torch.testing.assert_close(
        losses.focal_loss(pred, target, None, 0.0, "mean") * pred[:, 0].numel() * pred.size(1),
        F.cross_entropy(pred, target, reduction="sum"),
    )


@pytest.mark.parametrize("dtype", [torch.float16, torch.float32, torch.float64])
@pytest.mark.parametrize("gamma", [0.0, 0.5, 2.0])
def test_focal_of_masked_classes(gamma: float, dtype: torch.dtype) -> None:
    """-inf leaves a class out: of two, the other one is sure; of three, two remain."""
    free = torch.tensor([0.5, -1.0, 3.0], dtype=dtype)
    never = torch.full_like(free, -math.inf)
    target = torch.zeros(1, 3, dtype=torch.int64)
    pred = torch.stack([free, never])[None].requires_grad_()
    loss = losses.focal_loss(pred, target, None, gamma)
    (grad,) = torch.autograd.grad(loss.sum(), pred)
    assert not loss.any() and not grad.any()
    pred = torch.stack([free, never, 0.0 * free])[None].requires_grad_()
    loss = losses.focal_loss(pred, target, None, gamma)
    (grad,) = torch.autograd.grad(loss.sum(), pred)
    two = losses.focal_loss(pred[:, [0, 2]], target, None, gamma)
    torch.testing.assert_close(loss[:, 0], two[:, 0])
    assert grad.isfinite().all() and not grad[:, 1].any()
    assert losses.focal_loss(pred, target + 1, None, gamma)[:, 1].isposinf().all()


def test_focal_of_two_classes_is_binary() -> None:
    pred, target, _ = segmentation((3, 2, 11, 7))
    binary = losses.binary_focal_loss_with_logits(pred[:, 1] - pred[:, 0], target, 0.3, 1.7)
    torch.testing.assert_close(losses.focal_loss(pred, target, 0.3, 1.7).sum(1), binary)


@sizes
@pytest.mark.parametrize(("alpha", "gamma"), [(0.25, 2.0), (None, 0.5)])
def test_binary_focal_equals_the_formula(shape: tuple[int, ...], alpha: float | None, gamma: float) -> None:
    pred, _, weight = segmentation(shape)
    drawn = torch.rand(shape, generator=torch.Generator().manual_seed(1))
    target = torch.where(drawn < 0.2, IGNORED, (drawn < 0.6).long())
    channel = (-1, *[1] * (len(shape) - 2))
    w, positive = weight.numpy().reshape(channel), weight.flip(0).numpy().reshape(channel)
    p, y = scipy.special.expit(pred.numpy()), target.numpy()
    front, back = (1.0, 1.0) if alpha is None else (alpha, 1 - alpha)
    expected = (
        -w
        * (front * positive * y * (1 - p) ** gamma * np.log(p) + back * (1 - y) * p**gamma * np.log1p(-p))
        * (y != IGNORED)
    )
    settings = {"pos_weight": weight.flip(0), "weight": weight}
    np.testing.assert_allclose(
        losses.binary_focal_loss_with_logits(pred, target, alpha, gamma, **settings),
        expected,
        rtol=1e-8,
        atol=1e-12,
    )
    mean = losses.binary_focal_loss_with_logits(pred, target, alpha, gamma, "mean", **settings).item()
    assert mean == pytest.approx(expected.mean())
    soft = drawn.to(torch.float64)
    plain = losses.binary_focal_loss_with_logits(pred, soft, None, 0.0)
    torch.testing.assert_close(plain, F.binary_cross_entropy_with_logits(pred, soft, reduction="none"))


@pytest.mark.parametrize("gamma", [0.0, 0.5, 2.0])
def test_focal_gradient_is_finite_and_right_at_the_ends(gamma: float) -> None:
    logits = torch.tensor([-200.0, -50.0, 0.0, 50.0, 200.0], dtype=torch.float64)
    x = logits.clone().requires_grad_(True)
    losses.binary_focal_loss_with_logits(x, torch.ones(5), None, gamma, "sum").backward()
    p, q = scipy.special.expit(logits.numpy()), scipy.special.expit(-logits.numpy())
    np.testing.assert_allclose(
        x.grad, q**gamma * (gamma * p * scipy.special.log_expit(logits.numpy()) - q), rtol=1e-9, atol=1e-15
    )


# --- Lovász -------------------------------------------------------------------------------------------------


def lovasz_extension(errors: np.ndarray, foreground: np.ndarray) -> float:
    """Berman et al. 2018, equation 8: 1 - Jaccard of the sets of wrong pixels, from the largest error on."""
    total, before, wrong = 0.0, 0.0, np.zeros(errors.size, bool)
    for pixel in np.argsort(-errors, kind="stable"):
        wrong[pixel] = True
        found = foreground ^ wrong
        union = (foreground | found).sum()
        value = 1.0 - (foreground & found).sum() / union if union else 0.0
        total, before = total + errors[pixel] * (value - before), value
    return total


@sizes
@pytest.mark.parametrize("weighted", [False, True])
def test_lovasz_softmax_equals_the_definition(shape: tuple[int, ...], weighted: bool) -> None:
    pred, target, weight = segmentation(shape, ignored=0.0)
    target[0] = target[0].clamp(max=shape[1] - 2)  # the first image lacks a class
    w = weight.numpy() if weighted else np.ones(shape[1])
    images = []
    for p, g in class_rows(pred, target):
        images.append(
            # As Kornia: the mean divides by the number of classes, not by the sum of the weights.
            np.mean([w[c] * lovasz_extension(np.abs(g[c] - p[c]), g[c]) for c in range(shape[1])])
        )
    given = weight if weighted else None
    assert losses.lovasz_softmax_loss(pred, target, given).item() == pytest.approx(np.mean(images), rel=1e-10)
    assert losses.lovasz_softmax_loss(pred.float(), target, given).item() == pytest.approx(
        np.mean(images), rel=1e-5
    )


@pytest.mark.parametrize("shape", [(1, 17, 23), (3, 13, 19)], ids=str)
def test_lovasz_hinge_equals_the_definition(shape: tuple[int, ...]) -> None:
    generator = torch.Generator().manual_seed(2)
    pred = 2.0 * torch.randn((shape[0], 1, *shape[1:]), generator=generator, dtype=torch.float64)
    target = (torch.rand(shape, generator=generator) < 0.4).long()
    target[-1] = 0 if shape[0] > 1 else target[-1]  # nothing in the foreground
    expected = []
    for z, t in zip(pred.flatten(1).numpy(), target.flatten(1).numpy(), strict=True):
        expected.append(lovasz_extension(np.maximum(0.0, 1 - z * (2 * t - 1)), t > 0))
    assert losses.lovasz_hinge_loss(pred, target).item() == pytest.approx(np.mean(expected), rel=1e-10)
    for mask in (target.float(), target > 0):
        assert losses.lovasz_hinge_loss(pred, mask).equal(losses.lovasz_hinge_loss(pred, target))


def test_lovasz_of_a_large_image_keeps_its_digits() -> None:
    generator = torch.Generator().manual_seed(3)
    pred = torch.randn((1, 1, 700, 900), generator=generator)
    target = (torch.rand((1, 700, 900), generator=generator) < 0.5).long()
    expected = losses.lovasz_hinge_loss(pred.double(), target).item()
    assert losses.lovasz_hinge_loss(pred, target).item() == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_lovasz_of_an_image_that_is_all_foreground_is_the_mean(dtype: torch.dtype) -> None:
    # each pixel weighs 1e-6, for which float16 has two digits
    pred = torch.rand((1, 2, 1000, 1000), generator=torch.Generator().manual_seed(3)).to(dtype)
    everywhere = torch.zeros(1, 1000, 1000, dtype=torch.int64)
    hinge = losses.lovasz_hinge_loss(pred[:, :1], everywhere + 1)
    softmax = losses.lovasz_softmax_loss(pred, everywhere)
    assert hinge.dtype == softmax.dtype == dtype
    p = scipy.special.softmax(pred.double().numpy(), 1)
    rel = torch.finfo(dtype).eps
    assert hinge.item() == pytest.approx((1.0 - pred[:, 0].double()).mean().item(), rel=rel)
    assert softmax.item() == pytest.approx(0.5 * (p[:, 1].mean() + p[:, 1].max()), rel=rel)


def test_lovasz_of_right_and_wrong() -> None:
    target = torch.tensor([[[0, 1, 2, 1]]])
    sure = 1e4 * losses.one_hot(target, 3)
    assert losses.lovasz_softmax_loss(sure, target).item() == 0.0
    # one wrong class: the Jaccard indices of the classes are 1, 1/2 and 1/2
    found = torch.tensor([[[0, 1, 2, 2]]])
    assert losses.lovasz_softmax_loss(1e4 * losses.one_hot(found, 3), target).item() == pytest.approx(
        1.0 / 3.0
    )


# --- Hausdorff ----------------------------------------------------------------------------------------------


def eroded_sum(error: np.ndarray, alpha: float, k: int) -> np.ndarray:
    """Karimi and Salcudean 2020, equation 8, for a plane or volume."""
    cross = scipy.ndimage.generate_binary_structure(error.ndim, 1) / (2 * error.ndim + 1)
    total = np.zeros_like(error)
    for i in range(1, k + 1):
        error = np.maximum(scipy.ndimage.convolve(error, cross, mode="constant") - 0.5, 0)
        if error.max() > error.min():
            error = (error - error.min()) / (error.max() - error.min())
        total += error * i**alpha
    return total


@pytest.mark.parametrize(
    "shape", [(1, 1, 17, 23), (3, 3, 13, 19), (1, 5, 14, 9), (1, 1, 7, 9, 11), (3, 3, 8, 6, 9)], ids=str
)
def test_hausdorff_equals_the_formula(shape: tuple[int, ...]) -> None:
    generator = torch.Generator().manual_seed(4)
    pred = torch.rand(shape, generator=generator, dtype=torch.float64) ** 0.3
    target = torch.randint(0, max(shape[1], 2), (shape[0], 1, *shape[2:]), generator=generator)
    target[:, :, 1:7] = 0
    pred[:, :, 1:7] = 1.0 - 0.1 * pred[:, :, 1:7]  # erosions do not remove all of these errors
    loss = losses.hausdorff_er_loss if len(shape) == 4 else losses.hausdorff_er_loss3d
    expected = np.empty(shape)
    for b in range(shape[0]):
        for c in range(shape[1]):
            mask = target[b, 0] == (c if shape[1] > 1 else 1)
            expected[b, c] = eroded_sum((pred[b, c] - mask.double()).numpy() ** 2, 1.5, 6)
    np.testing.assert_allclose(loss(pred, target, 1.5, 6, "none"), expected, rtol=1e-10, atol=1e-10)
    assert loss(pred, target, 1.5, 6).item() == pytest.approx(expected.mean())
    assert loss(pred, target, 1.5, 6, "sum").item() == pytest.approx(expected.sum())
    assert expected.max() > 5.0
    assert isinstance(
        (losses.HausdorffERLoss if len(shape) == 4 else losses.HausdorffERLoss3D)(2, 3)(pred, target), Tensor
    )


def test_hausdorff_of_a_right_prediction() -> None:
    target = torch.randint(0, 2, (1, 1, 9, 9))
    pred = target.float().requires_grad_(True)
    value = losses.hausdorff_er_loss(pred, target)
    value.backward()
    assert value.item() == 0.0
    assert torch.equal(pred.grad, torch.zeros_like(pred))


# --- one-hot ------------------------------------------------------------------------------------------------


@sizes
def test_one_hot_equals_torch(shape: tuple[int, ...]) -> None:
    labels = segmentation(shape, ignored=0.0)[1]
    expected = F.one_hot(labels, shape[1]).movedim(-1, 1)
    assert torch.equal(losses.one_hot(labels, shape[1], torch.device("cpu"), torch.int64), expected)
    torch.testing.assert_close(
        losses.one_hot(labels.to(torch.uint8), shape[1], eps=1e-3), expected.float() + 1e-3
    )
    assert losses.one_hot(torch.tensor([7, -100, 3]), 3).sum() == 0


WRONG = [
    (lambda: losses.one_hot(X, 3), TypeError, "labels: expected integer labels, got dtype torch.float32"),
    (lambda: losses.one_hot(Y, 0), ValueError, "num_classes: expected a positive number, got 0"),
    (lambda: losses.one_hot(Y[0, 0, 0], 3), ValueError, r"labels: expected shape \(B, \*\), got a scalar"),
    (lambda: losses.dice_loss(X, Y, "mean"), ValueError, "average: expected one of"),
    (lambda: losses.dice_loss(X.int(), Y), TypeError, "pred: expected a floating-point"),
    (lambda: losses.dice_loss(X, Y.float()), TypeError, "target: expected integer labels"),
    (lambda: losses.dice_loss(X, Y[:, 1:]), ValueError, r"target: expected shape \(B, \*\) for pred"),
    (
        lambda: losses.dice_loss(X[..., 0, 0], Y[..., 0, 0]),
        ValueError,
        r"pred: expected shape \(B, C, \*\) of 3 dimensions or more",
    ),
    (lambda: losses.dice_loss(X, Y, weight=torch.ones(2)), ValueError, r"weight: expected shape \(3,\)"),
    (lambda: losses.tversky_loss(X, X, 0.5, 0.5), TypeError, "target: expected integer labels"),
    (lambda: losses.tversky_loss(X, Y, 0.5, 0.5, average="none"), ValueError, "average: expected one of"),
    (lambda: losses.focal_loss(X[:, :1], Y, 0.5), ValueError, "pred: expected at least 2 classes"),
    (lambda: losses.focal_loss(X, Y, 0.5, reduction="max"), ValueError, "reduction: expected one of"),
    (
        lambda: losses.focal_loss(X, Y, 0.5, weight=torch.ones(1, 3)),
        ValueError,
        r"weight: expected shape \(3,\)",
    ),
    (lambda: losses.binary_focal_loss_with_logits(X, Y), ValueError, "target: expected pred's shape"),
    (
        lambda: losses.binary_focal_loss_with_logits(X, X, pos_weight=torch.ones(2)),
        ValueError,
        r"pos_weight: expected shape \(3,\)",
    ),
    (
        lambda: losses.binary_focal_loss_with_logits(X[0, 0, 0], X[0, 0, 0], weight=torch.ones(1)),
        ValueError,
        "pred: expected .* with weight",
    ),
    (lambda: losses.lovasz_hinge_loss(X, Y), ValueError, r"pred: expected shape \(B, 1, H, W\)"),
    (lambda: losses.lovasz_hinge_loss(X[:, :1], Y[0]), ValueError, r"target: expected shape \(B, H, W\)"),
    (lambda: losses.lovasz_softmax_loss(X, Y, torch.ones(1)), ValueError, r"weight: expected shape \(3,\)"),
    (lambda: losses.hausdorff_er_loss(X, Y), ValueError, r"target: expected shape \(B, 1, \*\)"),
    (lambda: losses.hausdorff_er_loss(X, X[:, :1]), TypeError, "target: expected integer labels"),
    (lambda: losses.hausdorff_er_loss(X, Y[None], k=0), ValueError, "k: expected a positive number, got 0"),
    (lambda: losses.hausdorff_er_loss3d(X, Y), ValueError, r"pred: expected shape \(B, C, D, H, W\)"),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
