"""The classes of the augmentations that change values, with Kornia's constructors.

Given the same seeds, each class computes the same as its function, in eager Python and in TorchScript. The
classes are generated as source text, like the module classes in ``primitives/core/modules.py``.
"""

import inspect
import math
from typing import Any, Callable, Dict, List, Tuple, Type

from torch import Tensor, nn

from ..primitives.core.modules import hold, shown
from ..primitives.core.source import made_from
from ..primitives.random.draws import uniform
from . import blur, colour, distort, jitter, levels, light, noise, policies, weather
from .base import ImagesOnly, IntensityAugmentationBase2D, select
from .decisions import below
from .settings import (
    Reader,
    about,
    bits,
    fixed,
    list_of_whole,
    number,
    number_or_tensor,
    one_whole,
    plain,
    vector,
    whole,
    word,
)

Setting = Tuple[str, Any, Reader]
#: Marks a setting without a default.
_NEEDED = inspect.Parameter.empty
_INFINITE = math.inf


def _class(
    name: str,
    function: Callable[..., Any],
    settings: List[Setting],
    tail: str,
    base: Type[nn.Module] = IntensityAugmentationBase2D,
) -> Type[nn.Module]:
    """``tail`` gives the order of the arguments that all classes have: ``p`` with its default,
    ``same_on_batch``, ``keepdim``, and any settings that come after them."""
    scope: Dict[str, Any] = {
        "Base": base,
        "Tensor": Tensor,
        "List": List,
        "Dict": Dict,
        "function": function,
        "select": select,
        "below": below,
        "store": _store,
        "number": number,
        "uniform": uniform,
    }
    named = {setting[0]: setting for setting in settings}
    parameters = inspect.signature(function).parameters
    words = [w.partition("=") for w in tail.split()]
    late = [w[0] for w in words]
    defaults: Dict[str, Any] = {"same_on_batch": False, "keepdim": False}
    defaults.update({w[0]: float(w[2]) for w in words if w[0] == "p"})
    order = [s[0] for s in settings if s[0] not in late] + late
    common = [each for each in order if each not in named]
    header: List[str] = []
    body: List[str] = []
    stored: Dict[str, Any] = {}
    # For the photometric distortion, p is the probability of each of its changes, not of the whole.
    whole_chance = function is not distort.random_photometric_distort
    start = ["p=1.0"] if "p" not in common or not whole_chance else []
    start += [f"{each}={each}" for each in common if each != "p" or whole_chance]
    body.append(f"super().__init__({', '.join(start)})")
    if not whole_chance:
        body.append("self.chance = number('p', p)")
    for each in order:
        default = named[each][1] if each in named else defaults[each]
        scope[f"default_{each}"] = default
        scope[f"type_{each}"] = type(default)
        if each in named:
            read = inspect.signature(named[each][2])
            given = read.parameters["value"].annotation
            scope[f"type_{each}"] = parameters[each].annotation if given is Any else given
            stored[each] = parameters[each].annotation if given is Any else read.return_annotation
            scope[f"read_{each}"] = named[each][2]
            body.append(f"store(self, {each!r}, read_{each}({each!r}, {each}))")
        header.append(f"{each}: type_{each}" + ("" if default is _NEEDED else f" = default_{each}"))
    passed = [f"{each}=self.{each}" for each in named if each in parameters]
    if not whole_chance:
        passed.append("p=self.chance")
    lines = [f"class {name}(Base):", f"    def __init__({', '.join(['self', *header])}):"]
    lines += [f"        {line}" for line in body]
    if "p" in common and whole_chance:
        passed.append("p=1.0")  # the base class has already chosen the samples
    lines += [
        "    def generate_parameters(self, seed: Tensor, shape: List[int]) -> Dict[str, Tensor]:",
        '        return {"batch_prob": below(uniform(seed, 1)[:, 0], self.p), "draws": seed}',
        "    def apply_transform(self, input: Tensor, params: Dict[str, Tensor]) -> Tensor:",
        '        draws = params["draws"]',
        f"        changed = function({', '.join(['input', 'draws', *passed])})",
        "        return select(params, changed, input)",
    ]
    made = made_from("\n".join(lines) + "\n", f"<chiasm augmentation {name}>", name, scope)
    text = (inspect.getdoc(function) or "").partition("\nExample:")[0]  # the example calls the function
    made.__doc__ = f"`{function.__name__}` as a module, which draws the seeds if none are given.\n\n{text}"
    made.__module__ = __name__.rpartition(".")[0]
    made.stored = stored  # the types of the attributes, for the stub
    if not whole_chance:
        made.extra_repr = lambda self: shown(self, p=self.chance)
    return made


def _store(module: nn.Module, name: str, value: Any) -> None:
    if isinstance(value, Tensor):
        hold(module, name, value)
    else:
        setattr(module, name, value)


def _normalized(name: str, value: bool) -> bool:
    if not value:
        raise ValueError(f"{name}: expected True, for a mean; got {value}")
    return True


def _ratio(default: float) -> List[Setting]:
    return [
        ("brightness", default, about(1.0, 0.0, 2.0)),
        ("contrast", default, about(1.0, 0.0, _INFINITE)),
        ("saturation", default, about(1.0, 0.0, _INFINITE)),
        ("hue", default, about(0.0, -0.5, 0.5)),
        ("order", None, list_of_whole),
    ]


_SAME, _HALF = "same_on_batch p=1 keepdim", "same_on_batch p=0.5 keepdim"
_LAST = "p=0.5 same_on_batch keepdim"
_STATISTICS: List[Setting] = [("mean", _NEEDED, vector), ("std", _NEEDED, vector)]
_ROUGHNESS: Setting = ("roughness", (0.1, 0.7), fixed)
_SIGN: Setting = ("sign", (-1.0, 1.0), fixed)
_CLIP: Setting = ("clip_output", True, plain)
_ANY = about(0.0, -_INFINITE, _INFINITE)

_MADE = [
    _class("ColorJiggle", jitter.random_color_jiggle, _ratio(0.0), f"{_SAME} order"),
    _class("ColorJitter", jitter.random_color_jitter, _ratio(0.0), f"{_SAME} order"),
    _class("Denormalize", levels.random_denormalize, _STATISTICS, "p=1 keepdim"),
    _class("Normalize", levels.random_normalize, _STATISTICS, "p=1 keepdim"),
    _class("RandomAutoContrast", levels.random_auto_contrast, [_CLIP], _SAME),
    _class(
        "RandomBoxBlur",
        blur.random_box_blur,
        [("kernel_size", (3, 3), whole), ("border_type", "reflect", word), ("normalized", True, _normalized)],
        _HALF,
    ),
    _class(
        "RandomBrightness",
        colour.random_brightness,
        [("brightness", (1.0, 1.0), about(1, 0, 2)), _CLIP],
        _SAME,
    ),
    _class(
        "RandomChannelDropout",
        noise.random_channel_dropout,
        [("num_drop_channels", 1, one_whole), ("fill_value", 0.0, number)],
        _HALF,
    ),
    _class("RandomChannelShuffle", noise.random_channel_shuffle, [], _HALF),
    _class(
        "RandomClahe",
        levels.random_clahe,
        [
            ("clip_limit", (40.0, 40.0), fixed),
            ("grid_size", (8, 8), whole),
            ("slow_and_differentiable", False, plain),
        ],
        _HALF,
    ),
    _class(
        "RandomContrast",
        colour.random_contrast,
        [("contrast", (1.0, 1.0), about(1, 0, _INFINITE)), _CLIP],
        _SAME,
    ),
    _class("RandomEqualize", levels.random_equalize, [], _HALF),
    _class(
        "RandomGamma", colour.random_gamma, [("gamma", (1.0, 1.0), fixed), ("gain", (1.0, 1.0), fixed)], _SAME
    ),
    _class(
        "RandomGaussianBlur",
        blur.random_gaussian_blur,
        [
            ("kernel_size", _NEEDED, whole),
            ("sigma", _NEEDED, fixed),
            ("border_type", "reflect", word),
            ("separable", True, plain),
        ],
        _HALF,
    ),
    _class(
        "RandomGaussianIllumination",
        light.random_gaussian_illumination,
        [
            ("gain", (0.01, 0.15), fixed),
            ("center", (0.1, 0.9), fixed),
            ("sigma", (0.2, 1.0), fixed),
            _SIGN,
        ],
        _LAST,
    ),
    _class(
        "RandomGaussianNoise",
        noise.random_gaussian_noise,
        [("mean", 0.0, number), ("std", 1.0, number)],
        _HALF,
    ),
    _class(
        "RandomGrayscale",
        colour.random_grayscale,
        [("rgb_weights", None, plain)],
        "same_on_batch p=0.1 keepdim",
    ),
    _class("RandomHue", colour.random_hue, [("hue", (0.0, 0.0), about(0, -0.5, 0.5))], _SAME),
    _class("RandomInvert", levels.random_invert, [("max_val", 1.0, number_or_tensor)], _HALF),
    _class("RandomJPEG", noise.random_jpeg, [("jpeg_quality", 50.0, about(50, 1, 100))], _SAME),
    _class(
        "RandomLinearCornerIllumination",
        light.random_linear_corner_illumination,
        [("gain", (0.01, 0.2), fixed), _SIGN],
        _LAST,
    ),
    _class(
        "RandomLinearIllumination",
        light.random_linear_illumination,
        [("gain", (0.01, 0.2), fixed), _SIGN],
        _LAST,
    ),
    _class("RandomMedianBlur", blur.random_median_blur, [("kernel_size", (3, 3), whole)], _HALF),
    _class(
        "RandomMotionBlur",
        blur.random_motion_blur,
        [
            ("kernel_size", _NEEDED, whole),
            ("angle", _NEEDED, _ANY),
            ("direction", _NEEDED, about(0, -1, 1)),
            ("border_type", "constant", word),
            ("resample", "nearest", word),
        ],
        _HALF,
    ),
    _class(
        "RandomPhotometricDistort",
        distort.random_photometric_distort,
        [
            ("brightness", (0.875, 1.125), fixed),
            ("contrast", (0.5, 1.5), fixed),
            ("saturation", (0.5, 1.5), fixed),
            ("hue", (-0.05, 0.05), fixed),
        ],
        "p=0.5",
    ),
    _class(
        "RandomPlanckianJitter",
        light.random_planckian_jitter,
        [("mode", "blackbody", plain), ("select_from", None, list_of_whole)],
        _HALF,
    ),
    _class(
        "RandomPlasmaBrightness",
        light.random_plasma_brightness,
        [_ROUGHNESS, ("intensity", (0.0, 1.0), fixed)],
        _HALF,
    ),
    _class("RandomPlasmaContrast", light.random_plasma_contrast, [_ROUGHNESS], _HALF),
    _class(
        "RandomPlasmaShadow",
        light.random_plasma_shadow,
        [_ROUGHNESS, ("shade_intensity", (-1.0, 0.0), fixed), ("shade_quantity", (0.0, 1.0), fixed)],
        _HALF,
    ),
    _class("RandomPosterize", levels.random_posterize, [("bits", 3, bits)], _HALF),
    _class(
        "RandomRain",
        weather.random_rain,
        [
            ("number_of_drops", (1000, 2000), whole),
            ("drop_height", (5, 20), whole),
            ("drop_width", (-5, 5), whole),
        ],
        _HALF,
    ),
    _class(
        "RandomRGBShift",
        colour.random_rgb_shift,
        [(f"{channel}_shift_limit", 0.5, _ANY) for channel in "rgb"],
        _HALF,
    ),
    _class(
        "RandomSaltAndPepperNoise",
        noise.random_salt_and_pepper_noise,
        [("amount", (0.01, 0.06), fixed), ("salt_vs_pepper", (0.4, 0.6), fixed)],
        _LAST,
    ),
    _class(
        "RandomSaturation",
        colour.random_saturation,
        [("saturation", (1.0, 1.0), about(1, 0, _INFINITE))],
        _SAME,
    ),
    _class("RandomSharpness", levels.random_sharpness, [("sharpness", 0.5, about(0, 0, _INFINITE))], _HALF),
    _class(
        "RandomSnow",
        weather.random_snow,
        [("snow_coefficient", (0.5, 0.5), fixed), ("brightness", (2, 2), fixed)],
        _SAME,
    ),
    _class(
        "RandomSolarize",
        levels.random_solarize,
        [("thresholds", 0.1, about(0.5, 0, 1)), ("additions", 0.1, about(0, -0.5, 0.5))],
        _HALF,
    ),
    _class("AutoAugment", policies.auto_augment, [("policy", "imagenet", plain)], "", ImagesOnly),
    _class(
        "RandAugment",
        policies.rand_augment,
        [("n", _NEEDED, one_whole), ("m", _NEEDED, one_whole)],
        "",
        ImagesOnly,
    ),
    _class("TrivialAugment", policies.trivial_augment, [], "", ImagesOnly),
    _class(
        "AugMix",
        policies.aug_mix,
        [
            ("severity", 3, one_whole),
            ("mixture_width", 3, one_whole),
            ("chain_depth", -1, one_whole),
            ("alpha", 1.0, number),
            ("all_ops", True, plain),
        ],
        "",
        ImagesOnly,
    ),
]
CLASSES: Dict[str, Type[nn.Module]] = {made.__name__: made for made in _MADE}
