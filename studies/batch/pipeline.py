"""Five ops as one function, for one bundle: prepares a camera's images for a network, with changed colours
for training."""

from typing import Tuple

import torch
from torch import Tensor

from chiasm.enhance import (
    adjust_brightness_accumulative,
    adjust_contrast_with_mean_subtraction,
    adjust_hue,
    adjust_saturation_with_gray_subtraction,
    normalize,
)
from chiasm.filters import gaussian_blur2d
from chiasm.geometry.calibration import undistort_image
from chiasm.geometry.transform import resize


def prepare(
    image: Tensor,
    camera: Tuple[float, float, float, float],
    lens: Tuple[float, float, float, float, float],
    size: Tuple[int, int],
    jitter: Tuple[float, float, float, float],
    blur: Tuple[int, float],
    mean: Tuple[float, float, float],
    std: Tuple[float, float, float],
) -> Tensor:
    """Undistort, resize (bilinear), jitter the colours, blur (Gaussian, mirrored border), normalise.

    The jitter is that of Kornia's and torchvision's ``ColorJitter``, with given instead of random factors:
    Pillow's brightness, contrast and saturation, each limited to [0, 1], then the hue.

    Args:
        image: (B, 3, H, W), RGB in [0, 1], all of one camera.
        camera: focal lengths fx, fy and principal point cx, cy, in pixels.
        lens: OpenCV's coefficients k1, k2, p1, p2, k3.
        size: height and width of the result.
        jitter: factors of brightness, contrast and saturation, and the rotation of hues, in radians. blur:
            taps and standard deviation, in pixels.
        mean, std: for the channels R, G, B.

    Returns:
        (B, 3, *size).
    """
    matrix = torch.tensor(
        [[camera[0], 0.0, camera[2]], [0.0, camera[1], camera[3]], [0.0, 0.0, 1.0]],
        dtype=image.dtype,
        device=image.device,
    )
    coefficients = torch.tensor(lens, dtype=image.dtype, device=image.device)
    # As channels of one image, so that one map serves all images.
    channels = undistort_image(image.flatten(0, 1)[None], matrix[None], coefficients[None])
    out = resize(channels.reshape(image.shape), size)
    out = adjust_brightness_accumulative(out, jitter[0])
    out = adjust_contrast_with_mean_subtraction(out, jitter[1])
    out = adjust_saturation_with_gray_subtraction(out, jitter[2])
    out = adjust_hue(out, jitter[3])
    out = gaussian_blur2d(out, blur[0], (blur[1], blur[1]))
    means, deviations = (
        torch.tensor(mean, dtype=image.dtype, device=image.device),
        torch.tensor(std, dtype=image.dtype, device=image.device),
    )
    return normalize(out, means, deviations)
