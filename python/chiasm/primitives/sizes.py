"""Window sizes that need not be odd; ``checks`` has the odd ones."""

from typing import Tuple, Union


def positive_pair(size: Union[int, Tuple[int, int]], name: str) -> Tuple[int, int]:
    """``size`` as (rows, columns); raise ValueError unless both are positive.

    >>> positive_pair((2, 3), "kernel_size")
    (2, 3)
    """
    if isinstance(size, int):
        ky, kx = size, size
    else:
        ky, kx = size
    if ky < 1 or kx < 1:
        raise ValueError(f"{name}: expected positive sizes, got ({ky}, {kx})")
    return ky, kx
