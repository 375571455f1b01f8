"""Augmentations of volumes."""

from typing import Any

from ..spec import Spec, TensorSpec
from . import add
from .augmentation_intensity import SEED
from .augmentation_mix import VOLUMES

_TURN = [(-20.0, 20.0), (-10.0, 30.0), (-45.0, 45.0)]
_SCIPY = "SciPy's map_coordinates, of the drawn numbers"


def _add(name: str, config: dict[str, Any], reference: str, least: int = 1, **options: Any) -> None:
    symbols = {"D": (least, 4096), "H": (least, 32768), "W": (least, 32768)}
    add(
        Spec(
            f"augmentation.{name}",
            [VOLUMES, SEED],
            [TensorSpec("output", layout="NCDHW")],
            config=config,
            symbols=symbols,
            reference=reference,
            **options,
        )
    )


_add("random_horizontal_flip3d", {"p": 0.7}, "NumPy")
_add("random_vertical_flip3d", {"p": 0.7}, "NumPy")
_add("random_depthical_flip3d", {"p": 0.7}, "NumPy")
_add("random_rotation3d", {"degrees": _TURN, "p": 0.7}, _SCIPY)
_add(
    "random_affine3d",
    {"degrees": _TURN, "translate": (0.1, 0.2, 0.1), "scale": [(0.8, 1.25)], "p": 0.7},
    _SCIPY,
    also=({"scale": [(0.8, 1.25)] * 3, "shears": [(-5.0, 10.0)] * 6},),
)
# a volume of one slice has no homography
_add("random_perspective3d", {"p": 0.7}, _SCIPY, least=2)
_add(
    "random_crop3d",
    # not 6 or 7: a trace treats sizes that equal its inputs' as the same
    {"size": (4, 5, 9), "padding": (3, 2, 1, 0, 2, 2)},
    "numpy.pad and slices",
    least=8,
    also=({"padding_mode": "reflect"}, {"pad_if_needed": True}),
)
_add("random_equalize3d", {"p": 0.7}, "Pillow ImageOps.equalize of the volume's values", gradients=())
_add(
    "random_motion_blur3d",
    {"kernel_size": (3, 5), "angle": _TURN, "direction": (-0.5, 0.5), "p": 0.7},
    "SciPy's correlate, by the kernel of the drawn numbers",
    least=8,
)
