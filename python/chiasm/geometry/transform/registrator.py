# An attribute of an nn.Module is declared as a Tensor or a Module, whichever it is.
# pyright: reportArgumentType=false, reportCallIssue=false, reportIndexIssue=false, reportOperatorIssue=false
"""Registration of images by gradient descent: learn a transform that aligns one image with another.

E. Riba et al., Kornia: an Open Source Differentiable Computer Vision Library for PyTorch, WACV 2020. From
coarse to fine, as in B. Lucas, T. Kanade, An Iterative Image Registration Technique with an Application to
Stereo Vision, IJCAI 1981.
"""

from typing import Callable, List, Optional, Tuple, Type, Union

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from ...primitives.core.checks import check_choice, check_image
from ...primitives.core.modules import Module, shown
from ...primitives.linalg.matrices import inverse3x3
from .homography_warp import HomographyWarper
from .pyramid import build_pyramid
from .resize import resize


class Homography(nn.Module):
    """Learnable homographies between normalized coordinates; they start as the identity.

    Shape:
        forward() and forward_inverse(): (B, 3, 3), the last entry 1, B being 1 unless ``reset_model`` was
        told otherwise.

    Example:
        >>> Homography()()[0]
        tensor([[1., 0., 0.],
                [0., 1., 0.],
                [0., 0., 1.]], grad_fn=<SelectBackward0>)
    """

    def __init__(self) -> None:
        super().__init__()
        self.model = nn.Parameter(torch.eye(3)[None])

    def reset_model(self, batch_size: int = 1, aspect: float = 1.0) -> None:
        """Reset to the identity, for ``batch_size`` images. ``aspect`` has no effect here."""
        like = self.model
        self.model = nn.Parameter(torch.eye(3, dtype=like.dtype, device=like.device).repeat(batch_size, 1, 1))

    def forward(self) -> Tensor:
        return self.model / self.model[:, 2:, 2:]

    @torch.jit.export
    def forward_inverse(self) -> Tensor:
        """The inverse of the result of ``forward``."""
        return _inverse(self.model)


class Similarity(Module):
    """Learnable rotations, scalings and shifts, or some of these, between normalized coordinates. They start
    as the identity. Points are rotated about the image centre and scaled, in pixels, and then shifted.

    Args:
        rotation, scale, shift: True for the parts that are learned.

    Attributes:
        rot: (B,), angles in radians, clockwise as seen.
        scale: (B,), factors.
        shift: (B, 2), along x and y, in halves of the image's width and height.

    Shape:
        forward() and forward_inverse(): (B, 3, 3), B being 1 unless ``reset_model`` was told otherwise.

    Example:
        >>> [name for name, p in Similarity(scale=False).named_parameters() if p.requires_grad]
        ['rot', 'shift']
    """

    def __init__(self, rotation: bool = True, scale: bool = True, shift: bool = True) -> None:
        super().__init__()
        self.learned = (rotation, scale, shift)
        self.rot, self.scale, self.shift = (
            nn.Parameter(torch.zeros(1)),
            nn.Parameter(torch.ones(1)),
            nn.Parameter(torch.zeros(1, 2)),
        )
        self.reset_model()

    def reset_model(self, batch_size: int = 1, aspect: float = 1.0) -> None:
        """Reset to the identity, for ``batch_size`` images whose width is ``aspect`` times their height."""
        self.aspect = aspect
        like = self.rot.detach()
        values = (like.new_zeros(batch_size), like.new_ones(batch_size), like.new_zeros(batch_size, 2))
        for name, value, learned in zip(("rot", "scale", "shift"), values, self.learned):
            setattr(self, name, nn.Parameter(value, requires_grad=learned))

    def forward(self) -> Tensor:
        along, across = self.scale * torch.cos(self.rot), self.scale * torch.sin(self.rot)
        zero, one = torch.zeros_like(along), torch.ones_like(along)
        rows = [
            [along, -across / self.aspect, self.shift[:, 0]],
            [across * self.aspect, along, self.shift[:, 1]],
            [zero, zero, one],
        ]
        return torch.stack([torch.stack(row, -1) for row in rows], -2)

    @torch.jit.export
    def forward_inverse(self) -> Tensor:
        """The inverse of the result of ``forward``."""
        return _inverse(self.forward())

    def extra_repr(self) -> str:
        rotation, scale, shift = self.learned
        return shown(self, rotation=rotation, scale=scale, shift=shift)


def _inverse(matrix: Tensor) -> Tensor:
    inverse = inverse3x3(matrix.to(torch.float64)).to(matrix.dtype)
    return inverse / inverse[:, 2:, 2:]


class ImageRegistrator(Module):
    """Find transforms that align images with other images: by default Adam on the absolute difference, over
    an image pyramid from coarse to fine. Each level starts with the result of the level before. Only pixels
    whose source lies inside the image count. Each image of a batch has its own transform. This is a loop in
    eager Python; the warper and the models can be scripted.

    Args:
        model_type: "homography", "similarity", "translation", "scale" or "rotation"; or a module like
            :class:`Homography`, with parameters, ``forward()`` that returns (B, 3, 3), ``forward_inverse()``
            and ``reset_model(batch_size, aspect)``.
        optimizer: class of the optimizer.
        loss_fn: a function of two images and reduction="none" that returns the loss of each pixel.
        pyramid_levels: number of levels; each has half the size of the level before.
        lr: learning rate at each level, in halves of the image's width and height.
        num_iterations: the maximum number of steps at each level.
        tolerance: a level ends when one step changes the loss by less than this; 0 for never. On images in
            [0, 1], 1e-4 can save half of the time, with two to three times the error.
        warper: a function of (height, width) that returns a module like :class:`HomographyWarper`.
        allow_shape_mismatch: True resizes the source images to the size of the destination images.

    Raises:
        ValueError: if model_type or a number is not as above.

    Example:
        >>> row = torch.linspace(-1, 1, 32)
        >>> image = torch.exp(-4 * (row * row + row[:, None] ** 2))[None, None]
        >>> registrator = ImageRegistrator("translation", pyramid_levels=2)
        >>> homography = registrator.register(image, torch.roll(image, 2, 3))
        >>> (homography[0, :2, 2] * 16).round() + 0.0
        tensor([-2.,  0.])
    """

    def __init__(
        self,
        model_type: Union[str, nn.Module] = "homography",
        optimizer: Type[torch.optim.Optimizer] = torch.optim.Adam,
        loss_fn: Callable[..., Tensor] = F.l1_loss,
        pyramid_levels: int = 5,
        lr: float = 1e-3,
        num_iterations: int = 200,
        tolerance: float = 0.0,
        warper: Callable[[int, int], nn.Module] = HomographyWarper,
        allow_shape_mismatch: bool = False,
    ) -> None:
        super().__init__()
        if pyramid_levels < 1 or num_iterations < 1:
            raise ValueError(
                f"pyramid_levels, num_iterations: expected positive numbers, got ({pyramid_levels},"
                f" {num_iterations})"
            )
        self.model = _model(model_type) if isinstance(model_type, str) else model_type
        self.optimizer, self.loss_fn, self.warper = optimizer, loss_fn, warper
        self.allow_shape_mismatch = allow_shape_mismatch
        self.pyramid_levels, self.lr, self.num_iterations, self.tolerance = (
            pyramid_levels,
            lr,
            num_iterations,
            tolerance,
        )

    def get_single_level_loss(self, img_src: Tensor, img_dst: Tensor, transform_model: Tensor) -> Tensor:
        """Mean loss of img_src (B, C, H, W), warped by (B, 3, 3), over the pixels that it covers; summed over
        the images, which are learned independently."""
        warp = self.warper(img_dst.size(2), img_dst.size(3))
        loss = self.loss_fn(warp(img_src, transform_model), img_dst, reduction="none").mean(1)
        return mean_over_covered(
            loss, warp(torch.ones_like(img_src[:, :1]), transform_model.detach())[:, 0]
        ).sum()

    @torch.enable_grad()
    def register(
        self,
        src_img: Tensor,
        dst_img: Tensor,
        verbose: bool = False,
        output_intermediate_models: bool = False,
    ) -> Union[Tensor, Tuple[Tensor, List[Tensor]]]:
        """Learn the transforms that align source images with destination images, starting from the identity.

        Args:
            src_img: (B, C, H, W), floating point, values of the order of 1.
            dst_img: (B, C, H, W); with ``allow_shape_mismatch`` of any height and width.
            verbose: print the loss at the end of each level.
            output_intermediate_models: also return the transforms of each level, the coarsest first.

        Returns:
            (B, 3, 3), from dst_img to src_img in normalized coordinates, as :class:`HomographyWarper` takes
            them: ``denormalize_homography(result, (H, W), (H, W), align_corners=False)`` is in pixels. With
                output_intermediate_models, a list of such tensors follows.

        Raises:
            TypeError: if an image is not floating point.
            ValueError: if the shapes are not as above, or the images too small for the pyramid.
        """
        check_image(src_img, "src_img")
        check_image(dst_img, "dst_img")
        if self.allow_shape_mismatch and src_img.shape[2:] != dst_img.shape[2:]:
            src_img = resize(src_img, (dst_img.size(2), dst_img.size(3)))
        if src_img.shape != dst_img.shape:
            raise ValueError(
                f"dst_img: expected src_img's shape {list(src_img.shape)}, got {list(dst_img.shape)}"
            )
        self.model.to(src_img).reset_model(src_img.size(0), src_img.size(3) / src_img.size(2))
        sources, targets = (
            build_pyramid(image.detach(), self.pyramid_levels) for image in (src_img, dst_img)
        )
        models = []
        for source, target in zip(sources[::-1], targets[::-1]):
            self._descend(source, target)
            models.append(self.model().detach())
            if verbose:
                loss = self.get_single_level_loss(source, target, models[-1])
                print(f"{source.size(3)} x {source.size(2)} pixels: loss {loss.item():.6f}")
        return (models[-1], models) if output_intermediate_models else models[-1]

    def warp_src_into_dst(self, src_img: Tensor) -> Tensor:
        """Source images (B, C, H, W), warped to the destination images by the last learned transforms."""
        return self.warper(src_img.size(2), src_img.size(3))(src_img, self.model())

    def warp_dst_into_src(self, dst_img: Tensor) -> Tensor:
        """Destination images (B, C, H, W), warped to the source images."""
        return self.warper(dst_img.size(2), dst_img.size(3))(dst_img, self.model.forward_inverse())

    def _descend(self, source: Tensor, target: Tensor) -> None:
        """The steps of one level."""
        optimizer = self.optimizer(self.model.parameters(), lr=self.lr)
        before: Optional[float] = None
        for _ in range(self.num_iterations):
            optimizer.zero_grad()
            loss = self.get_single_level_loss(source, target, self.model())
            loss.backward()
            optimizer.step()
            if self.tolerance > 0.0:
                now = loss.item()
                if before is not None and abs(now - before) < self.tolerance:
                    return
                before = now


def mean_over_covered(loss: Tensor, coverage: Tensor) -> Tensor:
    """Means (B,) of losses (B, H, W) over the pixels whose source lies inside the image: where ``coverage``
    (B, H, W) is 1. ``coverage`` is an image of ones, warped like the image."""
    covered = (coverage > 0.999).to(loss.dtype)
    return (loss * covered).sum((1, 2)) / covered.sum((1, 2)).clamp(min=1.0)


def _model(name: str) -> nn.Module:
    check_choice(name, ["homography", "similarity", "translation", "scale", "rotation"], "model_type")
    if name == "homography":
        return Homography()
    every = name == "similarity"
    return Similarity(every or name == "rotation", every or name == "scale", every or name == "translation")
