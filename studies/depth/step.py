"""The computations at every scale. Eager Python, the exported bundles and the C++ program all run these
functions."""

from typing import Tuple

import torch
from torch import Tensor

from chiasm.geometry.depth import depth_warp
from chiasm.geometry.transform import pyrdown, resize
from chiasm.losses import inverse_depth_smoothness_loss, ssim_loss

from ..optimizers import momentum


def reduce(images: Tensor, cameras: Tensor) -> Tuple[Tensor, Tensor]:
    """The next coarser scale: images of half the size, and their cameras.

    Args:
        images: (B, 3, H, W).
        cameras: (B, 3, 3), camera matrices in pixels.

    Returns:
        (B, 3, H // 2, W // 2) and (B, 3, 3).
    """
    smaller = pyrdown(images)
    zero = torch.zeros_like(cameras[:, 0, 0])
    # An image extends half a pixel beyond the centres of its outer pixels, at every scale.
    x, y = (zero + smaller.size(3)) / images.size(3), (zero + smaller.size(2)) / images.size(2)
    scale = torch.stack([x, zero, 0.5 * x - 0.5, zero, y, 0.5 * y - 0.5, zero, zero, zero + 1.0], 1).reshape(
        -1, 3, 3
    )
    return smaller, (scale[:, :, :, None] * cameras[:, None]).sum(2)


def enlarge(inverse_depth: Tensor, like: Tensor) -> Tensor:
    """An inverse depth (1, 1, H, W) at the size of the images `like` (B, 3, H2, W2) of a finer scale."""
    return resize(inverse_depth, (like.shape[-2], like.shape[-1]))


def photometric(
    depth: Tensor,
    reference: Tensor,
    views: Tensor,
    camera: Tensor,
    view_cameras: Tensor,
    motions: Tensor,
    window: int,
    ssim_weight: float,
    l1_weight: float,
) -> Tensor:
    """The difference of the views, warped to the reference by its depth, from the reference: a mean of (1 -
    SSIM) / 2 and of absolute differences.

    The mean is over the pixels that a view covers: a point outside its image does not count.

    Args:
        depth: (1, 1, H, W), the reference's.
        reference: (1, 3, H, W).
        views: (B, 3, H, W).
        camera, view_cameras: (1, 3, 3) and (B, 3, 3).
        motions: (B, 4, 4), from the reference's frame to each view's.
        window: taps of SSIM's window.
        ssim_weight, l1_weight: weights of the two differences.

    Returns:
        A scalar.
    """
    still = torch.eye(4, dtype=depth.dtype, device=depth.device)[None]
    warped = depth_warp(view_cameras, motions, camera, still, depth, views)
    inside = depth_warp(view_cameras, motions, camera, still, depth.detach(), torch.ones_like(views[:, 0:1]))
    seen = (inside > 0.999).to(depth.dtype)
    target = reference.expand_as(warped)
    differences = (
        ssim_weight * ssim_loss(target, warped, window, reduction="none")
        + l1_weight * (target - warped).abs()
    )
    return (seen * differences.mean(1, keepdim=True)).sum() / seen.sum().clamp(min=1.0)


def step(
    inverse_depth: Tensor,
    velocity: Tensor,
    reference: Tensor,
    views: Tensor,
    camera: Tensor,
    view_cameras: Tensor,
    motions: Tensor,
    limits: Tensor,
    rate: Tensor,
    window: int,
    ssim_weight: float,
    l1_weight: float,
    smoothness: float,
    inertia: float,
) -> Tuple[Tensor, Tensor, Tensor]:
    """One step of gradient descent with momentum: loss, gradient and update.

    The unknown is the inverse depth, because a pixel's position in another view is nearly linear in it. The
    descent is in units of parallax: the pixels by which a change of the inverse depth moves a point in the
    farthest view. So one rate suits all scales and all units of length.

    Args:
        inverse_depth: (1, 1, H, W), the reference's.
        velocity: (1, 1, H, W); zeros at first.
        reference, views, camera, view_cameras, motions: as in :func:`photometric`.
        limits: (2,), the smallest and the greatest inverse depth.
        rate: (), the learning rate.
        window, ssim_weight, l1_weight: as in :func:`photometric`.
        smoothness: weight of the edge-aware smoothness of parallax.
        inertia: the part of the velocity that is kept.

    Returns:
        inverse_depth and velocity after the step, and the loss before it.
    """
    baseline = torch.sqrt((motions[:, 0:3, 3] * motions[:, 0:3, 3]).sum(1)).amax(0)
    unit = camera[0, 0, 0] * baseline
    parallax = (inverse_depth * unit).detach().requires_grad_(True)
    photo = photometric(
        unit / parallax, reference, views, camera, view_cameras, motions, window, ssim_weight, l1_weight
    )
    loss = photo + smoothness * inverse_depth_smoothness_loss(parallax, reference)
    gradient = torch.autograd.grad([loss], [parallax])[0]
    assert gradient is not None
    # Convert the gradient of the mean to that of each pixel.
    gradient = gradient * inverse_depth.size(2) * inverse_depth.size(3)
    parallax, velocity = momentum(parallax.detach(), gradient, velocity, rate, inertia)
    inverse_depth = torch.minimum(torch.maximum(parallax / unit, limits[0]), limits[1])
    return inverse_depth, velocity, loss.detach()
