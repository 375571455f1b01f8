"""Warps by homographies between normalized coordinates."""

from typing import Optional, Tuple

import torch
from torch import Tensor

from ...primitives.core.broadcasting import one_for_each
from ...primitives.core.checks import check_image, check_last, check_leading, check_pair
from ...primitives.core.modules import Module
from ...primitives.resampling.warping import (
    check_matrices,
    check_sampling,
    from_normalized,
    mapped,
    normalized_axis,
    position_dtype,
    resample_image,
    resample_projective,
)
from ..grid import create_meshgrid
from .warp import pixels_to_source


def warp_grid(grid: Tensor, src_homo_dst: Tensor) -> Tensor:
    """Transform a grid of points by homographies.

    Args:
        grid: (B or 1, H, W, 2), points (x, y).
        src_homo_dst: (B, 3, 3).

    Returns:
        (B, H, W, 2). Differentiable in both.

    Raises:
        TypeError: if an argument is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> warp_grid(torch.ones(1, 1, 1, 2), torch.diag(torch.tensor([3.0, 2.0, 0.5]))[None])
        tensor([[[[6., 4.]]]])
    """
    check_last(grid, 2, "grid")
    if grid.dim() != 4:
        raise ValueError(f"grid: expected shape (B, H, W, 2), got {list(grid.shape)}")
    check_matrices(src_homo_dst, 3, 3, "src_homo_dst")
    check_leading([grid, src_homo_dst], ["grid", "src_homo_dst"], [3, 2])
    x, y = mapped(grid[..., 0], grid[..., 1], src_homo_dst)
    return torch.stack([x, y], -1)


def homography_warp(
    patch_src: Tensor,
    src_homo_dst: Tensor,
    dsize: Tuple[int, int],
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool = False,
    normalized_coordinates: bool = True,
    normalized_homography: bool = True,
) -> Tensor:
    """Warp an image by homographies from the output to the image: out(p) = patch_src(src_homo_dst p).

    Args:
        patch_src: (B, C, H, W), floating point.
        src_homo_dst: (B, 3, 3), or (1, 3, 3) for all images, between coordinates in [-1, 1] unless one of the
            last two arguments is False.
        dsize: (height, width) of the output; may come from another tensor's shape.
        mode: "bilinear", "nearest" (halves are rounded to the even neighbour) or "bicubic" (a = -0.75, as in
            PyTorch and OpenCV).
        padding_mode: the values outside the input: "zeros", "border" (replicate), "reflection" (about the
            corner pixels' centres, or the outer edges when align_corners is False) or "fill" (black here, as
            "zeros").
        align_corners: True: coordinates -1 and 1 are the centres of the corner pixels; False: the outer
            edges.
        normalized_coordinates: when False, src_homo_dst maps output pixels to pixels of patch_src.
        normalized_homography: when False, src_homo_dst maps in the other direction, from pixels of patch_src
            to output pixels as in ``warp_perspective``, and normalized_coordinates is ignored. (Both as in
            Kornia.)

    Returns:
        (B, C, height, width). Differentiable in patch_src and src_homo_dst ("nearest": in patch_src).

    Raises:
        TypeError: if patch_src or src_homo_dst is not floating point.
        ValueError: if a shape or a choice is not as above.

    Example:
        >>> mirror = torch.diag(torch.tensor([-1.0, 1.0, 1.0]))[None]
        >>> homography_warp(torch.arange(4.0).expand(1, 1, 2, 4), mirror, (2, 4))[0, 0, 0]
        tensor([3., 2., 1., 0.])
    """
    check_image(patch_src, "patch_src")
    check_matrices(src_homo_dst, 3, 3, "src_homo_dst")
    check_sampling(mode, padding_mode)
    check_pair(dsize, "dsize")
    patch_src = one_for_each(patch_src, src_homo_dst, "patch_src", "src_homo_dst")
    if not normalized_homography:
        return resample_projective(
            patch_src,
            pixels_to_source(src_homo_dst),
            dsize[0],
            dsize[1],
            mode,
            padding_mode,
            align_corners,
            None,
        )
    if normalized_coordinates:
        precision = position_dtype(patch_src.dtype)
        column = normalized_axis(dsize[1], align_corners, precision, patch_src.device)[None, None, :]
        row = normalized_axis(dsize[0], align_corners, precision, patch_src.device)[None, :, None]
        x, y = mapped(column, row, src_homo_dst.to(precision))
        x, y = (
            from_normalized(x, patch_src.size(3), align_corners),
            from_normalized(y, patch_src.size(2), align_corners),
        )
        return resample_image(patch_src, x, y, mode, padding_mode, align_corners, None)
    return resample_projective(
        patch_src, src_homo_dst, dsize[0], dsize[1], mode, padding_mode, align_corners, None
    )


class HomographyWarper(Module):
    """``homography_warp`` as a module with a fixed output size; the homography is an argument of the call or
    set before.

    E. Riba et al., Kornia: an Open Source Differentiable Computer Vision Library for PyTorch, WACV 2020.

    Args:
        height, width: the size of the output.
        mode, padding_mode: as in :func:`homography_warp`.
        normalized_coordinates: when False, homographies map output pixels to pixels of the image.
        align_corners: as in :func:`homography_warp`.

    Shape:
        patch_src (B, C, H, W), floating point, and src_homo_dst (B, 3, 3) or (1, 3, 3), from the output to
        patch_src, to (B, C, height, width). Without src_homo_dst, the homography of ``precompute_warp_grid``
        is used.

    Raises:
        TypeError: if a tensor is not floating point.
        ValueError: if a shape or a choice is not as above, or there is no homography.

    Example:
        >>> image, mirror = (
        ...     torch.arange(4.0).expand(1, 1, 2, 4),
        ...     torch.diag(torch.tensor([-1.0, 1.0, 1.0]))[None],
        ... )
        >>> warper = HomographyWarper(2, 4)
        >>> warper(image, mirror)[0, 0, 0]
        tensor([3., 2., 1., 0.])
        >>> warper.precompute_warp_grid(mirror)
        >>> warper(image)[0, 0, 0]
        tensor([3., 2., 1., 0.])
    """

    warped_grid: Optional[Tensor]

    def __init__(
        self,
        height: int,
        width: int,
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        normalized_coordinates: bool = True,
        align_corners: bool = False,
    ) -> None:
        super().__init__()
        check_sampling(mode, padding_mode)
        self.height, self.width, self.mode, self.padding_mode = height, width, mode, padding_mode
        self.normalized_coordinates, self.align_corners = normalized_coordinates, align_corners
        self.register_buffer("warped_grid", None, persistent=False)

    @torch.jit.export
    def precompute_warp_grid(self, src_homo_dst: Tensor) -> None:
        """Store the grid of homographies (B, 3, 3) for calls without a homography."""
        check_matrices(src_homo_dst, 3, 3, "src_homo_dst")
        dtype = position_dtype(src_homo_dst.dtype)
        grid = create_meshgrid(
            self.height,
            self.width,
            self.normalized_coordinates,
            src_homo_dst.device,
            dtype,
            self.align_corners,
        )
        self.warped_grid = warp_grid(grid, src_homo_dst.to(dtype))

    def forward(self, patch_src: Tensor, src_homo_dst: Optional[Tensor] = None) -> Tensor:
        if src_homo_dst is not None:
            size = (self.height, self.width)
            return homography_warp(
                patch_src,
                src_homo_dst,
                size,
                self.mode,
                self.padding_mode,
                self.align_corners,
                self.normalized_coordinates,
            )
        grid = self.warped_grid
        if grid is None:
            raise ValueError(
                "src_homo_dst: expected a homography here or, before, for precompute_warp_grid, got None"
            )
        check_image(patch_src, "patch_src")
        if grid.size(0) != patch_src.size(0) and grid.size(0) != 1:
            raise ValueError(
                "patch_src: expected an image for each of precompute_warp_grid's"
                f" {grid.size(0)} homographies, got {list(patch_src.shape)}"
            )
        x, y = grid[..., 0], grid[..., 1]
        if self.normalized_coordinates:
            x, y = (
                from_normalized(x, patch_src.size(3), self.align_corners),
                from_normalized(y, patch_src.size(2), self.align_corners),
            )
        return resample_image(patch_src, x, y, self.mode, self.padding_mode, self.align_corners, None)
