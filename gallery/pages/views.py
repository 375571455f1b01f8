"""The photographs that show an op best."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gallery.photographs import View

CARD, SMALL = (236, 177), (118, 88)

PORTRAIT = View("astronaut.png", (0, 0, 512, 384), CARD)
FACE = View("astronaut.png", (165, 50, 283, 138))
CAT = View("chelsea.png", (50, 0, 450, 300), CARD)
EYE = View("chelsea.png", (265, 80, 383, 168))
CUP = View("coffee.png", (60, 0, 593, 400), CARD)
COINS = View("coins.png", (60, 60, 384, 303), CARD)
MOON = View("moon.png", (0, 60, 512, 444), CARD)
NIGHT = View("rocket.jpg", (35, 0, 604, 427), CARD)
HORSE = View("horse.png", None, (216, 177))
PAGE = View("page.png", (110, 2, 228, 90))
MIDDLE = View("page.png", (0, 0, 236, 177))
TINY = View("chelsea.png", (265, 80, 385, 170), (40, 30))
STARS = View("hubble_deep_field.jpg", (330, 180, 448, 268))


@dataclass(frozen=True)
class Scene:
    """Photographs of one size, and the result's size (height, width) for ops that take it."""

    views: tuple[View, ...]
    target: tuple[int, int] | None = None

    def images(self) -> np.ndarray:
        """(B, H, W, 3)."""
        return np.stack([v.pixels() for v in self.views])


QUARTERS = tuple(View("coffee.png", (x, y, x + 236, y + 177), SMALL) for y in (20, 197) for x in (100, 336))

#: Losses on classes.
CLASSIFIED = ("binary_focal", "dice", "focal", "hausdorff", "lovasz", "one_hot", "tversky")
#: By the beginning of an op's name; the longest match counts.
SCENES = {
    "": Scene((PORTRAIT,)),
    "augmentation": Scene((PORTRAIT, CAT)),
    "color.raw_to_rgb": Scene((EYE,)),
    "color.rgb_to_raw": Scene((EYE,)),
    "contrib.connected": Scene((COINS,)),
    "contrib.distance_transform": Scene((HORSE,)),
    "contrib.extract_tensor_patches": Scene((TINY,)),
    "contrib.combine_tensor_patches": Scene((replace(TINY, size=None),)),
    "contrib.kmeans": Scene((CUP,)),
    "enhance": Scene((CAT,)),
    "enhance.adjust_gamma": Scene((NIGHT,)),
    "enhance.adjust_log": Scene((NIGHT,)),
    "enhance.adjust_log.inverse": Scene((CAT,)),
    "enhance.autocontrast": Scene((MOON,)),
    "enhance.clahe": Scene((NIGHT,)),
    "enhance.count_histogram": Scene((CUP,)),
    "enhance.equalize": Scene((NIGHT,)),
    "enhance.image_histogram2d": Scene((CUP,)),
    "enhance.jpeg": Scene((EYE,)),
    "enhance.sharpness": Scene((EYE,)),
    "feature": Scene((View("camera.png", (100, 40, 452, 304), CARD),)),
    "feature.mean_patch": Scene((PORTRAIT,)),
    "filters": Scene((EYE,)),
    "filters.adaptive_threshold": Scene((PAGE,)),
    "filters.bilateral_blur": Scene((replace(FACE, noise=12),)),
    "filters.canny": Scene((CUP,)),
    "filters.edge_aware": Scene((FACE,)),
    "filters.fast_guided_blur": Scene((replace(FACE, noise=12),)),
    "filters.guided_blur": Scene((replace(FACE, noise=12),)),
    "filters.in_range": Scene((PORTRAIT,)),
    "filters.joint_bilateral": Scene((replace(FACE, noise=12),)),
    "filters.median": Scene((replace(FACE, specks=0.08),)),
    "filters.non_local_means": Scene((replace(FACE, noise=12),)),
    "filters.otsu": Scene((COINS,)),
    "filters.prewitt": Scene((CUP,)),
    "filters.roberts": Scene((CUP,)),
    "filters.scharr": Scene((CUP,)),
    "filters.sobel": Scene((CUP,)),
    "filters.spatial_gradient": Scene((CUP,)),
    "geometry.homography": Scene((PORTRAIT,)),
    "geometry.transform.resize": Scene((View("chelsea.png", (275, 90, 334, 134)),), (177, 236)),
    "geometry.transform.resize.bicubic_antialias": Scene((View("camera.png", (0, 40, 472, 394)),), (88, 118)),
    "geometry.transform.resize.bilinear_antialias": Scene(
        (View("camera.png", (0, 40, 472, 394)),), (88, 118)
    ),
    "geometry.transform.warp_perspective": Scene((PORTRAIT,), CARD[::-1]),
    "image.draw_point2d": Scene((FACE,)),
    "image.make_grid": Scene(QUARTERS),
    "losses": Scene((CAT,)),
    **{f"losses.{name}": Scene((HORSE,)) for name in CLASSIFIED},
    "metrics": Scene((HORSE,)),
    "metrics.mean_average_precision": Scene((COINS,)),
    "metrics.mean_iou_bbox": Scene((COINS,)),
    "metrics.psnr": Scene((CAT,)),
    "metrics.ssim3d": Scene((CAT,)),
    "morphology": Scene((PAGE,)),
    "morphology.gradient": Scene((MIDDLE,)),
    "morphology.max_filter2d": Scene((EYE,)),
    "morphology.min_filter2d": Scene((EYE,)),
    "morphology.reconstruction": Scene((COINS,)),
    "morphology.skeletonize": Scene((HORSE,)),
    "morphology.thin": Scene((HORSE,)),
    "morphology.top_hat": Scene((STARS,)),
    "pipelines.two_view": Scene((View("astronaut.png", (0, 0, 512, 384), (354, 266)),)),
}


def scene(name: str) -> Scene:
    """The photographs for an op."""
    return SCENES[max((key for key in SCENES if name.startswith(key)), key=len)]
