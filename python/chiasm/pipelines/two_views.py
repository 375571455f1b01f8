"""From two images to the homography between them."""

from typing import Tuple

import torch
from torch import Tensor

from ..feature.described import sift_laf_descriptors
from ..feature.detection import detect_keypoints
from ..feature.laf import get_laf_center
from ..feature.matching import match_smnn
from ..feature.shape import orient_laf
from ..geometry.ransac.homography import ransac_homography
from ..primitives.core.checks import check_one_channel


def two_view_homography(
    image1: Tensor,
    image2: Tensor,
    uniforms: Tensor,
    max_keypoints: int = 1000,
    response: str = "dog",
    num_octaves: int = 4,
    mr_size: float = 6.0,
    threshold: float = 0.005,
    ratio: float = 1.0,
    inl_th: float = 3.0,
    double_image: bool = False,
) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
    """Estimate the homography from one image to another: keypoints, RootSIFT, mutual matches, RANSAC.

    This combines ``detect_keypoints``, ``orient_laf``, ``sift_describe``, ``match_smnn`` and
    ``ransac_homography`` in one op, for one bundle.

    Args:
        image1, image2: grey images (B, 1, H, W), floating point, of any two sizes.
        uniforms: (B, S, 4), random numbers in [0, 1): see ``ransac_homography``.
        max_keypoints: number K of slots for keypoints in each image.
        response, num_octaves, mr_size, threshold, double_image: see ``detect_keypoints``.
        ratio: the argument th of ``match_smnn``; 1 uses all mutual nearest neighbours, since RANSAC rejects
            outliers well.
        inl_th: an inlier's distance in the second image, in pixels.

    Returns:
        homography (B, 3, 3) from image1 to image2; points1 and points2 (B, K, 2), the keypoints of image1 and
        their matches in image2, zeros in empty slots; matched (B, K) and inliers (B, K), bool, masks of the
        keypoints that are matched and of those that agree with the homography.

    Raises:
        TypeError: if an input is not floating point.
        ValueError: if a shape is not as above or a number not as the ops want it.

    Example:
        >>> from chiasm.geometry.transform import resize
        >>> image = resize(
        ...     torch.rand(1, 1, 24, 24, generator=torch.Generator().manual_seed(0)), (96, 96), "bicubic"
        ... )
        >>> moved = torch.roll(image, 4, 3)
        >>> uniforms = torch.rand(1, 100, 4, generator=torch.Generator().manual_seed(1))
        >>> homography = two_view_homography(image, moved, uniforms, 200, num_octaves=2, mr_size=3.0)[0]
        >>> homography[0, 0, 2].round()
        tensor(4.)
    """
    _check_grey(image1, "image1")
    _check_grey(image2, "image2")
    if image2.size(0) != image1.size(0):
        raise ValueError(f"image2: expected image1's batch of {image1.size(0)}, got {list(image2.shape)}")
    lafs1, _, valid1 = detect_keypoints(
        image1,
        max_keypoints,
        response,
        num_octaves,
        mr_size=mr_size,
        threshold=threshold,
        double_image=double_image,
    )
    lafs2, _, valid2 = detect_keypoints(
        image2,
        max_keypoints,
        response,
        num_octaves,
        mr_size=mr_size,
        threshold=threshold,
        double_image=double_image,
    )
    described1, described2 = _described(image1, lafs1), _described(image2, lafs2)
    _, indices, matched = match_smnn(described1, described2, ratio, None, valid1, valid2)
    points1, partners = get_laf_center(lafs1), get_laf_center(lafs2)
    chosen = indices[..., 1].clamp(min=0)[..., None]
    points2 = partners.gather(1, chosen.expand([partners.size(0), max_keypoints, 2]))
    points1, points2 = (
        torch.where(matched[..., None], points1, torch.zeros_like(points1)),
        torch.where(matched[..., None], points2, torch.zeros_like(points2)),
    )
    homography, inliers = ransac_homography(points1, points2, uniforms, inl_th, mask=matched)
    return homography, points1, points2, matched, inliers


def _check_grey(image: Tensor, name: str) -> None:
    check_one_channel(image, name)
    if image.size(2) < 8 or image.size(3) < 8:
        raise ValueError(f"{name}: expected at least 8 x 8 pixels, got {list(image.shape)}")


def _described(image: Tensor, lafs: Tensor) -> Tensor:
    return sift_laf_descriptors(image, orient_laf(lafs, image))
