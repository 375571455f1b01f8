"""Modules for patches and frames with Kornia's names, which accept networks. Without a network they are
``sift_describe``, ``dominant_orientation``, ``affine_shape``, ``orient_laf`` and ``adapt_laf_shape``.
"""

from typing import Optional, Tuple

from torch import Tensor, nn

from ..geometry.conversions import rad2deg
from ..primitives.core.checks import check_choice
from ..primitives.core.modules import Module
from .laf import get_laf_orientation, rotate_laf, set_laf_orientation
from .matching import match_mnn, match_nn, match_smnn, match_snn, only_matches
from .patches import patches_of
from .shape import affine_shape, dominant_orientation, reshaped_by
from .sift import dense_sift, sift_describe


class SIFTDescriptor(Module):
    """``sift_describe`` of patches (N, 1, PS, PS) of any size; ``patch_size`` is what ``LAFDescriptor`` cuts.

    Args:
        patch_size: side PS of the patches for which the module is intended.
        num_ang_bins, num_spatial_bins, rootsift, clipval: see ``sift_describe``.

    >>> SIFTDescriptor(32)(torch.rand(3, 1, 32, 32)).shape
    torch.Size([3, 128])
    """

    def __init__(
        self,
        patch_size: int = 41,
        num_ang_bins: int = 8,
        num_spatial_bins: int = 4,
        rootsift: bool = True,
        clipval: float = 0.2,
    ) -> None:
        super().__init__()
        self.patch_size, self.num_ang_bins, self.num_spatial_bins = patch_size, num_ang_bins, num_spatial_bins
        self.rootsift, self.clipval = rootsift, float(clipval)

    def forward(self, input: Tensor) -> Tensor:
        return sift_describe(input, self.num_ang_bins, self.num_spatial_bins, self.rootsift, self.clipval)


class DenseSIFTDescriptor(Module):
    """``dense_sift`` of images (B, 1, H, W), whose windows lie where Kornia's do.

    Args:
        num_ang_bins, num_spatial_bins, spatial_bin_size, rootsift, clipval, stride: see ``dense_sift``.
        padding: a window may reach beyond the image by so many pixels and half a spatial bin, rounded down.

    >>> DenseSIFTDescriptor()(torch.rand(1, 1, 40, 50)).shape
    torch.Size([1, 128, 31, 41])
    """

    def __init__(
        self,
        num_ang_bins: int = 8,
        num_spatial_bins: int = 4,
        spatial_bin_size: int = 4,
        rootsift: bool = True,
        clipval: float = 0.2,
        stride: int = 1,
        padding: int = 1,
    ) -> None:
        super().__init__()
        self.num_ang_bins, self.num_spatial_bins = num_ang_bins, num_spatial_bins
        self.spatial_bin_size, self.stride, self.padding = spatial_bin_size, stride, padding
        self.rootsift, self.clipval = rootsift, float(clipval)

    def forward(self, input: Tensor) -> Tensor:
        return dense_sift(
            input,
            self.num_ang_bins,
            self.num_spatial_bins,
            self.spatial_bin_size,
            self.rootsift,
            self.clipval,
            self.stride,
            self.padding + self.spatial_bin_size // 2,
        )


class PatchDominantGradientOrientation(Module):
    """``dominant_orientation`` of patches (N, 1, PS, PS): (N,), radians.

    Args:
        patch_size: side PS of the patches for which the module is intended; any is taken.
        num_angular_bins: see ``dominant_orientation``.

    >>> PatchDominantGradientOrientation()(torch.rand(3, 1, 32, 32)).shape
    torch.Size([3])
    """

    def __init__(self, patch_size: int = 32, num_angular_bins: int = 36) -> None:
        super().__init__()
        self.patch_size, self.num_angular_bins = patch_size, num_angular_bins

    def forward(self, patch: Tensor) -> Tensor:
        return dominant_orientation(patch, self.num_angular_bins)


class PatchAffineShapeEstimator(Module):
    """``affine_shape`` of patches (N, 1, PS, PS), as (N, 1, 3).

    Args:
        patch_size: side PS of the patches for which the module is intended; any is taken.

    >>> PatchAffineShapeEstimator()(torch.rand(3, 1, 19, 19)).shape
    torch.Size([3, 1, 3])
    """

    def __init__(self, patch_size: int = 19) -> None:
        super().__init__()
        self.patch_size = patch_size

    def forward(self, patch: Tensor) -> Tensor:
        return affine_shape(patch)[:, None]


class LAFOrienter(Module):
    """Rotate frames by the angles that a module computes from their patches, like ``orient_laf``.

    Args:
        patch_size: side PS of the patches.
        num_angular_bins: see ``dominant_orientation``; used only with the default angle_detector.
        angle_detector: takes (M, 1, PS, PS), returns (M,) angles in radians by which to turn;
            ``PatchDominantGradientOrientation`` by default.

    >>> laf = torch.tensor([[[[5.0, 0.0, 16.0], [0.0, 5.0, 16.0]]]])
    >>> LAFOrienter(32)(laf, torch.arange(32.0)[:, None].expand(1, 1, 32, 32)).round().long()
    tensor([[[[ 0, -5, 16],
              [ 5,  0, 16]]]])
    """

    def __init__(
        self, patch_size: int = 32, num_angular_bins: int = 36, angle_detector: Optional[nn.Module] = None
    ) -> None:
        super().__init__()
        self.patch_size = patch_size
        self.angle_detector = (
            PatchDominantGradientOrientation(patch_size, num_angular_bins)
            if angle_detector is None
            else angle_detector
        )

    def forward(self, laf: Tensor, img: Tensor) -> Tensor:
        angle = self.angle_detector(patches_of(img, laf, self.patch_size, True))
        return rotate_laf(laf, rad2deg(angle.to(laf.dtype)).reshape(laf.size(0), laf.size(1), 1))


class LAFAffineShapeEstimator(Module):
    """Adapt the shape of frames by the ellipses that a module computes from their patches, like
    ``adapt_laf_shape``.

    Args:
        patch_size: side PS of the patches.
        affine_shape_detector: takes (M, 1, PS, PS), returns (M, 1, 3) or (M, 3), ellipses as ``affine_shape``
            does; ``PatchAffineShapeEstimator`` by default.
        preserve_orientation: True gives the new frames the orientation of the old ones.

    >>> laf = torch.tensor([[[[5.0, 0.0, 16.0], [0.0, 5.0, 16.0]]]])
    >>> LAFAffineShapeEstimator()(laf, torch.rand(1, 1, 32, 32)).shape
    torch.Size([1, 1, 2, 3])
    """

    def __init__(
        self,
        patch_size: int = 32,
        affine_shape_detector: Optional[nn.Module] = None,
        preserve_orientation: bool = True,
    ) -> None:
        super().__init__()
        self.patch_size, self.preserve_orientation = patch_size, preserve_orientation
        self.affine_shape_detector = (
            PatchAffineShapeEstimator(patch_size) if affine_shape_detector is None else affine_shape_detector
        )

    def forward(self, laf: Tensor, img: Tensor) -> Tensor:
        moments = self.affine_shape_detector(patches_of(img, laf, self.patch_size, True))
        adapted = reshaped_by(laf, moments.reshape(laf.size(0), laf.size(1), 3))
        if self.preserve_orientation:
            return set_laf_orientation(adapted, get_laf_orientation(laf))
        return adapted


class DescriptorMatcher(Module):
    """Only the matches of two sets of descriptors, as in Kornia: for eager code, because their number depends
    on the data. ``GeometryAwareDescriptorMatcher`` has a row for each descriptor, and exports.

    Args:
        match_mode: "nn", "mnn", "snn" or "smnn".
        th: the largest ratio that passes the ratio test, in modes with such a test.

    ``forward`` takes (N1, D) and (N2, D) and returns distances (M, 1) and indices (M, 2).

    >>> match = DescriptorMatcher("mnn")
    >>> match(torch.tensor([[0.0], [5.0], [6.0]]), torch.tensor([[4.0], [1.0]]))
    (tensor([[1.],
            [1.]]), tensor([[0, 1],
            [1, 0]]))
    """

    def __init__(self, match_mode: str = "snn", th: float = 0.8) -> None:
        super().__init__()
        check_choice(match_mode, ["nn", "mnn", "snn", "smnn"], "match_mode")
        self.match_mode, self.th = match_mode, float(th)

    def forward(self, desc1: Tensor, desc2: Tensor) -> Tuple[Tensor, Tensor]:
        if self.match_mode == "nn":
            found = match_nn(desc1, desc2)
        elif self.match_mode == "mnn":
            found = match_mnn(desc1, desc2)
        elif self.match_mode == "snn":
            found = match_snn(desc1, desc2, self.th)
        else:
            found = match_smnn(desc1, desc2, self.th)
        return only_matches(found[0], found[1], found[2])
