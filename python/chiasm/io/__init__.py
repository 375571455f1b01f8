"""Image files in and out, for eager Python: Kornia's module."""

from ..image.files import ImageLoadType, load_image, write_image

__all__ = ["ImageLoadType", "load_image", "write_image"]


def __dir__() -> list[str]:
    return list(__all__)
