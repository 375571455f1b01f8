"""Mixes of images with other images of the batch, and of their labels. Here, the result for a sample depends
on the whole batch: its partner comes from a permutation, which is computed from the seeds of all samples. All
seeds should differ.
"""

from typing import List, Tuple

import torch
from torch import Tensor

from ..enhance.arithmetic import add_weighted
from ..primitives.core.checks import check_pair, check_pixels, check_tensor
from ..primitives.numbers.loss_reduction import widened
from ..primitives.random.draws import ranks, uniform
from ..primitives.random.philox import key_of, philox4x32
from ..primitives.resampling.volumes import check_voxels
from .decisions import between, check_bounds, check_chance, drawn
from .distributions import beta as beta_numbers


def random_mix_up(
    input: Tensor, label: Tensor, seed: Tensor, lambda_val: Tuple[float, float] = (0.0, 1.0), p: float = 1.0
) -> Tuple[Tensor, Tensor]:
    """Blend each image with another one of the batch.

    H. Zhang et al., mixup: beyond empirical risk minimization, ICLR 2018. With l uniform in ``lambda_val``,
    an image becomes ``(1 - l) * image + l * partner``. The partners are a permutation of the batch, in which
    an image may be its own.

    Args:
        input: (B, C, H, W), floating point or uint8.
        label: (B,), the class index of each image.
        seed: (B,), int64, one for each sample, all different.
        lambda_val: (least, greatest) share of the partner, within [0, 1].
        p: probability that a sample is changed; if not, its share is 0.

    Returns:
        (B, C, H, W), of the input's dtype, bytes rounded; and (B, 3), float32, for float64 images float64:
        label, partner's label, share of the partner.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x, label = torch.zeros(1, 1, 1, 1), torch.tensor([4])
        >>> random_mix_up(x, label, torch.tensor([7]), (0.25, 0.25))[1]
        tensor([[4.0000, 4.0000, 0.2500]])
    """
    check_pixels(input, "input")
    _check_label(label, input)
    check_bounds(lambda_val, 0.0, 1.0, "lambda_val")
    check_chance(p)
    u = drawn(seed, 3, input)
    partner = ranks(u[:, 2])
    share = between(u[:, 1], lambda_val, input)
    share = torch.where(u[:, 0] < p, share, torch.zeros_like(share))
    mixed = add_weighted(input, 1.0 - share, input.index_select(0, partner), share, 0.0)
    return mixed, _labels(label, partner, widened(share))


def random_cut_mix(
    input: Tensor,
    label: Tensor,
    seed: Tensor,
    num_mix: int = 1,
    cut_size: Tuple[float, float] = (0.0, 1.0),
    beta: float = 1.0,
    use_correct_lambda: bool = False,
    p: float = 1.0,
) -> Tuple[Tensor, Tensor]:
    """Paste a rectangle of another image of the batch into each image, at the same position.

    S. Yun et al., CutMix: regularization strategy to train strong classifiers with localizable features, ICCV
    2019. With l drawn from Beta(beta, beta) and limited to ``cut_size``, the rectangle is ``sqrt(1 - l)``
    times as high and wide as the image, rounded down, and lies completely within the image; all positions are
    equally likely.

    Args:
        input: (B, C, H, W), floating point or uint8.
        label: (B,), the class index of each image.
        seed: (B,), int64, one for each sample, all different.
        num_mix: how many rectangles; each comes from a different permutation of the batch.
        cut_size: (least, greatest) of l, within [0, 1].
        beta: the parameter of the distribution, positive.
        use_correct_lambda: True returns the image's remaining share of the area, as in the paper; False the
            rectangle's share.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype, and (num_mix, B, 3), float32, for float64 images float64: label,
        partner's label, the rectangle's share of the area or, with use_correct_lambda, one minus this share.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x, label = torch.zeros(1, 1, 4, 4), torch.tensor([5])
        >>> random_cut_mix(x, label, torch.tensor([7]), cut_size=(0.75, 0.75))[1]
        tensor([[[5.0000, 5.0000, 0.2500]]])
    """
    check_pixels(input, "input")
    _check_label(label, input)
    if num_mix < 1:
        raise ValueError(f"num_mix: expected at least 1, got {num_mix}")
    if not beta > 0.0:
        raise ValueError(f"beta: expected a positive number, got {beta}")
    check_bounds(cut_size, 0.0, 1.0, "cut_size")
    check_chance(p)
    height, width = input.size(2), input.size(3)
    u = drawn(seed, 1 + 3 * num_mix, input)
    kept = beta_numbers(seed, beta, num_mix, 1).clamp(cut_size[0], cut_size[1])
    side = torch.where(u[:, :1] < p, torch.sqrt(1.0 - kept), torch.zeros_like(kept))
    rows = torch.arange(height, device=input.device)
    columns = torch.arange(width, device=input.device)
    dtype = torch.float64 if input.dtype == torch.float64 else torch.float32
    mixed = input
    labels: List[Tensor] = []
    for i in range(num_mix):
        partner = ranks(u[:, 1 + 3 * i])
        down, within_rows = _span(side[:, i], u[:, 2 + 3 * i], rows, height)
        across, within_columns = _span(side[:, i], u[:, 3 + 3 * i], columns, width)
        inside = (within_rows[:, :, None] & within_columns[:, None, :])[:, None]
        mixed = torch.where(inside, input.index_select(0, partner), mixed)
        share = (down * across).to(dtype) / (height * width)
        labels.append(_labels(label, partner, 1.0 - share if use_correct_lambda else share))
    return mixed, torch.stack(labels)


def _span(side: Tensor, u: Tensor, positions: Tensor, size: int) -> Tuple[Tensor, Tensor]:
    """The length (B,) of an interval that covers a fraction of an axis, and whether each position lies in it,
    (B, size)."""
    length = torch.floor(side * size).to(torch.int64)
    first = torch.minimum(torch.floor(u * (size - length + 1)).to(torch.int64), size - length)
    within = (positions >= first[:, None]) & (positions < (first + length)[:, None])
    return length, within


def random_jigsaw(
    input: Tensor, seed: Tensor, grid: Tuple[int, int] = (4, 4), ensure_perm: bool = True, p: float = 0.5
) -> Tensor:
    """Cut each image into tiles and shuffle the tiles; all orders are equally likely.

    Args:
        input: (B, C, H, W), floating point or uint8, H and W multiples of the numbers of tiles.
        seed: (B,), int64, one for each sample. Samples are independent.
        grid: number of tiles (down, across).
        ensure_perm: True moves each tile by one place if the random order is the original one.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype.

    Raises:
        TypeError: if input is neither floating point nor uint8, or seed is not int64.
        ValueError: if a shape or a setting is not as above.

    Example:
        >>> x = torch.arange(2.0).reshape(1, 1, 1, 2)
        >>> random_jigsaw(x, torch.tensor([7]), (1, 2), p=1.0)
        tensor([[[[1., 0.]]]])
    """
    check_pixels(input, "input")
    check_pair(grid, "grid")
    check_chance(p)
    order = jigsaw_order(seed, grid, ensure_perm, drawn(seed, 1, input)[:, 0] < p)
    return put_together(input, order, grid)


def jigsaw_order(seed: Tensor, grid: Tuple[int, int], ensure_perm: bool, is_changed: Tensor) -> Tensor:
    """The index of the tile for each place, (B, tiles); for unchanged samples, each place keeps its tile."""
    order = ranks(uniform(seed, grid[0] * grid[1], 1))
    place = torch.arange(grid[0] * grid[1], device=seed.device)
    if ensure_perm:
        same = (order == place).to(torch.int64).sum(1, keepdim=True) == grid[0] * grid[1]
        order = torch.where(same, order.roll(-1, 1), order)
    return torch.where(is_changed[:, None], order, place)


def put_together(input: Tensor, order: Tensor, grid: Tuple[int, int]) -> Tensor:
    """Images (B, C, H, W), whose tiles are put into an order (B, tiles)."""
    down, across = grid
    if down < 1 or across < 1 or input.size(2) % down != 0 or input.size(3) % across != 0:
        raise ValueError(
            f"grid: expected numbers that divide the image {input.size(2)} x {input.size(3)}, got ({down},"
            f" {across})"
        )
    batch, channels, high, wide = input.size(0), input.size(1), input.size(2) // down, input.size(3) // across
    tiles = input.reshape(batch, channels, down, high, across, wide).permute(0, 2, 4, 1, 3, 5).flatten(0, 2)
    first = torch.arange(batch, device=input.device)[:, None] * (down * across)
    moved = tiles.index_select(0, (first + order).flatten())
    moved = moved.reshape(batch, down, across, channels, high, wide).permute(0, 3, 1, 4, 2, 5)
    return moved.reshape(input.shape)


def random_transplantation(
    input: Tensor, mask: Tensor, seed: Tensor, excluded_labels: List[int], p: float = 0.5
) -> Tuple[Tensor, Tensor]:
    """Copy the region of one label from another image of the batch to the same position, in image and mask.

    For segmentation, after D. Dwibedi et al., Cut, paste and learn, ICCV 2017. The label is one of the labels
    in the partner's mask; all are equally likely. The partners are a permutation of the batch, in which an
    image may be its own.

    Args:
        input: (B, C, H, W), floating point or uint8.
        mask: (B, H, W), int64, a label for each pixel.
        seed: (B,), int64, one for each sample, all different.
        excluded_labels: labels that are not copied.
        p: probability that a sample is changed.

    Returns:
        (B, C, H, W), of the input's dtype, and (B, H, W), int64. Where the partner has only labels that are
        excluded, nothing changes.

    Raises:
        TypeError: if input is neither floating point nor uint8, or mask or seed is not int64.
        ValueError: if a shape or p is not as above.

    Example:
        >>> x, mask = torch.zeros(1, 1, 1, 2), torch.tensor([[[0, 3]]])
        >>> random_transplantation(x, mask, torch.tensor([7]), [0], 1.0)[1]
        tensor([[[0, 3]]])
    """
    check_pixels(input, "input")
    return _transplanted(input, mask, seed, excluded_labels, p)


def random_transplantation3d(
    input: Tensor, mask: Tensor, seed: Tensor, excluded_labels: List[int], p: float = 0.5
) -> Tuple[Tensor, Tensor]:
    """``random_transplantation`` for volumes.

    Args:
        input: (B, C, D, H, W), floating point or uint8.
        mask: (B, D, H, W), int64, a label for each voxel.
        seed: (B,), int64, one for each sample, all different.
        excluded_labels: labels that are not copied.
        p: probability that a sample is changed.

    Returns:
        (B, C, D, H, W), of the input's dtype, and (B, D, H, W), int64. Where the partner has only labels that
        are excluded, nothing changes.

    Raises:
        TypeError: if input is neither floating point nor uint8, or mask or seed is not int64.
        ValueError: if a shape or p is not as above.

    Example:
        >>> x, mask = torch.zeros(1, 1, 1, 1, 2), torch.tensor([[[[0, 3]]]])
        >>> random_transplantation3d(x, mask, torch.tensor([7]), [0], 1.0)[1]
        tensor([[[[0, 3]]]])
    """
    check_voxels(input, "input")
    return _transplanted(input, mask, seed, excluded_labels, p)


def _transplanted(
    input: Tensor, mask: Tensor, seed: Tensor, excluded_labels: List[int], p: float
) -> Tuple[Tensor, Tensor]:
    check_tensor(mask, "mask")
    if mask.dtype != torch.int64:
        raise TypeError(f"mask: expected an int64 tensor, got dtype {mask.dtype}")
    if mask.dim() != input.dim() - 1 or mask.size(0) != input.size(0) or mask.shape[1:] != input.shape[2:]:
        sizes = "(B, H, W)" if input.dim() == 4 else "(B, D, H, W)"
        raise ValueError(
            f"mask: expected shape {sizes} of input's {list(input.shape)}, got {list(mask.shape)}"
        )
    check_chance(p)
    u = drawn(seed, 2, input)
    partner = ranks(u[:, 1])
    donor = mask.index_select(0, partner)
    flat = donor.flatten(1)
    # Each label gets a random number. The label with the greatest number is chosen: so the choice is uniform
    # over the labels that occur, whatever their values and however many pixels each has.
    low, high = flat & 0xFFFFFFFF, (flat >> 32) & 0xFFFFFFFF
    one = torch.ones_like(flat)
    key = philox4x32([low, high, one, one * 2], [k[:, None] for k in key_of(seed)])[0]
    for label in excluded_labels:
        key = torch.where(flat == label, -one, key)
    chosen = flat.gather(1, key.argmax(1, keepdim=True))
    copied = (flat == chosen) & (key >= 0) & (u[:, :1] < p)
    copied = copied.reshape(mask.shape)
    mixed = torch.where(copied[:, None], input.index_select(0, partner), input)
    return mixed, torch.where(copied, donor, mask)


def _check_label(label: Tensor, input: Tensor) -> None:
    check_tensor(label, "label")
    if label.dim() != 1 or label.size(0) != input.size(0):
        raise ValueError(f"label: expected shape ({input.size(0)},), got {list(label.shape)}")


def _labels(label: Tensor, partner: Tensor, share: Tensor) -> Tensor:
    return torch.stack([label.to(share.dtype), label.index_select(0, partner).to(share.dtype), share], -1)
