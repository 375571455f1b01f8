"""Patches of local affine frames: a frame's square [-1, 1]^2, resampled to PS x PS pixels.

Pixel (i, j) of a patch is at ((2 j + 1) / PS - 1, (2 i + 1) / PS - 1) of the frame: -1 and 1 are the patch's
outer edges. Images are read by bilinear interpolation, with pixel centres at integers; the border is
replicated. (Kornia's positions are wrong by up to half a pixel: it normalizes them by the corner pixels'
centres and reads them by the outer edges.)
"""

from typing import List

import torch
from torch import Tensor, nn

from ..color.gray import rgb_to_grayscale
from ..primitives.core.checks import check_grey_or_rgb, check_image
from ..primitives.core.materialise import materialised
from ..primitives.core.modules import Module
from ..primitives.features.patches import patch_positions, read_patches
from ..primitives.numbers.reshaping import reshaped
from ..primitives.resampling.warping import position_dtype, resample_image
from .laf import check_laf, denormalize_laf, determinants


def extract_patches_simple(
    img: Tensor, laf: Tensor, PS: int = 32, normalize_lafs_before_extraction: bool = True
) -> Tensor:
    """Patches of frames, read from the image itself; there is aliasing if a frame is much larger than its
    patch.

    Args:
        img: (B, C, H, W), floating point.
        laf: (B, N, 2, 3), floating point.
        PS: side of a patch in pixels.
        normalize_lafs_before_extraction: True if frames are in pixels, False if they come from
            ``normalize_laf``.

    Returns:
        (B, N, C, PS, PS). Differentiable in img and laf.

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape or PS is not as above.

    Example:
        >>> ramp = torch.arange(9.0).expand(1, 1, 9, 9)
        >>> extract_patches_simple(ramp, torch.tensor([[[[2.0, 0.0, 4.0], [0.0, 2.0, 4.0]]]]), 2)[0, 0, 0]
        tensor([[3., 5.],
                [3., 5.]])
    """
    frame = _in_pixels(img, laf, PS, normalize_lafs_before_extraction)
    x, y = patch_positions(frame, PS)
    patches = resample_image(img, x.flatten(1, 2), y.flatten(1, 2), "bilinear", "border", True, None)
    return reshaped(patches, [img.size(0), img.size(1), laf.size(1), PS, PS]).transpose(1, 2)


def extract_patches_from_pyramid(
    img: Tensor, laf: Tensor, PS: int = 32, normalize_lafs_before_extraction: bool = True
) -> Tensor:
    """Patches of frames, read from a Gaussian pyramid. The level of each patch has pixels of the size of the
    patch's pixels, or down to half of it.

    There are six levels for every image size, so that frames whose square has a side of up to 64 PS pixels
    are read without aliasing. Each level is the one before, blurred by (1, 4, 6, 4, 1) / 16 and reduced to
    every second pixel. All levels are stored in one row of pixels, from which a frame gathers those of its
    level. (Kornia has levels down to the patch's size.)

    Args:
        img: (B, C, H, W), floating point.
        laf: (B, N, 2, 3), floating point.
        PS: side of a patch in pixels.
        normalize_lafs_before_extraction: True if frames are in pixels, False if they come from
            ``normalize_laf``.

    Returns:
        (B, N, C, PS, PS). Differentiable in img and laf.

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape or PS is not as above.

    Example:
        >>> stripes = torch.tensor([0.0, 1.0]).repeat(32).expand(1, 1, 64, 64)
        >>> extract_patches_from_pyramid(
        ...     stripes, torch.tensor([[[[16.0, 0.0, 32.0], [0.0, 16.0, 32.0]]]]), 4
        ... ).flatten()
        tensor([0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000,
                0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000])
    """
    frame = _in_pixels(img, laf, PS, normalize_lafs_before_extraction)
    levels = _pyramid(img, 6)
    # The square of a patch's pixel in the image is compared with those of the levels, so that no logarithm
    # decides.
    area = determinants(frame.detach()).abs() * (4.0 / (PS * PS))
    start = torch.zeros_like(area).to(torch.int64)
    height, width = start + levels[0].size(2), start + levels[0].size(3)
    shrink = torch.ones_like(frame[..., 0, 0])
    offset, pixel = 0, 1.0
    for k in range(1, len(levels)):
        offset = offset + levels[k - 1].size(2) * levels[k - 1].size(3)
        pixel = pixel * 2.0
        coarse = area >= pixel * pixel
        start = torch.where(coarse, torch.full_like(start, offset), start)
        height = torch.where(coarse, torch.full_like(start, levels[k].size(2)), height)
        width = torch.where(coarse, torch.full_like(start, levels[k].size(3)), width)
        shrink = torch.where(coarse, torch.full_like(shrink, 1.0 / pixel), shrink)
    pixels = torch.cat([level.flatten(2) for level in levels], 2)
    return read_patches(pixels, start, height, width, frame * shrink[..., None, None], PS).transpose(1, 2)


class LAFDescriptor(Module):
    """Descriptors of frames: patches, and the output of a module for patches (M, C, PS, PS).

    Args:
        patch_descriptor_module: takes (M, C, PS, PS), returns (M, D): ``SiftDescribe``, a network.
        patch_size: side PS of the patches.
        grayscale_descriptor: True converts images with three channels to grey first.

    >>> describe = LAFDescriptor(nn.Flatten(), 8)
    >>> describe(torch.rand(1, 3, 40, 40), torch.tensor([[[[9.0, 0.0, 20.0], [0.0, 9.0, 20.0]]]])).shape
    torch.Size([1, 1, 64])
    """

    def __init__(
        self, patch_descriptor_module: nn.Module, patch_size: int = 32, grayscale_descriptor: bool = True
    ) -> None:
        super().__init__()
        self.descriptor = patch_descriptor_module
        self.patch_size = patch_size
        self.grayscale_descriptor = grayscale_descriptor

    def forward(self, img: Tensor, lafs: Tensor) -> Tensor:
        patches = patches_of(img, lafs, self.patch_size, self.grayscale_descriptor, "lafs")
        return _by_frame(self.descriptor(patches), lafs)


def get_laf_descriptors(
    img: Tensor,
    lafs: Tensor,
    patch_descriptor: nn.Module,
    patch_size: int = 32,
    grayscale_descriptor: bool = True,
) -> Tensor:
    """Descriptors of frames: patches from a pyramid, and what a module makes of them.

    For eager code; ``LAFDescriptor`` is the same as a module, which can be scripted and exported.

    Args:
        img: (B, C, H, W), floating point.
        lafs: (B, N, 2, 3), floating point, in pixels.
        patch_descriptor: takes (M, C, PS, PS), returns (M, D); any callable.
        patch_size: side PS of the patches.
        grayscale_descriptor: True converts images with three channels to grey first.

    Returns:
        (B, N, D).

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape or patch_size is not as above.

    Example:
        >>> frame = torch.tensor([[[[9.0, 0.0, 20.0], [0.0, 9.0, 20.0]]]])
        >>> get_laf_descriptors(torch.rand(1, 1, 40, 40), frame, nn.Flatten(), 8).shape
        torch.Size([1, 1, 64])
    """
    patches = patches_of(img, lafs, patch_size, grayscale_descriptor, "lafs")
    return _by_frame(patch_descriptor(patches), lafs)


def patches_of(img: Tensor, laf: Tensor, PS: int, grayscale: bool, name: str = "laf") -> Tensor:
    """(B * N, C, PS, PS): patches from a pyramid; with ``grayscale``, the image is first converted to grey.
    ``name`` is the caller's for the frames."""
    check_image(img, "img")
    check_laf(laf, name)
    _check_batch(img, laf, name)
    if grayscale and img.size(1) == 3:
        img = rgb_to_grayscale(img)
    # Stored: each pixel of a patch is interpolated once, and read by all derivatives there.
    return materialised(extract_patches_from_pyramid(img, laf, PS).flatten(0, 1), 0)


def grey_patches_of(img: Tensor, laf: Tensor, PS: int, name: str = "laf") -> Tensor:
    """(B * N, 1, PS, PS): ``patches_of`` grey images or images with three channels."""
    check_image(img, "img")
    check_grey_or_rgb(img, "img")
    return patches_of(img, laf, PS, True, name)


def _by_frame(descriptors: Tensor, lafs: Tensor) -> Tensor:
    return descriptors.unflatten(0, [lafs.size(0), lafs.size(1)])


def _check_batch(img: Tensor, laf: Tensor, name: str) -> None:
    if laf.size(0) != img.size(0):
        raise ValueError(f"{name}: expected img's batch of {img.size(0)}, got {list(laf.shape)}")


def _in_pixels(img: Tensor, laf: Tensor, PS: int, in_pixels: bool) -> Tensor:
    check_image(img, "img")
    check_laf(laf, "laf")
    if PS < 1:
        raise ValueError(f"PS: expected a positive number, got {PS}")
    _check_batch(img, laf, "laf")
    frame = laf.to(position_dtype(img.dtype))
    return frame if in_pixels else denormalize_laf(frame, img)


def _pyramid(img: Tensor, count: int) -> List[Tensor]:
    levels = [img]
    for k in range(count - 1):
        levels.append(_halved(_halved(levels[k], 2), 3))
    return levels


def _halved(x: Tensor, dim: int) -> Tensor:
    """Every second slice of x blurred by (1, 4, 6, 4, 1) / 16 with a replicated border, up to the last slice
    or one beyond."""
    last = x.size(dim) - 1
    middle = 2 * torch.arange(x.size(dim) // 2 + 1, device=x.device)
    out = x.index_select(dim, middle.clamp(max=last)) * 0.375
    for k, weight in [(1, 0.25), (2, 0.0625)]:
        before, after = (middle - k).clamp(min=0, max=last), (middle + k).clamp(max=last)
        out = out + (x.index_select(dim, before) + x.index_select(dim, after)) * weight
    return out
