# Written by `make stubs` from the signatures of the functions; do not edit.

from typing import List, Optional, Tuple, Union

from torch import Tensor, nn

from .affine import Affine as Affine
from .affine import affine as affine
from .affine import rotate as rotate
from .affine import scale as scale
from .affine import shear as shear
from .affine import translate as translate
from .affine import warp_affine as warp_affine
from .border import copy_make_border as copy_make_border
from .crop import CenterCrop2D as CenterCrop2D
from .crop import center_crop as center_crop
from .crop import crop_and_resize as crop_and_resize
from .crop import crop_by_boxes as crop_by_boxes
from .crop import crop_by_indices as crop_by_indices
from .crop import crop_by_transform_mat as crop_by_transform_mat
from .crop3d import center_crop3d as center_crop3d
from .crop3d import crop_and_resize3d as crop_and_resize3d
from .crop3d import crop_by_boxes3d as crop_by_boxes3d
from .elastic import elastic_transform2d as elastic_transform2d
from .flips import hflip as hflip
from .flips import rot180 as rot180
from .flips import transpose as transpose
from .flips import vflip as vflip
from .homography_warp import HomographyWarper as HomographyWarper
from .homography_warp import homography_warp as homography_warp
from .homography_warp import warp_grid as warp_grid
from .matrices import get_affine_matrix2d as get_affine_matrix2d
from .matrices import get_perspective_transform as get_perspective_transform
from .matrices import get_rotation_matrix2d as get_rotation_matrix2d
from .matrices import get_shear_matrix2d as get_shear_matrix2d
from .matrices import get_translation_matrix2d as get_translation_matrix2d
from .matrices import invert_affine_transform as invert_affine_transform
from .matrices import projection_from_Rt as projection_from_Rt
from .matrices3d import get_affine_matrix3d as get_affine_matrix3d
from .matrices3d import get_perspective_transform3d as get_perspective_transform3d
from .matrices3d import get_projective_transform as get_projective_transform
from .matrices3d import get_shear_matrix3d as get_shear_matrix3d
from .polar import warp_polar as warp_polar
from .pyramid import ScalePyramid as ScalePyramid
from .pyramid import build_laplacian_pyramid as build_laplacian_pyramid
from .pyramid import build_pyramid as build_pyramid
from .pyramid import pyrdown as pyrdown
from .pyramid import pyrup as pyrup
from .registrator import Homography as Homography
from .registrator import ImageRegistrator as ImageRegistrator
from .registrator import Similarity as Similarity
from .remap import remap as remap
from .rescale import rescale as rescale
from .rescale import resize_to_be_divisible as resize_to_be_divisible
from .resize import resize as resize
from .thin_plate import get_tps_transform as get_tps_transform
from .thin_plate import warp_image_tps as warp_image_tps
from .thin_plate import warp_points_tps as warp_points_tps
from .volume import affine3d as affine3d
from .volume import crop_by_transform_mat3d as crop_by_transform_mat3d
from .volume import homography_warp3d as homography_warp3d
from .volume import rotate3d as rotate3d
from .volume import warp_affine3d as warp_affine3d
from .volume import warp_grid3d as warp_grid3d
from .volume import warp_perspective3d as warp_perspective3d
from .warp import warp_perspective as warp_perspective

class Affine3d(nn.Module):
    """`affine3d` as a module: ``warp_affine3d`` with an output of the volume's size."""

    mode: str
    padding_mode: str
    align_corners: bool
    def __init__(
        self, mode: str = "bilinear", padding_mode: str = "zeros", align_corners: bool = False
    ) -> None: ...
    def forward(self, tensor: Tensor, matrix: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor, matrix: Tensor) -> Tensor: ...

class BuildLaplacianPyramid(nn.Module):
    """`build_laplacian_pyramid` as a module: Laplacian pyramid: the difference of each Gaussian level
    and the upsampled next one; the last level as it is. A level is upsampled to the size of the level
    before and then blurred, so that upsampling, blurring and adding from the last level reconstructs the
    image exactly, whatever its size. (Kornia pads the image to powers of two instead, and agrees if the
    sizes are powers of two.)"""

    max_level: int
    border_type: str
    align_corners: bool
    def __init__(self, max_level: int, border_type: str = "reflect", align_corners: bool = False) -> None: ...
    def forward(self, input: Tensor) -> List[Tensor]: ...
    def __call__(self, input: Tensor) -> List[Tensor]: ...

class BuildPyramid(nn.Module):
    """`build_pyramid` as a module: Gaussian pyramid: the image, and the results of repeated ``pyrdown``.
    With sampling "alternate" it is OpenCV's ``buildPyramid``, identical for uint8."""

    max_level: int
    border_type: str
    align_corners: bool
    sampling: str
    def __init__(
        self,
        max_level: int,
        border_type: str = "reflect",
        align_corners: bool = False,
        sampling: str = "bilinear",
    ) -> None: ...
    def forward(self, input: Tensor) -> List[Tensor]: ...
    def __call__(self, input: Tensor) -> List[Tensor]: ...

class CenterCrop(nn.Module):
    """`center_crop` as a module: Crop the centre of images. If the image size and the crop size differ
    by an odd number, the crop begins between two pixels; integers are rounded half up there."""

    size: Tuple[int, int]
    mode: str
    padding_mode: str
    align_corners: bool
    def __init__(
        self,
        size: Tuple[int, int],
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
    ) -> None: ...
    def forward(self, input_tensor: Tensor) -> Tensor: ...
    def __call__(self, input_tensor: Tensor) -> Tensor: ...

class CenterCrop3d(nn.Module):
    """`center_crop3d` as a module: Crop the centre of volumes. If the sizes differ by an odd number, the
    crop begins between two voxels."""

    size: Tuple[int, int, int]
    interpolation: str
    align_corners: bool
    def __init__(
        self, size: Tuple[int, int, int], interpolation: str = "bilinear", align_corners: bool = True
    ) -> None: ...
    def forward(self, tensor: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor) -> Tensor: ...

class CopyMakeBorder(nn.Module):
    """`copy_make_border` as a module: Put images into larger ones, like OpenCV's ``copyMakeBorder``."""

    top: int
    bottom: int
    left: int
    right: int
    border_type: str
    value: float
    def __init__(
        self, top: int, bottom: int, left: int, right: int, border_type: str = "constant", value: float = 0.0
    ) -> None: ...
    def forward(self, image: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor) -> Tensor: ...

class CropAndResize(nn.Module):
    """`crop_and_resize` as a module: Crop one quadrilateral of each image and resize it; its corners
    become the centres of the corner pixels."""

    size: Tuple[int, int]
    mode: str
    padding_mode: str
    align_corners: bool
    def __init__(
        self,
        size: Tuple[int, int],
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
    ) -> None: ...
    def forward(self, input_tensor: Tensor, boxes: Tensor) -> Tensor: ...
    def __call__(self, input_tensor: Tensor, boxes: Tensor) -> Tensor: ...

class CropAndResize3d(nn.Module):
    """`crop_and_resize3d` as a module: Crop one box of each volume and resize it; its corners become the
    centres of the corner voxels."""

    size: Tuple[int, int, int]
    interpolation: str
    align_corners: bool
    def __init__(
        self, size: Tuple[int, int, int], interpolation: str = "bilinear", align_corners: bool = False
    ) -> None: ...
    def forward(self, tensor: Tensor, boxes: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor, boxes: Tensor) -> Tensor: ...

class CropByBoxes(nn.Module):
    """`crop_by_boxes` as a module: Warp images so that src_box maps to dst_box, and crop to dst_box. The
    output has the size of the first dst_box, or ``size`` if given: exported programs cannot have sizes
    that depend on data."""

    mode: str
    padding_mode: str
    align_corners: bool
    validate_boxes: bool
    size: Optional[Tuple[int, int]]
    def __init__(
        self,
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
        validate_boxes: bool = True,
        size: Optional[Tuple[int, int]] = None,
    ) -> None: ...
    def forward(self, input_tensor: Tensor, src_box: Tensor, dst_box: Tensor) -> Tensor: ...
    def __call__(self, input_tensor: Tensor, src_box: Tensor, dst_box: Tensor) -> Tensor: ...

class CropByBoxes3d(nn.Module):
    """`crop_by_boxes3d` as a module: Warp volumes so that src_box maps to dst_box, and crop to dst_box.
    The output has the size of the first dst_box, or ``size`` if given: exported programs cannot have
    sizes that depend on data."""

    interpolation: str
    align_corners: bool
    size: Optional[Tuple[int, int, int]]
    def __init__(
        self,
        interpolation: str = "bilinear",
        align_corners: bool = False,
        size: Optional[Tuple[int, int, int]] = None,
    ) -> None: ...
    def forward(self, tensor: Tensor, src_box: Tensor, dst_box: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor, src_box: Tensor, dst_box: Tensor) -> Tensor: ...

class CropByIndices(nn.Module):
    """`crop_by_indices` as a module: Crop one box of whole pixels out of each image, and resize the
    crops to one size. The resize does not use pixels outside the crop. For integers, positions are
    rounded to 1/2048 pixel, or 1/32 for "bicubic", and values to integers, half up."""

    size: Optional[Tuple[int, int]]
    interpolation: str
    align_corners: Optional[bool]
    antialias: bool
    shape_compensation: str
    def __init__(
        self,
        size: Optional[Tuple[int, int]] = None,
        interpolation: str = "bilinear",
        align_corners: Optional[bool] = None,
        antialias: bool = False,
        shape_compensation: str = "resize",
    ) -> None: ...
    def forward(self, input_tensor: Tensor, src_box: Tensor) -> Tensor: ...
    def __call__(self, input_tensor: Tensor, src_box: Tensor) -> Tensor: ...

class CropByTransformMat(nn.Module):
    """`crop_by_transform_mat` as a module: Warp images by homographies in pixels: out(p) =
    input_tensor(transform^-1 p)."""

    out_size: Tuple[int, int]
    mode: str
    padding_mode: str
    align_corners: bool
    def __init__(
        self,
        out_size: Tuple[int, int],
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
    ) -> None: ...
    def forward(self, input_tensor: Tensor, transform: Tensor) -> Tensor: ...
    def __call__(self, input_tensor: Tensor, transform: Tensor) -> Tensor: ...

class CropByTransformMat3d(nn.Module):
    """`crop_by_transform_mat3d` as a module: Warp volumes by 3D homographies: out(p) =
    tensor(transform^-1 p)."""

    out_size: Tuple[int, int, int]
    mode: str
    padding_mode: str
    align_corners: bool
    def __init__(
        self,
        out_size: Tuple[int, int, int],
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
    ) -> None: ...
    def forward(self, tensor: Tensor, transform: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor, transform: Tensor) -> Tensor: ...

class ElasticTransform2d(nn.Module):
    """`elastic_transform2d` as a module: Deform an image by smoothed random displacements."""

    kernel_size: Tuple[int, int]
    sigma: Union[Tuple[float, float], Tensor]
    alpha: Union[Tuple[float, float], Tensor]
    align_corners: bool
    mode: str
    padding_mode: str
    def __init__(
        self,
        kernel_size: Tuple[int, int] = (63, 63),
        sigma: Union[Tuple[float, float], Tensor] = (32.0, 32.0),
        alpha: Union[Tuple[float, float], Tensor] = (1.0, 1.0),
        align_corners: bool = False,
        mode: str = "bilinear",
        padding_mode: str = "zeros",
    ) -> None: ...
    def forward(self, image: Tensor, noise: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor, noise: Tensor) -> Tensor: ...

class GetAffineMatrix2d(nn.Module):
    """`get_affine_matrix2d` as a module: Homography that shears, scales and rotates about a centre and
    then translates."""

    sx: Optional[Tensor]
    sy: Optional[Tensor]
    def __init__(self, sx: Optional[Tensor] = None, sy: Optional[Tensor] = None) -> None: ...
    def forward(self, translations: Tensor, center: Tensor, scale: Tensor, angle: Tensor) -> Tensor: ...
    def __call__(self, translations: Tensor, center: Tensor, scale: Tensor, angle: Tensor) -> Tensor: ...

class GetAffineMatrix3d(nn.Module):
    """`get_affine_matrix3d` as a module: 3D homography that shears, scales and rotates about a centre
    and then translates."""

    sxy: Optional[Tensor]
    sxz: Optional[Tensor]
    syx: Optional[Tensor]
    syz: Optional[Tensor]
    szx: Optional[Tensor]
    szy: Optional[Tensor]
    def __init__(
        self,
        sxy: Optional[Tensor] = None,
        sxz: Optional[Tensor] = None,
        syx: Optional[Tensor] = None,
        syz: Optional[Tensor] = None,
        szx: Optional[Tensor] = None,
        szy: Optional[Tensor] = None,
    ) -> None: ...
    def forward(self, translations: Tensor, center: Tensor, scale: Tensor, angles: Tensor) -> Tensor: ...
    def __call__(self, translations: Tensor, center: Tensor, scale: Tensor, angles: Tensor) -> Tensor: ...

class GetPerspectiveTransform(nn.Module):
    """`get_perspective_transform` as a module: Homography that maps four points exactly to four others,
    like ``cv2.getPerspectiveTransform``. In closed form: one homography maps the points at infinity of
    the axes, the origin and (1, 1, 1) to any four points; two of these give the homography between two
    quadruples (R. Hartley, A. Zisserman, Multiple View Geometry, 2nd ed., section 2.3)."""
    def __init__(self) -> None: ...
    def forward(self, points_src: Tensor, points_dst: Tensor) -> Tensor: ...
    def __call__(self, points_src: Tensor, points_dst: Tensor) -> Tensor: ...

class GetPerspectiveTransform3d(nn.Module):
    """`get_perspective_transform3d` as a module: 3D homography between two boxes with eight corners."""
    def __init__(self) -> None: ...
    def forward(self, src: Tensor, dst: Tensor) -> Tensor: ...
    def __call__(self, src: Tensor, dst: Tensor) -> Tensor: ...

class GetProjectiveTransform(nn.Module):
    """`get_projective_transform` as a module: Rotation of space about a centre, after scaling: T(center)
    R(angles) S(scales) T(-center)."""
    def __init__(self) -> None: ...
    def forward(self, center: Tensor, angles: Tensor, scales: Tensor) -> Tensor: ...
    def __call__(self, center: Tensor, angles: Tensor, scales: Tensor) -> Tensor: ...

class GetRotationMatrix2d(nn.Module):
    """`get_rotation_matrix2d` as a module: Rotation about a centre, after scaling: T(center) R(angle)
    S(scale) T(-center)."""
    def __init__(self) -> None: ...
    def forward(self, center: Tensor, angle: Tensor, scale: Tensor) -> Tensor: ...
    def __call__(self, center: Tensor, angle: Tensor, scale: Tensor) -> Tensor: ...

class GetShearMatrix2d(nn.Module):
    """`get_shear_matrix2d` as a module: Homography that shears along x, then along y, about a centre:
    T(center) Y X T(-center)."""

    sx: Optional[Tensor]
    sy: Optional[Tensor]
    def __init__(self, sx: Optional[Tensor] = None, sy: Optional[Tensor] = None) -> None: ...
    def forward(self, center: Tensor) -> Tensor: ...
    def __call__(self, center: Tensor) -> Tensor: ...

class GetShearMatrix3d(nn.Module):
    """`get_shear_matrix3d` as a module: 3D homography that shears along z, then y, then x, about a
    centre: T(center) X Y Z T(-center)."""

    sxy: Optional[Tensor]
    sxz: Optional[Tensor]
    syx: Optional[Tensor]
    syz: Optional[Tensor]
    szx: Optional[Tensor]
    szy: Optional[Tensor]
    def __init__(
        self,
        sxy: Optional[Tensor] = None,
        sxz: Optional[Tensor] = None,
        syx: Optional[Tensor] = None,
        syz: Optional[Tensor] = None,
        szx: Optional[Tensor] = None,
        szy: Optional[Tensor] = None,
    ) -> None: ...
    def forward(self, center: Tensor) -> Tensor: ...
    def __call__(self, center: Tensor) -> Tensor: ...

class GetTpsTransform(nn.Module):
    """`get_tps_transform` as a module: Weights of the spline that maps points_src to points_dst; its
    kernels are centred at **points_dst**. This is as in Kornia: ``warp_points_tps(points_src,
    points_dst, *get_tps_transform(points_src, points_dst))`` is points_dst. (Bookstein centres the
    kernels at the source points. Both splines interpolate; only his has the least bending energy.)"""
    def __init__(self) -> None: ...
    def forward(self, points_src: Tensor, points_dst: Tensor) -> Tuple[Tensor, Tensor]: ...
    def __call__(self, points_src: Tensor, points_dst: Tensor) -> Tuple[Tensor, Tensor]: ...

class GetTranslationMatrix2d(nn.Module):
    """`get_translation_matrix2d` as a module: Homography that translates an image."""
    def __init__(self) -> None: ...
    def forward(self, translations: Tensor) -> Tensor: ...
    def __call__(self, translations: Tensor) -> Tensor: ...

class Hflip(nn.Module):
    """`hflip` as a module: Flip images horizontally (left to right)."""
    def __init__(self) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class HomographyWarp(nn.Module):
    """`homography_warp` as a module: Warp an image by homographies from the output to the image: out(p)
    = patch_src(src_homo_dst p)."""

    dsize: Tuple[int, int]
    mode: str
    padding_mode: str
    align_corners: bool
    normalized_coordinates: bool
    normalized_homography: bool
    def __init__(
        self,
        dsize: Tuple[int, int],
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = False,
        normalized_coordinates: bool = True,
        normalized_homography: bool = True,
    ) -> None: ...
    def forward(self, patch_src: Tensor, src_homo_dst: Tensor) -> Tensor: ...
    def __call__(self, patch_src: Tensor, src_homo_dst: Tensor) -> Tensor: ...

class HomographyWarp3d(nn.Module):
    """`homography_warp3d` as a module: Warp volumes by homographies from the output to the volume:
    out(p) = patch_src(src_homo_dst p)."""

    dsize: Tuple[int, int, int]
    mode: str
    padding_mode: str
    align_corners: bool
    normalized_coordinates: bool
    def __init__(
        self,
        dsize: Tuple[int, int, int],
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = False,
        normalized_coordinates: bool = True,
    ) -> None: ...
    def forward(self, patch_src: Tensor, src_homo_dst: Tensor) -> Tensor: ...
    def __call__(self, patch_src: Tensor, src_homo_dst: Tensor) -> Tensor: ...

class InvertAffineTransform(nn.Module):
    """`invert_affine_transform` as a module: The inverse of an affine transform, like
    ``cv2.invertAffineTransform``."""
    def __init__(self) -> None: ...
    def forward(self, matrix: Tensor) -> Tensor: ...
    def __call__(self, matrix: Tensor) -> Tensor: ...

class ProjectionFromRt(nn.Module):
    """`projection_from_Rt` as a module: Concatenate rotation and translation: [R | t]."""
    def __init__(self) -> None: ...
    def forward(self, rmat: Tensor, tvec: Tensor) -> Tensor: ...
    def __call__(self, rmat: Tensor, tvec: Tensor) -> Tensor: ...

class PyrDown(nn.Module):
    """`pyrdown` as a module: Blur with the binomial kernel (1, 4, 6, 4, 1) / 16 along both axes, then
    downsample. With sampling "bilinear", as in Kornia, an even size is halved by the mean of 2 x 2
    blurred pixels. With "alternate", every other blurred pixel is kept, beginning with the first, which
    is a shift by half a pixel: this is ``cv2.pyrDown``, identical for uint8, which is rounded (halves
    up)."""

    border_type: str
    align_corners: bool
    factor: float
    sampling: str
    def __init__(
        self,
        border_type: str = "reflect",
        align_corners: bool = False,
        factor: float = 2.0,
        sampling: str = "bilinear",
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class PyrUp(nn.Module):
    """`pyrup` as a module: Upsample to twice the size, then blur with the binomial kernel (1, 4, 6, 4,
    1) / 16 along both axes. Sampling "bilinear" is as in Kornia. "alternate" inserts a zero after each
    pixel and blurs with four times the kernel: this is ``cv2.pyrUp``, identical for uint8, which is
    rounded (halves up)."""

    border_type: str
    align_corners: bool
    sampling: str
    def __init__(
        self, border_type: str = "reflect", align_corners: bool = False, sampling: str = "bilinear"
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Remap(nn.Module):
    """`remap` as a module: Sample an image at given positions: out(p) = image(map_x(p), map_y(p))."""

    mode: str
    padding_mode: str
    align_corners: Optional[bool]
    normalized_coordinates: bool
    def __init__(
        self,
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: Optional[bool] = None,
        normalized_coordinates: bool = False,
    ) -> None: ...
    def forward(self, image: Tensor, map_x: Tensor, map_y: Tensor) -> Tensor: ...
    def __call__(self, image: Tensor, map_x: Tensor, map_y: Tensor) -> Tensor: ...

class Rescale(nn.Module):
    """`rescale` as a module: Resize images by a factor; sizes are rounded down."""

    factor: Union[float, Tuple[float, float]]
    interpolation: str
    align_corners: Optional[bool]
    antialias: bool
    def __init__(
        self,
        factor: Union[float, Tuple[float, float]],
        interpolation: str = "bilinear",
        align_corners: Optional[bool] = True,
        antialias: bool = False,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Resize(nn.Module):
    """`resize` as a module: Resize an image."""

    size: Union[int, Tuple[int, int]]
    interpolation: str
    align_corners: Optional[bool]
    side: str
    antialias: bool
    def __init__(
        self,
        size: Union[int, Tuple[int, int]],
        interpolation: str = "bilinear",
        align_corners: Optional[bool] = None,
        side: str = "short",
        antialias: bool = False,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class ResizeToBeDivisible(nn.Module):
    """`resize_to_be_divisible` as a module: Resize images to the nearest sizes that are divisible by a
    number."""

    divisible_factor: int
    interpolation: str
    align_corners: Optional[bool]
    side: str
    antialias: bool
    def __init__(
        self,
        divisible_factor: int,
        interpolation: str = "bilinear",
        align_corners: Optional[bool] = None,
        side: str = "short",
        antialias: bool = False,
    ) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Rot180(nn.Module):
    """`rot180` as a module: Rotate images by 180 degrees."""
    def __init__(self) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Rotate(nn.Module):
    """`rotate` as a module: Rotate images counterclockwise."""

    angle: Tensor
    center: Optional[Tensor]
    mode: str
    padding_mode: str
    align_corners: bool
    def __init__(
        self,
        angle: Tensor,
        center: Optional[Tensor] = None,
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
    ) -> None: ...
    def forward(self, tensor: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor) -> Tensor: ...

class Rotate3d(nn.Module):
    """`rotate3d` as a module: Rotate volumes by rotation vectors (yaw, pitch, roll)."""

    center: Optional[Tensor]
    mode: str
    padding_mode: str
    align_corners: bool
    def __init__(
        self,
        center: Optional[Tensor] = None,
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = False,
    ) -> None: ...
    def forward(self, tensor: Tensor, yaw: Tensor, pitch: Tensor, roll: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor, yaw: Tensor, pitch: Tensor, roll: Tensor) -> Tensor: ...

class Scale(nn.Module):
    """`scale` as a module: Enlarge or shrink the content of images; the image size stays the same."""

    scale_factor: Tensor
    center: Optional[Tensor]
    mode: str
    padding_mode: str
    align_corners: bool
    def __init__(
        self,
        scale_factor: Tensor,
        center: Optional[Tensor] = None,
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
    ) -> None: ...
    def forward(self, tensor: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor) -> Tensor: ...

class Shear(nn.Module):
    """`shear` as a module: Shear images by the matrix [[1, shear_x, 0], [shear_y, 1, 0]] from source to
    destination pixels."""

    shear: Tensor
    mode: str
    padding_mode: str
    align_corners: bool
    def __init__(
        self, shear: Tensor, mode: str = "bilinear", padding_mode: str = "zeros", align_corners: bool = True
    ) -> None: ...
    def forward(self, tensor: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor) -> Tensor: ...

class Translate(nn.Module):
    """`translate` as a module: Translate images."""

    translation: Tensor
    mode: str
    padding_mode: str
    align_corners: bool
    def __init__(
        self,
        translation: Tensor,
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
    ) -> None: ...
    def forward(self, tensor: Tensor) -> Tensor: ...
    def __call__(self, tensor: Tensor) -> Tensor: ...

class Transpose(nn.Module):
    """`transpose` as a module: Swap the axes of images, like ``cv2.transpose``: pixel (i, j) of the
    output is pixel (j, i) of input. After ``hflip`` it is a rotation by 90 degrees counterclockwise,
    before it one clockwise."""
    def __init__(self) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class Vflip(nn.Module):
    """`vflip` as a module: Flip images vertically (top to bottom)."""
    def __init__(self) -> None: ...
    def forward(self, input: Tensor) -> Tensor: ...
    def __call__(self, input: Tensor) -> Tensor: ...

class WarpAffine(nn.Module):
    """`warp_affine` as a module: Warp an image by affine transforms: out(p) = src(M^-1 p)."""

    dsize: Tuple[int, int]
    mode: str
    padding_mode: str
    align_corners: bool
    fill_value: Optional[Tensor]
    def __init__(
        self,
        dsize: Tuple[int, int],
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
        fill_value: Optional[Tensor] = None,
    ) -> None: ...
    def forward(self, src: Tensor, M: Tensor) -> Tensor: ...
    def __call__(self, src: Tensor, M: Tensor) -> Tensor: ...

class WarpAffine3d(nn.Module):
    """`warp_affine3d` as a module: Warp volumes by affine transforms: out(p) = src(M^-1 p), voxel
    centres at integers."""

    dsize: Tuple[int, int, int]
    flags: str
    padding_mode: str
    align_corners: bool
    def __init__(
        self,
        dsize: Tuple[int, int, int],
        flags: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
    ) -> None: ...
    def forward(self, src: Tensor, M: Tensor) -> Tensor: ...
    def __call__(self, src: Tensor, M: Tensor) -> Tensor: ...

class WarpGrid(nn.Module):
    """`warp_grid` as a module: Transform a grid of points by homographies."""
    def __init__(self) -> None: ...
    def forward(self, grid: Tensor, src_homo_dst: Tensor) -> Tensor: ...
    def __call__(self, grid: Tensor, src_homo_dst: Tensor) -> Tensor: ...

class WarpGrid3d(nn.Module):
    """`warp_grid3d` as a module: Transform a grid of 3D points by homographies."""
    def __init__(self) -> None: ...
    def forward(self, grid: Tensor, src_homo_dst: Tensor) -> Tensor: ...
    def __call__(self, grid: Tensor, src_homo_dst: Tensor) -> Tensor: ...

class WarpImageTps(nn.Module):
    """`warp_image_tps` as a module: Warp an image by thin-plate splines: out(p) = image(spline(p)), in
    coordinates from -1 to 1. So the spline maps the output to the image. With kernel_centers = points
    and the weights of ``get_tps_transform(others, points)``, the content of the image at points moves to
    others."""

    align_corners: bool
    padding_mode: str
    def __init__(self, align_corners: bool = False, padding_mode: str = "zeros") -> None: ...
    def forward(
        self, image: Tensor, kernel_centers: Tensor, kernel_weights: Tensor, affine_weights: Tensor
    ) -> Tensor: ...
    def __call__(
        self, image: Tensor, kernel_centers: Tensor, kernel_weights: Tensor, affine_weights: Tensor
    ) -> Tensor: ...

class WarpPerspective(nn.Module):
    """`warp_perspective` as a module: Warp an image by homographies: out(p) = src(M^-1 p)."""

    dsize: Tuple[int, int]
    mode: str
    padding_mode: str
    align_corners: bool
    fill_value: Optional[Tensor]
    def __init__(
        self,
        dsize: Tuple[int, int],
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
        fill_value: Optional[Tensor] = None,
    ) -> None: ...
    def forward(self, src: Tensor, M: Tensor) -> Tensor: ...
    def __call__(self, src: Tensor, M: Tensor) -> Tensor: ...

class WarpPerspective3d(nn.Module):
    """`warp_perspective3d` as a module: Warp volumes by 3D homographies: out(p) = src(M^-1 p), voxel
    centres at integers."""

    dsize: Tuple[int, int, int]
    flags: str
    border_mode: str
    align_corners: bool
    def __init__(
        self,
        dsize: Tuple[int, int, int],
        flags: str = "bilinear",
        border_mode: str = "zeros",
        align_corners: bool = False,
    ) -> None: ...
    def forward(self, src: Tensor, M: Tensor) -> Tensor: ...
    def __call__(self, src: Tensor, M: Tensor) -> Tensor: ...

class WarpPointsTps(nn.Module):
    """`warp_points_tps` as a module: Transform points by thin-plate splines."""
    def __init__(self) -> None: ...
    def forward(
        self, points_src: Tensor, kernel_centers: Tensor, kernel_weights: Tensor, affine_weights: Tensor
    ) -> Tensor: ...
    def __call__(
        self, points_src: Tensor, kernel_centers: Tensor, kernel_weights: Tensor, affine_weights: Tensor
    ) -> Tensor: ...

class WarpPolar(nn.Module):
    """`warp_polar` as a module: Warp images to polar coordinates, like ``cv2.warpPolar``: rows are
    directions, columns distances."""

    dsize: Tuple[int, int]
    center: Optional[Tensor]
    max_radius: Optional[Tensor]
    mapping: str
    mode: str
    padding_mode: str
    align_corners: bool
    def __init__(
        self,
        dsize: Tuple[int, int],
        center: Optional[Tensor] = None,
        max_radius: Optional[Tensor] = None,
        mapping: str = "linear",
        mode: str = "bilinear",
        padding_mode: str = "zeros",
        align_corners: bool = True,
    ) -> None: ...
    def forward(self, src: Tensor) -> Tensor: ...
    def __call__(self, src: Tensor) -> Tensor: ...

__all__ = [
    "Affine",
    "Affine3d",
    "BuildLaplacianPyramid",
    "BuildPyramid",
    "CenterCrop",
    "CenterCrop2D",
    "CenterCrop3d",
    "CopyMakeBorder",
    "CropAndResize",
    "CropAndResize3d",
    "CropByBoxes",
    "CropByBoxes3d",
    "CropByIndices",
    "CropByTransformMat",
    "CropByTransformMat3d",
    "ElasticTransform2d",
    "GetAffineMatrix2d",
    "GetAffineMatrix3d",
    "GetPerspectiveTransform",
    "GetPerspectiveTransform3d",
    "GetProjectiveTransform",
    "GetRotationMatrix2d",
    "GetShearMatrix2d",
    "GetShearMatrix3d",
    "GetTpsTransform",
    "GetTranslationMatrix2d",
    "Hflip",
    "Homography",
    "HomographyWarp",
    "HomographyWarp3d",
    "HomographyWarper",
    "ImageRegistrator",
    "InvertAffineTransform",
    "ProjectionFromRt",
    "PyrDown",
    "PyrUp",
    "Remap",
    "Rescale",
    "Resize",
    "ResizeToBeDivisible",
    "Rot180",
    "Rotate",
    "Rotate3d",
    "Scale",
    "ScalePyramid",
    "Shear",
    "Similarity",
    "Translate",
    "Transpose",
    "Vflip",
    "WarpAffine",
    "WarpAffine3d",
    "WarpGrid",
    "WarpGrid3d",
    "WarpImageTps",
    "WarpPerspective",
    "WarpPerspective3d",
    "WarpPointsTps",
    "WarpPolar",
    "affine",
    "affine3d",
    "build_laplacian_pyramid",
    "build_pyramid",
    "center_crop",
    "center_crop3d",
    "copy_make_border",
    "crop_and_resize",
    "crop_and_resize3d",
    "crop_by_boxes",
    "crop_by_boxes3d",
    "crop_by_indices",
    "crop_by_transform_mat",
    "crop_by_transform_mat3d",
    "elastic_transform2d",
    "get_affine_matrix2d",
    "get_affine_matrix3d",
    "get_perspective_transform",
    "get_perspective_transform3d",
    "get_projective_transform",
    "get_rotation_matrix2d",
    "get_shear_matrix2d",
    "get_shear_matrix3d",
    "get_tps_transform",
    "get_translation_matrix2d",
    "hflip",
    "homography_warp",
    "homography_warp3d",
    "invert_affine_transform",
    "projection_from_Rt",
    "pyrdown",
    "pyrup",
    "remap",
    "rescale",
    "resize",
    "resize_to_be_divisible",
    "rot180",
    "rotate",
    "rotate3d",
    "scale",
    "shear",
    "translate",
    "transpose",
    "vflip",
    "warp_affine",
    "warp_affine3d",
    "warp_grid",
    "warp_grid3d",
    "warp_image_tps",
    "warp_perspective",
    "warp_perspective3d",
    "warp_points_tps",
    "warp_polar",
]
