"""CIE XYZ."""

from torch import Tensor

from ..primitives.images.color_planes import mix_channels


def rgb_to_xyz(image: Tensor) -> Tensor:
    """CIE XYZ of linear RGB with sRGB's primaries and D65 white, (0.950456, 1, 1.088754).

    ITU-R BT.709; the matrix of OpenCV and Kornia. Nothing is linearised: give the result of
    ``rgb_to_linear_rgb`` for the colorimetric value of an sRGB image. OpenCV's uint8 form is 255 times this,
    rounded and saturated.

    Args:
        image: RGB image (*, 3, H, W) in [0, 1], floating point.

    Returns:
        (*, 3, H, W): X, Y, Z.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> rgb_to_xyz(torch.ones(1, 3, 1, 1)).flatten()
        tensor([0.9505, 1.0000, 1.0888])
    """
    return mix_channels(
        image,
        [0.412453, 0.357580, 0.180423, 0.212671, 0.715160, 0.072169, 0.019334, 0.119193, 0.950227],
        0.0,
        "image",
    )


def xyz_to_rgb(image: Tensor) -> Tensor:
    """RGB from CIE XYZ, the inverse of ``rgb_to_xyz``; the result is not clipped.

    Args:
        image: XYZ image (*, 3, H, W), floating point.

    Returns:
        (*, 3, H, W): red, green, blue.

    Raises:
        TypeError: if image is not floating point.
        ValueError: if image is not (*, 3, H, W).

    Example:
        >>> xyz_to_rgb(torch.tensor([0.950456, 1.0, 1.088754]).reshape(1, 3, 1, 1)).flatten()
        tensor([1.0000, 1.0000, 1.0000])
    """
    inverse = [
        3.240481343200526, -1.5371515162713185, -0.4985363261688878,
        -0.9692549499965682, 1.8759900014898907, 0.04155592655829284,
        0.05564663913517716, -0.20404133836651123, 1.0573110696453443,
    ]  # fmt: skip
    return mix_channels(image, inverse, 0.0, "image")
