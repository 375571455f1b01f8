"""Camera models as objects, for eager Python: a projection, a distortion and their parameters."""

from enum import Enum
from typing import Any, Callable, ClassVar, Dict, Tuple, Type, Union

import torch
from torch import Tensor
from typing_extensions import Self  # Python's own from 3.11; torch needs the package

from ...image.base import ImageSize
from ...primitives.core.checks import check_floating, check_last
from ..calibration import distort_points, undistort_points
from ..vector import Vector2, Vector3, bare
from .affine import distort_points_affine, undistort_points_affine
from .kannala_brandt import distort_points_kannala_brandt, undistort_points_kannala_brandt
from .planes import (
    project_points_orthographic,
    project_points_z1,
    unproject_points_orthographic,
    unproject_points_z1,
)

Move = Callable[[Tensor, Tensor], Tensor]


class CameraModelType(Enum):
    """The models of cameras.

    >>> CameraModelType.BROWN_CONRADY.value
    1
    """

    PINHOLE = 0
    BROWN_CONRADY = 1
    KANNALA_BRANDT_K3 = 2
    ORTHOGRAPHIC = 3


class CameraModelBase:
    """A camera: points of its frame are projected to a plane, and then distorted to pixels.

    A subclass names its functions and the number of its parameters.

    Args:
        image_size: height and width in pixels, ``ImageSize`` or a pair.
        params: (N,), or (B, N) for B cameras, floating point: fx, fy, cx, cy in pixels, then the
            coefficients of the distortion.

    Raises:
        TypeError: if params is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> PinholeModel((480, 640), torch.tensor([328.0, 328.0, 320.0, 240.0])).matrix()
        tensor([[328.,   0., 320.],
                [  0., 328., 240.],
                [  0.,   0.,   1.]])
    """

    #: The number of parameters.
    count: ClassVar[int] = 4
    _project: ClassVar[Callable[[Tensor], Tensor]] = staticmethod(project_points_z1)
    _unproject: ClassVar[Move] = staticmethod(unproject_points_z1)
    _distort: ClassVar[Move] = staticmethod(distort_points_affine)
    _undistort: ClassVar[Move] = staticmethod(undistort_points_affine)

    def __init__(self, image_size: Union[ImageSize, Tuple[int, int]], params: Tensor) -> None:
        check_floating(params, "params")
        if params.dim() not in (1, 2) or params.size(-1) != self.count:
            raise ValueError(
                f"params: expected shape ({self.count},) or (B, {self.count}) for {type(self).__name__}, got"
                f" {list(params.shape)}"
            )
        self.image_size, self.params = ImageSize(*image_size), params

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.image_size}, {self.params})"

    @property
    def height(self) -> int:
        """The image's height in pixels."""
        return self.image_size.height

    @property
    def width(self) -> int:
        """The image's width in pixels."""
        return self.image_size.width

    @property
    def fx(self) -> Tensor:
        """() or (B,), the horizontal focal length in pixels."""
        return self.params[..., 0]

    @property
    def fy(self) -> Tensor:
        """() or (B,), the vertical focal length in pixels."""
        return self.params[..., 1]

    @property
    def cx(self) -> Tensor:
        """() or (B,), the principal point's column."""
        return self.params[..., 2]

    @property
    def cy(self) -> Tensor:
        """() or (B,), the principal point's row."""
        return self.params[..., 3]

    def matrix(self) -> Tensor:
        """(3, 3) or (B, 3, 3), the camera matrix."""
        return _matrix_of(self.params)

    #: ``matrix``, by Kornia's other name.
    K = matrix

    def project(self, points: Union[Vector3, Tensor]) -> Any:
        """The pixels at which the camera sees points.

        Args:
            points: (*, 3) of the camera's frame, or (B, *, 3) for B cameras.

        Returns:
            (*, 2), a ``Vector2`` for a ``Vector3``.
        """
        flat = _for_each(bare(points), 3, "points", self.params)
        pixels = type(self)._distort(type(self)._project(flat), self._beside(flat))
        pixels = pixels.reshape([*points.shape[:-1], 2])
        return Vector2(pixels) if isinstance(points, Vector3) else pixels

    def unproject(self, points: Union[Vector2, Tensor], depth: Any) -> Any:
        """The points that the camera sees at pixels, at a depth.

        Args:
            points: (*, 2) pixels, or (B, *, 2) for B cameras.
            depth: z in the camera's frame, a tensor that broadcasts to (*).

        Returns:
            (*, 3), a ``Vector3`` for a ``Vector2``.
        """
        pixels = bare(points)
        flat = _for_each(pixels, 2, "points", self.params)
        z = torch.as_tensor(bare(depth), dtype=flat.dtype, device=flat.device)
        z = z.expand(pixels.shape[:-1]).reshape(flat.shape[:-1])
        found = type(self)._unproject(type(self)._undistort(flat, self._beside(flat)), z)
        found = found.reshape([*pixels.shape[:-1], 3])
        return Vector3(found) if isinstance(points, Vector2) else found

    def _beside(self, flat: Tensor) -> Tensor:
        """The parameters (n,), or (B, 1, n) beside points (B, N, *)."""
        return self.params if self.params.dim() == 1 else self.params[:, None]


class PinholeModel(CameraModelBase):
    """A camera without distortion; ``params`` are fx, fy, cx, cy.

    Example:
        >>> camera = PinholeModel((480, 640), torch.tensor([328.0, 328.0, 320.0, 240.0]))
        >>> camera.project(torch.tensor([1.0, 1.0, 1.0]))
        tensor([648., 568.])
    """

    def scale(self, scale_factor: float) -> Self:
        """The camera of an image whose sides are multiplied, as are focal lengths and principal point: its
        pixels' coordinates begin at the image's edge, as those of ``PinholeCamera.scale``."""
        height, width = [int(side * scale_factor) for side in self.image_size]
        return type(self)(ImageSize(height, width), self.params * scale_factor)


class BrownConradyModel(CameraModelBase):
    """A camera with radial and tangential distortion, OpenCV's rational model: ``params`` are fx, fy, cx, cy,
    k1, k2, p1, p2, k3, k4, k5, k6.

    Example:
        >>> params = torch.tensor([328.0, 328.0, 320.0, 240.0, 0.1, 0, 0, 0, 0, 0, 0, 0])
        >>> BrownConradyModel((480, 640), params).project(torch.tensor([1.0, 0.0, 1.0]))
        tensor([680.8000, 240.0000])
    """

    count = 12

    @staticmethod
    def _distort(points: Tensor, params: Tensor) -> Tensor:
        return distort_points(points, *_lens(points, params))

    @staticmethod
    def _undistort(points: Tensor, params: Tensor) -> Tensor:
        # More steps than an image needs: points of a wide angle take them.
        return undistort_points(points, *_lens(points, params), num_iters=10)


class KannalaBrandtK3(CameraModelBase):
    """A fisheye camera: ``params`` are fx, fy, cx, cy, k1, k2, k3, k4, as of
    ``distort_points_kannala_brandt``.

    Example:
        >>> params = torch.tensor([400.0, 400.0, 320.0, 240.0, 0.0, 0.0, 0.0, 0.0])
        >>> KannalaBrandtK3((480, 640), params).project(torch.tensor([1.0, 0.0, 1.0]))
        tensor([634.1593, 240.0000])
    """

    count = 8
    _distort = staticmethod(distort_points_kannala_brandt)
    _undistort = staticmethod(undistort_points_kannala_brandt)


class Orthographic(CameraModelBase):
    """A camera without perspective: ``params`` are fx, fy, cx, cy.

    Example:
        >>> camera = Orthographic((480, 640), torch.tensor([2.0, 2.0, 320.0, 240.0]))
        >>> camera.project(torch.tensor([1.0, 1.0, 7.0]))
        tensor([322., 242.])
    """

    _project = staticmethod(project_points_orthographic)
    _unproject = staticmethod(unproject_points_orthographic)


_MODELS: Dict[CameraModelType, Type[CameraModelBase]] = {
    CameraModelType.PINHOLE: PinholeModel,
    CameraModelType.BROWN_CONRADY: BrownConradyModel,
    CameraModelType.KANNALA_BRANDT_K3: KannalaBrandtK3,
    CameraModelType.ORTHOGRAPHIC: Orthographic,
}


class CameraModel:
    """A camera of one of the models, with all that the model has.

    Args:
        image_size, params: as of ``CameraModelBase``.
        model_type: the model.

    Raises:
        TypeError: if params is not floating point.
        ValueError: if model_type is not one of ``CameraModelType``, or a shape is not as above.

    Example:
        >>> params = torch.tensor([328.0, 328.0, 320.0, 240.0])
        >>> camera = CameraModel((480, 640), CameraModelType.PINHOLE, params)
        >>> pixels = camera.project(torch.tensor([1.0, 1.0, 2.0]))
        >>> pixels, camera.unproject(pixels, 2.0)
        (tensor([484., 404.]), tensor([1., 1., 2.]))
    """

    def __init__(
        self, image_size: Union[ImageSize, Tuple[int, int]], model_type: CameraModelType, params: Tensor
    ) -> None:
        if model_type not in _MODELS:
            raise ValueError(f"model_type: expected one of CameraModelType, got {model_type!r}")
        self._model = _MODELS[model_type](image_size, params)

    def __getattr__(self, name: str) -> Any:
        if name == "_model":  # not there yet, in a copy
            raise AttributeError(name)
        return getattr(self._model, name)

    def __repr__(self) -> str:
        return f"CameraModel({self.image_size}, {type(self._model).__name__}, {self.params})"


def _matrix_of(params: Tensor) -> Tensor:
    """(*, 3, 3) of parameters (*, n)."""
    zero, one = torch.zeros_like(params[..., 0]), torch.ones_like(params[..., 0])
    fx, fy, cx, cy = params[..., :4].unbind(-1)
    return torch.stack([fx, zero, cx, zero, fy, cy, zero, zero, one], -1).unflatten(-1, (3, 3))


def _lens(points: Tensor, params: Tensor) -> Tuple[Tensor, Tensor, Tensor]:
    """For points (N, 2) or (B, N, 2): camera matrices, distortions, and the matrices of the plane z = 1."""
    own = params if params.dim() == 1 else params[:, 0]
    matrix = _matrix_of(own)
    return matrix, own[..., 4:], torch.eye(3, dtype=matrix.dtype, device=matrix.device).expand_as(matrix)


def _for_each(points: Tensor, last: int, name: str, params: Tensor) -> Tensor:
    """Points (*, n) as (N, n), or (B, *, n) as (B, N, n) for B cameras."""
    check_last(points, last, name)
    if params.dim() == 1:
        return points.reshape(-1, last)
    if points.dim() < 2 or points.size(0) != params.size(0):
        raise ValueError(
            f"{name}: expected shape ({params.size(0)}, *, {last}) for {params.size(0)} cameras, got"
            f" {list(points.shape)}"
        )
    return points.reshape(points.size(0), -1, last)
