"""Registration of images by gradient descent, under a name of its own: `transform` has the classes too."""

from .transform.registrator import Homography, ImageRegistrator, Similarity

__all__ = ["Homography", "ImageRegistrator", "Similarity"]


def __dir__() -> list[str]:
    return __all__
