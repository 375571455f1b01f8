"""Export of ops and pipelines to bundles.

    from chiasm.export import Spec, export, image
    export(my_function, Spec("my.op", [image()]), "bundles")
"""

from .bundle import BundleError
from .errors import ExportError
from .exporter import FORMATS, export
from .spec import Spec, TensorSpec, Tolerance, frame, image

__all__ = ["FORMATS", "BundleError", "ExportError", "Spec", "TensorSpec", "Tolerance", "export", "frame", "image"]
