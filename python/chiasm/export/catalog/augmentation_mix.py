"""Augmentations that mix the images of a batch, and policies."""

from ..spec import Frames, Spec, TensorSpec, image
from . import add
from .augmentation_intensity import SEED

VOLUMES = TensorSpec(
    "input", ("B", "C", "D", "H", "W"), layout="NCDHW", range=(0.0, 1.0), description="volumes"
)
_LABEL = TensorSpec("label", ("B",), "int64", range=(0, 999), description="the number of each image's class")
_MIXED = TensorSpec("output", layout="NCHW")
_LABELS = TensorSpec("labels", description="label, the partner's label, the partner's share")

add(
    Spec(
        "augmentation.random_mix_up",
        [image(), _LABEL, SEED],
        [_MIXED, _LABELS],
        config={"lambda_val": (0.1, 0.6), "p": 0.7},
        gradients=("input",),
        reference="the definition as loops in NumPy, of the drawn numbers",
        frames=Frames(),
    )
)
add(
    Spec(
        "augmentation.random_cut_mix",
        [image(), _LABEL, SEED],
        [_MIXED, _LABELS],
        config={"num_mix": 2, "cut_size": (0.1, 0.9), "p": 0.7},
        gradients=("input",),
        also=({"beta": 0.6, "use_correct_lambda": True},),
        reference="the definition as loops in NumPy, of the drawn numbers",
        frames=Frames(),
    )
)
add(
    Spec(
        "augmentation.random_transplantation",
        [
            image(),
            TensorSpec("mask", ("B", "H", "W"), "int64", range=(0, 5), description="a label for each pixel"),
            SEED,
        ],
        [_MIXED, TensorSpec("labels")],
        config={"excluded_labels": [0, 3], "p": 0.7},
        gradients=("input",),
        reference="the definition as loops in NumPy; chi-square of the drawn label",
    )
)
add(
    Spec(
        "augmentation.random_jigsaw",
        # the sides are multiples of the tiles
        [TensorSpec("input", ("B", "C", 24, 32), layout="NCHW", range=(0.0, 1.0)), SEED],
        [_MIXED],
        config={"grid": (3, 4), "p": 0.7},
        reference="the definition as loops in NumPy; chi-square of the orders",
        frames=Frames(),
    )
)
add(
    Spec(
        "augmentation.random_transplantation3d",
        [
            TensorSpec(
                "input", ("B", "C", "D", "H", "W"), "T", "NCDHW", range=(0.0, 1.0), description="volumes"
            ),
            TensorSpec(
                "mask", ("B", "D", "H", "W"), "int64", range=(0, 5), description="a label for each voxel"
            ),
            SEED,
        ],
        [TensorSpec("output", layout="NCDHW"), TensorSpec("labels")],
        config={"excluded_labels": [0, 3], "p": 0.7},
        symbols={"D": (1, 4096)},
        gradients=("input",),
        reference="the definition as loops in NumPy; chi-square of the drawn label",
    )
)
add(
    Spec(
        "augmentation.random_mosaic",
        [image(), SEED],
        [_MIXED],
        config={"output_size": (20, 17), "mosaic_grid": (2, 3), "p": 0.7},
        also=({"output_size": None}, {"padding_mode": "replicate", "p": 1.0}),
        reference="numpy.block and numpy.pad, of the drawn numbers",
        frames=Frames(),
    )
)

# --- policies -----------------------------------------------------------------------------------------------

_SIDES = {"H": (8, 32768), "W": (8, 32768)}

for _name, _config in (
    ("rand_augment", {"n": 2, "m": 9}),
    ("trivial_augment", {}),
    ("auto_augment", {"policy": "imagenet"}),
    ("aug_mix", {"mixture_width": 2, "chain_depth": 1}),
):
    add(
        Spec(
            f"augmentation.{_name}",
            [image(channels=3, color="RGB"), SEED],
            [_MIXED],
            config=_config,
            symbols=_SIDES,
            gradients=(),
            reference="torchvision's operations, as drawn",
        )
    )
