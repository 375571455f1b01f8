"""What one who comes from Kornia relies on: layouts, dtypes and ranges."""

import math

import pytest
import torch
import torch.nn.functional as F

from chiasm import color, contrib, enhance, filters
from chiasm.geometry import transform
from chiasm.geometry.camera import StereoCamera
from chiasm.geometry.conversions import axis_angle_to_quaternion, quaternion_log_to_exp
from chiasm.geometry.linalg import transform_points


@pytest.mark.parametrize("dtype", [torch.float16, torch.float32, torch.float64])
def test_points_keep_their_dtype(dtype: torch.dtype) -> None:
    matrix = torch.eye(4, dtype=torch.float64)[None]
    matrix[0, 0, 3] = 0.5
    moved = transform_points(matrix, torch.ones(1, 2, 3, dtype=dtype))
    assert moved.dtype == dtype
    assert moved[0, 0].tolist() == [1.5, 1.0, 1.0]


@pytest.mark.parametrize(
    ("dtype", "length"),
    [(torch.float16, 200.0), (torch.float16, 1e4), (torch.float32, 1e19), (torch.float32, 1e37)],
)
def test_long_vectors_do_not_overflow(dtype: torch.dtype, length: float) -> None:
    v = torch.tensor([length, 0.0, 0.0], dtype=dtype).requires_grad_()
    q = quaternion_log_to_exp(v)
    exact = v[0].item()
    expected = torch.tensor([math.cos(exact), math.sin(exact), 0.0, 0.0])
    tolerance = 2e-3 if dtype == torch.float16 else 1e-6
    torch.testing.assert_close(q.detach().float(), expected, rtol=0, atol=tolerance)
    q.sum().backward()
    assert v.grad is not None and bool(v.grad.isfinite().all())


def test_quaternions_of_any_length_equal_the_definition() -> None:
    length = torch.tensor([1e-9, 1e-3, 9.9e-3, 1.01e-2, 1.0, 49.9, 50.1, 1e4], dtype=torch.float64)
    axis = torch.tensor([2.0, -3.0, 6.0], dtype=torch.float64) / 7
    expected = torch.cat([length.cos()[:, None], length.sin()[:, None] * axis], 1)
    torch.testing.assert_close(quaternion_log_to_exp(length[:, None] * axis), expected, rtol=0, atol=1e-11)
    torch.testing.assert_close(
        axis_angle_to_quaternion(2 * length[:, None] * axis), expected, rtol=0, atol=1e-11
    )
    for scale in (1e-3, 1.0, 60.0):
        assert torch.autograd.gradcheck(quaternion_log_to_exp, (scale * axis).requires_grad_())


def test_disparities_with_the_channel_last() -> None:
    left = torch.tensor([[[100.0, 0.0, 32.0, 0.0], [0.0, 100.0, 24.0, 0.0], [0.0, 0.0, 1.0, 0.0]]])
    right = left.clone()
    right[0, 0, 3] = -50.0
    camera, disparity = StereoCamera(left, right), torch.rand(1, 1, 4, 5) + 5
    points = camera.reproject_disparity_to_3D(disparity.permute(0, 2, 3, 1))
    depth = 50.0 / disparity[:, 0]
    x = (torch.arange(5.0) - 32.0) * depth / 100.0
    torch.testing.assert_close(points[..., 2], depth)
    torch.testing.assert_close(points[..., 0], x)
    assert points.equal(camera(disparity))


def test_classes_take_keywords_and_defaults_of_their_own() -> None:
    image = torch.rand(2, 3, 8, 9)
    assert enhance.AdjustContrast(contrast_factor=0.5)(image).equal(enhance.adjust_contrast(image, 0.5))
    assert enhance.AdjustHue(hue_factor=0.1)(image).equal(enhance.adjust_hue(image, 0.1))
    normalize = enhance.Normalize((0.1, 0.2, 0.3), (1.0, 2.0, 4.0))
    expected = (image - torch.tensor([0.1, 0.2, 0.3])[:, None, None]) / torch.tensor([1.0, 2.0, 4.0])[
        :, None, None
    ]
    torch.testing.assert_close(torch.jit.script(normalize)(image), expected)
    wide = F.interpolate(image, scale_factor=2.0, mode="bilinear", align_corners=True)
    torch.testing.assert_close(transform.Rescale(2.0)(image), wide)
    patches = contrib.extract_tensor_patches(image, 4, 2, 1)
    joined = contrib.CombineTensorPatches((8, 9), 4, 2, 1, True)(
        contrib.extract_tensor_patches(image, 4, 2, 1, True)
    )
    assert patches.shape[1] == 16 and joined.shape == image.shape


def test_kornias_spellings_are_the_same_classes() -> None:
    for package, names in {
        filters: {
            "BlurPool2D": "BlurPool2d",
            "MaxBlurPool2D": "MaxBlurPool2d",
            "MotionBlur3D": "MotionBlur3d",
        },
        enhance: {"JPEGCodecDifferentiable": "JpegCodecDifferentiable"},
        color: {"ApplyColorMap": "ApplyColormap"},
    }.items():
        for name, own in names.items():
            assert getattr(package, name) is getattr(package, own) and name in dir(package)
