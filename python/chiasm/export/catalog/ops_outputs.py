"""Decoders of networks' outputs: key points, label sequences, tiles of large images, text boxes."""

import torch
from torch import Generator, Tensor

from ..spec import Spec, TensorSpec, Tolerance, image
from . import STENCIL, add
from .ops import clusters

# --- key points ---------------------------------------------------------------------------------------------


def _heatmaps(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """One Gaussian per map, with noise too small to move the maximum."""
    shape = (sizes["B"], sizes["K"])
    height, width = sizes["H"], sizes["W"]

    def profile(length: int):
        centre = 1.5 + (length - 4) * torch.rand(shape, generator=generator, dtype=torch.float64)
        return torch.exp(-((torch.arange(length) - centre[..., None]) ** 2) / 8)

    maps = profile(height)[..., :, None] * profile(width)[..., None, :]
    noise = torch.rand((*shape, height, width), generator=generator, dtype=torch.float64)
    return {"heatmaps": (maps + 1e-3 * noise).to(dtype)}


add(
    Spec(
        "ops.decode_heatmaps",
        [TensorSpec("heatmaps", ("B", "K", "H", "W"), description="one of each key point")],
        [
            TensorSpec("points", description="x and y in pixels of the maps"),
            TensorSpec("scores", description="the largest values"),
        ],
        config={"refinement": "dark"},
        also=({"refinement": "quarter"}, {"refinement": "none"}),
        symbols={"K": (1, 1024)} | STENCIL,
        # a Newton step by differences of logarithms
        tolerances={"float32": Tolerance(1e-3, 1e-5)},
        gradients=(),
        make_inputs=_heatmaps,
        reference="the papers' equations in NumPy loops; the centres of Gaussians",
        picture="tensors",
    )
)
add(
    Spec(
        "ops.decode_simcc",
        [
            TensorSpec("simcc_x", ("B", "K", "W"), description="places from left to right"),
            TensorSpec("simcc_y", ("B", "K", "H"), description="places from top to bottom"),
        ],
        [
            TensorSpec("points", description="x and y in pixels"),
            TensorSpec("scores", description="the lesser of the largest values along x and y"),
        ],
        config={"split_ratio": 2.0},
        symbols={"K": (1, 1024)},
        gradients=(),
        reference="NumPy argmax",
        picture="tensors",
    )
)

# --- label sequences ----------------------------------------------------------------------------------------


def _steps(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Classes that last for some steps, with blanks between."""
    shape = (sizes["B"], sizes["T"], sizes["C"])
    logits = torch.randn(shape, generator=generator, dtype=torch.float64)
    said = torch.randint(0, sizes["C"], shape[:2], generator=generator)
    said = said[:, torch.arange(sizes["T"]) // 3 * 3]
    logits = logits + 4 * torch.nn.functional.one_hot(said, sizes["C"])
    lengths = torch.randint(1, sizes["T"] + 1, shape[:1], generator=generator)
    return {"log_probs": logits.log_softmax(-1).to(dtype), "lengths": lengths}


for _name, _config, _reference in (
    ("greedy", {"blank": 0}, "itertools.groupby of NumPy argmax"),
    ("beam", {"beam": 8, "blank": 0}, "sums over all alignments; torch.nn.functional.ctc_loss"),
):
    add(
        Spec(
            f"ops.ctc_{_name}_decode",
            [
                TensorSpec("log_probs", ("B", "T", "C"), description="logarithms of probabilities"),
                TensorSpec("lengths", ("B",), "int64", description="how many steps count"),
            ],
            [
                TensorSpec("labels", description="blanks after the last"),
                TensorSpec("label_lengths", description="how many labels there are"),
                TensorSpec("scores", description="logarithms of probabilities"),
            ],
            config=_config,
            symbols={"T": (2, 1 << 14), "C": (2, 1 << 16)},
            gradients=(),
            make_inputs=_steps,
            reference=_reference,
            picture="tensors",
        )
    )

# --- tiles of large images ----------------------------------------------------------------------------------

add(
    Spec(
        "ops.tile",
        [image("image")],
        [
            TensorSpec("tiles", description="row after row"),
            TensorSpec("positions", description="x and y of their upper left pixels"),
        ],
        config={"size": (8, 5), "overlap": (3, 2)},
        # A single tile has another graph; and no size may equal one of the traced sizes.
        symbols={"H": (9, 32768), "W": (9, 32768)},
        reference="NumPy slices",
        picture="windows",
    )
)
add(
    Spec(
        "ops.merge",
        [TensorSpec("tiles", ("B", 21, "C", 8, 5), description="3 x 7 tiles of an image of 17 x 21")],
        [TensorSpec("output", layout="NCHW", description="the image")],
        config={"image_size": (17, 21), "overlap": (3, 2)},
        reference="a loop in NumPy",
        picture="windows",
    )
)


def _tiled(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    batch, tiles, count = sizes["B"], sizes["M"], sizes["N"]
    centred = clusters(generator, {"B": batch, "N": tiles * count}).reshape(batch, tiles, count, 4)
    boxes = torch.cat([centred[..., :2] - centred[..., 2:] / 2, centred[..., :2] + centred[..., 2:] / 2], 3)
    shape = (batch, tiles, count)
    return {
        "boxes": boxes.to(dtype),
        "scores": torch.rand(shape, generator=generator).to(dtype),
        "labels": torch.randint(0, 3, shape, generator=generator),
        "found": torch.rand(shape, generator=generator) < 0.7,
        "origins": torch.randint(0, 400, (tiles, 2), generator=generator),
    }


add(
    Spec(
        "ops.merge_detections",
        [
            TensorSpec("boxes", ("B", "M", "N", 4), description="x1, y1, x2, y2 in pixels of the tiles"),
            TensorSpec("scores", ("B", "M", "N"), description="scores"),
            TensorSpec("labels", ("B", "M", "N"), "int64", description="classes"),
            TensorSpec("found", ("B", "M", "N"), "bool", description="which slots hold an object"),
            TensorSpec("origins", ("M", 2), "int64", description="where the tiles begin, x and y"),
        ],
        # The inputs have the names of the other decoders' outputs.
        [
            TensorSpec("merged_boxes", description="x1, y1, x2, y2 in pixels of the image"),
            TensorSpec("merged_scores", description="by falling score"),
            TensorSpec("merged_labels", description="classes"),
            TensorSpec("kept", description="which slots hold an object"),
        ],
        symbols={"B": (1, 64), "M": (1, 1024), "N": (1, 1024)},
        gradients=(),
        make_inputs=_tiled,
        reference="torchvision.ops.batched_nms",
        picture="tensors",
    )
)

# --- text boxes ---------------------------------------------------------------------------------------------


def _lines(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    """Rotated bars on a noisy background."""
    height, width = sizes["H"], sizes["W"]
    y, x = torch.meshgrid(torch.arange(height) + 0.0, torch.arange(width) + 0.0, indexing="ij")
    shape = (4, sizes["B"], 1, 1, 1)
    maps = 0.2 * torch.rand((sizes["B"], 1, height, width), generator=generator)
    for _ in range(4):
        across, down, turn, long = torch.rand(shape, generator=generator)
        angle = 3.2 * turn
        dx, dy = x - across * width, y - down * height
        along = (dx * torch.cos(angle) + dy * torch.sin(angle)).abs()
        beside = (dy * torch.cos(angle) - dx * torch.sin(angle)).abs()
        is_line = (along < 4 + 0.3 * width * long) & (beside < 3)
        maps = torch.where(is_line, 0.75 + maps, maps)
    return {"probability": maps.to(dtype)}


add(
    Spec(
        "ops.decode_db",
        [TensorSpec("probability", ("B", 1, "H", "W"), range=(0.0, 1.0), description="that a pixel is text")],
        [
            TensorSpec("corners", description="x and y in pixels, clockwise"),
            TensorSpec("scores", description="by falling score"),
            TensorSpec("found", description="which slots hold a box"),
        ],
        symbols={"B": (1, 256)} | STENCIL,
        # a corner may be at 0, as a difference of positions in the image
        tolerances={"float32": Tolerance(1e-4, 1e-5)},
        gradients=(),
        make_inputs=_lines,
        reference="OpenCV findContours and minAreaRect",
        picture="tensors",
    )
)
