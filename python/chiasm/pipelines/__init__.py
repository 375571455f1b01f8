"""Ready compositions of ops, from a camera frame on."""

from .frames import edges, preprocess

__all__ = ["edges", "preprocess"]
