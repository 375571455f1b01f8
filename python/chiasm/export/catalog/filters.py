"""Filters."""

import math
from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Call, Peer, opencv
from ..spec import ErrorInput, Frames, Spec, TensorSpec, Tolerance, image
from . import STENCIL, add, rejected, rejected_sizes, rejected_words

_NOT_POSITIVE = (0.0, -1.0, math.nan)
_SIGMA = rejected("sigma", "a positive number", *_NOT_POSITIVE)
_SIGMAS = rejected("sigma", "positive numbers", (0.0, 1.0), (1.0, -2.0), (math.nan, 1.0))
_SIGMAS_3D = rejected("sigma", "positive numbers", (1.0, math.nan, 1.0))
_BILATERAL = (
    *rejected("sigma_color", "a positive number", *_NOT_POSITIVE),
    ErrorInput("sigma_color", "1", "sigma_color: expected a number or a tensor, got str", TypeError),
    *rejected("sigma_space", "positive numbers", (math.nan, 1.0)),
)

_GAUSSIAN = opencv(
    lambda cv2, x, sigma: cv2.GaussianBlur(
        x, (5, 5), float(sigma[1]), sigmaY=float(sigma[0]), borderType=cv2.BORDER_REFLECT_101
    )
)


def _correlated(border: str) -> Peer:
    return opencv(lambda cv2, x, kernel: cv2.filter2D(x, -1, kernel, borderType=getattr(cv2, border)))


def _gradient_magnitude(cv2: Any, x: Any):
    dx, dy = (
        cv2.Sobel(x, cv2.CV_32F, d, 1 - d, ksize=3, scale=1 / 8, borderType=cv2.BORDER_REPLICATE)
        for d in (1, 0)
    )
    return cv2.magnitude(dx, dy)


def _derivatives(scale: float, depth: str = "CV_32F"):
    def call(cv2: Any, x: Any):
        return [
            cv2.Sobel(x, getattr(cv2, depth), d, 1 - d, ksize=3, scale=scale, borderType=cv2.BORDER_REPLICATE)
            for d in (1, 0)
        ]

    return call


_EIGHT_NEIGHBOURS = np.array([[1, 1, 1], [1, -8, 1], [1, 1, 1]], np.float32)


def _laplacian(scale: float, depth: str = "CV_32F") -> Call:
    return lambda cv2, x: cv2.filter2D(
        x, getattr(cv2, depth), _EIGHT_NEIGHBOURS * scale, borderType=cv2.BORDER_REFLECT_101
    )


def _unsharp(cv2: Any, x: Any):
    blurred = cv2.GaussianBlur(x, (5, 5), 1.5, borderType=cv2.BORDER_REFLECT_101)
    return cv2.addWeighted(x, 2, blurred, -1, 0)


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
            *_SIGMAS,
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
        errors=_SIGMAS,
    ),
    fn="filters.gaussian_blur2d",
)

_ZERO_TAPS = (
    "ONNX Runtime multiplies by the taps that are 0, which eager code leaves out: NaN of what is not finite"
)
_OWN_WEIGHT = (
    "native code knows a pixel's weight for itself, which eager code computes of the difference of an"
    " infinity with itself"
)

add(
    Spec(
        "filters.sobel",
        [image()],
        [TensorSpec("output", layout="NCHW", description="gradient magnitude")],
        config={"normalized": True, "eps": 1e-6},
        symbols=STENCIL,
        dtypes=("float32", "float64"),
        special_values=_ZERO_TAPS,
        peer=opencv(_gradient_magnitude, "planes", atol=2e-3),
        reference="OpenCV Sobel(BORDER_REPLICATE)",
        frames=Frames(),
    )
)

# --- kernels ------------------------------------------------------------------------------------------------

SIGMA = TensorSpec("sigma", ("B",), range=(0.5, 3.0), description="standard deviations in pixels")
KERNELS = [TensorSpec("kernel", description="one kernel for each entry")]

add(
    Spec(
        "filters.gaussian",
        [SIGMA, TensorSpec("mean", ("B",), range=(1.0, 4.0), description="positions of the maxima")],
        KERNELS,
        config={"window_size": 5},
        reference="SciPy stats.norm.pdf",
        picture="kernels",
        errors=_SIGMA,
    )
)

_TAPS = opencv(lambda cv2, sigma: cv2.getGaussianKernel(5, sigma)[:, 0], "samples")
_TAPS_2D = opencv(
    lambda cv2, sigma: np.outer(cv2.getGaussianKernel(5, sigma[0]), cv2.getGaussianKernel(3, sigma[1])),
    "samples",
)
for _name, _size, _axes, _reference, _peer in (
    ("get_gaussian_kernel1d", 5, 1, "OpenCV getGaussianKernel", _TAPS),
    ("get_gaussian_erf_kernel1d", 5, 1, "SciPy stats.norm.cdf", None),
    ("get_gaussian_discrete_kernel1d", 5, 1, "SciPy special.ive", None),
    ("get_gaussian_kernel2d", (5, 3), 2, "OpenCV getGaussianKernel", _TAPS_2D),
    ("get_gaussian_kernel3d", (3, 5, 3), 3, "OpenCV getGaussianKernel", None),
):
    _sigma = (
        SIGMA
        if _axes == 1
        else TensorSpec(
            "sigma", ("B", _axes), range=(0.5, 3.0), description="standard deviations, the last is x's"
        )
    )
    add(
        Spec(
            f"filters.{_name}",
            [_sigma],
            KERNELS,
            config={"kernel_size": _size},
            peer=_peer,
            reference=_reference,
            errors=_SIGMA if _axes == 1 else _SIGMAS if _axes == 2 else _SIGMAS_3D,
            picture="kernels",
        )
    )

ANGLE = TensorSpec("angle", ("B",), range=(-180.0, 180.0), description="degrees, counterclockwise")
TURN = TensorSpec("angle", ("B", 3), range=(-90.0, 90.0), description="rotation vectors (x, y, z) in degrees")
DIRECTION = TensorSpec(
    "direction", ("B",), range=(-0.9, 0.9), description="-1 to 1: where along the line the weight is"
)

add(
    Spec(
        "filters.get_motion_kernel2d",
        [ANGLE, DIRECTION],
        KERNELS,
        config={"kernel_size": 5, "mode": "bilinear"},
        reference="SciPy affine_transform(order=1)",
        picture="kernels",
    )
)

add(
    Spec(
        "filters.get_motion_kernel3d",
        [TURN, DIRECTION],
        KERNELS,
        config={"kernel_size": 5, "mode": "nearest"},
        gradients=("direction",),
        reference="SciPy affine_transform(order=0)",
        picture="kernels",
    )
)

WAVE = [
    SIGMA,
    TensorSpec("theta", ("B",), range=(-3.0, 3.0), description="directions in radians"),
    TensorSpec("lambd", ("B",), range=(3.0, 8.0), description="wavelengths in pixels"),
]

add(
    Spec(
        "filters.get_gabor_kernel2d",
        [
            *WAVE,
            TensorSpec("gamma", ("B",), range=(0.3, 1.5), description="aspect ratios"),
            TensorSpec("psi", ("B",), range=(-3.0, 3.0), description="phases"),
        ],
        KERNELS,
        config={"kernel_size": (5, 9)},
        reference="OpenCV getGaborKernel",
        picture="kernels",
    )
)

# --- correlation --------------------------------------------------------------------------------------------

SAME = [TensorSpec("output", layout="NCHW")]
DEEP = {**STENCIL, "D": (8, 4096)}
#: The gradient of a kernel, or of its parameters, is a sum over all pixels whose terms cancel, so float32
#: loses digits.
SUMMED = {"float32": Tolerance(1e-3, 1e-3)}
VOLUME = TensorSpec("input", ("B", "C", "D", "H", "W"), "T", "NCDHW", range=(0.0, 1.0), description="volumes")


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
        "filters.laplacian",
        [image()],
        SAME,
        config={"kernel_size": (3, 3)},
        symbols=STENCIL,
        peer=opencv(_laplacian(1 / 16)),
        reference="OpenCV filter2D",
        frames=Frames(config={"normalized": False}, peer=opencv(_laplacian(1, "CV_16S"))),
    )
)

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
        errors=_SIGMAS,
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

add(
    Spec(
        "filters.gabor",
        [image(), *WAVE],
        SAME,
        config={"kernel_size": (5, 5)},
        symbols=STENCIL,
        gradient_tolerances=SUMMED,
        reference="OpenCV filter2D with getGaborKernel",
    )
)

# --- derivatives --------------------------------------------------------------------------------------------

add(
    Spec(
        "filters.spatial_gradient",
        [image()],
        [TensorSpec("output", description="d/dx and d/dy")],
        config={"mode": "sobel", "order": 1, "normalized": True},
        symbols=STENCIL,
        special_values=_ZERO_TAPS,
        peer=opencv(_derivatives(1 / 8), "planes"),
        also=({"mode": "diff", "normalized": False}, {"order": 2}, {"mode": "diff", "order": 2}),
        reference="OpenCV Sobel(BORDER_REPLICATE)",
        frames=Frames(config={"normalized": False}, peer=opencv(_derivatives(1, "CV_16S"), "planes")),
        picture="derivatives",
        errors=(*rejected_words("mode"), *rejected("order", "1 or 2", 3)),
    )
)

add(
    Spec(
        "filters.spatial_gradient3d",
        [VOLUME],
        [TensorSpec("output", description="d/dx, d/dy and d/dz")],
        config={"mode": "diff", "order": 1},
        symbols=DEEP,
        reference="NumPy gradient, SciPy ndimage.correlate",
        picture="derivatives",
    )
)


def _scikit(operator: str, scale: float) -> Peer:
    return Peer(
        "skimage.filters",
        lambda filters, x: getattr(filters, operator)(x),
        "planes",
        edge=1,
        atol=2e-3,
        after=lambda magnitude: magnitude * scale,
    )


for _name, _reference, _peer in (
    # scikit-image takes the mean of the squares of two derivatives, but not of the diagonal ones.
    ("scharr", "OpenCV Scharr, scikit-image scharr", _scikit("scharr", math.sqrt(0.5))),
    ("prewitt", "scikit-image prewitt", _scikit("prewitt", math.sqrt(0.5))),
    ("roberts", "scikit-image roberts", _scikit("roberts", 1.0)),
):
    add(
        Spec(
            f"filters.{_name}",
            [image()],
            [TensorSpec("output", layout="NCHW", description="gradient magnitude")],
            symbols=STENCIL,
            peer=_peer,
            reference=_reference,
        )
    )

# --- pooling ------------------------------------------------------------------------------------------------

for _name in ("blur_pool2d", "max_blur_pool2d"):
    add(
        Spec(
            f"filters.{_name}",
            [image()],
            SAME,
            config={"kernel_size": 3, "stride": 2},
            symbols=STENCIL,
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

# --- thresholds ---------------------------------------------------------------------------------------------

add(
    Spec(
        "filters.in_range",
        [
            image(),
            TensorSpec("lower", ("C",), range=(0.0, 0.3), description="of each channel"),
            TensorSpec("upper", ("C",), range=(0.7, 1.0), description="of each channel"),
        ],
        SAME,
        symbols=STENCIL,
        gradients=("input",),
        reference="OpenCV inRange",
        frames=Frames(
            ranges={"lower": (0.0, 80.0), "upper": (170.0, 255.0)},
            peer=opencv(
                lambda cv2, x, low, high: cv2.copyTo(x, cv2.inRange(x, low, high)),
                before=lambda x, low, high: (x, np.ceil(low), np.floor(high)),
                sizes={"C": 3},
            ),
        ),
    )
)


def _two_classes(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Dark and bright pixels, so that no rounding decides between two thresholds."""
    import torch

    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    noise = torch.rand(shape, generator=generator, dtype=torch.float64)
    bright = torch.rand(shape, generator=generator, dtype=torch.float64) < 0.4
    return {"x": (0.3 * noise + 0.6 * bright).to(dtype)}


for _suffix, _differentiable in (("", False), ("_differentiable", True)):
    add(
        Spec(
            f"filters.otsu_threshold{_suffix}",
            [image("x")],
            [TensorSpec("output", layout="NCHW"), TensorSpec("threshold", description="of each plane")],
            config={"slow_and_differentiable": _differentiable},
            symbols=STENCIL,
            sample=_two_classes,
            reference="scikit-image threshold_otsu, OpenCV THRESH_OTSU",
            frames=None if _differentiable else Frames(reference="OpenCV THRESH_OTSU"),
        ),
        fn="filters.otsu_threshold",
    )


def _levels(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    import torch

    shape = (sizes["B"], sizes["C"], sizes["H"], sizes["W"])
    return {"input": torch.randint(0, 256, shape, generator=generator).to(dtype)}


for _suffix, _method, _kind in (
    ("", "mean", "ADAPTIVE_THRESH_MEAN_C"),
    ("_gaussian", "gaussian", "ADAPTIVE_THRESH_GAUSSIAN_C"),
):
    add(
        Spec(
            f"filters.adaptive_threshold{_suffix}",
            [image(range=(0.0, 255.0))],
            SAME,
            config={"max_value": 255.0, "adaptive_method": _method, "block_size": 5, "c": 2.0},
            symbols=STENCIL,
            gradients=(),
            sample=_levels,
            peer=opencv(
                lambda cv2, x, kind=_kind: cv2.adaptiveThreshold(
                    x, 255, getattr(cv2, kind), cv2.THRESH_BINARY, 5, 2
                ),
                "planes",
                before=lambda x: (x.astype(np.uint8),),
            ),
            reference="OpenCV adaptiveThreshold",
            frames=Frames(errors=rejected("max_value", "a whole number, 0 to 255, for bytes", math.nan)),
        ),
        fn="filters.adaptive_threshold",
    )

# --- not linear ---------------------------------------------------------------------------------------------

add(
    Spec(
        "filters.median_blur",
        [image()],
        [TensorSpec("output", layout="NCHW")],
        config={"kernel_size": (3, 3), "border_type": "reflect"},
        symbols=STENCIL,
        without_nan=True,
        peer=opencv(lambda cv2, x: cv2.medianBlur(x, 3), "planes", edge=1),
        also=(
            {"kernel_size": (5, 5), "border_type": "replicate"},
            {"kernel_size": (3, 5), "border_type": "constant"},
        ),
        reference="SciPy median_filter(mode='mirror')",
        frames=Frames(
            ("uint8", "uint16"), peer=opencv(lambda cv2, x: cv2.medianBlur(x, 3), "planes", edge=1)
        ),
        errors=(*rejected_sizes("kernel_size"), *rejected("kernel_size", "odd positive sizes", (3, 2))),
    )
)

add(
    Spec(
        "filters.bilateral_blur",
        [image()],
        [TensorSpec("output", layout="NCHW")],
        config={
            "kernel_size": (5, 5),
            "sigma_color": 0.1,
            "sigma_space": (1.5, 1.5),
            "border_type": "reflect",
        },
        symbols=STENCIL,
        special_values=_OWN_WEIGHT,
        also=({"kernel_size": (3, 5), "border_type": "replicate", "color_distance_type": "l2"},),
        reference="the definition in NumPy float64, and OpenCV bilateralFilter on one channel",
        frames=Frames(
            config={"sigma_color": 25.0},
            reference="the definition in NumPy float64, and OpenCV bilateralFilter",
        ),
        errors=(*_BILATERAL, *rejected_words("color_distance_type")),
    )
)

add(
    Spec(
        "filters.canny",
        [image(channels=3, color="RGB")],
        [
            TensorSpec(
                "magnitude", layout="NCHW", description="gradient magnitude on the ridges, 0 elsewhere"
            ),
            TensorSpec("edges", layout="NCHW", description="1 on edges, 0 elsewhere"),
        ],
        config={
            "low_threshold": 0.5,
            "high_threshold": 0.9,
            "kernel_size": (5, 5),
            "sigma": (1.0, 1.0),
            "hysteresis": True,
        },
        symbols=STENCIL,
        reference="OpenCV Canny on the same gradients",
        frames=Frames(
            config={"low_threshold": 100.0, "high_threshold": 200.0},
            reference="OpenCV GaussianBlur and Canny",
        ),
        errors=(
            *_SIGMAS,
            *(
                ErrorInput(t, math.nan, "low_threshold: expected 0 <= low_threshold <= high_threshold, got")
                for t in ("low_threshold", "high_threshold")
            ),
        ),
    )
)

add(
    Spec(
        "filters.joint_bilateral_blur",
        [image(), image("guidance", channels=1, color="GRAY")],
        [TensorSpec("output", layout="NCHW")],
        config={
            "kernel_size": (3, 3),
            "sigma_color": 0.1,
            "sigma_space": (1.5, 1.5),
            "border_type": "reflect",
        },
        symbols=STENCIL,
        special_values=_OWN_WEIGHT,
        reference="the definition in NumPy float64",
        frames=Frames(config={"sigma_color": 25.0}, reference="the definition in NumPy float64"),
        errors=_BILATERAL,
    )
)

add(
    Spec(
        "filters.guided_blur",
        [image("guidance", channels=3, color="RGB"), image()],
        [TensorSpec("output", layout="NCHW")],
        config={"kernel_size": (5, 5), "eps": 0.01, "border_type": "reflect"},
        symbols=STENCIL,
        reference="the definition in NumPy float64",
    )
)

add(
    Spec(
        "filters.fast_guided_blur",
        [image("guidance", channels=1, color="GRAY"), image()],
        [TensorSpec("output", layout="NCHW")],
        config={"kernel_size": (5, 5), "eps": 0.01, "border_type": "reflect", "subsample": 2},
        # The small images must also be large enough for stencils.
        symbols={"H": (16, 32768), "W": (16, 32768)},
        reference="the definition in NumPy float64",
    ),
    fn="filters.guided_blur",
)

add(
    Spec(
        "filters.rank_filter",
        [image()],
        [TensorSpec("output", layout="NCHW")],
        config={"rank": 2, "kernel_size": (3, 3), "border_type": "reflect"},
        symbols=STENCIL,
        without_nan=True,
        peer=Peer("scipy.ndimage", lambda ndimage, x: ndimage.rank_filter(x, 2, 3, mode="mirror"), "planes"),
        reference="SciPy rank_filter(mode='mirror')",
    )
)

add(
    Spec(
        "filters.percentile_filter",
        [image()],
        [TensorSpec("output", layout="NCHW")],
        config={"percentile": 80.0, "kernel_size": (3, 3), "border_type": "reflect"},
        symbols=STENCIL,
        without_nan=True,
        peer=Peer(
            "scipy.ndimage", lambda ndimage, x: ndimage.percentile_filter(x, 80, 3, mode="mirror"), "planes"
        ),
        reference="SciPy percentile_filter(mode='mirror')",
        errors=rejected("percentile", "0 to 100", math.nan),
    )
)

add(
    Spec(
        "filters.non_local_means",
        [image()],
        [TensorSpec("output", layout="NCHW")],
        config={"patch_size": 5, "patch_distance": 5, "h": 0.2, "sigma": 0.05, "border_type": "reflect"},
        symbols=STENCIL,
        gradients=(),
        reference="the definition in NumPy float64, OpenCV fastNlMeansDenoising",
        errors=rejected("h", "a positive number", math.nan),
    )
)
