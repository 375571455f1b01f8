"""Images at the border of a product: bytes in and out, grids, drawing."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import Peer, opencv
from ..spec import InputMaker, Spec, TensorSpec, Tolerance, image
from . import add

add(
    Spec(
        "image.frames_to_tensor",
        [
            TensorSpec(
                "image",
                ("B", "H", "W", "C"),
                "uint8",
                "NHWC",
                range=(0, 255),
                description="image batch, channels last",
            )
        ],
        [TensorSpec("output", layout="NCHW")],
        peer=Peer(
            "torchvision.transforms.functional", lambda functional, x: functional.to_tensor(x), "samples"
        ),
        reference="torchvision to_tensor",
    )
)
add(
    Spec(
        "image.tensor_to_frames",
        [image("tensor")],
        [TensorSpec("output", layout="NHWC", description="bytes")],
        gradients=(),
        peer=opencv(
            lambda cv2, x: cv2.convertScaleAbs(x, alpha=255),
            "samples",
            before=lambda x: (x.transpose(1, 2, 0).copy(),),
            sizes={"C": 3},
        ),
        reference="NumPy rint; OpenCV convertScaleAbs",
    )
)
add(
    Spec(
        "image.make_grid",
        [image("tensor")],
        [TensorSpec("output", layout="CHW", description="one image, two of the batch to a row")],
        config={"n_row": 2, "padding": 2},
        # with a border around the grid, unless there is one image only
        peer=Peer(
            "torchvision.utils",
            lambda utils, x: utils.make_grid(x, nrow=2, padding=2),
            "tensors",
            after=lambda grid: grid[:, 2:-2, 2:-2],
            sizes={"B": 5, "C": 3},
        ),
        reference="NumPy slices",
    )
)

# --- drawing ------------------------------------------------------------------------------------------------

_COLOR = TensorSpec("color", ("C",), range=(0.0, 1.0), description="one value a channel")
# the gradient of a colour is a sum over its pixels, whose order each backend chooses
_SUM = {"float32": Tolerance(1e-3, 1e-4)}


def _places(generator: Generator, shape: Sequence[int], sizes: dict[str, int]):
    """Integer coordinates (x, y) in and slightly around the image: drawing rounds, and halves could round
    either way."""
    span = torch.tensor([sizes["W"] + 6, sizes["H"] + 6], dtype=torch.float64)
    return torch.floor(torch.rand((*shape, 2), generator=generator, dtype=torch.float64) * span) - 3


def _made(names: Sequence[str], coordinates: int = 2) -> InputMaker:
    """Images, colours, and points under the given names."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        b, c, n = sizes["B"], sizes["C"], sizes["N"]
        made: dict[str, Tensor] = {}
        for key in ("image", "images"):
            made[key] = torch.rand(
                (b, c, sizes["H"], sizes["W"]), generator=generator, dtype=torch.float64
            ).to(dtype)
        made["color"] = torch.rand(
            (b, n, c) if coordinates == 4 else (c,), generator=generator, dtype=torch.float64
        ).to(dtype)
        made["colors"] = torch.rand((b, c), generator=generator, dtype=torch.float64).to(dtype)
        for name in names:
            made[name] = torch.cat(
                [_places(generator, (b, n), sizes) for _ in range(coordinates // 2)], -1
            ).to(dtype)
        return made

    return sample


def _drawn(one: Callable[..., Any]) -> Peer:
    """OpenCV's drawing of one thing after the other, into a larger image, because OpenCV cuts lines."""

    def call(cv2: Any, x: np.ndarray, *arguments: Any) -> np.ndarray:
        for each in zip(*arguments, strict=True):
            one(cv2, x, *each)
        return x

    def before(x: np.ndarray, *given: np.ndarray) -> tuple[Any, ...]:
        *places, colors = given
        colors = np.broadcast_to(colors, (len(places[0]), colors.shape[-1]))
        moved = [(p.astype(int) + 8).tolist() for p in places]
        return np.pad(x, ((8, 8), (8, 8), (0, 0))), *moved, colors.tolist()

    return opencv(call, before=before, after=lambda x: x[8:-8, 8:-8], sizes={"C": 3}, timed=False)


def _point(cv2: Any, x: np.ndarray, place: list[int], color: list[float]) -> None:
    cv2.circle(x, place, 0, color, -1)


def _line(cv2: Any, x: np.ndarray, start: list[int], end: list[int], color: list[float]) -> None:
    cv2.line(x, start, end, color)


def _rectangle(cv2: Any, x: np.ndarray, place: list[int], color: list[float]) -> None:
    if place[0] <= place[2] and place[1] <= place[3]:
        cv2.rectangle(x, place[:2], place[2:], color)


_POINTS = ("B", "N", 2)
add(
    Spec(
        "image.draw_point2d",
        [
            image("image"),
            TensorSpec("points", _POINTS, range=(0, 100), description="(x, y) in pixels"),
            _COLOR,
        ],
        [TensorSpec("output", layout="NCHW")],
        gradients=("image", "color"),
        gradient_tolerances=_SUM,
        make_inputs=_made(["points"]),
        peer=_drawn(_point),
        reference="NumPy indexing",
    )
)
add(
    Spec(
        "image.draw_line",
        [
            image("image"),
            TensorSpec("p1", _POINTS, range=(0, 100), description="starts (x, y) in pixels"),
            TensorSpec("p2", _POINTS, range=(0, 100), description="ends (x, y) in pixels"),
            _COLOR,
        ],
        [TensorSpec("output", layout="NCHW")],
        gradients=("image", "color"),
        gradient_tolerances=_SUM,
        make_inputs=_made(["p1", "p2"]),
        peer=_drawn(_line),
        reference="OpenCV line(LINE_8)",
    )
)
add(
    Spec(
        "image.draw_rectangle",
        [
            image("image"),
            TensorSpec("rectangle", ("B", "N", 4), range=(0, 100), description="x1, y1, x2, y2 in pixels"),
            TensorSpec(
                "color", ("B", "N", "C"), range=(0.0, 1.0), description="one value a rectangle and channel"
            ),
        ],
        [TensorSpec("output", layout="NCHW")],
        config={"fill": False, "line_width": 1},
        gradients=("image", "color"),
        gradient_tolerances=_SUM,
        make_inputs=_made(["rectangle"], 4),
        peer=_drawn(_rectangle),
        reference="OpenCV rectangle",
    )
)


def _make_polygon(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Points in order around an ellipse: convex, and no pixel's centre on an edge."""
    made = _made([])(generator, sizes, dtype)
    turn = (
        torch.sort(torch.rand((sizes["B"], sizes["N"]), generator=generator, dtype=torch.float64), 1).values
        * 6.28
    )
    x, y = sizes["W"] * (0.47 + 0.4 * torch.cos(turn)), sizes["H"] * (0.52 + 0.4 * torch.sin(turn))
    return {**made, "polygons": torch.stack([x, y], -1).to(dtype)}


add(
    Spec(
        "image.draw_convex_polygon",
        [
            image("images"),
            TensorSpec("polygons", _POINTS, range=(0, 100), description="vertices (x, y) in pixels"),
            TensorSpec("colors", ("B", "C"), range=(0.0, 1.0), description="one value an image and channel"),
        ],
        [TensorSpec("output", layout="NCHW")],
        symbols={"N": (3, 4096)},
        gradients=("images", "colors"),
        gradient_tolerances=_SUM,
        make_inputs=_make_polygon,
        special_values="ONNX Runtime passes NaN over in minima, which infinite vertices give",
        reference="OpenCV pointPolygonTest",
    )
)
