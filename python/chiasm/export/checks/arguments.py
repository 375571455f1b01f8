# A caller may have put something else into a spec than its types say, which is what is checked here.
# pyright: reportUnnecessaryIsInstance=false
"""Checks a call of `export` before anything is traced: the spec, the function and its results. An error is
one sentence."""

from __future__ import annotations

import ast
import inspect
import keyword
import math
import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, cast

import torch
from torch import Tensor, nn

from ..dates import given_time
from ..errors import ExportError
from ..manifest import FORMATS, METHODS
from ..spec import DEFAULT_SYMBOLS, Spec, TensorSpec, Tolerance
from ..text import one_line
from ..tracing.module import results_of

_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z0-9_]+)*")
_VERSION = re.compile(r"[0-9]{1,9}\.[0-9]{1,9}\.[0-9]{1,9}")
_RANK = 8
#: Dtypes that users may have, and what to give an op instead.
_INSTEAD = {
    "uint32": "; convert to int64 before the op, which holds every value",
    "complex64": "; take the real and the imaginary part as two float32 tensors",
    "complex128": "; take the real and the imaginary part as two float64 tensors",
}


def check_call(fn: Any, spec: Any, path: Any, formats: Any, isas: Any, methods: Any) -> None:
    """Reject wrong arguments of `export`."""
    given_time()  # checked here, because it is used only at the end
    if not isinstance(spec, Spec):
        raise ExportError(
            f"spec: expected a chiasm.export.Spec, got {type(spec).__name__}: export(fn, Spec('my.op',"
            " [image()]), folder)"
        )
    if not isinstance(path, (str, Path)) or "\0" in str(path):
        raise ExportError(f"{spec.name}: path: expected the path of a folder (str or Path), got {path!r}")
    from ..isas import ISAS

    for name, given, known in (
        ("formats", formats, FORMATS),
        ("isas", isas, tuple(ISAS)),
        ("methods", methods, METHODS),
    ):
        if not _is_list(given) or not given or any(g not in known for g in given):
            raise ExportError(f"{spec.name}: {name}: expected a sequence of some of {known}, got {given!r}")
    if "forward" not in methods:
        raise ExportError(f"{spec.name}: methods: {tuple(methods)} lacks 'forward', which every bundle has")
    check_spec(spec)
    try:
        _check_function(fn, spec)
    except ExportError:
        raise
    except Exception as error:  # from the attributes of an object of the user's class
        raise ExportError(
            f"{spec.name}: fn: reading the attributes of {type(fn).__name__} raises {type(error).__name__}:"
            f" {one_line(error)}: its __getattr__ should raise AttributeError for a name it does not know"
        ) from error


def check_spec(spec: Spec) -> None:
    """Reject an invalid spec."""
    if not isinstance(spec.name, str) or not _NAME.fullmatch(spec.name) or len(spec.name) > 200:
        raise ExportError(
            "spec: name: expected words of letters, digits and _ joined by dots, such as 'my.op' (at most"
            f" 200 characters), got {spec.name!r}"
        )
    if not isinstance(spec.version, str) or not _VERSION.fullmatch(spec.version):
        raise ExportError(
            f"{spec.name}: version: expected three numbers such as '1.0.0', got {spec.version!r}"
        )
    for text in ("summary", "reference"):
        _text(spec.name, text, getattr(spec, text))
    if not _is_list(spec.dtypes) or not spec.dtypes or any(spec.dtypes.count(d) > 1 for d in spec.dtypes):
        raise ExportError(
            f"{spec.name}: dtypes: expected a tuple of different dtypes such as ('float32',), got"
            f" {spec.dtypes!r}"
        )
    for dtype in spec.dtypes:
        _dtype(spec.name, "dtypes", dtype)
    for name in ("config", "symbols", "tolerances", "gradient_tolerances"):
        if not isinstance(getattr(spec, name), Mapping):
            raise ExportError(
                f"{spec.name}: {name}: expected a dict, got {type(getattr(spec, name)).__name__}"
            )
    for kind, tensors in (("input", spec.inputs), ("output", spec.outputs)):
        if not _is_list(tensors) or not tensors or not all(isinstance(t, TensorSpec) for t in tensors):
            raise ExportError(
                f"{spec.name}: {kind}s: expected at least one TensorSpec in a list ([image()], [frame()],"
                f" [TensorSpec('name', (...))]), got {tensors!r}"
            )
        for tensor in tensors:
            _check_tensor(spec, kind, tensor)
    names = [t.name for t in (*spec.inputs, *spec.outputs)]
    if twice := [n for n in names if names.count(n) > 1]:
        raise ExportError(
            f"{spec.name}: {twice[0]!r} is the name of two tensors: inputs and outputs need different names"
        )
    for symbol in dict.fromkeys(d for t in spec.inputs for d in t.shape if isinstance(d, str)):
        _check_limits(spec, symbol)
    _check_config(spec)
    if spec.gradients is not None and not _is_list(spec.gradients):
        raise ExportError(
            f"{spec.name}: gradients: expected None or a tuple of inputs' names such as ('input',), got"
            f" {spec.gradients!r}"
        )
    floating = [t.name for t in spec.inputs if t.dtype == "T" or "float" in t.dtype]
    if unknown := [g for g in spec.gradients or () if g not in floating]:
        raise ExportError(
            f"{spec.name}: gradients: {unknown[0]!r} is not a floating input (those are {floating})"
        )
    for tolerances in (spec.tolerances, spec.gradient_tolerances):
        for dtype, tolerance in tolerances.items():
            _dtype(spec.name, "tolerances", dtype)
            if not isinstance(tolerance, Tolerance) or not all(
                math.isfinite(v) and v >= 0 for v in (tolerance.atol, tolerance.rtol)
            ):
                raise ExportError(
                    f"{spec.name}: tolerances[{dtype!r}]: expected a Tolerance of numbers from 0, got"
                    f" {tolerance!r}"
                )


def _check_tensor(spec: Spec, kind: str, t: TensorSpec) -> None:
    where = f"{spec.name}: {kind} {t.name!r}"
    if (
        not isinstance(t.name, str)
        or not _WORD.fullmatch(t.name)
        or keyword.iskeyword(t.name)
        or t.name == "self"
    ):
        raise ExportError(f"{where}: a tensor's name is a Python identifier of ASCII letters, digits and _")
    if t.dtype != "T":
        _dtype(spec.name, f"{kind} {t.name!r}", t.dtype)
    if not _is_list(t.shape):
        raise ExportError(
            f"{where}: shape: expected a tuple of numbers and symbols such as ('B', 3, 'H', 'W'), got"
            f" {t.shape!r}"
        )
    if len(t.shape) > _RANK:
        raise ExportError(f"{where}: {len(t.shape)} dimensions, at most {_RANK} are possible")
    for d in t.shape:
        symbol = isinstance(d, str) and _WORD.fullmatch(d) and not keyword.iskeyword(d)
        if not symbol and (isinstance(d, (bool, str)) or not isinstance(d, int) or not 1 <= d <= 2**48):
            raise ExportError(
                f"{where}: shape {tuple(t.shape)}: {d!r} is neither a number from 1 to 2**48 nor a symbol"
                " such as 'H'"
            )
    if (
        not _is_list(t.sizes)
        or len(t.sizes) not in (0, 1, len(t.shape))
        or not all(isinstance(name, str) for name in t.sizes)
    ):
        raise ExportError(
            f"{where}: sizes: expected a tuple of the name of one argument for all sizes, or of one for each"
            f" of the {len(t.shape)}, got {t.sizes!r}"
        )
    for text in ("layout", "color", "description"):
        _text(where, text, getattr(t, text))
    if t.range is not None:
        numbers = (
            isinstance(t.range, (tuple, list))
            and len(t.range) == 2
            and all(isinstance(v, (int, float)) and math.isfinite(v) for v in t.range)
        )
        if not numbers or t.range[0] > t.range[1]:
            raise ExportError(f"{where}: range: expected (least, greatest), got {t.range!r}")
        if t.dtype in _dtypes() and not (t.dtype == "bool" or "float" in t.dtype):
            limits = torch.iinfo(getattr(torch, t.dtype))
            if t.range[0] < limits.min or t.range[1] > limits.max:
                raise ExportError(f"{where}: range {t.range!r} does not fit into {t.dtype}")


def _check_limits(spec: Spec, symbol: str) -> None:
    limits = spec.symbols.get(symbol, DEFAULT_SYMBOLS.get(symbol))
    if limits is None:
        raise ExportError(
            f"{spec.name}: symbol {symbol!r} has no limits: add symbols={{{symbol!r}: (min, max)}} to the"
            " spec"
        )
    pair = (
        isinstance(limits, Sequence)
        and len(limits) == 2
        and all(isinstance(v, int) and not isinstance(v, bool) for v in limits)
    )
    if not pair or not 1 <= limits[0] <= limits[1] < 2**48:
        raise ExportError(
            f"{spec.name}: symbols[{symbol!r}]: expected (min, max) with 1 <= min < max < 2**48, got"
            f" {limits!r}"
        )
    if limits[0] == limits[1]:
        raise ExportError(
            f"{spec.name}: symbols[{symbol!r}]: min and max are both {limits[0]}: write {limits[0]} into the"
            f" shape instead of {symbol!r}"
        )


def _check_config(spec: Spec) -> None:
    for key, value in spec.config.items():
        if (
            not isinstance(key, str)
            or not key.isidentifier()
            or keyword.iskeyword(key)
            or key in {t.name for t in spec.inputs}
        ):
            raise ExportError(
                f"{spec.name}: config: {key!r} is not the name of an argument beside the inputs"
            )
        try:
            literal = ast.literal_eval(repr(value))
            constant = literal == value and _is_setting(literal)
        except (ValueError, SyntaxError):
            constant = False
        if not constant:
            raise ExportError(
                f"{spec.name}: config[{key!r}]: expected a finite number, a string, a bool, None or a tuple"
                f" or list of such, got {value!r}"
                + (": a tensor is an input, or a buffer of a module" if isinstance(value, Tensor) else "")
            )


def _is_setting(literal: object) -> bool:
    """Whether a literal of Python is one of JSON and of TorchScript too: JSON has no sets, bytes and complex
    numbers, TorchScript no dicts of several types."""
    if isinstance(literal, (tuple, list)):
        return all(map(_is_setting, cast("Sequence[object]", literal)))
    return literal is None or isinstance(literal, (int, float, str))


def _is_list(value: Any) -> bool:
    """Whether this is a tuple, a list or the like: a text is one too, but of letters."""
    return isinstance(value, Sequence) and not isinstance(value, (str, bytes))


@cache
def _dtypes() -> tuple[str, ...]:
    from chiasm import _runtime

    return tuple(_runtime.dtypes())


def _dtype(name: str, where: str, dtype: Any) -> None:
    if dtype not in _dtypes():
        raise ExportError(
            f"{name}: {where}: dtype {dtype!r} is not one of"
            f" {', '.join(_dtypes())}{_INSTEAD.get(str(dtype), '')}"
        )


def _text(name: str, what: str, text: Any) -> None:
    try:
        text.encode()
    except (AttributeError, UnicodeEncodeError):
        raise ExportError(f"{name}: {what}: expected text, got {text!r}") from None


def _check_function(fn: Any, spec: Spec) -> None:
    """Reject a function that cannot be called with the spec's inputs and configuration."""
    if not callable(fn) or inspect.isclass(fn):
        hint = f": give an instance, {fn.__name__}(...)" if inspect.isclass(fn) else ""
        raise ExportError(f"{spec.name}: fn: expected a function or a module, got {fn!r}{hint}")
    if inspect.isgeneratorfunction(fn) or inspect.iscoroutinefunction(fn) or inspect.isasyncgenfunction(fn):
        raise ExportError(f"{spec.name}: fn: a generator or coroutine cannot be exported: return tensors")
    is_module = isinstance(fn, nn.Module)
    if is_module:
        _check_module(fn, spec)
    try:
        signature = inspect.signature(fn.forward if is_module else fn)
    except (ValueError, TypeError):  # functions of torch itself have no signature
        return
    parameters = signature.parameters.values()
    if star := [p for p in parameters if p.kind in (p.VAR_POSITIONAL, p.VAR_KEYWORD)]:
        mark = "*" if star[0].kind is inspect.Parameter.VAR_POSITIONAL else "**"
        raise ExportError(
            f"{spec.name}: fn takes {mark}{star[0].name}: name every argument, as in def f(input: Tensor,"
            " sigma: float = 1.0) -> Tensor"
        )
    if only := [p for p in parameters if p.kind is p.POSITIONAL_ONLY and not is_module]:
        raise ExportError(
            f"{spec.name}: fn takes {only[0].name!r} by position only: inputs are passed by name, so remove"
            " the / from its arguments"
        )
    inputs = [name for t in spec.inputs for name in t.sizes or (t.name,)]
    try:
        signature.bind(
            *(inputs if is_module else ()), **({} if is_module else dict.fromkeys(inputs)), **spec.config
        )
    except TypeError as error:
        hint = (
            " (the names of inputs are those of arguments; what is no input needs a default or a place in"
            " config)"
        )
        raise ExportError(
            f"{spec.name}: fn{signature} does not take the spec's inputs {inputs} and configuration"
            f" {sorted(spec.config)}: {error}{'' if is_module else hint}"
        ) from None


def _check_module(module: nn.Module, spec: Spec) -> None:
    """Reject a module that wraps another one, and a module without values (on the meta device)."""
    what = f"{spec.name}: fn ({type(module).__name__})"
    if isinstance(module, (nn.DataParallel, nn.parallel.DistributedDataParallel)):
        raise ExportError(f"{what} has the module inside it: export fn.module")
    if hasattr(module, "_orig_mod"):
        raise ExportError(f"{what} is what torch.compile made of a module: export fn._orig_mod")
    if isinstance(module, torch.jit.ScriptModule) and not isinstance(
        module,
        torch.jit.TopLevelTracedModule,  # pyright: ignore[reportPrivateImportUsage]
    ):
        raise ExportError(f"{what} is what torch.jit.script made of a module: export that module")
    for name, tensor in (*module.named_parameters(), *module.named_buffers()):
        if nn.parameter.is_lazy(tensor):
            raise ExportError(f"{what}: its {name!r} has no shape yet: call it once with an example first")
        if tensor.device.type != "cpu":
            advice = "give it values" if tensor.is_meta else "call fn.cpu()"
            raise ExportError(
                f"{what}: its {name!r} is on the device {tensor.device}, expected cpu: {advice} first"
            )
        if tensor.layout != torch.strided or tensor.is_nested or tensor.is_quantized:
            kind = "nested" if tensor.is_nested else "quantized" if tensor.is_quantized else "sparse"
            raise ExportError(f"{what}: its {name!r} is {kind}, expected a dense tensor: convert it first")
        # torch.export's results are copied, which torch refuses for others
        if type(tensor) is not Tensor and _copy_of(type(tensor)) is _copy_of(Tensor):
            raise ExportError(
                f"{what}: its {name!r} is a {type(tensor).__name__}, expected a torch.Tensor: call"
                " .as_subclass(torch.Tensor) first"
            )


def _copy_of(kind: type) -> Any:
    return inspect.getattr_static(kind, "__deepcopy__")


def check_inputs(
    spec: Spec, inputs: Mapping[str, Tensor], sizes: Mapping[str, int], variant: str | None
) -> None:
    """Reject results of the spec's `make_inputs` that do not match the spec."""
    for t in spec.inputs:
        value, shape = inputs.get(t.name), tuple(sizes[d] if isinstance(d, str) else d for d in t.shape)
        dtype = variant if t.dtype == "T" else t.dtype
        if (
            not isinstance(value, Tensor)
            or tuple(value.shape) != shape
            or value.dtype != getattr(torch, str(dtype))
        ):
            got = f"{value.dtype} {tuple(value.shape)}" if isinstance(value, Tensor) else repr(value)
            raise ExportError(
                f"{spec.name}: make_inputs: input {t.name!r} at sizes {dict(sizes)}: expected {dtype}"
                f" {shape}, got {got}"
            )


def check_results(spec: Spec, result: Any) -> tuple[Tensor, ...]:
    """The op's results as a tuple, or an error that says why they cannot be a bundle's outputs."""
    results = results_of(result)
    for place, value in enumerate(results):
        if not isinstance(value, Tensor):
            raise ExportError(
                f"{spec.name}: the op returns"
                f" {_described(value)}{f' as result {place}' if len(results) > 1 else ''}: {_advice(value)}"
            )
        if value.layout != torch.strided or value.is_quantized or value.device.type != "cpu":
            raise ExportError(
                f"{spec.name}: result {place} is {value.layout} on {value.device}: return dense tensors where"
                " the inputs are"
            )
        if value.dim() > _RANK:
            raise ExportError(
                f"{spec.name}: result {place} has {value.dim()} dimensions, at most {_RANK} are possible"
            )
        _dtype(spec.name, f"result {place}", str(value.dtype).removeprefix("torch."))
    if len(results) != len(spec.outputs):
        raise ExportError(
            f"{spec.name}: the spec names {len(spec.outputs)} outputs, the op returns {len(results)}"
        )
    return results


def _described(value: Any) -> str:
    return "nothing" if value is None else f"a {type(value).__name__}"


def _advice(value: Any) -> str:
    if value is None:
        return "return a tensor, or a tuple of tensors"
    if isinstance(value, Mapping):
        return "return a tuple of its tensors; the spec's outputs give them their names"
    if isinstance(value, (tuple, list)):
        return "return one flat tuple of tensors"
    if isinstance(value, (bool, int, float)):
        return "return a tensor, as torch.tensor or a reduction makes one"
    return "return tensors only"
