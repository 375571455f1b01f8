"""Letterboxes, borders and centre crops with other settings than those of `pipelines`: how a frame fits, its
filter, and the type and layout of what the network gets."""

from dataclasses import replace
from typing import Any

import numpy as np

from ..peer import opencv
from ..spec import ErrorInput, Spec, like
from . import add, rejected, rejected_words
from .geometry_transform import SIZES
from .pipelines import FRAMES, INPUT, STD, TO_FRAME, bordered, fitted

_LEVEL = 1.001 / 255
_PIXELS = replace(INPUT, layout="NHWC", description="input of a network: levels, not normalised")


def _planes(image: Any, dtype: type = np.float32) -> Any:
    """RGB in [0, 1] of BGR of 8 or 16 bits."""
    return (image[..., ::-1].transpose(2, 0, 1) * np.float32(1 / np.iinfo(image.dtype).max)).astype(dtype)


def _stretched(cv2: Any, frame: np.ndarray):
    inner = cv2.resize(frame, (640, 640), interpolation=cv2.INTER_LINEAR)
    across, down = frame.shape[1] / 640, frame.shape[0] / 640
    to_frame = np.array([[across, 0, 0], [0, down, 0], [0, 0, 1]], np.float32)
    return cv2.dnn.blobFromImage(inner, 1 / 255, swapRB=True)[0], to_frame


def _rgb(cv2: Any, frame: np.ndarray):
    whole, to_frame = fitted(cv2, frame)
    return cv2.cvtColor(whole, cv2.COLOR_BGR2RGB), to_frame


def _words(cv2: Any, frame: np.ndarray):
    whole, to_frame = fitted(cv2, frame)
    return _planes(whole), to_frame


def _half(cv2: Any, frame: np.ndarray):
    whole, to_frame = fitted(cv2, frame)
    return _planes(whole, np.float16), to_frame


def _of_size(cv2: Any, frame: np.ndarray, size: np.ndarray):
    whole, to_frame = fitted(cv2, frame, size.shape)
    return cv2.dnn.blobFromImage(whole, 1 / 255, swapRB=True)[0], to_frame


def _padded(cv2: Any, frame: np.ndarray):
    below, beside = -frame.shape[0] % 32, -frame.shape[1] % 32
    edges = below // 2, below - below // 2, beside // 2, beside - beside // 2
    whole = cv2.copyMakeBorder(frame, *edges, cv2.BORDER_CONSTANT, value=(114, 114, 114))
    to_frame = np.array([[1, 0, -edges[2]], [0, 1, -edges[0]], [0, 0, 1]], np.float32)
    return cv2.dnn.blobFromImage(whole, 1 / 255, swapRB=True)[0], to_frame


add(
    Spec(
        "pipelines.letterbox.stretch",
        [FRAMES],
        [INPUT, TO_FRAME],
        config={"fit": "stretch"},
        also=({"layout": "NHWC"},),
        peer=opencv(_stretched, "samples", atol=_LEVEL),
        reference="OpenCV resize, blobFromImage",
        errors=rejected_words("fit", "interpolation", "dtype", "layout"),
    ),
    "pipelines.letterbox",
)
add(
    Spec(
        "pipelines.letterbox.antialias",
        [FRAMES],
        [INPUT, TO_FRAME],
        config={"antialias": True},
        also=({"antialias": False, "interpolation": "area"}, {"interpolation": "bicubic", "fit": "stretch"}),
        reference="Pillow resize, NumPy slices",
    ),
    "pipelines.letterbox",
)
add(
    Spec(
        "pipelines.letterbox.uint8_nhwc",
        [FRAMES],
        [_PIXELS, TO_FRAME],
        config={"dtype": "uint8", "layout": "NHWC"},
        also=({"layout": "NCHW"},),
        peer=opencv(_rgb, "samples", atol=1),
        reference="OpenCV resize, copyMakeBorder, cvtColor",
        errors=(
            ErrorInput(
                "mean", (0.5, 0.5, 0.5), "mean: expected zeros for dtype 'uint8', got (0.5, 0.5, 0.5)"
            ),
            ErrorInput("std", (2.0, 1.0, 1.0), "std: expected ones for dtype 'uint8', got (2.0, 1.0, 1.0)"),
        ),
    ),
    "pipelines.letterbox",
)
add(
    Spec(
        "pipelines.letterbox.float16",
        [FRAMES],
        [INPUT, TO_FRAME],
        config={"dtype": "float16"},
        also=({"layout": "NHWC"},),
        peer=opencv(_half, "samples", atol=_LEVEL + 5e-4),
        reference="OpenCV resize, copyMakeBorder, and NumPy's float16",
    ),
    "pipelines.letterbox",
)
add(
    Spec(
        "pipelines.letterbox.uint16",
        [replace(FRAMES, dtype="uint16", range=(0, 65535))],
        [INPUT, TO_FRAME],
        peer=opencv(_words, "samples", atol=2e-5),
        reference="OpenCV resize, copyMakeBorder",
        errors=(
            ErrorInput(
                "dtype",
                "uint8",
                "dtype: expected 'float32' or 'float16' for a frame of torch.uint16, got 'uint8'",
            ),
        ),
    ),
    "pipelines.letterbox",
)
add(
    Spec(
        "pipelines.letterbox.like",
        [FRAMES, like("size")],
        [INPUT, TO_FRAME],
        symbols=SIZES,
        peer=opencv(_of_size, "samples", atol=_LEVEL),
        reference="OpenCV resize, copyMakeBorder",
    ),
    "pipelines.letterbox",
)


def _longest(cv2: Any, frame: np.ndarray):
    height, width = frame.shape[:2]
    ratio = 640 / max(height, width)
    size = tuple(-(-max(round(side * ratio), 1) // 32) * 32 for side in (height, width))
    whole, to_frame = bordered(cv2, frame, size, ratio)
    return cv2.dnn.blobFromImage(whole, 1 / 255, swapRB=True)[0], to_frame


add(
    Spec(
        "pipelines.letterbox_longest",
        [FRAMES],
        [INPUT, TO_FRAME],
        also=({"antialias": True, "longest": 300, "multiple": 64},),
        peer=opencv(_longest, "samples", atol=_LEVEL),
        reference="OpenCV resize, copyMakeBorder, blobFromImage",
        errors=(
            *STD,
            *rejected("longest", "a positive whole number", 0, 1.5),
            *rejected("multiple", "a positive even number", 0, 3, 2.5),
            *rejected_words("anchor", "interpolation", "dtype", "layout"),
        ),
    )
)
add(
    Spec(
        "pipelines.pad_to_multiple",
        [FRAMES],
        [INPUT, TO_FRAME],
        peer=opencv(_padded, "samples"),
        reference="OpenCV copyMakeBorder, blobFromImage",
        errors=(*STD, *rejected("multiple", "a positive whole number", 0, 1.5), *rejected_words("anchor")),
    )
)
add(
    Spec(
        "pipelines.center_crop.antialias",
        [FRAMES],
        [INPUT, TO_FRAME],
        config={"antialias": True},
        reference="torchvision Resize and CenterCrop of Pillow's images",
    ),
    "pipelines.center_crop",
)
