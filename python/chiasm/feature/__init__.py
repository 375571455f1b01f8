"""Interest points."""

from ..primitives.twin import lazy_twins
from .harris import harris_keypoints, harris_response

__all__ = ["harris_keypoints", "harris_response"]

__getattr__ = lazy_twins(__name__, globals())
