"""Rigid motions between two frames that have names."""

from typing import Any, Optional, Union

from torch import Tensor

from ..primitives.core.checks import check_tensor
from .liegroup import Se2, Se3, So2, So3
from .quaternion import Quaternion

__all__ = ["NamedPose"]


def __dir__() -> list[str]:
    return __all__


class NamedPose:
    """A motion from one frame's coordinates to another's, for eager Python. ``*`` composes two whose frames
    meet: (c from b) * (b from a) is c from a.

    Args:
        dst_from_src: the motion.
        frame_src: the name of the frame whose points it takes; a name of its own by default.
        frame_dst: the name of the frame whose points it returns.

    Raises:
        TypeError: if dst_from_src is not a motion; by ``*``, if one is of the plane and one of space.
        ValueError: if both frames have one name; by ``*``, if the frames do not meet.

    Example:
        >>> from chiasm.geometry.liegroup import Se3
        >>> b_from_a = NamedPose(Se3.trans_x(torch.tensor(2.0)), "a", "b")
        >>> from chiasm.geometry.liegroup import Se3
        >>> b_from_a.inverse().transform_points(torch.tensor([5.0, 0.0, 0.0]))
        tensor([3., 0., 0.])
    """

    _count = 0

    def __init__(
        self,
        dst_from_src: Union[Se2, Se3],
        frame_src: Optional[str] = None,
        frame_dst: Optional[str] = None,
    ) -> None:
        if not isinstance(dst_from_src, (Se2, Se3)):
            raise TypeError(f"dst_from_src: expected a Se2 or a Se3, got {type(dst_from_src).__name__}")
        self._pose = dst_from_src
        self._frame_src, self._frame_dst = frame_src or _new_name(), frame_dst or _new_name()
        if self._frame_src == self._frame_dst:
            raise ValueError(f"frame_dst: expected a name other than frame_src's, got '{frame_dst}'")

    def __repr__(self) -> str:
        return f"NamedPose({self._frame_dst} from {self._frame_src}: {self._pose.log().detach()})"

    def __mul__(self, other: "NamedPose") -> "NamedPose":
        if self._frame_src != other._frame_dst:
            raise ValueError(
                f"expected a pose to frame '{self._frame_src}', got one to frame '{other._frame_dst}'"
            )
        if type(self._pose) is not type(other._pose):
            raise TypeError(f"expected a pose with a {type(self._pose).__name__}")
        second: Any = other._pose
        return NamedPose(self._pose * second, other._frame_src, self._frame_dst)

    @property
    def pose(self) -> Union[Se2, Se3]:
        """The motion."""
        return self._pose

    @property
    def rotation(self) -> Union[So2, So3]:
        """Its rotation."""
        return self._pose.rotation

    @property
    def translation(self) -> Tensor:
        """Its translation, (*, 2) or (*, 3)."""
        return self._pose.translation

    @property
    def frame_src(self) -> str:
        """The frame whose points it takes."""
        return self._frame_src

    @property
    def frame_dst(self) -> str:
        """The frame whose points it returns."""
        return self._frame_dst

    @classmethod
    def from_rt(
        cls,
        rotation: Union[So3, So2, Tensor, Quaternion],
        translation: Tensor,
        frame_src: Optional[str] = None,
        frame_dst: Optional[str] = None,
    ) -> "NamedPose":
        """From a rotation (an object, or matrices (*, 2, 2) or (*, 3, 3)) and a translation."""
        turn = rotation
        if isinstance(turn, Tensor):
            turn = (So2 if turn.size(-1) == 2 else So3).from_matrix(turn)
        motion = Se2(turn, translation) if isinstance(turn, So2) else Se3(turn, translation)
        return cls(motion, frame_src, frame_dst)

    @classmethod
    def from_matrix(
        cls, matrix: Tensor, frame_src: Optional[str] = None, frame_dst: Optional[str] = None
    ) -> "NamedPose":
        """From matrices (*, 3, 3) of the plane or (*, 4, 4) of space."""
        check_tensor(matrix, "matrix")
        return cls((Se2 if matrix.size(-1) == 3 else Se3).from_matrix(matrix), frame_src, frame_dst)

    def inverse(self) -> "NamedPose":
        """The motion back."""
        return NamedPose(self._pose.inverse(), self._frame_dst, self._frame_src)

    def transform_points(self, points_in_src: Tensor) -> Tensor:
        """Points (*, 2) or (*, 3) of the frame ``frame_src``, in the frame ``frame_dst``."""
        return self._pose * points_in_src


def _new_name() -> str:
    """A name that no other frame has."""
    NamedPose._count += 1
    return f"frame {NamedPose._count}"
