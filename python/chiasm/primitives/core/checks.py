"""Input checks: one message that names the argument, the expected and the actual value. No check reads
data."""

from collections.abc import Sequence
from numbers import Integral, Real
from typing import List, Optional, Tuple, Union

import torch
from torch import Tensor


def check_tensor(value: Tensor, name: str) -> None:
    """Raise TypeError unless ``value`` is a tensor. TorchScript knows the type, and drops this check."""
    if not isinstance(value, Tensor):
        raise TypeError(f"{name}: expected a tensor, got {type(value).__name__}")


def check_number(value: float, name: str) -> None:
    """Raise TypeError unless ``value`` is a number: for arguments that may be a tensor or a number."""
    if not torch.jit.is_scripting():
        _check_number(value, name)


def check_positive(value: float, name: str) -> None:
    """Raise unless ``value`` is a number above 0, which NaN is not."""
    check_number(value, name)
    if not value > 0.0:
        raise ValueError(f"{name}: expected a positive number, got {value}")


def check_integer(value: int, name: str) -> None:
    """``check_number`` for a whole number, which TorchScript does not take for a ``float``."""
    if not torch.jit.is_scripting():
        _check_number(value, name)


def check_pair(value: Tuple[int, int], name: str) -> None:
    """Raise unless ``value`` has two whole numbers. TorchScript knows its length and type."""
    if not torch.jit.is_scripting():
        _check_length(value, 2, name)
        _check_whole(value, name)


def check_indices(value: List[int], name: str) -> None:
    """Raise unless ``value`` has two whole numbers, of a row and a column."""
    if not torch.jit.is_scripting():
        _check_length(value, 2, name)
        _check_whole(value, name)


def check_size3d(value: Tuple[int, int, int], name: str) -> None:
    """Raise unless ``value`` has three whole numbers, the sizes of a volume."""
    if not torch.jit.is_scripting():
        _check_length(value, 3, name)
        _check_whole(value, name)


def check_sides(value: Sequence[int], name: str) -> None:
    """Raise unless ``value`` has two or four whole numbers. Not for TorchScript, which knows its type."""
    expected = f"{name}: expected a whole number, or 2 or 4, got"
    if not isinstance(value, Sequence) or isinstance(value, str):
        raise TypeError(f"{expected} {type(value).__name__}")
    if len(value) not in (2, 4):
        raise ValueError(f"{expected} {len(value)}")
    _check_whole(value, name)


def check_four_sides(value: Tuple[int, int, int, int], name: str) -> None:
    """Raise unless ``value`` has four whole numbers, one for each side of an image."""
    if not torch.jit.is_scripting():
        _check_length(value, 4, name)
        _check_whole(value, name)


def check_six_sides(value: Tuple[int, int, int, int, int, int], name: str) -> None:
    """Raise unless ``value`` has six whole numbers, one for each side of a volume."""
    if not torch.jit.is_scripting():
        _check_length(value, 6, name)
        _check_whole(value, name)


def check_triple(value: Tuple[float, float, float], name: str) -> None:
    """Raise unless ``value`` has three numbers. TorchScript knows its length."""
    if not torch.jit.is_scripting():
        _check_length(value, 3, name)


def check_interval(value: Tuple[float, float], name: str) -> None:
    """Raise unless ``value`` has two numbers. TorchScript knows its length and type."""
    if not torch.jit.is_scripting():
        _check_length(value, 2, name)
        for number in value:
            _check_number(number, name)


def check_optional(value: Optional[Tensor], name: str) -> None:
    """``check_tensor`` for an argument that may be None."""
    if value is not None:
        check_tensor(value, name)


def check_sigmas(sigma: Tuple[float, float], name: str) -> None:
    """Raise unless ``sigma`` holds two positive numbers."""
    if not torch.jit.is_scripting():
        _check_length(sigma, 2, name)
    if not (sigma[0] > 0.0 and sigma[1] > 0.0):  # which NaN is not
        raise ValueError(f"{name}: expected positive numbers, got ({sigma[0]}, {sigma[1]})")


def _check_number(value: object, name: str) -> None:
    if not isinstance(value, (Real, torch.SymInt, torch.SymFloat)):
        raise TypeError(f"{name}: expected a number or a tensor, got {type(value).__name__}")


def _check_length(value: object, length: int, name: str) -> None:
    if not isinstance(value, Sequence) or isinstance(value, str):
        raise TypeError(f"{name}: expected {length} numbers, got {type(value).__name__}")
    if len(value) != length:
        raise ValueError(f"{name}: expected {length} numbers, got {len(value)}")


def _check_whole(values: Sequence[object], name: str) -> None:
    if not all(isinstance(n, (Integral, torch.SymInt)) for n in values):
        raise TypeError(f"{name}: expected whole numbers, got {values}")


def check_floating(value: Tensor, name: str) -> None:
    """Raise TypeError unless ``value`` has a floating-point dtype."""
    check_tensor(value, name)
    if not value.is_floating_point():
        raise TypeError(f"{name}: expected a floating-point tensor, got dtype {value.dtype}")


def check_values(value: Tensor, name: str, deep: bool = False) -> None:
    """Raise TypeError unless ``value`` has a floating-point dtype or is uint8; ``deep`` also allows 16
    bits."""
    check_tensor(value, name)
    if value.is_floating_point() or value.dtype == torch.uint8:
        return
    if not deep:
        raise TypeError(f"{name}: expected a floating-point or uint8 tensor, got dtype {value.dtype}")
    if value.dtype != torch.int16 and value.dtype != torch.uint16:
        raise TypeError(
            f"{name}: expected a floating-point, uint8, int16 or uint16 tensor, got dtype {value.dtype}"
        )


def check_rank(value: Tensor, rank: int, layout: str, name: str) -> None:
    """Raise ValueError unless ``value`` has ``rank`` dimensions; ``layout`` describes them in the message."""
    check_tensor(value, name)
    if value.dim() != rank:
        raise ValueError(
            f"{name}: expected shape {layout}, got {value.dim()} dimensions: {list(value.shape)}"
        )


def check_image(value: Tensor, name: str) -> None:
    """Raise unless ``value`` is a floating-point (B, C, H, W) tensor with values; B may be 0."""
    check_rank(value, 4, "(B, C, H, W)", name)
    check_floating(value, name)
    check_not_empty(value, 3, name)


def check_one_channel(value: Tensor, name: str) -> None:
    """Raise unless ``value`` is a floating-point (B, 1, H, W) tensor."""
    check_image(value, name)
    if value.size(1) != 1:
        raise ValueError(f"{name}: expected shape (B, 1, H, W), got {list(value.shape)}")


def check_grey_or_rgb(value: Tensor, name: str) -> None:
    """Raise ValueError unless ``value``, of four dimensions, has 1 or 3 channels."""
    if value.size(1) != 1 and value.size(1) != 3:
        raise ValueError(f"{name}: expected shape (B, 1, H, W) or (B, 3, H, W), got {list(value.shape)}")


def check_not_empty(value: Tensor, dims: int, name: str) -> None:
    """Raise ValueError if one of the last ``dims`` dimensions has size 0."""
    for i in range(value.dim() - dims, value.dim()):
        if value.size(i) == 0:
            raise ValueError(f"{name}: expected sizes of at least 1, got {list(value.shape)}")


def check_pixels(value: Tensor, name: str, deep: bool = False) -> None:
    """Raise unless ``value`` is a (B, C, H, W) tensor, floating point or uint8; ``deep`` also allows 16
    bits. B may be 0, no other size."""
    check_rank(value, 4, "(B, C, H, W)", name)
    check_not_empty(value, 3, name)
    check_values(value, name, deep)


def check_rgb(value: Tensor, name: str) -> None:
    """Raise unless ``value`` is a (*, 3, H, W) tensor."""
    check_tensor(value, name)
    if value.dim() < 3 or value.size(-3) != 3:
        raise ValueError(f"{name}: expected shape (*, 3, H, W), got {list(value.shape)}")


def check_last(value: Tensor, size: int, name: str) -> None:
    """Raise unless ``value`` is a floating-point (*, ``size``) tensor."""
    check_tensor(value, name)
    if value.dim() < 1 or value.size(-1) != size:
        raise ValueError(f"{name}: expected shape (*, {size}), got {list(value.shape)}")
    check_floating(value, name)


def check_matrix(value: Tensor, rows: int, columns: int, name: str) -> None:
    """Raise unless ``value`` is a floating-point (*, ``rows``, ``columns``) tensor."""
    check_tensor(value, name)
    if value.dim() < 2 or value.size(-2) != rows or value.size(-1) != columns:
        raise ValueError(f"{name}: expected shape (*, {rows}, {columns}), got {list(value.shape)}")
    check_floating(value, name)


def check_same_shape(value: Tensor, other: Tensor, name: str, other_name: str) -> None:
    """Raise ValueError unless ``value`` has the shape of ``other``."""
    check_tensor(value, name)
    check_tensor(other, other_name)
    if value.shape != other.shape:
        raise ValueError(
            f"{name}: expected {other_name}'s shape {list(other.shape)}, got {list(value.shape)}"
        )


def broadcastable(value: Tensor, other: Tensor, own: int = 0, others: int = 0) -> bool:
    """Whether two shapes broadcast, without the last ``own`` dimensions of ``value`` and the last ``others``
    of ``other``.

    >>> (
    ...     broadcastable(torch.zeros(2, 1, 3), torch.zeros(4, 3)),
    ...     broadcastable(torch.zeros(2), torch.zeros(3)),
    ... )
    (True, False)
    """
    for i in range(min(value.dim() - own, other.dim() - others)):
        # Ask of symbols what broadcasting itself asks, equality first, so that the trace adds no guard.
        a, b = value.size(-1 - own - i), other.size(-1 - others - i)
        if a != b and a != 1 and b != 1:
            return False
    return True


def check_broadcastable(
    value: Tensor, other: Tensor, name: str, other_name: str, own: int = 0, others: int = 0
) -> None:
    """Raise ValueError unless the shapes are ``broadcastable``."""
    check_tensor(value, name)
    check_tensor(other, other_name)
    if not broadcastable(value, other, own, others):
        part = "a shape that broadcasts" if own == 0 else "leading dimensions that broadcast"
        raise ValueError(
            f"{name}: expected {part} with {other_name}'s {list(other.shape)}, got {list(value.shape)}"
        )


def check_all_broadcastable(values: List[Tensor], names: List[str]) -> None:
    """Raise ValueError unless the shapes of all ``values`` broadcast."""
    check_leading(values, names, [0 for _ in values])


def check_leading(values: List[Tensor], names: List[str], own: List[int]) -> None:
    """Raise ValueError unless the leading dimensions of all ``values`` broadcast: those before the last
    ``own[i]`` of ``values[i]``."""
    for i in range(len(values)):
        for j in range(i):
            check_broadcastable(values[i], values[j], names[i], names[j], own[i], own[j])


def check_same_leading(values: List[Tensor], names: List[str], own: List[int]) -> None:
    """Raise ValueError unless ``values`` have the same leading dimensions: those before the last ``own[i]``
    of ``values[i]``."""
    for i in range(1, len(values)):
        check_tensor(values[i], names[i])
        leading, other = values[i].dim() - own[i], values[0].dim() - own[0]
        if leading != other or values[i].shape[:leading] != values[0].shape[:other]:
            raise ValueError(
                f"{names[i]}: expected the leading dimensions of {names[0]}, {list(values[0].shape[:other])},"
                f" got {list(values[i].shape)}"
            )


def expands(value: Tensor, other: Tensor, own: int = 0, others: int = 0) -> bool:
    """Whether the shape of ``value`` broadcasts to that of ``other``, without the last ``own`` dimensions of
    ``value`` and the last ``others`` of ``other``."""
    if value.dim() - own > other.dim() - others:
        return False
    for i in range(value.dim() - own):
        if value.size(-1 - own - i) != other.size(-1 - others - i) and value.size(-1 - own - i) != 1:
            return False
    return True


def check_expands(
    value: Tensor, other: Tensor, name: str, other_name: str, own: int = 0, others: int = 0
) -> None:
    """Raise ValueError unless ``value`` ``expands`` to ``other``."""
    if not expands(value, other, own, others):
        part = "a shape that expands" if own == 0 else "leading dimensions that expand"
        raise ValueError(
            f"{name}: expected {part} to {other_name}'s {list(other.shape)}, got {list(value.shape)}"
        )


def check_one_for_each(value: Tensor, src: Tensor, name: str, src_name: str) -> None:
    """Raise ValueError unless ``value`` has one item, or one for each sample of ``src``."""
    if value.size(0) != src.size(0) and value.size(0) != 1:
        raise ValueError(
            f"{name}: expected one, or one for each sample of {src_name} {list(src.shape)}, got"
            f" {list(value.shape)}"
        )


def check_choice(value: str, choices: List[str], name: str) -> None:
    """Raise ValueError unless ``value`` is one of ``choices``."""
    if value not in choices:
        raise ValueError(f"{name}: expected one of {choices}, got '{value}'")


def check_reduction(reduction: str) -> None:
    """Raise ValueError unless ``reduction`` is a known reduction of a loss."""
    check_choice(reduction, ["mean", "sum", "none"], "reduction")


def odd_pair(kernel_size: Union[int, Tuple[int, int]], name: str) -> Tuple[int, int]:
    """``kernel_size`` as (rows, columns); raise ValueError unless both are odd and positive.

    >>> odd_pair(3, "kernel_size")
    (3, 3)
    """
    if isinstance(kernel_size, int):
        ky, kx = kernel_size, kernel_size
    else:
        check_pair(kernel_size, name)
        ky, kx = kernel_size
    if ky < 1 or kx < 1 or ky % 2 == 0 or kx % 2 == 0:
        raise ValueError(f"{name}: expected odd positive sizes, got ({ky}, {kx})")
    return ky, kx
