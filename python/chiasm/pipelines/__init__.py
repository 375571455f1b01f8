"""Ready compositions of ops: for frames, and for two views of a scene."""

from .. import primitives as _primitives  # noqa: F401  (says so where there is no torch)
from .camera_letterbox import letterbox_i420, letterbox_nv12, letterbox_nv21, letterbox_yuyv
from .frames import edges, preprocess
from .letterbox import center_crop, crop_boxes, letterbox, letterbox_longest, pad_to_multiple
from .two_views import two_view_homography

__all__ = [
    "center_crop",
    "crop_boxes",
    "edges",
    "letterbox",
    "letterbox_i420",
    "letterbox_longest",
    "letterbox_nv12",
    "letterbox_nv21",
    "letterbox_yuyv",
    "pad_to_multiple",
    "preprocess",
    "two_view_homography",
]


def __dir__() -> list[str]:
    return __all__
