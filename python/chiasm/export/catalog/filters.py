"""Filters: correlation, blurs, sharpening, pooling."""

import math
from typing import Any

import numpy as np

from ..peer import Peer, opencv
from ..spec import ErrorInput, Frames, Spec, TensorSpec, Tolerance, image
from . import STENCIL, add, rejected, rejected_sizes, rejected_words
from .filters_kernels import ANGLE, DIRECTION, NOT_SIGMAS, TURN, WAVE

SAME = [TensorSpec("output", layout="NCHW")]
DEEP = {**STENCIL, "D": (8, 4096)}

#: The gradient of a kernel, or of its parameters, is a sum over all pixels whose terms cancel, so float32
#: loses digits.
SUMMED = {"float32": Tolerance(1e-3, 1e-3)}

VOLUME = TensorSpec("input", ("B", "C", "D", "H", "W"), "T", "NCDHW", range=(0.0, 1.0), description="volumes")

# --- correlation with a given kernel ------------------------------------------------------------------------


def _correlated(border: str) -> Peer:
    return opencv(lambda cv2, x, kernel: cv2.filter2D(x, -1, kernel, borderType=getattr(cv2, border)))


def _kernel(*shape: int | str, name: str = "kernel"):
    return TensorSpec(
        name,
        shape,
        range=(-1.0, 1.0),
        description="one for each sample" if shape[0] == "B" else "shared by all samples",
    )


for _name, _shape, _config, _peer in (
    ("filter2d", (3, 3), {"border_type": "reflect"}, _correlated("BORDER_REFLECT_101")),
    ("correlate2d", (3, 5), {"border_type": "replicate"}, _correlated("BORDER_REPLICATE")),
    (
        "convolve2d",
        ("B", 3, 3),
        {"border_type": "reflect", "normalized": True},
        opencv(
            lambda cv2, x, kernel: cv2.filter2D(x, -1, kernel, borderType=cv2.BORDER_REFLECT_101),
            before=lambda x, kernel: (x, kernel[::-1, ::-1] / np.abs(kernel).sum()),
        ),
    ),
    (
        "fft_conv",
        (5, 5),
        {"padding": "valid"},
        Peer(
            "scipy.signal",
            lambda signal, x, kernel: signal.fftconvolve(x, kernel[::-1, ::-1], "valid"),
            "planes",
        ),
    ),
):
    add(
        Spec(
            f"filters.{_name}",
            [image(), _kernel(*_shape)],
            SAME,
            config=_config,
            symbols=STENCIL,
            gradient_tolerances=SUMMED,
            peer=_peer,
            reference="OpenCV filter2D, SciPy ndimage.correlate",
            frames=Frames(peer=opencv(_peer.call, atol=1)) if _name == "filter2d" else None,
        )
    )

add(
    Spec(
        "filters.filter2d_separable",
        [image(), _kernel("B", 5, name="kernel_x"), _kernel(3, name="kernel_y")],
        SAME,
        config={"border_type": "reflect"},
        symbols=STENCIL,
        gradient_tolerances=SUMMED,
        peer=opencv(lambda cv2, x, kx, ky: cv2.sepFilter2D(x, -1, kx, ky, borderType=cv2.BORDER_REFLECT_101)),
        reference="OpenCV sepFilter2D, SciPy correlate1d",
        frames=Frames(
            peer=opencv(
                lambda cv2, x, kx, ky: cv2.sepFilter2D(x, -1, kx, ky, borderType=cv2.BORDER_REFLECT_101),
                atol=1,
            )
        ),
    )
)

for _name, _shape, _config, _mode in (
    ("filter3d", (3, 3, 3), {"border_type": "replicate"}, "nearest"),
    ("correlate3d", ("B", 1, 3, 3), {"border_type": "constant"}, "constant"),
    ("convolve3d", (3, 3, 1), {"border_type": "reflect"}, "mirror"),
):
    add(
        Spec(
            f"filters.{_name}",
            [VOLUME, _kernel(*_shape)],
            [TensorSpec("output", layout="NCDHW")],
            config=_config,
            symbols=DEEP,
            gradient_tolerances=SUMMED,
            peer=Peer(
                "scipy.ndimage",
                lambda ndimage, x, kernel, mode=_mode, turned=_name == "convolve3d": (
                    ndimage.convolve if turned else ndimage.correlate
                )(x, kernel[None], mode=mode),
                "samples",
            ),
            reference="SciPy ndimage.correlate",
        )
    )

# --- blurs --------------------------------------------------------------------------------------------------

_GAUSSIAN = opencv(
    lambda cv2, x, sigma: cv2.GaussianBlur(
        x, (5, 5), float(sigma[1]), sigmaY=float(sigma[0]), borderType=cv2.BORDER_REFLECT_101
    )
)

add(
    Spec(
        "filters.gaussian_blur2d",
        [
            image(),
            TensorSpec(
                "sigma",
                ("B", 2),
                range=(0.5, 3.0),
                description="standard deviations (y, x) of each image, in pixels",
            ),
        ],
        [TensorSpec("output", layout="NCHW")],
        config={"kernel_size": (5, 5), "border_type": "reflect"},
        symbols=STENCIL,
        peer=_GAUSSIAN,
        also=(
            {"border_type": "replicate"},
            {"border_type": "constant", "separable": False, "kernel_size": (3, 5)},
        ),
        reference="OpenCV GaussianBlur(BORDER_REFLECT_101)",
        frames=Frames(peer=_GAUSSIAN),
        errors=(
            *NOT_SIGMAS,
            *rejected("kernel_size", "odd positive sizes", (4, 4)),
            *rejected_words("border_type"),
        ),
    )
)

# If sigma is a constant, the kernels are constants too, and ONNX Runtime can use its convolution.
add(
    Spec(
        "filters.gaussian_blur2d.constant",
        [image()],
        [TensorSpec("output", layout="NCHW")],
        config={"kernel_size": (5, 5), "sigma": (1.1, 1.1), "border_type": "reflect"},
        symbols=STENCIL,
        peer=opencv(lambda cv2, x: cv2.GaussianBlur(x, (5, 5), 1.1, borderType=cv2.BORDER_REFLECT_101)),
        also=(
            {"border_type": "circular", "sigma": (1.2, 0.8)},
            {"border_type": "constant", "kernel_size": (5, 3)},
        ),
        reference="OpenCV GaussianBlur(BORDER_REFLECT_101)",
        frames=Frames(
            peer=opencv(lambda cv2, x: cv2.GaussianBlur(x, (5, 5), 1.1, borderType=cv2.BORDER_REFLECT_101))
        ),
        errors=NOT_SIGMAS,
    ),
    fn="filters.gaussian_blur2d",
)

add(
    Spec(
        "filters.box_blur",
        [image()],
        SAME,
        config={"kernel_size": (5, 5)},
        symbols=STENCIL,
        peer=opencv(lambda cv2, x: cv2.blur(x, (5, 5), borderType=cv2.BORDER_REFLECT_101)),
        special_values="in running sums an infinity is subtracted from itself",
        reference="OpenCV blur, SciPy uniform_filter",
        frames=Frames(
            reference="OpenCV blur",
            peer=opencv(lambda cv2, x: cv2.blur(x, (5, 5), borderType=cv2.BORDER_REFLECT_101)),
        ),
        errors=rejected_sizes("kernel_size"),
    )
)

add(
    Spec(
        "filters.motion_blur",
        [image(), ANGLE, DIRECTION],
        SAME,
        config={"kernel_size": 5, "border_type": "reflect", "mode": "nearest"},
        symbols=STENCIL,
        gradients=("input", "direction"),
        gradient_tolerances=SUMMED,
        reference="OpenCV filter2D with SciPy's rotated kernel",
    )
)

add(
    Spec(
        "filters.motion_blur3d",
        [VOLUME, TURN, DIRECTION],
        [TensorSpec("output", layout="NCDHW")],
        config={"kernel_size": 3, "border_type": "replicate", "mode": "bilinear"},
        symbols=DEEP,
        gradient_tolerances=SUMMED,
        reference="SciPy ndimage.correlate with its rotated kernel",
    )
)

# --- sharpening, band-pass filters --------------------------------------------------------------------------


def _unsharp(cv2: Any, x: Any):
    blurred = cv2.GaussianBlur(x, (5, 5), 1.5, borderType=cv2.BORDER_REFLECT_101)
    return cv2.addWeighted(x, 2, blurred, -1, 0)


add(
    Spec(
        "filters.unsharp_mask",
        [image()],
        SAME,
        config={"kernel_size": (5, 5), "sigma": (1.5, 1.5)},
        symbols=STENCIL,
        peer=opencv(_unsharp),
        reference="OpenCV GaussianBlur and addWeighted, scikit-image unsharp_mask",
        frames=Frames(reference="OpenCV GaussianBlur and addWeighted", peer=opencv(_unsharp)),
        errors=NOT_SIGMAS,
    )
)

add(
    Spec(
        "filters.difference_of_gaussians",
        [image()],
        SAME,
        config={"low_sigma": 1.0, "truncate": 2.0},
        symbols=STENCIL,
        peer=Peer(
            "skimage.filters",
            lambda filters, x: filters.difference_of_gaussians(x, 1.0, truncate=2.0),
            "planes",
        ),
        reference="scikit-image difference_of_gaussians",
        errors=tuple(
            ErrorInput(s, math.nan, "high_sigma: expected 0 < low_sigma <= high_sigma, got")
            for s in ("low_sigma", "high_sigma")
        ),
    )
)

add(
    Spec(
        "filters.gabor",
        [image(), *WAVE],
        SAME,
        config={"kernel_size": (5, 5)},
        symbols=STENCIL,
        gradient_tolerances=SUMMED,
        peer=opencv(
            lambda cv2, x, sigma, theta, wave: cv2.filter2D(
                x, -1, cv2.getGaborKernel((5, 5), sigma, theta, wave, 0.5, 0.0)
            ),
        ),
        reference="OpenCV filter2D with getGaborKernel",
    )
)

# --- pooling ------------------------------------------------------------------------------------------------


def _blurred(cv2: Any, x: np.ndarray) -> np.ndarray:
    taps = np.array([0.25, 0.5, 0.25], np.float32)
    return cv2.sepFilter2D(x, -1, taps, taps, borderType=cv2.BORDER_CONSTANT)[::2, ::2]


def _blurred_maxima(cv2: Any, x: np.ndarray) -> np.ndarray:
    return _blurred(cv2, cv2.dilate(x, np.ones((2, 2)), anchor=(0, 0))[:-1, :-1])


for _name in ("blur_pool2d", "max_blur_pool2d"):
    add(
        Spec(
            f"filters.{_name}",
            [image()],
            SAME,
            config={"kernel_size": 3, "stride": 2},
            symbols=STENCIL,
            peer=opencv(_blurred if _name == "blur_pool2d" else _blurred_maxima),
            reference="SciPy ndimage",
        )
    )

add(
    Spec(
        "filters.edge_aware_blur_pool2d",
        [image(range=(0.55, 1.0))],  # a range in which random pixels have some edges
        SAME,
        config={"kernel_size": 3},
        symbols=STENCIL,
        reference="NumPy and SciPy ndimage",
        errors=rejected("edge_threshold", "more than 1", math.nan),
    )
)
