"""Interest points, local affine frames, descriptors, matching."""

from ..primitives.core.modules import lazy_modules
from .adalam import match_adalam
from .detection import detect_keypoints
from .fast import fast_response
from .harris import harris_keypoints, harris_response
from .laf import (
    denormalize_laf,
    get_laf_center,
    get_laf_orientation,
    get_laf_scale,
    laf_from_center_scale_ori,
    make_upright,
    normalize_laf,
    rotate_laf,
    scale_laf,
    set_laf_orientation,
)
from .laf_points import (
    ellipse_to_laf,
    laf_from_three_points,
    laf_is_filled,
    laf_is_inside_image,
    laf_is_valid,
    laf_to_boundary_points,
    laf_to_three_points,
    perspective_transform_lafs,
)
from .local import (
    GeometryAwareDescriptorMatcher,
    LocalFeature,
    LocalFeatureMatcher,
    PassLAF,
    ScaleSpaceDetector,
)
from .matching import (
    match_fginn,
    match_mnn,
    match_nn,
    match_smnn,
    match_smnn_batched,
    match_snn,
    only_matches,
)
from .mkd import MKDDescriptor, mkd_describe
from .patch_modules import (
    DenseSIFTDescriptor,
    DescriptorMatcher,
    LAFAffineShapeEstimator,
    LAFOrienter,
    PatchAffineShapeEstimator,
    PatchDominantGradientOrientation,
    SIFTDescriptor,
)
from .patches import LAFDescriptor, extract_patches_from_pyramid, extract_patches_simple, get_laf_descriptors
from .proposal import index_proposal, multi_scale_index_proposal
from .response_modules import BlobDoG, BlobDoGSingle, BlobHessian, CornerGFTT, CornerHarris
from .responses import dog_response, dog_response_single, gftt_response, hessian_response
from .shape import adapt_laf_shape, affine_shape, dominant_orientation, orient_laf
from .sift import convert_sift_descriptor_layout, dense_sift, mean_patch, sift_describe
from .sift_feature import SIFTFeature, SIFTFeatureScaleSpace

__all__ = [
    "BlobDoG",
    "BlobDoGSingle",
    "BlobHessian",
    "CornerGFTT",
    "CornerHarris",
    "DenseSIFTDescriptor",
    "DescriptorMatcher",
    "GeometryAwareDescriptorMatcher",
    "LAFAffineShapeEstimator",
    "LAFDescriptor",
    "LAFOrienter",
    "LocalFeature",
    "LocalFeatureMatcher",
    "MKDDescriptor",
    "PassLAF",
    "PatchAffineShapeEstimator",
    "PatchDominantGradientOrientation",
    "SIFTDescriptor",
    "SIFTFeature",
    "SIFTFeatureScaleSpace",
    "ScaleSpaceDetector",
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

__getattr__, __dir__ = lazy_modules(__name__, globals())
