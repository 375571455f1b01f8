"""Interest points."""

from ..primitives.twin import lazy_twins
from .harris import harris_keypoints, harris_response
from .responses import dog_response, dog_response_single, gftt_response, hessian_response

__all__ = ["dog_response", "dog_response_single", "gftt_response", "harris_keypoints", "harris_response", "hessian_response"]

__getattr__ = lazy_twins(__name__, globals())
