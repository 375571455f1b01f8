"""Every public module prints the parameters of its constructor, and so do its copies; packages list what is
public."""

import copy
import importlib
import inspect
import pickle
import re
from types import ModuleType
from typing import Any

import pytest
import torch
from test_augmentation_classes import GIVEN, MOVING
from test_doctests import MODULES
from torch import Tensor, nn

import chiasm
from chiasm.augmentation import RandomInvert
from chiasm.feature import PassLAF
from chiasm.geometry.camera import PinholeCamera
from chiasm.geometry.liegroup import So2, So3
from chiasm.geometry.quaternion import Quaternion

OTHERS = [f"chiasm.{name}" for name in ("data", "export", "onnx", "runtime", "triton")]
PUBLIC: dict[str, ModuleType] = {"chiasm": chiasm} | {
    name: package
    for name in [*MODULES, *OTHERS]
    if hasattr(package := importlib.import_module(name), "__all__")
}
CLASSES = {
    f"{package}.{name}": made
    for package, module in PUBLIC.items()
    if package not in OTHERS
    for name in dir(module)
    if inspect.isclass(made := getattr(module, name)) and issubclass(made, nn.Module)
}
CAMERA = torch.eye(4)[None], torch.eye(4)[None], torch.ones(1), torch.ones(1)
IMAGE = torch.rand(2, 1, 8, 8)
#: Arguments of the classes that need some and are not generated from a function.
NEEDED: dict[str, tuple[Any, ...]] = {
    "AugmentationSequential": (RandomInvert(),),
    "CenterCrop2D": (2,),
    "CornerHarris": (0.04,),
    "DepthWarper": (PinholeCamera(*CAMERA), 4, 5),
    "HomographyWarper": (4, 5),
    "Hyperplane": (torch.eye(3)[0], torch.ones(())),
    "ImageSequential": (RandomInvert(),),
    "KMeans": (2,),
    "LAFDescriptor": (nn.Flatten(),),
    "LocalFeature": (PassLAF(), PassLAF()),
    "LocalFeatureMatcher": (PassLAF(),),
    "MILossFromRef": (IMAGE.flatten(1),),
    "MILossFromRef2D": (IMAGE,),
    "MILossFromRef3D": (IMAGE[None],),
    "NMILossFromRef": (IMAGE.flatten(1),),
    "NMILossFromRef2D": (IMAGE,),
    "NMILossFromRef3D": (IMAGE[None],),
    "NonMaximaSuppression2d": (3,),
    "NonMaximaSuppression3d": (3,),
    "ParametrizedLine": (torch.zeros(3), torch.ones(3)),
    "PatchSequential": tuple(RandomInvert() for _ in range(16)),
    "PinholeCamera": CAMERA,
    "Quaternion": (torch.eye(4)[0],),
    "Se2": (So2.identity(), torch.zeros(2)),
    "Se3": (So3.identity(), torch.zeros(3)),
    "So2": (torch.ones((), dtype=torch.complex64),),
    "So3": (Quaternion.identity(),),
    "StereoCamera": (torch.eye(3, 4)[None], torch.eye(3, 4)[None]),
    "VideoSequential": (RandomInvert(),),
    **GIVEN,
    **MOVING,
}
#: Parameters that describe a module within the module, which prints itself.
WITHIN = {
    "ImageRegistrator": {"model_type"},
    "LAFOrienter": {"num_angular_bins"},
    "LocalFeatureMatcher": {"matcher"},
}


def arguments(name: str) -> inspect.BoundArguments:
    signature, own = inspect.signature(CLASSES[name]), name.rpartition(".")[2]
    if own in NEEDED:
        return signature.bind(*NEEDED[own])
    needed = [p for p in signature.parameters.values() if p.default is p.empty]
    generated = {p.name: torch.ones(1) if p.annotation is Tensor else 3 for p in needed}
    return signature.bind(**{n: v for n, v in generated.items() if n not in ("args", "kwargs")})


def test_there_are_classes() -> None:
    assert len(CLASSES) > 500
    assert {"chiasm.feature.SIFTDescriptor", "chiasm.augmentation.ColorJitter"} < set(CLASSES)


@pytest.mark.parametrize("name", CLASSES)
def test_a_module_prints_its_parameters(name: str) -> None:
    made, bound = CLASSES[name], arguments(name)
    module = made(*bound.args, **bound.kwargs)
    bound.apply_defaults()
    plain = {n for n, v in bound.arguments.items() if isinstance(v, (bool, int, float, str, tuple))}
    without_effect = re.findall(r"^ *([\w, ]+): for compatibility with Kornia", made.__doc__ or "", re.M)
    ignored = {"args", *", ".join(without_effect).split(", "), *WITHIN.get(made.__name__, ())}
    assert plain - ignored <= set(re.findall(r"(\w+)=", module.extra_repr()))
    assert repr(copy.deepcopy(module)) == repr(module)
    assert repr(pickle.loads(pickle.dumps(module))) == repr(module)


@pytest.mark.parametrize("name", PUBLIC)
def test_a_package_lists_what_is_public(name: str) -> None:
    package, listed = PUBLIC[name], dir(PUBLIC[name])
    assert set(getattr(package, "__all__", ["__version__", "geometry"])) <= set(listed)
    for each in listed:
        value = getattr(package, each)
        home = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", "chiasm")
        assert home.startswith("chiasm"), each
        assert not home.startswith("chiasm.primitives.core"), each
