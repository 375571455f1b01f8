# An attribute of an nn.Module is declared as a Tensor or a Module, whichever it is.
# pyright: reportArgumentType=false, reportCallIssue=false, reportIndexIssue=false, reportOperatorIssue=false
"""A rectified stereo camera, which converts disparities to points."""

import torch
from torch import Tensor

from ...primitives.core.checks import check_matrix, check_rank
from ...primitives.core.modules import Module, hold
from ..stereo import reproject_disparity_to_3d


class StereoCamera(Module):
    """B rectified stereo pairs; a call with disparities is ``reproject_disparity_to_3D``.

    :func:`chiasm.geometry.stereo.stereo_rectify` computes such projection matrices. A tensor that is an
    ``nn.Parameter`` becomes a learnable parameter of the module.

    Args:
        rectified_left_camera, rectified_right_camera: (B, 3, 4), projection matrices in pixels, floating
            point, both [fx 0 cx; 0 fy cy; 0 0 1 | last], whose last columns are (0, 0, 0) on the left, (-fx
            tx, 0, 0) on the right. fx, fy and cy are read from the left matrix.

    Raises:
        TypeError: if a matrix is not floating point.
        ValueError: if a shape is not as above.

    Example:
        >>> left = torch.tensor([[[100.0, 0.0, 32.0, 0.0], [0.0, 100.0, 24.0, 0.0], [0.0, 0.0, 1.0, 0.0]]])
        >>> right = left.clone()
        >>> right[0, 0, 3] = -50.0
        >>> camera = StereoCamera(left, right)
        >>> camera.tx, camera(torch.full((1, 1, 1, 2), 10.0))[0, 0, :, 2]
        (tensor([0.5000]), tensor([5., 5.]))
    """

    def __init__(self, rectified_left_camera: Tensor, rectified_right_camera: Tensor) -> None:
        super().__init__()
        for name, value in (
            ("rectified_left_camera", rectified_left_camera),
            ("rectified_right_camera", rectified_right_camera),
        ):
            check_rank(value, 3, "(B, 3, 4)", name)
            check_matrix(value, 3, 4, name)
        if rectified_left_camera.shape != rectified_right_camera.shape:
            shapes = [list(rectified_left_camera.shape), list(rectified_right_camera.shape)]
            raise ValueError(
                f"rectified_right_camera: expected the left one's shape {shapes[0]}, got {shapes[1]}"
            )
        hold(self, "rectified_left_camera", rectified_left_camera)
        hold(self, "rectified_right_camera", rectified_right_camera)

    @property
    def batch_size(self) -> int:
        """B."""
        return self.rectified_left_camera.size(0)

    @property
    def fx(self) -> Tensor:
        """(B,), horizontal focal lengths in pixels."""
        return self.rectified_left_camera[:, 0, 0]

    @property
    def fy(self) -> Tensor:
        """(B,), vertical focal lengths in pixels."""
        return self.rectified_left_camera[:, 1, 1]

    @property
    def cx_left(self) -> Tensor:
        """(B,), columns of the left principal points."""
        return self.rectified_left_camera[:, 0, 2]

    @property
    def cx_right(self) -> Tensor:
        """(B,), columns of the right principal points."""
        return self.rectified_right_camera[:, 0, 2]

    @property
    def cy(self) -> Tensor:
        """(B,), rows of the principal points."""
        return self.rectified_left_camera[:, 1, 2]

    @property
    def tx(self) -> Tensor:
        """(B,), the baselines: how far the right cameras are to the right of the left ones, in the world's
        unit."""
        return -self.rectified_right_camera[:, 0, 3] / self.fx

    @property
    def Q(self) -> Tensor:
        """(B, 4, 4), from (x, y, disparity, 1) to homogeneous points; the same as Q of
        ``cv2.stereoRectify``."""
        zero, one = torch.zeros_like(self.tx), torch.ones_like(self.tx)
        shape = self.fx / self.fy
        rows = [
            torch.stack([one, zero, zero, -self.cx_left], -1),
            torch.stack([zero, shape, zero, -self.cy * shape], -1),
            torch.stack([zero, zero, zero, self.fx], -1),
            torch.stack([zero, zero, one / self.tx, (self.cx_right - self.cx_left) / self.tx], -1),
        ]
        return torch.stack(rows, -2)

    @torch.jit.export
    def reproject_disparity_to_3D(self, disparity_tensor: Tensor) -> Tensor:
        """Points (B, H, W, 3) in the left cameras' frames, from disparities (left column minus right column,
        in pixels): (B, 1, H, W), or (B, H, W, 1) as in Kornia (then H must be more than 1)."""
        if disparity_tensor.dim() == 4 and disparity_tensor.size(1) != 1 and disparity_tensor.size(3) == 1:
            disparity_tensor = disparity_tensor.permute(0, 3, 1, 2)
        return reproject_disparity_to_3d(disparity_tensor, self.Q)

    def forward(self, disparity_tensor: Tensor) -> Tensor:
        return self.reproject_disparity_to_3D(disparity_tensor)
