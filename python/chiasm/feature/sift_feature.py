"""SIFT as one module: Lowe's detector, orientation and descriptor."""

from typing import Tuple

from torch import Tensor

from ..primitives.core.checks import check_choice
from .local import LocalFeature, PassLAF, ScaleSpaceDetector
from .patch_modules import LAFOrienter, SIFTDescriptor
from .patches import LAFDescriptor
from .sift import convert_sift_descriptor_layout


class SIFTFeatureScaleSpace(LocalFeature):
    """Differences of Gaussians in scale space, the dominant orientation of each keypoint, and its (Root)SIFT
    descriptor.

    D. Lowe, Distinctive Image Features from Scale-Invariant Keypoints, IJCV 60(2), 2004: the image is first
    enlarged to twice its size. Unlike Lowe's, a keypoint has one orientation, and weak contrast and edges are
    not rejected, as in Kornia.

    Args:
        num_features: the number K of slots.
        upright: True leaves all keypoints upright.
        rootsift: see ``sift_describe``.
        descriptor_layout: the order of a descriptor's entries, "kornia" or "opencv"; see
            ``convert_sift_descriptor_layout``.

    ``forward`` takes an image (B, 1 or 3, H, W) and returns what ``LocalFeature`` does: frames (B, K, 2, 3),
    whose radius is 6 times the scale, scores (B, K), valid (B, K) and descriptors (B, K, 128).

    >>> lafs, scores, valid, descriptors = SIFTFeatureScaleSpace(5)(torch.rand(1, 1, 48, 64))
    >>> lafs.shape, descriptors.shape
    (torch.Size([1, 5, 2, 3]), torch.Size([1, 5, 128]))
    """

    def __init__(
        self,
        num_features: int = 8000,
        upright: bool = False,
        rootsift: bool = True,
        descriptor_layout: str = "kornia",
    ) -> None:
        check_choice(descriptor_layout, ["kornia", "opencv"], "descriptor_layout")
        orient = PassLAF() if upright else LAFOrienter(19)
        super().__init__(
            ScaleSpaceDetector(num_features, ori_module=orient, response="dog", double_image=True),
            LAFDescriptor(SIFTDescriptor(41, rootsift=rootsift), 41),
        )
        self.num_features, self.upright, self.rootsift = num_features, upright, rootsift
        self.descriptor_layout = descriptor_layout

    def forward(self, img: Tensor) -> Tuple[Tensor, Tensor, Tensor, Tensor]:
        lafs, scores, valid, descriptors = self.described(img)
        if self.descriptor_layout == "opencv":
            descriptors = convert_sift_descriptor_layout(descriptors, "kornia", "opencv")
        return lafs, scores, valid, descriptors


class SIFTFeature(SIFTFeatureScaleSpace):
    """``SIFTFeatureScaleSpace``. Kornia's class of this name looks for blobs of one scale in a pyramid of
    images instead.

    >>> SIFTFeature(5, upright=True)(torch.rand(1, 1, 48, 64))[3].shape
    torch.Size([1, 5, 128])
    """
