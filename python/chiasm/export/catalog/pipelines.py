"""Pipelines: several ops in one bundle, from camera frame to result."""

import math
from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import opencv
from ..spec import ErrorInput, Spec, TensorSpec, Tolerance, frame
from . import STENCIL, add, rejected, rejected_sizes
from .color_camera import in_one_buffer
from .feature_detection import blobs

STD = rejected("std", "numbers above 0", (math.nan, 1.0, 1.0))

#: ImageNet's, red, green, blue
_MEAN_LEVELS = tuple(255 * m for m in (0.485, 0.456, 0.406))
_DEVIATIONS = np.array([0.229, 0.224, 0.225], np.float32)[:, None, None]


def _edges(cv2: Any, frame: np.ndarray) -> np.ndarray:
    grey = cv2.cvtColor(frame.astype(np.float32), cv2.COLOR_BGR2GRAY)
    blurred = cv2.GaussianBlur(grey, (5, 5), 1.0, borderType=cv2.BORDER_REFLECT_101)
    dx, dy = (cv2.Sobel(blurred, cv2.CV_32F, i, 1 - i, borderType=cv2.BORDER_REPLICATE) for i in (1, 0))
    return cv2.convertScaleAbs(cv2.magnitude(dx, dy))


add(
    Spec(
        "pipelines.preprocess",
        [frame()],
        [
            TensorSpec(
                "output",
                layout="NCHW",
                color="RGB",
                description="224 x 224, normalised by ImageNet's mean and standard deviation",
            )
        ],
        symbols=STENCIL,
        peer=opencv(
            lambda cv2, x: (
                cv2.dnn.blobFromImage(
                    cv2.resize(x.astype(np.float32), (224, 224)), 1 / 255, mean=_MEAN_LEVELS, swapRB=True
                )
                / _DEVIATIONS
            ),
            "batch",
        ),
        reference="OpenCV resize and blobFromImage",
        errors=STD,
    )
)

add(
    Spec(
        "pipelines.edges",
        [frame()],
        [
            TensorSpec(
                "output",
                layout="HW",
                color="GRAY",
                range=(0, 255),
                description="Sobel magnitude of the blurred grey image",
            )
        ],
        symbols=STENCIL,
        tolerances={
            "uint8": Tolerance(1, 0)
        },  # a float result halfway between two integers may round either way
        peer=opencv(_edges, "batch"),
        reference="OpenCV cvtColor, GaussianBlur, Sobel, magnitude",
    )
)


FRAMES = TensorSpec("frame", ("B", "H", "W", 3), "uint8", "NHWC", "BGR", (0, 255), "frames")
INPUT = TensorSpec("output", layout="NCHW", color="RGB", description="input of a network")
TO_FRAME = TensorSpec("to_frame", description="from coordinates in the output to those in the frame")


def fitted(cv2: Any, frame: np.ndarray, size: tuple[int, ...] = (640, 640)):
    """The method of YOLO's authors, up to the conversion to planes, and the transform back. chiasm uses
    INTER_LINEAR_EXACT and may differ by a level."""
    return bordered(cv2, frame, size, min(size[0] / frame.shape[0], size[1] / frame.shape[1]))


def bordered(cv2: Any, frame: np.ndarray, size: tuple[int, ...], ratio: float):
    """``fitted``, with a ratio of its own."""
    height, width = frame.shape[:2]
    new_width, new_height = max(round(width * ratio), 1), max(round(height * ratio), 1)
    left, top = (size[1] - new_width) // 2, (size[0] - new_height) // 2
    inner = cv2.resize(frame, (new_width, new_height), interpolation=cv2.INTER_LINEAR)
    below, beside = size[0] - new_height - top, size[1] - new_width - left
    grey = (114 if frame.dtype == np.uint8 else 114 * 257,) * 3
    whole = cv2.copyMakeBorder(inner, top, below, left, beside, cv2.BORDER_CONSTANT, value=grey)
    across, down = width / new_width, height / new_height
    to_frame = np.array([[across, 0, -left * across], [0, down, -top * down], [0, 0, 1]], np.float32)
    return whole, to_frame


def _opencv_letterbox(cv2: Any, frame: Any):
    whole, to_frame = fitted(cv2, frame)
    return cv2.dnn.blobFromImage(whole, 1 / 255, swapRB=True)[0], to_frame


add(
    Spec(
        "pipelines.letterbox",
        [FRAMES],
        [INPUT, TO_FRAME],
        peer=opencv(_opencv_letterbox, "samples", atol=1.001 / 255),
        reference="OpenCV resize, copyMakeBorder, blobFromImage",
        errors=(
            *rejected_sizes("size"),
            *STD,
            ErrorInput("size", (5,), "size: expected 2 numbers, got 1"),
            ErrorInput("mean", (0.0,), "mean: expected 3 numbers, got 1"),
            *rejected("value", "a whole number from 0 to 255", 1.5),
        ),
    )
)


def _opencv_letterbox_of(code: str):
    return opencv(
        lambda cv2, frame: _opencv_letterbox(cv2, cv2.cvtColor(frame, getattr(cv2, code))),
        "samples",
        atol=1.001 / 255,
    )


for _name, _channels, _code in (("rgba", 4, "COLOR_RGBA2BGR"), ("gray", 1, "COLOR_GRAY2BGR")):
    add(
        Spec(
            f"pipelines.letterbox.{_name}",
            [
                TensorSpec(
                    "frame", ("B", "H", "W", _channels), "uint8", "NHWC", _name.upper(), (0, 255), "frames"
                )
            ],
            [INPUT, TO_FRAME],
            config={"color": _name},
            peer=_opencv_letterbox_of(_code),
            reference="OpenCV cvtColor, resize, copyMakeBorder, blobFromImage",
        ),
        "pipelines.letterbox",
    )


def _luma(name: str = "y", channels: int = 1, sizes: tuple[str, ...] = ("H", "W"), description: str = "luma"):
    return TensorSpec(name, ("B", *sizes, channels), "uint8", "NHWC", "", (0, 255), description)


def _chroma(name: str, channels: int):
    return _luma(name, channels, ("UH", "UW"), f"chroma {name.upper()} around 128, of any resolution")


def _opencv_camera_letterbox(code: str):
    """Conversion of the parts of one frame, then `_opencv_letterbox`."""

    def call(cv2: Any, y: Any, *pairs: Any):
        frame = (
            cv2.cvtColorTwoPlane(y, *pairs, getattr(cv2, code))
            if pairs
            else cv2.cvtColor(y.reshape(y.shape[0], -1, 2), getattr(cv2, code))
        )
        return _opencv_letterbox(cv2, frame)

    return opencv(call, "samples", atol=1.001 / 255, sizes={"H": 120, "W": 160, "UH": 60, "UW": 80})


_I420 = opencv(
    lambda cv2, whole: _opencv_letterbox(cv2, cv2.cvtColor(whole, cv2.COLOR_YUV2BGR_I420)),
    "samples",
    before=lambda y, u, v: (in_one_buffer(y, u, v),),
    atol=1.001 / 255,
    sizes={"H": 120, "W": 160, "UH": 60, "UW": 80},
)
for _name, _parts, _peer in (
    ("nv12", [_luma(), _chroma("uv", 2)], _opencv_camera_letterbox("COLOR_YUV2BGR_NV12")),
    ("nv21", [_luma(), _chroma("vu", 2)], _opencv_camera_letterbox("COLOR_YUV2BGR_NV21")),
    ("i420", [_luma(), _chroma("u", 1), _chroma("v", 1)], _I420),
    (
        "yuyv",
        [_luma("frame", 4, ("H", "W"), "pairs of pixels: luma, U, luma, V")],
        _opencv_camera_letterbox("COLOR_YUV2BGR_YUYV"),
    ),
):
    add(
        Spec(
            f"pipelines.letterbox_{_name}",
            _parts,
            [INPUT, TO_FRAME],
            symbols={} if _name == "yuyv" else {"UH": (1, 32768), "UW": (1, 32768)},
            peer=_peer,
            reference="OpenCV cvtColor, resize, copyMakeBorder, blobFromImage",
        )
    )
add(
    Spec(
        "pipelines.center_crop",
        [FRAMES],
        [INPUT, TO_FRAME],
        reference="OpenCV resize and slices",
        errors=(
            *rejected_sizes("size"),
            ErrorInput("size", 640, "size: expected 2 numbers, got int", TypeError),
        ),
    )
)


def _make_boxes(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Boxes, some of which extend beyond the frame."""
    height, width = sizes["H"], sizes["W"]
    corners = torch.rand((sizes["N"], 2, 2), generator=generator) * 1.2 - 0.1
    boxes = torch.cat([corners.amin(1), corners.amax(1)], 1) * torch.tensor([width, height, width, height])
    frame = torch.randint(0, 256, (height, width, 3), generator=generator)
    return {"frame": frame.to(torch.uint8), "boxes": boxes.to(torch.float32)}


add(
    Spec(
        "pipelines.crop_boxes",
        [frame(), TensorSpec("boxes", ("N", 4), "float32", description="x1, y1, x2, y2 in pixels")],
        [INPUT],
        config={"size": (64, 48)},
        symbols={"N": (1, 1 << 16)},
        gradients=(),
        make_inputs=_make_boxes,
        reference="OpenCV resize of slices",
        errors=(
            *rejected_sizes("size"),
            ErrorInput("std", 0.5, "std: expected 3 numbers, got float", TypeError),
        ),
    )
)


def _make_views(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    first, second = blobs(
        generator, sizes["B"], [(sizes["H"], sizes["W"], 0), (sizes["OH"], sizes["OW"], 5)], dtype
    )
    return {
        "image1": first,
        "image2": second,
        "uniforms": torch.rand((sizes["B"], sizes["S"], 4), generator=generator).to(dtype),
    }


add(
    Spec(
        "pipelines.two_view_homography",
        [
            TensorSpec("image1", ("B", 1, "H", "W"), layout="NCHW", color="GRAY", range=(0.0, 1.0)),
            TensorSpec("image2", ("B", 1, "OH", "OW"), layout="NCHW", color="GRAY", range=(0.0, 1.0)),
            TensorSpec(
                "uniforms",
                ("B", "S", 4),
                range=(0.0, 1.0),
                description="random numbers, uniform in [0, 1), of which samples are made",
            ),
        ],
        [
            TensorSpec("homography", description="from image1 to image2"),
            TensorSpec("points1", description="key points of image1 that are matched, zeros for the others"),
            TensorSpec("points2", description="their matches in image2"),
            TensorSpec("matched", description="which of the slots hold a match"),
            TensorSpec("inliers", description="which matches obey the homography"),
        ],
        config={"max_keypoints": 500, "num_octaves": 2, "mr_size": 3.0, "double_image": True},
        symbols={"H": (54, 32768), "W": (58, 32768), "OH": (54, 32768), "OW": (58, 32768), "S": (1, 1 << 16)},
        gradients=(),
        # points, in pixels; see the detector and the estimator
        tolerances={"float32": Tolerance(2e-2, 1e-3)},
        make_inputs=_make_views,
        reference="OpenCV SIFT, BFMatcher, findHomography",
        special_values="beside a row of infinities responses are infinite or NaN by the order of their sums",
        picture="registered views",
    )
)
