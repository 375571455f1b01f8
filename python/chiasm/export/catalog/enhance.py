"""Intensity changes."""

import math
from typing import Any

import numpy as np
import torch
from PIL import Image
from torch import Generator, Tensor

from ..peer import Call, Peer, opencv
from ..spec import PIXELS, ErrorInput, Frames, Spec, TensorSpec, Tolerance, image
from . import STENCIL, add, rejected

OUTPUT = [TensorSpec("output", layout="NCHW")]

#: The gradient of a number that all pixels share is a sum over them, whose order each backend chooses.
SUMS = {"float32": Tolerance(1e-3, 1e-4)}


def _curve(values: Call, **options: Any) -> Peer:
    """OpenCV's LUT of the values of the 256 levels, for a sample's numbers."""

    def call(cv2: Any, x: Any, *numbers: Any):
        levels = values(np.arange(256.0), *numbers)
        return cv2.LUT(x, np.rint(levels.clip(0, 255)).astype(np.uint8))

    return opencv(call, **options)


def _solarized(x: np.ndarray, threshold: float, addition: float) -> np.ndarray:
    moved = (x + addition).clip(0, 255)
    return np.where(moved < threshold, moved, 255 - moved)


def of_levels(call: Call, **options: Any) -> Peer:
    """Pillow's op on each plane as bytes, the levels of numbers in [0, 1]."""

    def before(x: np.ndarray, *numbers: Any) -> tuple[Any, ...]:
        return (Image.fromarray(np.floor(255 * x + 0.5).astype(np.uint8)), *numbers)

    def after(made: Any) -> np.ndarray:
        return np.asarray(made) / 255

    return Peer("PIL.ImageOps", call, "planes", before=before, after=after, **options)


def _with_grey(cv2: Any, x: Any, factor: Any):
    grey = cv2.cvtColor(cv2.cvtColor(x, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB)
    return _clipped(cv2, cv2.addWeighted(x, factor, grey, 1 - factor, 0))


def _with_mean(cv2: Any, x: Any, factor: Any):
    mean = cv2.mean(cv2.cvtColor(x, cv2.COLOR_RGB2GRAY))[0]
    return _clipped(cv2, cv2.addWeighted(x, factor, x, 0, mean * (1 - factor)))


def _clipped(cv2: Any, x: Any):
    flat = x.reshape(len(x), -1)
    return cv2.min(cv2.max(flat, 0.0), 1.0).reshape(x.shape)


def _sharpened(cv2: Any, x: Any, factor: Any):
    smooth = cv2.filter2D(x, -1, np.array([[1, 1, 1], [1, 5, 1], [1, 1, 1]], np.float32) / 13)
    return _clipped(cv2, cv2.addWeighted(x, factor, smooth, 1 - factor, 0))


def _turned(cv2: Any, x: Any, angle: Any):
    hsv = cv2.cvtColor(x, cv2.COLOR_RGB2HSV)
    hsv[..., 0] = np.mod(hsv[..., 0] + math.degrees(angle), 360)
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)


def _saturated(cv2: Any, x: Any, factor: Any):
    hsv = cv2.cvtColor(x, cv2.COLOR_RGB2HSV)
    hsv[..., 1] = (hsv[..., 1] * factor).clip(0, 1)
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)


def _factor(name: str, low: float, high: float, description: str) -> TensorSpec:
    return TensorSpec(name, ("B",), range=(low, high), description=f"{description}, of each image")


# --- normalisation ------------------------------------------------------------------------------------------

_MEAN = TensorSpec("mean", ("C",), description="one value a channel")
_STD = TensorSpec("std", ("C",), range=(0.2, 1.0), description="one value a channel, not zero")

add(
    Spec(
        "enhance.normalize",
        [image("data"), _MEAN, _STD],
        OUTPUT,
        gradient_tolerances=SUMS,
        peer=opencv(
            lambda cv2, x, mean, std: cv2.divide(cv2.subtract(x, mean), std),
            before=lambda x, mean, std: (x, (*map(float, mean), 0.0), (*map(float, std), 1.0)),
            sizes={"C": 3},
        ),
        reference="(data - mean) / std in NumPy float64",
    )
)

add(
    Spec(
        "enhance.denormalize",
        [image("data"), _MEAN, _STD],
        OUTPUT,
        gradient_tolerances=SUMS,
        peer=Peer("numpy", lambda np, x, mean, std: x * std[:, None, None] + mean[:, None, None], "batch"),
        reference="data * std + mean in NumPy float64",
    )
)

add(
    Spec(
        "enhance.normalize_min_max",
        [image()],
        OUTPUT,
        config={"min_val": -1.0, "max_val": 2.0, "eps": 1e-6},
        # one pixel's gradient is a sum over its channel
        gradient_tolerances=SUMS,
        peer=opencv(lambda cv2, x: cv2.normalize(x, None, -1.0, 2.0, cv2.NORM_MINMAX), "planes", atol=1e-4),
        reference="the formula in NumPy float64; OpenCV normalize(NORM_MINMAX)",
    )
)

# --- sums and differences -----------------------------------------------------------------------------------


def _weighted(cv2: Any, first: Any, alpha: Any, second: Any, beta: Any, gamma: Any):
    return cv2.addWeighted(first, alpha, second, beta, gamma)


add(
    Spec(
        "enhance.add_weighted",
        [
            image("src1"),
            _factor("alpha", -1.0, 1.0, "weight of src1"),
            image("src2"),
            _factor("beta", -1.0, 1.0, "weight of src2"),
            _factor("gamma", -1.0, 1.0, "what is added"),
        ],
        OUTPUT,
        gradient_tolerances=SUMS,
        peer=opencv(_weighted),
        reference="OpenCV addWeighted",
        frames=Frames(
            ranges={"gamma": (-50.0, 50.0)},
            peer=opencv(
                lambda cv2, a, alpha, b, beta, gamma: cv2.addWeighted(a, alpha, b, beta, gamma), atol=1
            ),
        ),
    )
)

add(
    Spec(
        "enhance.invert",
        [image("image"), _factor("max_val", 0.5, 1.5, "the value of white")],
        OUTPUT,
        gradient_tolerances=SUMS,
        peer=opencv(lambda cv2, x, white: cv2.subtract(white, x), "planes"),
        reference="Pillow ImageOps.invert",
        frames=Frames(ranges={"max_val": None}, peer=opencv(lambda cv2, x: cv2.bitwise_not(x))),
    )
)

add(
    Spec(
        "enhance.shift_rgb",
        [
            image("image", channels=3, color="RGB"),
            *(_factor(f"{c}_shift", -0.5, 0.5, "what is added") for c in "rgb"),
        ],
        [TensorSpec("output", layout="NCHW", color="RGB")],
        gradient_tolerances=SUMS,
        peer=opencv(
            lambda cv2, x, r, g, b: _clipped(cv2, cv2.add(x, (r, g, b, 0.0))),
        ),
        reference="OpenCV add",
    )
)

_INTEGRAL = opencv(
    lambda cv2, x: cv2.integral(x, sdepth=cv2.CV_32F),
    "planes",
    after=lambda s: s[1:, 1:],
    rtol=1e-4,
    atol=1e-3,
)

_INTEGRAL_OF_FRAMES = Frames(
    reference="OpenCV integral",
    peer=opencv(lambda cv2, x: cv2.integral(x), "planes", after=lambda s: s[1:, 1:]),
)

# along the channels and the rows
_SUMS = Peer("numpy", lambda np, x: np.cumsum(np.cumsum(x, 1), 3), "batch", atol=1e-3, rtol=1e-4)

for _name in ("integral_image", "integral_tensor"):
    add(
        Spec(
            f"enhance.{_name}",
            [image("image" if _name == "integral_image" else "input")],
            OUTPUT,
            config={} if _name == "integral_image" else {"dim": [1, -1]},
            # sums of up to all pixels, in another order
            tolerances={"float32": Tolerance(1e-3, 1e-4)},
            peer=_INTEGRAL if _name == "integral_image" else _SUMS,
            reference="OpenCV integral; NumPy cumsum",
            frames=_INTEGRAL_OF_FRAMES if _name == "integral_image" else None,
        )
    )

# --- brightness, contrast, saturation, curves ---------------------------------------------------------------

_CLIPPED_SUM = opencv(lambda cv2, x, factor: cv2.min(cv2.max(cv2.add(x, factor), 0.0), 1.0), "planes")
_CLIPPED_PRODUCT = opencv(lambda cv2, x, factor: cv2.min(cv2.multiply(x, factor), 1.0), "planes")

_CONTRAST = (
    *rejected("factor", "a number that is not negative", -0.5, math.nan),
    ErrorInput("factor", [0.5], "factor: expected a number or a tensor, got list", TypeError),
)

for _name, _low, _high, _unit, _peer, _frames_peer in (
    ("adjust_brightness", -0.3, 0.3, 255, _CLIPPED_SUM, _curve(lambda x, factor: x + factor)),
    ("adjust_brightness_accumulative", 0.5, 1.5, 1, _CLIPPED_PRODUCT, _curve(lambda x, factor: x * factor)),
    ("adjust_contrast", 0.5, 1.5, 1, _CLIPPED_PRODUCT, _curve(lambda x, factor: x * factor)),
):
    add(
        Spec(
            f"enhance.{_name}",
            [image("image"), _factor("factor", _low, _high, "strength")],
            OUTPUT,
            config={"clip_output": True},
            gradient_tolerances=SUMS,
            reference="Pillow ImageEnhance.Brightness; the formula in NumPy float64",
            peer=_peer,
            frames=Frames(ranges={"factor": (_low * _unit, _high * _unit)}, peer=_frames_peer),
            errors=_CONTRAST if _name == "adjust_contrast" else (),
        )
    )

for _name, _enhancer in (
    ("adjust_contrast_with_mean_subtraction", "Contrast"),
    ("adjust_saturation_with_gray_subtraction", "Color"),
):
    add(
        Spec(
            f"enhance.{_name}",
            [image("image", channels=3, color="RGB"), _factor("factor", 0.5, 1.5, "strength")],
            [TensorSpec("output", layout="NCHW", color="RGB")],
            gradient_tolerances=SUMS,
            peer=opencv(_with_mean if _enhancer == "Contrast" else _with_grey),
            reference=f"Pillow ImageEnhance.{_enhancer}",
        )
    )

for _name, _low, _high in (("adjust_hue", -3.0, 3.0), ("adjust_saturation", 0.3, 1.7)):
    _what = "angle in radians" if _name == "adjust_hue" else "strength"
    add(
        Spec(
            f"enhance.{_name}",
            [image("image", channels=3, color="RGB"), _factor("factor", _low, _high, _what)],
            [TensorSpec("output", layout="NCHW", color="RGB")],
            # dividing by the chroma of nearly grey pixels amplifies rounding, and the factor's gradient is a
            # sum over all pixels
            tolerances={"float32": Tolerance(1e-4, 1e-4)},
            gradient_tolerances={"float32": Tolerance(5e-3, 1e-3)},
            peer=opencv(_turned if _name == "adjust_hue" else _saturated, atol=1e-3),
            reference="OpenCV cvtColor(COLOR_RGB2HSV) and back",
        )
    )
    add(
        Spec(
            f"enhance.{_name}_raw",
            [image("image", channels=3, color="HSV"), _factor("factor", _low, _high, _what)],
            [TensorSpec("output", layout="NCHW", color="HSV")],
            gradient_tolerances=SUMS,
            reference="the formula in NumPy float64",
        )
    )

add(
    Spec(
        "enhance.adjust_gamma",
        [image(), _factor("gamma", 0.5, 2.0, "exponent"), _factor("gain", 0.8, 1.2, "factor")],
        OUTPUT,
        gradient_tolerances=SUMS,
        peer=opencv(
            lambda cv2, x, gamma, gain: cv2.min(cv2.multiply(cv2.pow(x, gamma), gain), 1.0), "planes"
        ),
        reference="scikit-image adjust_gamma",
        frames=Frames(peer=_curve(lambda x, gamma, gain: 255 * gain * (x / 255) ** gamma, atol=1)),
        errors=(
            *rejected("gamma", "a number that is not negative", -1.0, math.nan),
            *rejected("gain", "a number that is not negative", -1.0, math.nan),
        ),
    )
)

for _inverse in (False, True):
    add(
        Spec(
            "enhance.adjust_log" + ".inverse" * _inverse,
            [image("image")],
            OUTPUT,
            config={"gain": 1.1, "inv": _inverse, "clip_output": True},
            peer=Peer(
                "skimage.exposure",
                lambda exposure, x, inverse=_inverse: exposure.adjust_log(x, 1.1, inverse).clip(0, 1),
                "batch",
            ),
            reference="scikit-image adjust_log",
        ),
        fn="enhance.adjust_log",
    )

add(
    Spec(
        "enhance.adjust_sigmoid",
        [image("image")],
        OUTPUT,
        config={"cutoff": 0.5, "gain": 10.0, "inv": False},
        peer=Peer("skimage.exposure", lambda exposure, x: exposure.adjust_sigmoid(x), "batch"),
        reference="scikit-image adjust_sigmoid",
    )
)

# --- tones --------------------------------------------------------------------------------------------------

_LEVELS = TensorSpec(
    "image", ("B", "C", "H", "W"), "uint8", "NCHW", range=(0, 255), description="image batch"
)
_LUT = opencv(lambda cv2, x, table: cv2.LUT(x, table))

add(
    Spec(
        "enhance.lut",
        [
            _LEVELS,
            TensorSpec("table", (256,), "uint8", range=(0, 255), description="what replaces each byte"),
        ],
        OUTPUT,
        peer=_LUT,
        reference="OpenCV LUT",
        frames=Frames(peer=_LUT),
    )
)

add(
    Spec(
        "enhance.lut.numbers",
        [_LEVELS, TensorSpec("table", ("B", 256), description="what replaces each byte of each image")],
        OUTPUT,
        # an entry's gradient is a sum over the pixels that have it
        gradient_tolerances=SUMS,
        peer=_LUT,
        reference="OpenCV LUT",
    ),
    fn="enhance.lut",
)

add(
    Spec(
        "enhance.posterize",
        [
            image(),
            TensorSpec("bits", ("B",), "int64", range=(0, 8), description="bits to keep of each image"),
        ],
        OUTPUT,
        gradients=(),
        peer=of_levels(lambda ops, x, bits: ops.posterize(x, bits) if bits else x.point([0] * 256)),
        reference="Pillow ImageOps.posterize",
        frames=Frames(peer=_curve(lambda x, bits: x - x % 2.0 ** (8 - bits))),
    )
)

add(
    Spec(
        "enhance.solarize",
        [
            image(),
            _factor("thresholds", 0.3, 0.7, "threshold"),
            _factor("additions", -0.2, 0.2, "what is added first"),
        ],
        OUTPUT,
        gradients=("input", "additions"),
        gradient_tolerances=SUMS,
        peer=Peer(
            "torchvision.transforms.functional",
            lambda functional, x, threshold: functional.solarize(x, threshold),
            "samples",
            before=lambda x, threshold, addition: (torch.as_tensor(x + addition).clamp(0, 1), threshold),
            sizes={"C": 3},
        ),
        reference="Pillow ImageOps.solarize; torchvision solarize",
        frames=Frames(
            ranges={"thresholds": (70.0, 180.0), "additions": (-50.0, 50.0)}, peer=_curve(_solarized)
        ),
    )
)


def _threshold(kind: str, **options: Any) -> Peer:
    code = f"THRESH_{kind.upper()}"
    return opencv(
        lambda cv2, x, limit, value=0.0: cv2.threshold(x, limit, value, getattr(cv2, code))[1], **options
    )


for _type in ("binary", "binary_inv", "trunc", "tozero", "tozero_inv"):
    _binary = _type.startswith("binary")
    add(
        Spec(
            f"enhance.threshold.{_type}",
            [
                image(),
                _factor("thresh", 0.3, 0.7, "threshold"),
                *([_factor("maxval", 0.5, 1.0, "value of what is marked")] if _binary else []),
            ],
            OUTPUT,
            config={"type": _type},
            gradients=("maxval",) if _binary else ("input",),
            gradient_tolerances=SUMS,
            peer=_threshold(_type),
            reference="OpenCV threshold",
            frames=Frames(
                PIXELS,
                ranges={"thresh": (70.0, 180.0), "maxval": (100.0, 255.0)},
                # For bytes, OpenCV rounds the limit down to an integer.
                peer=_threshold(_type, atol=float(_type == "trunc")),
            ),
        ),
        fn="enhance.threshold",
    )

add(
    Spec(
        "enhance.sharpness",
        [image(), _factor("factor", 0.0, 2.0, "strength")],
        OUTPUT,
        symbols=STENCIL,
        gradient_tolerances=SUMS,
        peer=opencv(_sharpened, "planes", edge=1),
        reference="Pillow ImageEnhance.Sharpness",
    )
)

# --- JPEG ---------------------------------------------------------------------------------------------------


def _make_jpeg(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Images of low contrast: fewer coefficients are near the middle between two steps, where rounding
    decides."""
    import torch

    shape = (sizes["B"], 3, sizes["H"], sizes["W"])
    quality = torch.rand(sizes["B"], generator=generator, dtype=torch.float64) * 60 + 30
    return {
        "input": (torch.rand(shape, generator=generator, dtype=torch.float64) * 0.2 + 0.4).to(dtype),
        "jpeg_quality": quality.to(dtype),
    }


add(
    Spec(
        "enhance.jpeg_codec_differentiable",
        [
            image(channels=3, color="RGB"),
            TensorSpec("jpeg_quality", ("B",), range=(30, 90), description="1 to 100, of each image"),
        ],
        [TensorSpec("output", layout="NCHW", color="RGB")],
        symbols={
            "H": (17, 32768),
            "W": (17, 32768),
        },  # more than one block, because a single row of blocks is broadcast differently
        make_inputs=_make_jpeg,
        # steps of up to 100 levels times the cube of a rounding error
        tolerances={"float32": Tolerance(1e-4, 1e-4)},
        gradient_tolerances={"float32": Tolerance(1e-3, 1e-3)},
        reference="the definition with SciPy dctn in float64; Pillow's JPEG",
    )
)
