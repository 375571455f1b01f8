"""Features: key points in scale space."""

import math
from collections.abc import Sequence
from typing import Any

import torch
from torch import Generator, Tensor

from ..spec import Spec, TensorSpec, Tolerance, image
from . import add, rejected


def blobs(
    generator: Generator, batch: int, views: Sequence[tuple[int, int, int]], dtype: torch.dtype
) -> list[Tensor]:
    """Pictures (B, 1, H, W) of the same 40 blobs, with some noise: clear extrema at many scales. ``views``
    has the height and width of each picture, and its offset to the right of the first."""
    height, width, _ = views[0]
    draw = torch.rand((batch, 40, 4, 1, 1), generator=generator, dtype=torch.float64)
    radius = 1.5 + 6.0 * draw[:, :, 2] ** 2
    made: list[Tensor] = []
    for rows, columns, shift in views:
        x = torch.arange(columns, dtype=torch.float64) + shift - draw[:, :, 0] * width
        y = torch.arange(rows, dtype=torch.float64)[:, None] - draw[:, :, 1] * height
        hills = ((2.0 * draw[:, :, 3] - 1.0) * torch.exp(-(x * x + y * y) / (2.0 * radius * radius))).sum(
            1, keepdim=True
        )
        noise = torch.rand((batch, 1, rows, columns), generator=generator, dtype=torch.float64)
        made.append((0.5 + 0.4 * hills + 0.02 * noise).to(dtype))
    return made


def _make_blobs(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    return {"img": blobs(generator, sizes["B"], [(sizes["H"], sizes["W"], 0)], dtype)[0]}


for _response, _threshold, _reference in (
    ("harris", 1e-7, "a loop in NumPy"),
    ("gftt", 1e-4, "a loop in NumPy"),
    ("hessian", 1e-4, "a loop in NumPy; blobs that are known"),
    ("dog", 1e-4, "a loop in NumPy; blobs that are known; OpenCV SIFT"),
):
    add(
        Spec(
            f"feature.detect_keypoints.{_response}",
            [image("img", channels=1, color="GRAY")],
            [
                TensorSpec("lafs", description="upright disks, zeros where not valid"),
                TensorSpec("scores", description="response, sorted, 0 where not valid"),
                TensorSpec("valid", description="which of the slots hold a key point"),
            ],
            config={
                "max_keypoints": 32,
                "response": _response,
                "num_octaves": 2,
                "mr_size": 3.0,
                "threshold": _threshold,
            },
            # In the last octave, the widest Gaussian, of 27 taps, must fit twice. The exporter can prove that
            # halved sizes are more than 1 if the limits are 2 more than a multiple of the last octave's
            # pixel.
            symbols={"H": (54, 32768), "W": (58, 32768)},
            gradients=() if _response in ("harris", "gftt") else None,
            # if a quadratic is nearly flat, small changes of the image move its extremum far
            tolerances={"float32": Tolerance(5e-3, 1e-3)},
            make_inputs=_make_blobs,
            reference=_reference,
            picture="detected keypoints",
            errors=rejected("init_sigma", "more than 0.5", math.nan),
        ),
        fn="feature.detect_keypoints",
    )

_PROPOSALS = [
    TensorSpec("coordinates", description="x and y in pixels"),
    TensorSpec("scores", description="the largest response of each window"),
]
#: Symbols: more than one window along each axis, because an export would make a single one a constant.
_PEAKS: dict[str, Any] = {
    "reference": "a loop in NumPy",
    "tolerances": {"float32": Tolerance(2e-4, 1e-4)},
    "picture": "proposed keypoints",
    "special_values": "ONNX Runtime passes NaN over in maxima, and differences of infinities are NaN",
}
add(
    Spec(
        "feature.index_proposal",
        [image("response", channels=1)],
        _PROPOSALS,
        config={"window": 8, "base": 1e3},
        symbols={"H": (9, 32768), "W": (9, 32768)},
        **_PEAKS,
    )
)
add(
    Spec(
        "feature.multi_scale_index_proposal",
        [image("response", channels=1)],
        [*_PROPOSALS, TensorSpec("size", description="which of the windows' sizes")],
        config={"base": 1e3},
        symbols={"H": (41, 32768), "W": (41, 32768)},
        **_PEAKS,
    )
)
