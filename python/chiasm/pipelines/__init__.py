"""Ready compositions of ops: of a camera's frame, and of two views of one thing."""

from .frames import edges, preprocess
from .two_views import two_view_homography

__all__ = ["edges", "preprocess", "two_view_homography"]
