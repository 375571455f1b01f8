"""Local maxima to a fraction of a pixel, and heat maps."""

from ...primitives.core.modules import ModuleForm, lazy_modules
from .heatmaps import render_gaussian2d, spatial_expectation2d, spatial_soft_argmax2d, spatial_softmax2d
from .modules import NonMaximaSuppression2d, NonMaximaSuppression3d
from .quadratic import conv_quad_interp3d, iterative_quad_interp3d
from .suppression import nms2d, nms3d, nms3d_minmax
from .windows import conv_soft_argmax2d, conv_soft_argmax3d

__all__ = [
    "NonMaximaSuppression2d",
    "NonMaximaSuppression3d",
    "conv_quad_interp3d",
    "conv_soft_argmax2d",
    "conv_soft_argmax3d",
    "iterative_quad_interp3d",
    "nms2d",
    "nms3d",
    "nms3d_minmax",
    "render_gaussian2d",
    "spatial_expectation2d",
    "spatial_soft_argmax2d",
    "spatial_softmax2d",
]

# As Kornia's classes have them.
_FORMS = {
    "conv_quad_interp3d": ModuleForm(last=["precomputed_nms_mask"]),
    "iterative_quad_interp3d": ModuleForm(last=["precomputed_nms_mask"]),
}

__getattr__, __dir__ = lazy_modules(__name__, globals(), _FORMS)
