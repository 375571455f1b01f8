# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import Optional, Tuple, Union

from torch import Tensor, nn

from .essential import decompose_essential_matrix as decompose_essential_matrix
from .essential import decompose_essential_matrix_no_svd as decompose_essential_matrix_no_svd
from .essential import essential_from_fundamental as essential_from_fundamental
from .essential import essential_from_Rt as essential_from_Rt
from .essential import motion_from_essential as motion_from_essential
from .essential import motion_from_essential_choose_solution as motion_from_essential_choose_solution
from .essential import project_to_essential as project_to_essential
from .essential import relative_camera_motion as relative_camera_motion
from .five_point import find_essential as find_essential
from .five_point import find_essential_5point as find_essential_5point
from .fundamental import find_fundamental as find_fundamental
from .fundamental import find_fundamental_7point as find_fundamental_7point
from .fundamental import fundamental_from_essential as fundamental_from_essential
from .fundamental import fundamental_from_projections as fundamental_from_projections
from .fundamental import normalize_points as normalize_points
from .fundamental import normalize_transformation as normalize_transformation
from .lines import compute_correspond_epilines as compute_correspond_epilines
from .lines import cross_product_matrix as cross_product_matrix
from .lines import get_closest_point_on_epipolar_line as get_closest_point_on_epipolar_line
from .lines import get_perpendicular as get_perpendicular
from .metrics import left_to_right_epipolar_distance as left_to_right_epipolar_distance
from .metrics import right_to_left_epipolar_distance as right_to_left_epipolar_distance
from .metrics import sampson_epipolar_distance as sampson_epipolar_distance
from .metrics import symmetrical_epipolar_distance as symmetrical_epipolar_distance
from .projection import KRt_from_projection as KRt_from_projection
from .projection import depth_from_point as depth_from_point
from .projection import intrinsics_like as intrinsics_like
from .projection import projection_from_KRt as projection_from_KRt
from .projection import projections_from_fundamental as projections_from_fundamental
from .projection import scale_intrinsics as scale_intrinsics
from .scene import generate_scene as generate_scene
from .scene import random_intrinsics as random_intrinsics
from .triangulation import triangulate_points as triangulate_points

class KRtFromProjection(nn.Module):
    """`KRt_from_projection` as a module: Camera matrix, rotation and translation of projection matrices:
    P = K [R | t], up to its sign."""

    eps: float
    def __init__(self, eps: float = 1e-06) -> None: ...
    def forward(self, P: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, P: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class ComputeCorrespondEpilines(nn.Module):
    """`compute_correspond_epilines` as a module: Epipolar lines F x in the other image, on which the
    partners of points x lie."""
    def __init__(self) -> None: ...
    def forward(self, points: Tensor, F_mat: Tensor) -> Tensor: ...
    def __call__(self, points: Tensor, F_mat: Tensor) -> Tensor: ...

class CrossProductMatrix(nn.Module):
    """`cross_product_matrix` as a module: The skew-symmetric matrix that maps y to the cross product x x
    y."""
    def __init__(self) -> None: ...
    def forward(self, x: Tensor) -> Tensor: ...
    def __call__(self, x: Tensor) -> Tensor: ...

class DecomposeEssentialMatrix(nn.Module):
    """`decompose_essential_matrix` as a module: The two rotations and the direction of translation of
    essential matrices, also of approximate ones. With E = U S V^T they are U W V^T, U W^T V^T and the
    third column of U (R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., 9.6.2). They are
    computed in float64 without a decomposition: U diag(1, 1, 0) V^T is the 2x2 rotation nearest to E in
    the planes orthogonal to its null vectors."""
    def __init__(self) -> None: ...
    def forward(self, E_mat: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, E_mat: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class DecomposeEssentialMatrixNoSvd(nn.Module):
    """`decompose_essential_matrix_no_svd` as a module: The two rotations and the direction of
    translation of essential matrices, in closed form."""
    def __init__(self) -> None: ...
    def forward(self, E_mat: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...
    def __call__(self, E_mat: Tensor) -> Tuple[Tensor, Tensor, Tensor]: ...

class DepthFromPoint(nn.Module):
    """`depth_from_point` as a module: Depths of points in a camera's frame: z of R X + t."""
    def __init__(self) -> None: ...
    def forward(self, R: Tensor, t: Tensor, X: Tensor) -> Tensor: ...
    def __call__(self, R: Tensor, t: Tensor, X: Tensor) -> Tensor: ...

class EssentialFromRt(nn.Module):
    """`essential_from_Rt` as a module: Essential matrices [t]x R of the motion from the first camera's
    frame to the second's."""
    def __init__(self) -> None: ...
    def forward(self, R1: Tensor, t1: Tensor, R2: Tensor, t2: Tensor) -> Tensor: ...
    def __call__(self, R1: Tensor, t1: Tensor, R2: Tensor, t2: Tensor) -> Tensor: ...

class EssentialFromFundamental(nn.Module):
    """`essential_from_fundamental` as a module: Essential matrices K2^T F K1. R. Hartley, A. Zisserman,
    Multiple View Geometry, 2nd ed., formula 9.12."""
    def __init__(self) -> None: ...
    def forward(self, F_mat: Tensor, K1: Tensor, K2: Tensor) -> Tensor: ...
    def __call__(self, F_mat: Tensor, K1: Tensor, K2: Tensor) -> Tensor: ...

class FindEssential(nn.Module):
    """`find_essential` as a module: Essential matrices from five or more correspondences, by Nister's
    five-point algorithm."""

    weights: Optional[Tensor]
    def __init__(self, weights: Optional[Tensor] = None) -> None: ...
    def forward(self, points1: Tensor, points2: Tensor) -> Tensor: ...
    def __call__(self, points1: Tensor, points2: Tensor) -> Tensor: ...

class FindEssential5point(nn.Module):
    """`find_essential_5point` as a module: Up to ten essential matrices of five correspondences, with a
    mask of the solutions that exist. With more correspondences, the matrices are in the four-dimensional
    space that fits them best."""

    weights: Optional[Tensor]
    def __init__(self, weights: Optional[Tensor] = None) -> None: ...
    def forward(self, points1: Tensor, points2: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, points1: Tensor, points2: Tensor) -> Tuple[Tensor, Tensor]: ...

class FindFundamental(nn.Module):
    """`find_fundamental` as a module: Fundamental matrix from correspondences, by the normalized eight-
    point or the seven-point algorithm."""

    weights: Optional[Tensor]
    method: str
    def __init__(self, weights: Optional[Tensor] = None, method: str = "8POINT") -> None: ...
    def forward(self, points1: Tensor, points2: Tensor) -> Tensor: ...
    def __call__(self, points1: Tensor, points2: Tensor) -> Tensor: ...

class FindFundamental7point(nn.Module):
    """`find_fundamental_7point` as a module: The one to three fundamental matrices of seven
    correspondences."""
    def __init__(self) -> None: ...
    def forward(self, points1: Tensor, points2: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, points1: Tensor, points2: Tensor) -> Tuple[Tensor, Tensor]: ...

class FundamentalFromEssential(nn.Module):
    """`fundamental_from_essential` as a module: Fundamental matrices K2^-T E K1^-1. R. Hartley, A.
    Zisserman, Multiple View Geometry, 2nd ed., 9.6."""
    def __init__(self) -> None: ...
    def forward(self, E_mat: Tensor, K1: Tensor, K2: Tensor) -> Tensor: ...
    def __call__(self, E_mat: Tensor, K1: Tensor, K2: Tensor) -> Tensor: ...

class FundamentalFromProjections(nn.Module):
    """`fundamental_from_projections` as a module: Fundamental matrices of pairs of projection
    matrices."""
    def __init__(self) -> None: ...
    def forward(self, P1: Tensor, P2: Tensor) -> Tensor: ...
    def __call__(self, P1: Tensor, P2: Tensor) -> Tensor: ...

class GetClosestPointOnEpipolarLine(nn.Module):
    """`get_closest_point_on_epipolar_line` as a module: Points of the second image, moved to the nearest
    point on the epipolar line of their partner."""
    def __init__(self) -> None: ...
    def forward(self, pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor: ...
    def __call__(self, pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor: ...

class GetPerpendicular(nn.Module):
    """`get_perpendicular` as a module: Lines through points, perpendicular to given lines."""
    def __init__(self) -> None: ...
    def forward(self, lines: Tensor, points: Tensor) -> Tensor: ...
    def __call__(self, lines: Tensor, points: Tensor) -> Tensor: ...

class IntrinsicsLike(nn.Module):
    """`intrinsics_like` as a module: Camera matrices for images, with one focal length and the principal
    point at (W / 2, H / 2)."""

    focal: float
    def __init__(self, focal: float) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class LeftToRightEpipolarDistance(nn.Module):
    """`left_to_right_epipolar_distance` as a module: Distances of the second image's points from the
    epipolar lines of the first's."""
    def __init__(self) -> None: ...
    def forward(self, pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor: ...
    def __call__(self, pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor: ...

class MotionFromEssential(nn.Module):
    """`motion_from_essential` as a module: The four possible motions of an essential matrix, from the
    first camera's frame to the second's."""
    def __init__(self) -> None: ...
    def forward(self, E_mat: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, E_mat: Tensor) -> Tuple[Tensor, Tensor]: ...

class MotionFromEssentialChooseSolution(nn.Module):
    """`motion_from_essential_choose_solution` as a module: Choose the motion of an essential matrix that
    has most points in front of both cameras."""

    mask: Optional[Tensor]
    def __init__(self, mask: Optional[Tensor] = None) -> None: ...
    def forward(
        self, E_mat: Tensor, K1: Tensor, K2: Tensor, x1: Tensor, x2: Tensor
    ) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...
    def __call__(
        self, E_mat: Tensor, K1: Tensor, K2: Tensor, x1: Tensor, x2: Tensor
    ) -> Tuple[Tensor, Tensor, Tensor, Tensor]: ...

class NormalizePoints(nn.Module):
    """`normalize_points` as a module: Normalize points to centroid 0 and mean distance sqrt(2), and
    return this similarity."""

    eps: float
    weights: Optional[Tensor]
    def __init__(self, eps: float = 1e-08, weights: Optional[Tensor] = None) -> None: ...
    def forward(self, points: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, points: Tensor) -> Tuple[Tensor, Tensor]: ...

class NormalizeTransformation(nn.Module):
    """`normalize_transformation` as a module: Divide matrices by their last entry; a matrix stays
    unchanged if the entry's absolute value is at most eps."""

    eps: float
    def __init__(self, eps: float = 1e-08) -> None: ...
    def forward(self, M: Tensor) -> Tensor: ...
    def __call__(self, M: Tensor) -> Tensor: ...

class ProjectToEssential(nn.Module):
    """`project_to_essential` as a module: The nearest essential matrices in the least-squares sense: U
    diag(s, s, 0) V^T, where s is the mean of the two larger singular values."""
    def __init__(self) -> None: ...
    def forward(self, E_mat: Tensor) -> Tensor: ...
    def __call__(self, E_mat: Tensor) -> Tensor: ...

class ProjectionFromKRt(nn.Module):
    """`projection_from_KRt` as a module: Projection matrices K [R | t]."""
    def __init__(self) -> None: ...
    def forward(self, K: Tensor, R: Tensor, t: Tensor) -> Tensor: ...
    def __call__(self, K: Tensor, R: Tensor, t: Tensor) -> Tensor: ...

class ProjectionsFromFundamental(nn.Module):
    """`projections_from_fundamental` as a module: A pair of projection matrices that have a given
    fundamental matrix: [I | 0] and [[e]x F | e], e the second image's epipole."""
    def __init__(self) -> None: ...
    def forward(self, F_mat: Tensor) -> Tensor: ...
    def __call__(self, F_mat: Tensor) -> Tensor: ...

class RelativeCameraMotion(nn.Module):
    """`relative_camera_motion` as a module: Rotation and translation from the first camera's frame to
    the second's: R2 R1^T and t2 - R2 R1^T t1."""
    def __init__(self) -> None: ...
    def forward(self, R1: Tensor, t1: Tensor, R2: Tensor, t2: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, R1: Tensor, t1: Tensor, R2: Tensor, t2: Tensor) -> Tuple[Tensor, Tensor]: ...

class RightToLeftEpipolarDistance(nn.Module):
    """`right_to_left_epipolar_distance` as a module: Distances of the first image's points from the
    epipolar lines of the second's."""
    def __init__(self) -> None: ...
    def forward(self, pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor: ...
    def __call__(self, pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor: ...

class SampsonEpipolarDistance(nn.Module):
    """`sampson_epipolar_distance` as a module: Sampson distance: first-order approximation of the
    distance to the nearest exact correspondence. The distance is measured in both images together.
    Kornia's use_matmul_at_less_than_points, which only affects its speed, does not exist here."""

    squared: bool
    eps: float
    def __init__(self, squared: bool = True, eps: float = 1e-08) -> None: ...
    def forward(self, pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor: ...
    def __call__(self, pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor: ...

class ScaleIntrinsics(nn.Module):
    """`scale_intrinsics` as a module: Camera matrices for images scaled by a factor: focal lengths, skew
    and principal point are multiplied."""

    scale_factor: Union[float, Tensor]
    def __init__(self, scale_factor: Union[float, Tensor]) -> None: ...
    def forward(self, camera_matrix: Tensor) -> Tensor: ...
    def __call__(self, camera_matrix: Tensor) -> Tensor: ...

class SymmetricalEpipolarDistance(nn.Module):
    """`symmetrical_epipolar_distance` as a module: Squared distances of points from their epipolar
    lines, summed over both images."""

    squared: bool
    eps: float
    def __init__(self, squared: bool = True, eps: float = 1e-08) -> None: ...
    def forward(self, pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor: ...
    def __call__(self, pts1: Tensor, pts2: Tensor, Fm: Tensor) -> Tensor: ...

class TriangulatePoints(nn.Module):
    """`triangulate_points` as a module: Triangulate 3D points from their pixels in two cameras, by the
    direct linear transform."""

    solver: str
    def __init__(self, solver: str = "eigh") -> None: ...
    def forward(self, P1: Tensor, P2: Tensor, points1: Tensor, points2: Tensor) -> Tensor: ...
    def __call__(self, P1: Tensor, P2: Tensor, points1: Tensor, points2: Tensor) -> Tensor: ...

__all__ = [
    "ComputeCorrespondEpilines",
    "CrossProductMatrix",
    "DecomposeEssentialMatrix",
    "DecomposeEssentialMatrixNoSvd",
    "DepthFromPoint",
    "EssentialFromFundamental",
    "EssentialFromRt",
    "FindEssential",
    "FindEssential5point",
    "FindFundamental",
    "FindFundamental7point",
    "FundamentalFromEssential",
    "FundamentalFromProjections",
    "GetClosestPointOnEpipolarLine",
    "GetPerpendicular",
    "IntrinsicsLike",
    "KRtFromProjection",
    "KRt_from_projection",
    "LeftToRightEpipolarDistance",
    "MotionFromEssential",
    "MotionFromEssentialChooseSolution",
    "NormalizePoints",
    "NormalizeTransformation",
    "ProjectToEssential",
    "ProjectionFromKRt",
    "ProjectionsFromFundamental",
    "RelativeCameraMotion",
    "RightToLeftEpipolarDistance",
    "SampsonEpipolarDistance",
    "ScaleIntrinsics",
    "SymmetricalEpipolarDistance",
    "TriangulatePoints",
    "compute_correspond_epilines",
    "cross_product_matrix",
    "decompose_essential_matrix",
    "decompose_essential_matrix_no_svd",
    "depth_from_point",
    "essential_from_Rt",
    "essential_from_fundamental",
    "find_essential",
    "find_essential_5point",
    "find_fundamental",
    "find_fundamental_7point",
    "fundamental_from_essential",
    "fundamental_from_projections",
    "get_closest_point_on_epipolar_line",
    "get_perpendicular",
    "intrinsics_like",
    "left_to_right_epipolar_distance",
    "motion_from_essential",
    "motion_from_essential_choose_solution",
    "normalize_points",
    "normalize_transformation",
    "project_to_essential",
    "projection_from_KRt",
    "projections_from_fundamental",
    "relative_camera_motion",
    "right_to_left_epipolar_distance",
    "sampson_epipolar_distance",
    "scale_intrinsics",
    "symmetrical_epipolar_distance",
    "triangulate_points",
]
