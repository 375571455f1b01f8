"""Module classes: `GaussianBlur2d` from `gaussian_blur2d`, made from the function's signature on first use.

The class is written as source text because torch.jit.script reads source.
"""

import inspect
from dataclasses import dataclass, field
from enum import Enum
from typing import (
    Any,
    Callable,
    Dict,
    List,
    Mapping,
    Optional,
    Sequence,
    Tuple,
    Type,
    TypeVar,
    Union,
    get_args,
    get_origin,
)

import torch
from torch import Tensor, nn

from .source import made_from

_Function = TypeVar("_Function", bound=Callable[..., Any])


class Module(nn.Module):
    """A module that prints the parameters of its constructor, as far as it stores them under their names."""

    def extra_repr(self) -> str:
        return shown(self)


def shown(module: nn.Module, **others: Any) -> str:
    """The parameters of a module's constructor and their values, for `extra_repr`.

    Args:
        module: stores the values under the parameters' names; the modules within it print themselves.
        others: the values that it stores otherwise.
    """
    stored = {**vars(module), **module._parameters, **module._buffers, **others}
    names = [name for name in inspect.signature(type(module)).parameters if name in stored]
    return ", ".join(f"{name}={_short(stored[name])}" for name in names)


@dataclass(frozen=True)
class ModuleForm:
    """How a module class differs from its function, so that Kornia's calls work.

    held: tensors that the constructor takes. names: the constructor's keywords, by the function's. defaults:
    those of the constructor, where they differ. last: settings that come after all others. also: the class's
    other names.
    """

    held: Sequence[str] = ()
    names: Mapping[str, str] = field(default_factory=dict)
    defaults: Mapping[str, Any] = field(default_factory=dict)
    last: Sequence[str] = ()
    also: Sequence[str] = ()


def is_tensor(annotation: Any) -> bool:
    """Whether an annotation is of an input: a tensor, or a tensor that may be a list of several instead."""
    return annotation is Tensor or annotation == Union[Tensor, List[Tensor]]


def settings_of(function: Callable[..., Any], form: ModuleForm) -> List[inspect.Parameter]:
    """The function's parameters that the module class's constructor takes, in its order and with its
    defaults."""
    found = [
        p.replace(default=form.defaults.get(p.name, p.default))
        for p in inspect.signature(function).parameters.values()
        if not is_tensor(p.annotation) or p.default is not p.empty or p.name in form.held
    ]
    return sorted(found, key=lambda p: p.name in form.last)


def module_class(function: Callable[..., Any], form: ModuleForm = ModuleForm()) -> Type[nn.Module]:
    """The class whose `forward` takes the function's tensors and whose constructor takes everything else.

    Tensors are the parameters annotated so (`is_tensor`) without a default, except those that the form holds.
    The constructor takes these, so that `forward` takes only an image, as in `nn.Sequential`; `hold` stores
    them.

    >>> from chiasm.filters import median_blur
    >>> blur = module_class(median_blur)(3)
    >>> blur(torch.ones(1, 2, 5, 5)).shape, blur.kernel_size
    (torch.Size([1, 2, 5, 5]), 3)
    >>> blur
    MedianBlur(kernel_size=3, border_type='reflect')
    """
    signature = inspect.signature(function)
    settings = settings_of(function, form)
    own = {p.name for p in settings}
    tensors = [p for p in signature.parameters.values() if p.name not in own]
    keyword = {p.name: form.names.get(p.name, p.name) for p in settings}
    name = class_name(function.__name__)
    scope: Dict[str, Any] = {
        "Module": Module,
        "Tensor": Tensor,
        "Result": signature.return_annotation,
        "function": function,
        "fitted": _fitted,
    }
    written: List[str] = []
    for p in settings:
        scope[f"type_{p.name}"], scope[f"default_{p.name}"] = p.annotation, p.default
        default = "" if p.default is p.empty else f" = default_{p.name}"
        written.append(f"{keyword[p.name]}: type_{p.name}{default}")
    scope |= {f"type_{p.name}": p.annotation for p in tensors}
    typed = ", ".join(["self"] + [f"{p.name}: type_{p.name}" for p in tensors])
    passed = ", ".join(
        [f"{p.name}={p.name}" for p in tensors] + [f"{p.name}=self.{p.name}" for p in settings]
    )
    lines = [
        f"class {name}(Module):",
        f"    def __init__({', '.join(['self'] + written)}):",
        "        super().__init__()",
    ]
    lines += [f"        fitted(self, {p.name!r}, {keyword[p.name]}, type_{p.name})" for p in settings]
    lines += [f"    def forward({typed}) -> Result:", f"        return function({passed})", ""]
    source = "\n".join(lines)
    made = made_from(source, f"<chiasm module {function.__module__}.{name}>", name, scope)
    about = (inspect.getdoc(function) or "").partition("\nExample:")[0]  # the example calls the function
    made.__doc__ = f"`{function.__name__}` as a module.\n\n{about}"
    renamed = {name: attribute for attribute, name in keyword.items() if name != attribute}
    if renamed:
        made.extra_repr = lambda self: shown(self, **{n: getattr(self, a) for n, a in renamed.items()})
    made.form = form
    made.__module__ = function.__module__.rpartition(".")[0]
    return made


def _short(value: Any) -> str:
    """A setting as a module's repr shows it: of a tensor the shape, of a function or a class the name."""
    if isinstance(value, Tensor):
        return f"Tensor{tuple(value.shape)}"
    return getattr(value, "__qualname__", repr(value))


def class_name(function_name: str) -> str:
    """The module class's name.

    >>> class_name("rgb_to_hsv")
    'RgbToHsv'
    """
    return _SPELLED.get(function_name) or "".join(
        part[:1].upper() + part[1:] for part in function_name.split("_")
    )


# Spellings of words that a function's name joins, or that Kornia writes in capitals.
_SPELLED = {
    "aepe": "AEPE",
    "hausdorff_er_loss": "HausdorffERLoss",
    "hausdorff_er_loss3d": "HausdorffERLoss3D",
    "kmeans": "KMeans",
    "ms_ssim_loss": "MS_SSIMLoss",
    "psnr_loss": "PSNRLoss",
    "pyrdown": "PyrDown",
    "pyrup": "PyrUp",
    "ssim": "SSIM",
    "ssim3d": "SSIM3D",
    "ssim3d_loss": "SSIM3DLoss",
    "ssim_loss": "SSIMLoss",
}


def eager_only(function: _Function) -> _Function:
    """Mark a function of arrays, text or files, of which no module class is made."""
    vars(function)["eager_only"] = True
    return function


def has_class(public: Any) -> bool:
    """Whether a public name of a package is a function of which a module class is made."""
    return inspect.isfunction(public) and not hasattr(public, "eager_only")


def lazy_modules(
    package: str, functions: Dict[str, Any], forms: Optional[Mapping[str, ModuleForm]] = None
) -> Tuple[Callable[[str], Type[nn.Module]], Callable[[], List[str]]]:
    """A package's `__getattr__`, which generates the module class of a public function at its first use, and
    its `__dir__` (PEP 562), which lists the public names and these classes.

    Args:
        package: the package's `__name__`.
        functions: its `globals()`, which also store the generated classes.
        forms: by function name, for module classes that differ from their function.
    """

    known = forms or {}
    others = {name: class_name(public) for public, form in known.items() for name in form.also}

    def __getattr__(name: str) -> Type[nn.Module]:
        wanted = others.get(name, name)
        if wanted in functions:
            return functions[wanted]
        for public in functions["__all__"]:
            if class_name(public) == wanted and has_class(functions[public]):
                functions[wanted] = module_class(functions[public], known.get(public, ModuleForm()))
                return functions[wanted]
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    def __dir__() -> List[str]:
        public: List[str] = functions["__all__"]
        classes = [class_name(name) for name in public if has_class(functions[name])]
        return sorted({*public, *classes, *others})

    return __getattr__, __dir__


def hold(module: nn.Module, name: str, value: Tensor) -> None:
    """Store a tensor: a Parameter is learned with the module; any other tensor moves with the module, but is
    not in its state."""
    if isinstance(value, nn.Parameter):
        module.register_parameter(name, value)
    else:
        module.register_buffer(name, value, persistent=False)


def _fitted(module: nn.Module, name: str, value: Any, annotation: Any) -> None:
    """Store a setting. An int becomes a float if the annotation allows only float: TorchScript distinguishes
    them."""
    fitting = value if isinstance(value, Tensor) else _as(value, annotation)
    if isinstance(fitting, Tensor):
        hold(module, name, fitting)
    else:
        setattr(module, name, fitting)


def _as(value: Any, annotation: Any) -> Any:
    choices: Tuple[Any, ...] = get_args(annotation) if get_origin(annotation) is Union else (annotation,)
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, (tuple, list)) and Tensor in choices and not any(map(get_origin, choices)):
        return torch.tensor(value)  # one number for each channel, for a tensor setting
    if isinstance(value, int) and not isinstance(value, bool) and float in choices and int not in choices:
        return float(value)
    for choice in choices:
        items = get_args(choice)
        if isinstance(value, (tuple, list)) and get_origin(choice) is tuple and len(items) == len(value):
            return tuple(_as(v, item) for v, item in zip(value, items))
    return value
