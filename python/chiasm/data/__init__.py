"""Run a bundle over a data set: on Ray, Spark, Daft, in processes or in a plain loop, with the same numbers.

A `Map` describes the work. It can be pickled and sent to a worker, where it opens the bundle by itself. It
takes a batch of rows, as NumPy arrays or as Arrow, and returns the batch with the op's outputs.

    from chiasm.data import Map
    preprocess = Map("bundles/pipelines.preprocess.chiasm", columns={"frame": "image"})
    images = preprocess({"image": [open("photo.jpg", "rb").read()]})["output"]

docs/scale.md compares the engines. This module needs only the standard library; NumPy, Pillow and pyarrow are
imported when a batch needs them.
"""

from .errors import DataError
from .mapping import Files, Map

__all__ = ["DataError", "Files", "Map"]


def __dir__() -> list[str]:
    return __all__
