"""Ready compositions of ops: of frames, and of two views of one thing."""

from .frames import edges, preprocess
from .letterbox import center_crop, crop_boxes, letterbox
from .two_views import two_view_homography

__all__ = ["center_crop", "crop_boxes", "edges", "letterbox", "preprocess", "two_view_homography"]
