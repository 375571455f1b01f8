"""Settings with one number for all samples or one per sample."""

from typing import Union

import torch
from torch import Tensor

from .checks import broadcastable, check_number, check_tensor
from .lowering import primitive
from .materialise import materialised


def per_sample(value: Union[float, Tensor], like: Tensor, name: str) -> Tensor:
    """``value`` as a tensor of ``like``'s dtype that broadcasts against it, with one entry per sample if it
    is (B,).

    >>> per_sample(torch.ones(2), torch.zeros(2, 3, 4, 5), "factor").shape
    torch.Size([2, 1, 1, 1])
    """
    if not isinstance(value, Tensor):
        check_number(value, name)
        return torch.full([1], value, dtype=like.dtype, device=like.device)
    value = value.to(like.dtype)
    if value.dim() == 0 or (value.dim() == like.dim() and broadcastable(value, like)):
        return value
    # Compare the batch size first: in a symbolic shape it is the same symbol, so the trace adds no guard.
    if value.dim() != 1 or like.dim() == 0 or (value.size(0) != like.size(0) and value.size(0) != 1):
        raise ValueError(
            f"{name}: expected a number, or a tensor that is a scalar, (B,) or broadcasts against"
            f" {list(like.shape)}, got {list(value.shape)}"
        )
    return each(value, like)


def each(value: Tensor, like: Tensor) -> Tensor:
    """(B,) as (B, 1, ...), to broadcast against ``like``.

    >>> each(torch.zeros(2), torch.zeros(2, 3, 4, 5)).shape
    torch.Size([2, 1, 1, 1])
    """
    for _ in range(like.dim() - 1):
        value = value.unsqueeze(-1)
    return value


def in_batch(x: Tensor, name: str) -> Tensor:
    """An image (C, H, W) or (H, W) as a batch of one; anything else as it is.

    >>> in_batch(torch.zeros(4, 5), "image").shape
    torch.Size([1, 1, 4, 5])
    """
    check_tensor(x, name)
    if x.dim() == 3:
        return x.unsqueeze(0)
    if x.dim() == 2:
        return x.unsqueeze(0).unsqueeze(0)
    return x


def like_given(x: Tensor, given: Tensor) -> Tensor:
    """An op's result for ``in_batch(given)``, with as many dimensions as ``given`` has.

    >>> like_given(torch.zeros(1, 1, 4, 5), torch.zeros(8, 10)).shape
    torch.Size([4, 5])
    """
    if given.dim() == 3:
        return x.squeeze(0)
    if given.dim() == 2:
        return x.squeeze(0).squeeze(0)
    return x


def one_for_each(src: Tensor, matrix: Tensor, name: str, matrix_name: str) -> Tensor:
    """Images (B, C, H, W), or one image repeated for each matrix; raise ValueError unless the numbers of
    images and matrices are equal or one of them is 1.

    >>> one_for_each(torch.zeros(1, 3, 4, 5), torch.zeros(7, 2, 3), "src", "M").shape
    torch.Size([7, 3, 4, 5])
    """
    # Compare symbols for equality first, as in ``broadcastable``.
    if matrix.size(0) == src.size(0) or matrix.size(0) == 1:
        return src
    if src.size(0) != 1:
        raise ValueError(
            f"{matrix_name}: expected one, or one for each image of {name} {list(src.shape)}, got"
            f" {list(matrix.shape)}"
        )
    return src.expand(matrix.size(0), -1, -1, -1)


@primitive
def where_chosen(chosen: Tensor, changed: Tensor, other: Tensor) -> Tensor:
    """Samples (B, ...) of ``changed`` where ``chosen`` (B,), bool, is True, else of ``other``.

    >>> where_chosen(torch.tensor([True, False]), torch.ones(2, 1), torch.zeros(2, 1)).flatten()
    tensor([1., 0.])
    """
    return torch.where(each(chosen, changed), changed, other)


# Compiled tensor code has masks of floats and extracts bytes from them one by one, which takes 10 times as
# long.
@where_chosen.lowering("native", when=lambda _, changed, __: changed.dtype == torch.uint8)
def _bytes_of_chosen(chosen: Tensor, changed: Tensor, other: Tensor) -> Tensor:
    bits = materialised(torch.where(chosen, 255, 0).to(torch.uint8), 0)
    return other ^ ((changed ^ other) & each(bits, changed))


where_chosen.lowering("cuda")(where_chosen.definition)
