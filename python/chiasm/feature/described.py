"""Descriptors of frames as one exportable function: an exported function cannot take a module as an input."""

from torch import Tensor

from .patches import grey_patches_of
from .sift import sift_describe


def sift_laf_descriptors(img: Tensor, lafs: Tensor, patch_size: int = 32, rootsift: bool = True) -> Tensor:
    """``get_laf_descriptors`` with ``sift_describe``.

    Args:
        img: (B, 1 or 3, H, W), floating point; colours are converted to grey.
        lafs: (B, N, 2, 3), floating point, in pixels.
        patch_size: side of the patches.
        rootsift: see ``sift_describe``.

    Returns:
        (B, N, 128).

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape or patch_size is not as above.

    Example:
        >>> sift_laf_descriptors(
        ...     torch.rand(1, 1, 40, 40), torch.tensor([[[[9.0, 0.0, 20.0], [0.0, 9.0, 20.0]]]])
        ... ).shape
        torch.Size([1, 1, 128])
    """
    patches = grey_patches_of(img, lafs, patch_size, "lafs")
    return sift_describe(patches, rootsift=rootsift).unflatten(0, [lafs.size(0), lafs.size(1)])
