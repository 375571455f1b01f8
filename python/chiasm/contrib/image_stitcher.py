"""Panoramas of overlapping images, for eager Python: their width depends on the images."""

from typing import List, Optional, Tuple

import torch
from torch import Tensor, nn

from ..color.gray import rgb_to_grayscale
from ..geometry.homography import find_homography_dlt_iterated
from ..geometry.ransac import RANSAC
from ..geometry.transform.warp import warp_perspective
from ..primitives.core.checks import check_choice, check_image
from ..primitives.core.modules import Module


class ImageStitcher(Module):
    """Stitch images from left to right into one panorama, by homographies between neighbours.

    M. Brown, D. Lowe, Automatic Panoramic Image Stitching using Invariant Features, IJCV 74(1), 2007, without
    its adjustment and blending: each next image is warped onto the panorama so far, and covers it.

    Args:
        matcher: takes two grey images (B, 1, H, W) and returns what ``feature.LocalFeatureMatcher`` does.
        estimator: "ransac", or "vanilla", a weighted fit to all matches.
        blending_method: "naive": in an overlap, the image on the right is seen.

    ``forward`` takes images (B, 3, H, W), floating point, of one height and any widths, and returns the
    panorama (B, 3, H, W'), in the first image's coordinates. What lies to the left of the first image, above
    or below it is lost; W' ends with the last column that an image covers, and what none covers is 0.

    Raises:
        TypeError: if an image is not floating point.
        ValueError: if a setting is not as above, an image's shape does not fit, or a pair has fewer than 4
            matches.

    Example:
        >>> from chiasm.feature import LocalFeatureMatcher, SIFTFeature
        >>> stitcher = ImageStitcher(LocalFeatureMatcher(SIFTFeature(200), "smnn"))
        >>> stitcher.estimator, stitcher.blending_method
        ('ransac', 'naive')
    """

    def __init__(self, matcher: nn.Module, estimator: str = "ransac", blending_method: str = "naive") -> None:
        super().__init__()
        check_choice(estimator, ["ransac", "vanilla"], "estimator")
        check_choice(blending_method, ["naive"], "blending_method")
        self.matcher, self.estimator, self.blending_method = matcher, estimator, blending_method
        self.ransac = RANSAC("homography")

    def forward(self, *imgs: Tensor) -> Tensor:
        if not imgs:
            raise ValueError("imgs: expected at least one image, got none")
        for img in imgs:
            check_image(img, "imgs")
            first = imgs[0]
            if img.size(1) != 3 or img.size(0) != first.size(0) or img.size(2) != first.size(2):
                raise ValueError(
                    f"imgs: expected shape ({first.size(0)}, 3, {first.size(2)}, W), got {list(img.shape)}"
                )
        panorama, mask = imgs[0], torch.ones_like(imgs[0][:, :1])
        for img in imgs[1:]:
            panorama, mask = self.stitch_pair(panorama, img, mask)
            width = int(mask.amax((0, 1, 2)).nonzero().max()) + 1
            panorama, mask = panorama[..., :width], mask[..., :width]
        return panorama

    def stitch_pair(
        self,
        images_left: Tensor,
        images_right: Tensor,
        mask_left: Optional[Tensor] = None,
        mask_right: Optional[Tensor] = None,
    ) -> Tuple[Tensor, Tensor]:
        """Images (B, 3, H, W1) and (B, 3, H, W2) as (B, 3, H, W1 + W2), in the coordinates of the left one,
        and (B, 1, H, W1 + W2), 1 where an image covers a pixel completely, else 0.

        The masks, (B, 1, H, W), of the images, are ones by default.
        """
        left = torch.ones_like(images_left[:, :1]) if mask_left is None else mask_left
        right = torch.ones_like(images_right[:, :1]) if mask_right is None else mask_right
        matched = self.matcher(rgb_to_grayscale(images_left), rgb_to_grayscale(images_right))
        homography = self.estimate_transform(matched[0], matched[1], matched[3])
        size = (images_left.size(2), images_left.size(3) + images_right.size(3))
        warped = warp_perspective(
            torch.cat([images_right, right], 1), homography.to(images_right.dtype), size
        )
        covered = warped[:, 3:] > 1.0 - 1e-3
        beside = [0, images_right.size(3)]
        base, mask = nn.functional.pad(images_left, beside), nn.functional.pad(left, beside)
        return torch.where(covered, warped[:, :3], base), torch.where(covered, torch.ones_like(mask), mask)

    def estimate_transform(self, points1: Tensor, points2: Tensor, valid: Tensor) -> Tensor:
        """The homographies (B, 3, 3) from points2 to points1, (B, K, 2), where valid (B, K)."""
        found: List[Tensor] = []
        for sample, (to, of, use) in enumerate(zip(points1, points2, valid)):
            if int(use.sum()) < 4:
                raise ValueError(
                    f"imgs: expected at least 4 matches between neighbours, got {int(use.sum())} for sample"
                    f" {sample}"
                )
            to, of = to[use], of[use]
            if self.estimator == "ransac":
                found.append(self.ransac(of, to)[0])
            else:
                found.append(
                    find_homography_dlt_iterated(of[None], to[None], torch.ones_like(of[None, :, 0]))[0]
                )
        return torch.stack(found)
