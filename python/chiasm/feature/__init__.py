"""Interest points."""

from .harris import harris_keypoints, harris_response

__all__ = ["harris_keypoints", "harris_response"]
