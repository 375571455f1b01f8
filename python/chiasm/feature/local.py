"""Local features built from exchangeable modules, which can be scripted and exported as a whole.

A *detector* takes an image (B, C, H, W) and returns frames (B, K, 2, 3) in pixels, scores (B, K) and valid
(B, K), bool: K is fixed, and slots without a feature hold zeros. A *descriptor* takes the image and the
frames and returns (B, K, D): ``LAFDescriptor`` builds one from a network for patches. A *matcher* takes the
descriptors, frames and masks of both images, and returns the same as ``match_nn``. Each of them can be any
nn.Module that torch.jit.script accepts; its ``forward`` must be annotated, since TorchScript takes an
argument without annotation for a Tensor.
"""

from typing import Any, List, Optional, Tuple, Union

import torch
from torch import Tensor, nn

from ..color.gray import rgb_to_grayscale
from ..geometry.transform.pyramid import ScalePyramid
from ..primitives.core.checks import check_choice, check_image, check_positive
from ..primitives.core.modules import Module
from .adalam import match_adalam
from .detection import detect_keypoints
from .laf import get_laf_center, scale_laf
from .matching import match_fginn, match_mnn, match_nn, match_smnn, match_snn
from .patch_modules import DescriptorMatcher
from .response_modules import response_name

_MODES = ["nn", "mnn", "snn", "smnn", "fginn", "adalam"]


class PassLAF(Module):
    """Return frames unchanged: a placeholder for no orientation and no affine shape.

    >>> PassLAF()(torch.ones(1, 1, 2, 3), torch.rand(1, 1, 8, 8)).shape
    torch.Size([1, 1, 2, 3])
    """

    def forward(self, laf: Tensor, img: Tensor) -> Tensor:
        return laf


class ScaleSpaceDetector(Module):
    """A detector: ``detect_keypoints``, and the affine shape and the orientation of its frames.

    Args:
        num_features: the number of slots, ``max_keypoints`` of ``detect_keypoints``.
        mr_size: see ``detect_keypoints``.
        scale_pyr_module: a ``ScalePyramid`` that sets n_levels, init_sigma and double_image, and takes all
            octaves; it is not run, and its min_size has no effect: octaves end at 8 pixels.
        resp_module: ``CornerHarris(0.04)``, ``CornerGFTT()``, ``BlobHessian()`` or ``BlobDoG()``, which sets
            response; it is not run.
        subpix_module: must be None: keypoints are refined as ``detect_keypoints`` says.
        ori_module: takes frames and the image, returns frames, applied after aff_module: for example
            ``OrientLaf()``. None keeps upright frames.
        aff_module: the same, for example ``AdaptLafShape()`` or a network for patches. None keeps disks.
        minima_are_also_good: for ``BlobDoG()`` True, otherwise False; by response, None.
        scale_space_response, compile_modules: for compatibility with Kornia; they have no effect.
        response, num_octaves, n_levels, init_sigma, threshold, double_image: see ``detect_keypoints``.

    ``forward`` takes (B, 1 or 3, H, W) and converts colours to grey; aff_module and ori_module get the
    original image.

    >>> detect = ScaleSpaceDetector(5, mr_size=3, response="dog", num_octaves=2)
    >>> lafs, scores, valid = detect(torch.rand(1, 3, 64, 80))
    >>> lafs.shape, scores.shape, valid.shape
    (torch.Size([1, 5, 2, 3]), torch.Size([1, 5]), torch.Size([1, 5]))
    """

    def __init__(
        self,
        num_features: int = 500,
        mr_size: float = 6.0,
        scale_pyr_module: Optional[ScalePyramid] = None,
        resp_module: Optional[nn.Module] = None,
        subpix_module: Optional[nn.Module] = None,
        ori_module: Optional[nn.Module] = None,
        aff_module: Optional[nn.Module] = None,
        minima_are_also_good: Optional[bool] = None,
        scale_space_response: bool = False,
        compile_modules: Union[bool, List[str]] = False,
        *,
        response: str = "hessian",
        num_octaves: int = 4,
        n_levels: int = 3,
        init_sigma: float = 1.6,
        threshold: float = 0.0,
        double_image: bool = False,
    ) -> None:
        super().__init__()
        if subpix_module is not None:
            raise ValueError(
                f"subpix_module: expected None, the refinement of detect_keypoints, got {subpix_module}"
            )
        if scale_pyr_module is not None:
            n_levels, init_sigma = scale_pyr_module.n_levels, scale_pyr_module.init_sigma
            double_image, num_octaves = scale_pyr_module.double_image, 16
        if resp_module is not None:
            response = response_name(resp_module)
        if minima_are_also_good is not None and minima_are_also_good != (response == "dog"):
            raise ValueError(
                f"minima_are_also_good: expected {response == 'dog'} for the response '{response}', got"
                f" {minima_are_also_good}"
            )
        self.num_features, self.response, self.num_octaves, self.n_levels = (
            num_features,
            response,
            num_octaves,
            n_levels,
        )
        self.init_sigma, self.mr_size, self.threshold, self.double_image = (
            float(init_sigma),
            float(mr_size),
            float(threshold),
            double_image,
        )
        self.aff_module = PassLAF() if aff_module is None else aff_module
        self.ori_module = PassLAF() if ori_module is None else ori_module

    def forward(self, img: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
        check_image(img, "img")
        grey = rgb_to_grayscale(img) if img.size(1) == 3 else img
        lafs, scores, valid = detect_keypoints(
            grey,
            self.num_features,
            self.response,
            self.num_octaves,
            self.n_levels,
            self.init_sigma,
            self.mr_size,
            self.threshold,
            self.double_image,
        )
        return _where(valid, self.ori_module(self.aff_module(lafs, img), img)), scores, valid


class LocalFeature(Module):
    """Frames of an image and their descriptors.

    Args:
        detector: ``ScaleSpaceDetector``, or any other module (see above).
        descriptor: ``LAFDescriptor(SiftDescribe())``, ``LAFDescriptor`` of a network, or any other module
            (see above).
        scaling_coef: positive; frames are this many times as large for the descriptor, and in the result.

    ``forward`` takes an image and returns frames (B, K, 2, 3), scores (B, K), valid (B, K) and descriptors
    (B, K, D), zeros where not valid.

    >>> from chiasm.feature import LAFDescriptor, OrientLaf, SiftDescribe
    >>> detector = ScaleSpaceDetector(5, num_octaves=2, mr_size=3.0, ori_module=OrientLaf())
    >>> feature = LocalFeature(detector, LAFDescriptor(SiftDescribe(), 16))
    >>> lafs, scores, valid, descriptors = feature(torch.rand(1, 1, 64, 80))
    >>> descriptors.shape
    torch.Size([1, 5, 128])
    """

    def __init__(self, detector: nn.Module, descriptor: nn.Module, scaling_coef: float = 1.0) -> None:
        super().__init__()
        check_positive(scaling_coef, "scaling_coef")
        self.detector = detector
        self.descriptor = descriptor
        self.scaling_coef = float(scaling_coef)

    def forward(self, img: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
        return self.described(img)

    def described(self, img: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
        """``forward``, for a class that goes on from its results."""
        lafs, scores, valid = self.detector(img)
        if self.scaling_coef != 1.0:
            lafs = _where(valid, scale_laf(lafs, self.scaling_coef))
        return lafs, scores, valid, _where(valid, self.descriptor(img, lafs))


class GeometryAwareDescriptorMatcher(Module):
    """A matcher: one of the ``match_*`` functions.

    Args:
        match_mode: "nn", "mnn", "snn", "smnn", "fginn" or "adalam".
        th: the largest ratio that passes the ratio test, in modes with such a test.

    ``forward`` takes descriptors, frames and masks of both images (the masks may be left out), and returns
    the same as ``match_nn``. "adalam" computes its radii from the image sizes; here these are the sizes of
    the bounding rectangles of the frames.

    >>> frames = torch.eye(2, 3).expand(1, 2, 2, 3)
    >>> match = GeometryAwareDescriptorMatcher("mnn")
    >>> match(torch.tensor([[[0.0], [5.0]]]), torch.tensor([[[4.0], [1.0]]]), frames, frames)[1]
    tensor([[[0, 1],
             [1, 0]]])
    """

    def __init__(self, match_mode: str = "fginn", th: float = 0.8) -> None:
        super().__init__()
        check_choice(match_mode, _MODES, "match_mode")
        self.match_mode = match_mode
        self.th = float(th)

    def forward(
        self,
        desc1: Tensor,
        desc2: Tensor,
        lafs1: Tensor,
        lafs2: Tensor,
        mask1: Optional[Tensor] = None,
        mask2: Optional[Tensor] = None,
    ) -> Tuple[Tensor, Tensor, Tensor]:
        if self.match_mode == "nn":
            return match_nn(desc1, desc2, None, mask1, mask2)
        if self.match_mode == "mnn":
            return match_mnn(desc1, desc2, None, mask1, mask2)
        if self.match_mode == "snn":
            return match_snn(desc1, desc2, self.th, None, mask1, mask2)
        if self.match_mode == "smnn":
            return match_smnn(desc1, desc2, self.th, None, mask1, mask2)
        if self.match_mode == "fginn":
            return match_fginn(desc1, desc2, lafs1, lafs2, self.th, mask1=mask1, mask2=mask2)
        return match_adalam(desc1, desc2, lafs1, lafs2, mask1=mask1, mask2=mask2)


class LocalFeatureMatcher(Module):
    """Matches between two images.

    Args:
        local_feature: ``LocalFeature``, or any module that takes an image and returns the same.
        matcher: a mode of ``GeometryAwareDescriptorMatcher``, or any matcher (see above), or a
            ``DescriptorMatcher``, whose mode and ratio are taken.

    In eager Python a call also takes Kornia's dictionary, of "image0" and "image1", and returns Kornia's, of
    the M matches of all pairs of images: "keypoints0" and "keypoints1" (M, 2), "lafs0" and "lafs1"
    (1, M, 2, 3), "confidence" (M,), 1 less the distance, and "batch_indexes" (M,), the number of each pair.

    ``forward`` takes two images of the same batch and any two sizes. It returns, for each of the K slots of
    the first image: points1 and points2 (B, K, 2), x and y in pixels; distances (B, K) from the matcher;
    valid (B, K), bool, a mask of the slots that hold a match; lafs1 and lafs2 (B, K, 2, 3), frames of both
    images. All except valid are zeros in slots without a match.

    >>> from chiasm.feature import LAFDescriptor
    >>> feature = LocalFeature(
    ...     ScaleSpaceDetector(8, num_octaves=2, mr_size=3.0), LAFDescriptor(nn.Flatten(), 8)
    ... )
    >>> img = torch.rand(1, 1, 64, 80, generator=torch.Generator().manual_seed(0))
    >>> points1, points2, distances, valid, _, _ = LocalFeatureMatcher(feature, "smnn")(img, img)
    >>> bool(valid.all()), points1.equal(points2)
    (True, True)
    """

    def __init__(self, local_feature: nn.Module, matcher: Union[str, nn.Module] = "smnn") -> None:
        super().__init__()
        self.local_feature = local_feature
        if isinstance(matcher, DescriptorMatcher):
            matcher = GeometryAwareDescriptorMatcher(matcher.match_mode, matcher.th)
        self.matcher = GeometryAwareDescriptorMatcher(matcher) if isinstance(matcher, str) else matcher

    def __call__(self, *images: Any) -> Any:
        """``forward``, or what Kornia's class makes of its dictionary."""
        if len(images) != 1 or not isinstance(images[0], dict):
            return super().__call__(*images)
        given = images[0]
        if set(given) != {"image0", "image1"}:
            raise ValueError(f"data: expected 'image0' and 'image1', got {sorted(given)}")
        made = super().__call__(given["image0"], given["image1"])
        points1, points2, distances, valid, lafs1, lafs2 = made
        return {
            "keypoints0": points1[valid],
            "keypoints1": points2[valid],
            "lafs0": lafs1[valid][None],
            "lafs1": lafs2[valid][None],
            "confidence": 1.0 - distances[valid],
            "batch_indexes": valid.nonzero()[:, 0],
        }

    def forward(self, img1: Tensor, img2: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]:
        lafs1, _, valid1, descriptors1 = self.local_feature(img1)
        lafs2, _, valid2, descriptors2 = self.local_feature(img2)
        distances, indices, valid = self.matcher(descriptors1, descriptors2, lafs1, lafs2, valid1, valid2)
        chosen = indices[..., 1].clamp(min=0)[..., None, None]
        lafs1, lafs2 = _where(valid, lafs1), _where(valid, lafs2.gather(1, chosen.expand(-1, -1, 2, 3)))
        return get_laf_center(lafs1), get_laf_center(lafs2), distances[..., 0], valid, lafs1, lafs2


def _where(valid: Tensor, x: Tensor) -> Tensor:
    """Zeros where slots (B, K) of x (B, K, ...) are not valid."""
    return torch.where(valid.reshape(list(valid.shape) + [1] * (x.dim() - 2)), x, torch.zeros_like(x))
