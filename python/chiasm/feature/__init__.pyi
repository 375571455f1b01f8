# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import List, Optional, Tuple, Union

import torch
from torch import Tensor, nn

from .adalam import match_adalam as match_adalam
from .detection import detect_keypoints as detect_keypoints
from .fast import fast_response as fast_response
from .harris import harris_keypoints as harris_keypoints
from .harris import harris_response as harris_response
from .laf import denormalize_laf as denormalize_laf
from .laf import get_laf_center as get_laf_center
from .laf import get_laf_orientation as get_laf_orientation
from .laf import get_laf_scale as get_laf_scale
from .laf import laf_from_center_scale_ori as laf_from_center_scale_ori
from .laf import make_upright as make_upright
from .laf import normalize_laf as normalize_laf
from .laf import rotate_laf as rotate_laf
from .laf import scale_laf as scale_laf
from .laf import set_laf_orientation as set_laf_orientation
from .laf_points import ellipse_to_laf as ellipse_to_laf
from .laf_points import laf_from_three_points as laf_from_three_points
from .laf_points import laf_is_filled as laf_is_filled
from .laf_points import laf_is_inside_image as laf_is_inside_image
from .laf_points import laf_is_valid as laf_is_valid
from .laf_points import laf_to_boundary_points as laf_to_boundary_points
from .laf_points import laf_to_three_points as laf_to_three_points
from .laf_points import perspective_transform_lafs as perspective_transform_lafs
from .local import GeometryAwareDescriptorMatcher as GeometryAwareDescriptorMatcher
from .local import LocalFeature as LocalFeature
from .local import LocalFeatureMatcher as LocalFeatureMatcher
from .local import PassLAF as PassLAF
from .local import ScaleSpaceDetector as ScaleSpaceDetector
from .matching import match_fginn as match_fginn
from .matching import match_mnn as match_mnn
from .matching import match_nn as match_nn
from .matching import match_smnn as match_smnn
from .matching import match_smnn_batched as match_smnn_batched
from .matching import match_snn as match_snn
from .matching import only_matches as only_matches
from .mkd import MKDDescriptor as MKDDescriptor
from .mkd import mkd_describe as mkd_describe
from .patch_modules import DenseSIFTDescriptor as DenseSIFTDescriptor
from .patch_modules import DescriptorMatcher as DescriptorMatcher
from .patch_modules import LAFAffineShapeEstimator as LAFAffineShapeEstimator
from .patch_modules import LAFOrienter as LAFOrienter
from .patch_modules import PatchAffineShapeEstimator as PatchAffineShapeEstimator
from .patch_modules import PatchDominantGradientOrientation as PatchDominantGradientOrientation
from .patch_modules import SIFTDescriptor as SIFTDescriptor
from .patches import LAFDescriptor as LAFDescriptor
from .patches import extract_patches_from_pyramid as extract_patches_from_pyramid
from .patches import extract_patches_simple as extract_patches_simple
from .patches import get_laf_descriptors as get_laf_descriptors
from .proposal import index_proposal as index_proposal
from .proposal import multi_scale_index_proposal as multi_scale_index_proposal
from .response_modules import BlobDoG as BlobDoG
from .response_modules import BlobDoGSingle as BlobDoGSingle
from .response_modules import BlobHessian as BlobHessian
from .response_modules import CornerGFTT as CornerGFTT
from .response_modules import CornerHarris as CornerHarris
from .responses import dog_response as dog_response
from .responses import dog_response_single as dog_response_single
from .responses import gftt_response as gftt_response
from .responses import hessian_response as hessian_response
from .shape import adapt_laf_shape as adapt_laf_shape
from .shape import affine_shape as affine_shape
from .shape import dominant_orientation as dominant_orientation
from .shape import orient_laf as orient_laf
from .sift import convert_sift_descriptor_layout as convert_sift_descriptor_layout
from .sift import dense_sift as dense_sift
from .sift import mean_patch as mean_patch
from .sift import sift_describe as sift_describe
from .sift_feature import SIFTFeature as SIFTFeature
from .sift_feature import SIFTFeatureScaleSpace as SIFTFeatureScaleSpace

class AdaptLafShape(nn.Module):
    """`adapt_laf_shape` as a module: Adapt the shape of frames to the image, so that gradients in their
    patches are equally strong in all directions. A becomes A times the upright frame of the ellipse of
    its patch (``affine_shape``), divided by the root of its determinant: the area does not change."""

    PS: int
    iterations: int
    def __init__(self, PS: int = 32, iterations: int = 1) -> None: ...
    def forward(self, laf: Tensor, img: Tensor) -> Tensor: ...
    def __call__(self, laf: Tensor, img: Tensor) -> Tensor: ...

class AffineShape(nn.Module):
    """`affine_shape` as a module: The ellipses of patches: the second moments of the gradients, weighted
    by a Gaussian."""
    def __init__(self) -> None: ...
    def forward(self, patches: Tensor) -> Tensor: ...
    def __call__(self, patches: Tensor) -> Tensor: ...

class ConvertSiftDescriptorLayout(nn.Module):
    """`convert_sift_descriptor_layout` as a module: Reorder the entries of SIFT descriptors from another
    library."""

    source: str
    target: str
    num_ang_bins: int
    num_spatial_bins: int
    def __init__(
        self, source: str, target: str, num_ang_bins: int = 8, num_spatial_bins: int = 4
    ) -> None: ...
    def forward(self, descriptors: Tensor) -> Tensor: ...
    def __call__(self, descriptors: Tensor) -> Tensor: ...

class DenormalizeLaf(nn.Module):
    """`denormalize_laf` as a module: The inverse of ``normalize_laf``."""
    def __init__(self) -> None: ...
    def forward(self, LAF: Tensor, images: Tensor) -> Tensor: ...
    def __call__(self, LAF: Tensor, images: Tensor) -> Tensor: ...

class DenseSift(nn.Module):
    """`dense_sift` as a module: Dense SIFT: descriptors of upright windows on a grid over the image.
    There is no Gaussian weight, and gradients outside a window contribute to its outer spatial bins."""

    num_ang_bins: int
    num_spatial_bins: int
    spatial_bin_size: int
    rootsift: bool
    clipval: float
    stride: int
    padding: int
    def __init__(
        self,
        num_ang_bins: int = 8,
        num_spatial_bins: int = 4,
        spatial_bin_size: int = 4,
        rootsift: bool = True,
        clipval: float = 0.2,
        stride: int = 1,
        padding: int = 0,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class DetectKeypoints(nn.Module):
    """`detect_keypoints` as a module: Detect the strongest corners or blobs of all scales, in a fixed
    number of slots."""

    max_keypoints: int
    response: str
    num_octaves: int
    n_levels: int
    init_sigma: float
    mr_size: float
    threshold: float
    double_image: bool
    def __init__(
        self,
        max_keypoints: int,
        response: str = "hessian",
        num_octaves: int = 4,
        n_levels: int = 3,
        init_sigma: float = 1.6,
        mr_size: float = 6.0,
        threshold: float = 0.0,
        double_image: bool = False,
    ) -> None: ...
    def forward(self, img: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, img: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class DogResponse(nn.Module):
    """`dog_response` as a module: Differences of the neighbouring levels of a scale space, coarser minus
    finer."""
    def __init__(self) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class DogResponseSingle(nn.Module):
    """`dog_response_single` as a module: Difference of an image blurred by two Gaussians, the second
    minus the first."""

    sigma1: float
    sigma2: float
    def __init__(self, sigma1: float = 1.0, sigma2: float = 1.6) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class DominantOrientation(nn.Module):
    """`dominant_orientation` as a module: The angle by which to rotate the frame of a patch so that its
    dominant gradient points along x. It is the peak of a histogram of directions. Gradients are weighted
    by a Gaussian with sigma of a sixth of the patch's side and split linearly between two neighbouring
    bins. The histogram is smoothed by (1, 4, 6, 4, 1) / 16. The parabola through the highest bin (of
    equal ones the first) and its neighbours gives the peak."""

    num_angular_bins: int
    def __init__(self, num_angular_bins: int = 36) -> None: ...
    def forward(self, patches: Tensor) -> Tensor: ...
    def __call__(self, patches: Tensor) -> Tensor: ...

class EllipseToLaf(nn.Module):
    """`ellipse_to_laf` as a module: Upright frames of ellipses a dx^2 + 2 b dx dy + c dy^2 = 1 (the form
    of the Oxford affine regions)."""
    def __init__(self) -> None: ...
    def forward(self, ells: Tensor) -> Tensor: ...
    def __call__(self, ells: Tensor) -> Tensor: ...

class ExtractPatchesFromPyramid(nn.Module):
    """`extract_patches_from_pyramid` as a module: Patches of frames, read from a Gaussian pyramid. The
    level of each patch has pixels of the size of the patch's pixels, or down to half of it."""

    PS: int
    normalize_lafs_before_extraction: bool
    def __init__(self, PS: int = 32, normalize_lafs_before_extraction: bool = True) -> None: ...
    def forward(self, img: Tensor, laf: Tensor) -> Tensor: ...
    def __call__(self, img: Tensor, laf: Tensor) -> Tensor: ...

class ExtractPatchesSimple(nn.Module):
    """`extract_patches_simple` as a module: Patches of frames, read from the image itself; there is
    aliasing if a frame is much larger than its patch."""

    PS: int
    normalize_lafs_before_extraction: bool
    def __init__(self, PS: int = 32, normalize_lafs_before_extraction: bool = True) -> None: ...
    def forward(self, img: Tensor, laf: Tensor) -> Tensor: ...
    def __call__(self, img: Tensor, laf: Tensor) -> Tensor: ...

class FastResponse(nn.Module):
    """`fast_response` as a module: FAST-9 response: the largest threshold for which nine contiguous
    pixels of the circle of 16 are brighter or darker."""
    def __init__(self) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class GetLafCenter(nn.Module):
    """`get_laf_center` as a module: Centres of local affine frames."""
    def __init__(self) -> None: ...
    def forward(self, LAF: Tensor) -> Tensor: ...
    def __call__(self, LAF: Tensor) -> Tensor: ...

class GetLafDescriptors(nn.Module):
    """`get_laf_descriptors` as a module: Descriptors of frames: patches from a pyramid, and what a
    module makes of them."""

    patch_descriptor: torch.nn.modules.module.Module
    patch_size: int
    grayscale_descriptor: bool
    def __init__(
        self,
        patch_descriptor: torch.nn.modules.module.Module,
        patch_size: int = 32,
        grayscale_descriptor: bool = True,
    ) -> None: ...
    def forward(self, img: Tensor, lafs: Tensor) -> Tensor: ...
    def __call__(self, img: Tensor, lafs: Tensor) -> Tensor: ...

class GetLafOrientation(nn.Module):
    """`get_laf_orientation` as a module: Orientations of local affine frames: the angle of the rotation
    that ``make_upright`` undoes."""
    def __init__(self) -> None: ...
    def forward(self, LAF: Tensor) -> Tensor: ...
    def __call__(self, LAF: Tensor) -> Tensor: ...

class GetLafScale(nn.Module):
    """`get_laf_scale` as a module: Scales of local affine frames: the radius of the disk of the same
    area, the square root of |det A|."""
    def __init__(self) -> None: ...
    def forward(self, LAF: Tensor) -> Tensor: ...
    def __call__(self, LAF: Tensor) -> Tensor: ...

class GfttResponse(nn.Module):
    """`gftt_response` as a module: The smaller eigenvalue of the structure tensor (Shi-Tomasi, "good
    features to track")."""

    grads_mode: str
    sigmas: Optional[Tensor]
    def __init__(self, grads_mode: str = "sobel", sigmas: Optional[Tensor] = None) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class HarrisKeypoints(nn.Module):
    """`harris_keypoints` as a module: Detect the strongest Harris corners, in a fixed number of
    slots."""

    max_keypoints: int
    k: float
    nms_size: Union[int, Tuple[int, int]]
    threshold: float
    def __init__(
        self,
        max_keypoints: int,
        k: float = 0.04,
        nms_size: Union[int, Tuple[int, int]] = 5,
        threshold: float = 0.0,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, input: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class HarrisResponse(nn.Module):
    """`harris_response` as a module: Cornerness det(S) - k trace(S)^2 of the structure tensor S,
    smoothed by a 7x7 Gaussian of sigma 1."""

    k: float
    grads_mode: str
    sigmas: Optional[Tensor]
    def __init__(
        self, k: float = 0.04, grads_mode: str = "sobel", sigmas: Optional[Tensor] = None
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class HessianResponse(nn.Module):
    """`hessian_response` as a module: Determinant of the Hessian, with the second derivatives of
    ``spatial_gradient``."""

    grads_mode: str
    sigmas: Optional[Tensor]
    def __init__(self, grads_mode: str = "sobel", sigmas: Optional[Tensor] = None) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class IndexProposal(nn.Module):
    """`index_proposal` as a module: Soft position of the maximum of each window: the mean pixel position
    with weights base^r / sum of base^r."""

    window: int
    base: float
    def __init__(self, window: int, base: float = 2.718281828459045) -> None: ...
    def forward(self, response: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, response: Tensor) -> Tuple[Tensor, Tensor]: ...

class LafFromCenterScaleOri(nn.Module):
    """`laf_from_center_scale_ori` as a module: Local affine frames of disks: ori's rotation matrix times
    scale, and the centre."""

    scale: Optional[Tensor]
    ori: Optional[Tensor]
    def __init__(self, scale: Optional[Tensor] = None, ori: Optional[Tensor] = None) -> None: ...
    def forward(self, xy: Tensor) -> Tensor: ...
    def __call__(self, xy: Tensor) -> Tensor: ...

class LafFromThreePoints(nn.Module):
    """`laf_from_three_points` as a module: The inverse of ``laf_to_three_points``."""
    def __init__(self) -> None: ...
    def forward(self, threepts: Tensor) -> Tensor: ...
    def __call__(self, threepts: Tensor) -> Tensor: ...

class LafIsFilled(nn.Module):
    """`laf_is_filled` as a module: A mask of the slots that hold a frame; detectors with a fixed
    capacity fill the other slots with zeros."""
    def __init__(self) -> None: ...
    def forward(self, laf: Tensor) -> Tensor: ...
    def __call__(self, laf: Tensor) -> Tensor: ...

class LafIsInsideImage(nn.Module):
    """`laf_is_inside_image` as a module: A mask of the frames that lie inside their images. Twelve
    points, the centre and eleven around the ellipse, must be between border and W - border or H -
    border."""

    border: int
    def __init__(self, border: int = 0) -> None: ...
    def forward(self, laf: Tensor, images: Tensor) -> Tensor: ...
    def __call__(self, laf: Tensor, images: Tensor) -> Tensor: ...

class LafIsValid(nn.Module):
    """`laf_is_valid` as a module: A mask of the frames that are finite and have a finite, nonzero
    determinant."""
    def __init__(self) -> None: ...
    def forward(self, laf: Tensor) -> Tensor: ...
    def __call__(self, laf: Tensor) -> Tensor: ...

class LafToBoundaryPoints(nn.Module):
    """`laf_to_boundary_points` as a module: The centre of each frame, and points around its ellipse."""

    n_pts: int
    def __init__(self, n_pts: int = 50) -> None: ...
    def forward(self, LAF: Tensor) -> Tensor: ...
    def __call__(self, LAF: Tensor) -> Tensor: ...

class LafToThreePoints(nn.Module):
    """`laf_to_three_points` as a module: Local affine frames as three points: the ends of both axes, and
    the centre."""
    def __init__(self) -> None: ...
    def forward(self, laf: Tensor) -> Tensor: ...
    def __call__(self, laf: Tensor) -> Tensor: ...

class MakeUpright(nn.Module):
    """`make_upright` as a module: Rotate local affine frames so that their second axis points straight
    down. A12 becomes 0, and A11 becomes the length of A's first row. Mirrored frames (det A < 0) stay
    mirrored (Kornia loses the sign); ellipses do not change."""

    eps: float
    def __init__(self, eps: float = 1e-09) -> None: ...
    def forward(self, laf: Tensor) -> Tensor: ...
    def __call__(self, laf: Tensor) -> Tensor: ...

class MatchAdalam(nn.Module):
    """`match_adalam` as a module: Nearest neighbours that are consistent with a local affine map
    (AdaLAM); this gives many more and fewer wrong matches than a ratio test."""

    area_ratio: float
    search_expansion: float
    ransac_iters: int
    min_inliers: int
    min_confidence: float
    orientation_difference_threshold: float
    scale_rate_threshold: float
    detected_scale_rate_threshold: float
    num_seeds: int
    num_neighbors: int
    mutual: bool
    hw1: Union[Tensor, Tuple[int, int], None]
    hw2: Union[Tensor, Tuple[int, int], None]
    dm: Optional[Tensor]
    mask1: Optional[Tensor]
    mask2: Optional[Tensor]
    def __init__(
        self,
        area_ratio: float = 100.0,
        search_expansion: float = 4.0,
        ransac_iters: int = 128,
        min_inliers: int = 6,
        min_confidence: float = 200.0,
        orientation_difference_threshold: float = 30.0,
        scale_rate_threshold: float = 1.5,
        detected_scale_rate_threshold: float = 5.0,
        num_seeds: int = 128,
        num_neighbors: int = 128,
        mutual: bool = False,
        hw1: Union[Tensor, Tuple[int, int], None] = None,
        hw2: Union[Tensor, Tuple[int, int], None] = None,
        dm: Optional[Tensor] = None,
        mask1: Optional[Tensor] = None,
        mask2: Optional[Tensor] = None,
    ) -> None: ...
    def forward(
        self, desc1: Tensor, desc2: Tensor, lafs1: Tensor, lafs2: Tensor
    ) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(
        self, desc1: Tensor, desc2: Tensor, lafs1: Tensor, lafs2: Tensor
    ) -> Tuple[Tensor, Tensor, Tensor]: ...

class MatchFginn(nn.Module):
    """`match_fginn` as a module: Ratio test against the first geometrically inconsistent neighbour
    (FGINN): the second nearest must be elsewhere."""

    th: float
    spatial_th: float
    mutual: bool
    dm: Optional[Tensor]
    mask1: Optional[Tensor]
    mask2: Optional[Tensor]
    def __init__(
        self,
        th: float = 0.8,
        spatial_th: float = 10.0,
        mutual: bool = False,
        dm: Optional[Tensor] = None,
        mask1: Optional[Tensor] = None,
        mask2: Optional[Tensor] = None,
    ) -> None: ...
    def forward(
        self, desc1: Tensor, desc2: Tensor, lafs1: Tensor, lafs2: Tensor
    ) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(
        self, desc1: Tensor, desc2: Tensor, lafs1: Tensor, lafs2: Tensor
    ) -> Tuple[Tensor, Tensor, Tensor]: ...

class MatchMnn(nn.Module):
    """`match_mnn` as a module: Mutual nearest neighbours: pairs whose descriptors are each nearest to
    the other one."""

    dm: Optional[Tensor]
    mask1: Optional[Tensor]
    mask2: Optional[Tensor]
    def __init__(
        self, dm: Optional[Tensor] = None, mask1: Optional[Tensor] = None, mask2: Optional[Tensor] = None
    ) -> None: ...
    def forward(self, desc1: Tensor, desc2: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, desc1: Tensor, desc2: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class MatchNn(nn.Module):
    """`match_nn` as a module: Find the nearest descriptor of the second set for each descriptor of the
    first set."""

    dm: Optional[Tensor]
    mask1: Optional[Tensor]
    mask2: Optional[Tensor]
    def __init__(
        self, dm: Optional[Tensor] = None, mask1: Optional[Tensor] = None, mask2: Optional[Tensor] = None
    ) -> None: ...
    def forward(self, desc1: Tensor, desc2: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, desc1: Tensor, desc2: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class MatchSmnn(nn.Module):
    """`match_smnn` as a module: Mutual nearest neighbours that pass the ratio test both ways."""

    th: float
    dm: Optional[Tensor]
    mask1: Optional[Tensor]
    mask2: Optional[Tensor]
    def __init__(
        self,
        th: float = 0.95,
        dm: Optional[Tensor] = None,
        mask1: Optional[Tensor] = None,
        mask2: Optional[Tensor] = None,
    ) -> None: ...
    def forward(self, desc1: Tensor, desc2: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, desc1: Tensor, desc2: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class MatchSmnnBatched(nn.Module):
    """`match_smnn_batched` as a module: ``match_smnn`` of batches only."""

    th: float
    dm: Optional[Tensor]
    mask1: Optional[Tensor]
    mask2: Optional[Tensor]
    def __init__(
        self,
        th: float = 0.95,
        dm: Optional[Tensor] = None,
        mask1: Optional[Tensor] = None,
        mask2: Optional[Tensor] = None,
    ) -> None: ...
    def forward(self, desc1: Tensor, desc2: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, desc1: Tensor, desc2: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class MatchSnn(nn.Module):
    """`match_snn` as a module: Nearest neighbours that pass the ratio test: the second nearest is
    clearly farther."""

    th: float
    dm: Optional[Tensor]
    mask1: Optional[Tensor]
    mask2: Optional[Tensor]
    def __init__(
        self,
        th: float = 0.8,
        dm: Optional[Tensor] = None,
        mask1: Optional[Tensor] = None,
        mask2: Optional[Tensor] = None,
    ) -> None: ...
    def forward(self, desc1: Tensor, desc2: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, desc1: Tensor, desc2: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class MeanPatch(nn.Module):
    """`mean_patch` as a module: The mean of each channel of patches: the simplest descriptor."""
    def __init__(self) -> None: ...
    def forward(self, patches: Tensor) -> Tensor: ...
    def __call__(self, patches: Tensor) -> Tensor: ...

class MkdDescribe(nn.Module):
    """`mkd_describe` as a module: Kernel descriptors of patches: they encode the gradient and the
    position of every pixel without bins. The inner product of two descriptors, before normalization to
    unit vectors, is the sum over all pairs of pixels, one of each patch, of w(p) w(q) k(direction)
    k(place) k(place), where w is the root of the gradient's length times exp(-r^2), where r is the
    distance from the patch's centre (1 in its corners), and k is the von Mises kernel (exp(kappa cos d)
    - exp(-kappa)) / (2 sinh kappa) of the difference d of two angles, truncated after some terms of its
    Fourier series:"""

    kernel_type: str
    whitening: Optional[Tensor]
    mean: Optional[Tensor]
    power: float
    def __init__(
        self,
        kernel_type: str = "concat",
        whitening: Optional[Tensor] = None,
        mean: Optional[Tensor] = None,
        power: float = 1.0,
    ) -> None: ...
    def forward(self, patches: Tensor) -> Tensor: ...
    def __call__(self, patches: Tensor) -> Tensor: ...

class MultiScaleIndexProposal(nn.Module):
    """`multi_scale_index_proposal` as a module: ``index_proposal`` for windows of several sizes, with
    all proposals concatenated."""

    windows: Optional[List[int]]
    base: float
    def __init__(self, windows: Optional[List[int]] = None, base: float = 2.718281828459045) -> None: ...
    def forward(self, response: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, response: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class NormalizeLaf(nn.Module):
    """`normalize_laf` as a module: Normalize frames in pixels by the image size: x / (W - 1), y / (H -
    1) and A / min(W - 1, H - 1)."""
    def __init__(self) -> None: ...
    def forward(self, LAF: Tensor, images: Tensor) -> Tensor: ...
    def __call__(self, LAF: Tensor, images: Tensor) -> Tensor: ...

class OnlyMatches(nn.Module):
    """`only_matches` as a module: Select the rows that hold a match, which is what Kornia's functions
    return. For eager code: the number of rows depends on the data (it can be scripted, but not
    exported)."""
    def __init__(self) -> None: ...
    def forward(self, distances: Tensor, indices: Tensor, valid: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, distances: Tensor, indices: Tensor, valid: Tensor) -> Tuple[Tensor, Tensor]: ...

class OrientLaf(nn.Module):
    """`orient_laf` as a module: Rotate frames so that the dominant gradient of their patches points
    along x."""

    PS: int
    def __init__(self, PS: int = 32) -> None: ...
    def forward(self, laf: Tensor, img: Tensor) -> Tensor: ...
    def __call__(self, laf: Tensor, img: Tensor) -> Tensor: ...

class PerspectiveTransformLafs(nn.Module):
    """`perspective_transform_lafs` as a module: Transform frames by homographies: the centre is mapped,
    and A is multiplied by the homography's derivative there."""
    def __init__(self) -> None: ...
    def forward(self, trans_01: Tensor, lafs_1: Tensor) -> Tensor: ...
    def __call__(self, trans_01: Tensor, lafs_1: Tensor) -> Tensor: ...

class RotateLaf(nn.Module):
    """`rotate_laf` as a module: Rotate local affine frames about their centres: A times the rotation
    matrix. The ellipses do not change."""
    def __init__(self) -> None: ...
    def forward(self, LAF: Tensor, angles_degrees: Tensor) -> Tensor: ...
    def __call__(self, LAF: Tensor, angles_degrees: Tensor) -> Tensor: ...

class ScaleLaf(nn.Module):
    """`scale_laf` as a module: Enlarge local affine frames about their centres."""

    scale_coef: Union[float, Tensor]
    def __init__(self, scale_coef: Union[float, Tensor]) -> None: ...
    def forward(self, laf: Tensor) -> Tensor: ...
    def __call__(self, laf: Tensor) -> Tensor: ...

class SetLafOrientation(nn.Module):
    """`set_laf_orientation` as a module: Rotate local affine frames to given orientations."""
    def __init__(self) -> None: ...
    def forward(self, LAF: Tensor, angles_degrees: Tensor) -> Tensor: ...
    def __call__(self, LAF: Tensor, angles_degrees: Tensor) -> Tensor: ...

class SiftDescribe(nn.Module):
    """`sift_describe` as a module: SIFT descriptors of patches."""

    num_ang_bins: int
    num_spatial_bins: int
    rootsift: bool
    clipval: float
    def __init__(
        self, num_ang_bins: int = 8, num_spatial_bins: int = 4, rootsift: bool = True, clipval: float = 0.2
    ) -> None: ...
    def forward(self, patches: Tensor) -> Tensor: ...
    def __call__(self, patches: Tensor) -> Tensor: ...

__all__ = [
    "AdaptLafShape",
    "AffineShape",
    "BlobDoG",
    "BlobDoGSingle",
    "BlobHessian",
    "ConvertSiftDescriptorLayout",
    "CornerGFTT",
    "CornerHarris",
    "DenormalizeLaf",
    "DenseSIFTDescriptor",
    "DenseSift",
    "DescriptorMatcher",
    "DetectKeypoints",
    "DogResponse",
    "DogResponseSingle",
    "DominantOrientation",
    "EllipseToLaf",
    "ExtractPatchesFromPyramid",
    "ExtractPatchesSimple",
    "FastResponse",
    "GeometryAwareDescriptorMatcher",
    "GetLafCenter",
    "GetLafDescriptors",
    "GetLafOrientation",
    "GetLafScale",
    "GfttResponse",
    "HarrisKeypoints",
    "HarrisResponse",
    "HessianResponse",
    "IndexProposal",
    "LAFAffineShapeEstimator",
    "LAFDescriptor",
    "LAFOrienter",
    "LafFromCenterScaleOri",
    "LafFromThreePoints",
    "LafIsFilled",
    "LafIsInsideImage",
    "LafIsValid",
    "LafToBoundaryPoints",
    "LafToThreePoints",
    "LocalFeature",
    "LocalFeatureMatcher",
    "MKDDescriptor",
    "MakeUpright",
    "MatchAdalam",
    "MatchFginn",
    "MatchMnn",
    "MatchNn",
    "MatchSmnn",
    "MatchSmnnBatched",
    "MatchSnn",
    "MeanPatch",
    "MkdDescribe",
    "MultiScaleIndexProposal",
    "NormalizeLaf",
    "OnlyMatches",
    "OrientLaf",
    "PassLAF",
    "PatchAffineShapeEstimator",
    "PatchDominantGradientOrientation",
    "PerspectiveTransformLafs",
    "RotateLaf",
    "SIFTDescriptor",
    "SIFTFeature",
    "SIFTFeatureScaleSpace",
    "ScaleLaf",
    "ScaleSpaceDetector",
    "SetLafOrientation",
    "SiftDescribe",
    "adapt_laf_shape",
    "affine_shape",
    "convert_sift_descriptor_layout",
    "denormalize_laf",
    "dense_sift",
    "detect_keypoints",
    "dog_response",
    "dog_response_single",
    "dominant_orientation",
    "ellipse_to_laf",
    "extract_patches_from_pyramid",
    "extract_patches_simple",
    "fast_response",
    "get_laf_center",
    "get_laf_descriptors",
    "get_laf_orientation",
    "get_laf_scale",
    "gftt_response",
    "harris_keypoints",
    "harris_response",
    "hessian_response",
    "index_proposal",
    "laf_from_center_scale_ori",
    "laf_from_three_points",
    "laf_is_filled",
    "laf_is_inside_image",
    "laf_is_valid",
    "laf_to_boundary_points",
    "laf_to_three_points",
    "make_upright",
    "match_adalam",
    "match_fginn",
    "match_mnn",
    "match_nn",
    "match_smnn",
    "match_smnn_batched",
    "match_snn",
    "mean_patch",
    "mkd_describe",
    "multi_scale_index_proposal",
    "normalize_laf",
    "only_matches",
    "orient_laf",
    "perspective_transform_lafs",
    "rotate_laf",
    "scale_laf",
    "set_laf_orientation",
    "sift_describe",
]
