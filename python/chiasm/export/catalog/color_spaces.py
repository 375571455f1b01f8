"""Colour: hue and saturation, CIE spaces."""

from typing import Any

import numpy as np
import torch
from torch import Generator, Tensor

from ..peer import cvt_color
from ..spec import Frames, Spec, Tolerance, image
from . import add
from .color import OPENCV, output, rgb, second_last

# --- hexagonal spaces ---------------------------------------------------------------------------------------


def _in_radians(hsv: Any):
    """OpenCV's hue is in degrees."""
    return hsv * np.array([np.pi / 180, 1.0, 1.0])


def _in_degrees(hue: Any) -> tuple[Any, ...]:
    """The inverse conversion."""
    return (hue * np.array([180 / np.pi, 1.0, 1.0], np.float32),)


add(
    Spec(
        "color.rgb_to_hsv",
        [rgb()],
        output("HSV", "hue in [0, 2 pi], saturation and value in [0, 1]"),
        peer=cvt_color("COLOR_RGB2HSV", after=_in_radians, atol=1e-4),
        reference="OpenCV cvtColor(COLOR_RGB2HSV) on float32",
        frames=Frames(
            reference="OpenCV cvtColor(COLOR_RGB2HSV)", peer=cvt_color("COLOR_RGB2HSV", atol=1, share=1e-3)
        ),
    )
)


def _hue(name: str):
    """Hues of a turn and the two other channels in [0, 1]."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        unit = torch.rand((sizes["B"], 3, sizes["H"], sizes["W"]), generator=generator, dtype=torch.float64)
        return {name: (unit * torch.tensor([6.283, 1.0, 1.0], dtype=torch.float64)[:, None, None]).to(dtype)}

    return sample


_EXACT = "OpenCV cvtColor; exact numbers in float64"

for _space in ("hls", "hsl", "hsv"):
    _color = _space.upper()
    if _space == "hsl":  # OpenCV has another order
        _frames = Frames(
            reference=_EXACT, peer=cvt_color("COLOR_RGB2HLS", after=second_last, atol=1, share=5e-3)
        )
        _frames_back = Frames(
            reference=_EXACT,
            peer=cvt_color("COLOR_HLS2RGB", before=lambda x: (second_last(x),), atol=1, share=5e-3),
        )
    else:
        _frames, _frames_back = (
            Frames(reference=_EXACT, peer=cvt_color(f"COLOR_{way}", atol=1, share=5e-3))
            for way in (f"RGB2{_color}", f"{_color}2RGB")
        )
    if _space != "hsv":
        add(
            Spec(
                f"color.rgb_to_{_space}",
                [rgb()],
                output(_color, "hue in [0, 2 pi], the others in [0, 1]"),
                peer=cvt_color(
                    "COLOR_RGB2HLS",
                    after=_in_radians if _space == "hls" else lambda hls: second_last(_in_radians(hls)),
                    atol=1e-4,
                ),
                reference=OPENCV.format("COLOR_RGB2HLS"),
                frames=_frames,
            )
        )
    add(
        Spec(
            f"color.{_space}_to_rgb",
            [image("image", channels=3, color=_color, description="hue in radians, the others in [0, 1]")],
            output(),
            make_inputs=_hue("image"),
            peer=cvt_color(
                f"COLOR_{'HLS' if _space == 'hsl' else _color}2RGB",
                before=_in_degrees if _space != "hsl" else lambda hsl: _in_degrees(second_last(hsl)),
                atol=1e-4,
            ),
            reference=OPENCV.format("COLOR_HSV2RGB, COLOR_HLS2RGB") + "; colorsys",
            frames=_frames_back,
        )
    )

# --- CIE ----------------------------------------------------------------------------------------------------

_LOGARITHM = "powers in ONNX go by logarithms, and ONNX Runtime's logarithm of infinity is finite"

# exp(c log x) for x ^ c, here and in the backends, has a relative error of a few float32 roundings, which
# L*a*b* and L*u*v* multiply by up to 1500
_CIE = {"float32": Tolerance(5e-4, 1e-4)}

add(
    Spec(
        "color.rgb_to_linear_rgb",
        [rgb()],
        output(description="linear light"),
        reference="scikit-image; IEC 61966-2-1 in NumPy float64",
    )
)

add(
    Spec(
        "color.linear_rgb_to_rgb",
        [rgb()],
        output(),
        special_values=_LOGARITHM,
        reference="scikit-image; IEC 61966-2-1 in NumPy float64",
    )
)

add(
    Spec(
        "color.rgb_to_xyz",
        [rgb()],
        output("XYZ"),
        peer=cvt_color("COLOR_RGB2XYZ"),
        reference=OPENCV.format("COLOR_RGB2XYZ"),
        frames=Frames(peer=cvt_color("COLOR_RGB2XYZ")),
    )
)

add(
    Spec(
        "color.xyz_to_rgb",
        [image("image", channels=3, color="XYZ")],
        output(),
        peer=cvt_color("COLOR_XYZ2RGB"),
        reference=OPENCV.format("COLOR_XYZ2RGB"),
        frames=Frames(peer=cvt_color("COLOR_XYZ2RGB")),
    )
)

add(
    Spec(
        "color.rgb_to_lab",
        [rgb()],
        output("LAB", "L in [0, 100], a and b within [-128, 127]"),
        tolerances=_CIE,
        # derivatives of a and b with respect to a dark colour are in the hundreds
        gradient_tolerances={"float32": Tolerance(5e-3, 1e-3)},
        special_values=_LOGARITHM,
        peer=cvt_color("COLOR_RGB2Lab", atol=0.5),
        reference="scikit-image rgb2lab; OpenCV cvtColor(COLOR_RGB2Lab)",
        frames=Frames(peer=cvt_color("COLOR_RGB2Lab", atol=3)),
    )
)

add(
    Spec(
        "color.rgb_to_luv",
        [rgb()],
        output("LUV", "L in [0, 100], u in [-134, 220], v in [-140, 122]"),
        tolerances=_CIE,
        gradient_tolerances={"float32": Tolerance(5e-3, 1e-3)},
        special_values=_LOGARITHM,
        peer=cvt_color("COLOR_RGB2Luv", atol=0.05),
        reference="scikit-image rgb2luv; OpenCV cvtColor(COLOR_RGB2Luv)",
        frames=Frames(peer=cvt_color("COLOR_RGB2Luv", atol=1)),
    )
)


def _make_cie(space: str):
    """Colours in sRGB, away from the gamut's faces, where clipping has a kink."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        from chiasm import color

        unit = torch.rand((sizes["B"], 3, sizes["H"], sizes["W"]), generator=generator, dtype=torch.float64)
        return {"image": getattr(color, f"rgb_to_{space}")(0.05 + 0.9 * unit).to(dtype)}

    return sample


add(
    Spec(
        "color.lab_to_rgb",
        [image("image", channels=3, color="LAB", range=(-128.0, 127.0))],
        output(),
        make_inputs=_make_cie("lab"),
        peer=cvt_color("COLOR_Lab2RGB", atol=1e-3),
        reference="scikit-image lab2rgb; OpenCV cvtColor(COLOR_Lab2RGB)",
        frames=Frames(peer=cvt_color("COLOR_Lab2RGB", atol=4, share=0.1)),
    )
)

add(
    Spec(
        "color.luv_to_rgb",
        [image("image", channels=3, color="LUV", range=(-140.0, 220.0))],
        output(),
        special_values=_LOGARITHM,
        make_inputs=_make_cie("luv"),
        peer=cvt_color("COLOR_Luv2RGB", atol=1e-3),
        reference="scikit-image luv2rgb; OpenCV cvtColor(COLOR_Luv2RGB)",
        frames=Frames(peer=cvt_color("COLOR_Luv2RGB", atol=4, share=0.1)),
    )
)
