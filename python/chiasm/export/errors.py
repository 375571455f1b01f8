"""The one exception of the exporter, and how it finds the user's own line in an engine's traceback."""

from __future__ import annotations

import importlib.util
import linecache
import re
import sysconfig
import traceback
from collections.abc import Sequence
from pathlib import Path

from .text import plain, words

_EXPORT = str(Path(__file__).resolve().parent)
_PACKAGES = (
    "torch",
    "numpy",
    "scipy",
    "cv2",
    "PIL",
    "onnx",
    "onnxscript",
    "onnx_ir",
    "sympy",
    "click",
    "jsonschema",
    "safetensors",
)


def _folder(package: str) -> str | None:
    try:
        spec = importlib.util.find_spec(package)
    except ValueError:  # a stub in sys.modules, as tests and builds of documentation put there
        return None
    return str(Path(spec.origin).parent) if spec and spec.origin else None


_ENGINE_ROOTS = (
    _EXPORT,
    "<chiasm",
    "<eval_with_key>",
    "<frozen",
    "<__array_function__",
    *filter(None, map(_folder, _PACKAGES)),
)
_LIBRARY = sysconfig.get_paths()["stdlib"]
#: Errors of engines, and what to do about each.
_REMEDIES = (
    (
        r"No space left on device|File too large|Disk quota exceeded|inline_container.*unexpected pos",
        "instead: make room on the disk, or set TMPDIR to a folder that has some (see also ulimit -f)",
    ),
    (
        r"\.numpy\(\) is not supported|array\(\)|__array__|numpy",
        (
            "instead: NumPy cannot be exported: use the function of torch that does the same (torch.quantile"
            " for np.percentile)"
        ),
    ),
    (
        r"data-dependent|on.*[Tt]ensor.*bool|control flow",
        "instead: choose by torch.where(condition, a, b): a graph has no branches that data decide",
    ),
    (
        r"No ONNX function found for .*aten\._?(linalg|cholesky|lu_|triangular|matrix)",
        "instead: leave ONNX out (formats=('torchscript', 'native')): it has no operators for linear algebra,"
        " or write a small matrix's case as arithmetic on its elements",
    ),
    (
        r"found type '(Tuple|List)\[.*NoneType",
        "instead: give the size in place of None: TorchScript takes [7, input.shape[3]], and not (7, None)",
    ),
    (
        r"Expected a single top-level function",
        "instead: write a function with def and typed arguments: TorchScript cannot read a lambda",
    ),
    (
        r"qualified name|source.*(not|access)|get (the )?source",
        (
            "instead: put the function into a file: TorchScript reads its source text, which an interactive"
            " session does not have"
        ),
    ),
    (
        r"Could not export Python function call",
        "instead: write it with torch's own functions: TorchScript cannot hold an autograd.Function",
    ),
    (
        r"variable number of arguments|keyword-only|\*args|\*\*kwargs|vararg",
        "instead: name every argument: def f(input: Tensor, sigma: float = 1.0) -> Tensor",
    ),
    (
        r"because it was not annotated|was not annotated with an explicit type",
        "instead: give the argument its type: `k: float = 2.0`; what has none is taken for a tensor",
    ),
)
#: The remedy for `torch.cond` and `torch.while_loop`, which are traced where the op is only called.
_TRACED = (
    "instead: torch.cond and torch.while_loop cannot be exported: choose by torch.where(condition, a, b), and"
    " repeat a step by chiasm.primitives.core.loops, repeated or until_stable"
)
_ROUNDED = re.compile(r"round\(|trunc|ceil|floor\(|sym_float| / ")
#: The remedy for a size that is rounded.
SIZES = (
    "instead: sizes may be computed with + - * // only: take a size that is rounded from another input "
    "(as geometry.transform.resize does), or write fixed sizes into the input's shape"
)
_LIMITS = (
    "instead: narrow the symbols' limits in the spec (symbols={...}), or write the size into the input's"
    " shape"
)


class ExportError(RuntimeError):
    """An op could not be exported: the message says to which format, at which line or operator, and why."""


def explain(
    name: str,
    target: str | None,
    error: BaseException,
    guards: Sequence[tuple[object, str]] = (),
    shapes: str = "",
) -> ExportError:
    """An ExportError that names the line of the user's code, or the operator, that `error` comes from, and
    what to do if that is known.

    `target` is what was being exported to; None means that the op itself failed, in eager PyTorch, with
    inputs of `shapes`. `guards` are a trace's assumptions about sizes, each with the user's line that caused
    it.
    """
    text = plain(words(error))
    assumed = _assumption(text, guards) if "Constraints violated" in text else None
    where = assumed or _line(error, text)
    operator = _operator(text)
    traced = target is None and type(error).__module__.startswith("torch._dynamo")
    parts = [f"{name}: the op fails when it is called, with {shapes}"]
    if target or traced:
        parts = [f"{name}: cannot be exported{f' to {target}' if target else ''}"]
    if where:
        parts.append(f"  at {where}")
    if operator:
        parts.append(f"  operator {operator}")
    because = [type(error).__name__] if target is None or not text.strip() else []
    parts.append(f"  because: {': '.join([*because, *filter(None, [_reason(text)])])}")
    if traced:
        parts.append(f"  {_TRACED}")
    elif target and (remedy := _remedy(text)):
        parts.append(f"  {remedy}")
    return ExportError("\n".join(parts))


def own_line(frames: Sequence[traceback.FrameSummary]) -> str | None:
    """The innermost line of the op in a stack, quoted; None if the op has no lines of its own (a
    Sequential)."""
    # The exporter's callers come first, then the module that the exporter generated for the op.
    marks = [i for i, f in enumerate(frames) if f.filename.startswith("<chiasm")] or [
        i for i, f in enumerate(frames) if f.filename.startswith(_EXPORT)
    ][:1]
    marks = marks or [i for i, f in enumerate(frames) if _is_engine(f.filename)][:1]
    own = [f for f in frames[marks[-1] :] if not _is_engine(f.filename)] if marks else []
    return _quote(own[-1].filename, own[-1].lineno or 0) if own else None


def quoted_line(text: str, last: bool = False) -> str | None:
    """The first (or last) line of the user's code that an engine quotes in a text."""
    own = [
        (file, int(number))
        for file, number in re.findall(r'File "([^"]+)", line (\d+)', text)
        if not _is_engine(file)
    ]
    return _quote(*own[-1 if last else 0]) if own else None


def _line(error: BaseException, text: str) -> str | None:
    # TorchScript and torch.export quote the user's stack in the message, torch.export's innermost last.
    if quoted := quoted_line(text, last="torch.jit" not in type(error).__module__):
        return quoted
    chain: BaseException | None = error
    while chain is not None:
        if found := own_line(traceback.extract_tb(chain.__traceback__)):
            return found
        chain = chain.__cause__ or chain.__context__
    return None


def _is_engine(filename: str) -> bool:
    if filename.startswith(_ENGINE_ROOTS) or str(Path(filename).resolve()).startswith(_ENGINE_ROOTS):
        return True
    return filename.startswith(_LIBRARY) and "site-packages" not in filename


def _quote(filename: str, number: int) -> str:
    source = linecache.getline(filename, number).strip()
    return f"{filename}:{number}: {source}" if source else f"{filename}:{number}"


def _assumption(text: str, guards: Sequence[tuple[object, str]]) -> str | None:
    """The line that made the assumption which is violated."""
    constant = re.search(r"to be a constant \((\d+)\)", text)
    telling = (
        ["Round|Trunc|Ceil", "TrueDiv|Floor|ToFloat"]
        if _ROUNDED.search(text)
        else [rf"\b{constant[1]}\b"]
        if constant
        else []
    )
    for pattern in (*telling, ""):
        if found := next((line for expression, line in guards if re.search(pattern, str(expression))), None):
            return found
    return None


def _operator(text: str) -> str | None:
    for pattern in (
        r"No ONNX function found for <OpOverload\(op='([^']+)'",
        r"undefined symbol: (aoti_torch_\w+)",
        r"(aten[.:]+\w+(?:\.\w+)?)",
    ):
        found = re.search(pattern, text)
        if found:
            return found.group(1)
    return None


def _reason(text: str) -> str:
    """The first informative lines."""
    lines = [line.strip() for line in text.splitlines()]
    if "Constraints violated" in text:
        # torch.export lists the code's assumptions about a dimension, once per use
        facts = [line[2:].split(" If you're using")[0] for line in lines if line.startswith("- ")]
        fact = re.sub(r"L\['(\w+)'\]\.size\(\)\[(\d+)\]", r"\1.shape[\2]", facts[0] if facts else "")
        fact = re.sub(r"torch\.sym_float\(([^()]*)\)", r"\1", fact)
        return f"the code does not allow every size that the spec's symbols do: {fact}"
    if summary := re.search(r"## Exception summary\s+<class '[^']+'>: (.+)", text):
        return re.sub(r"<OpOverload\(op='([^']+)'.*?\)>.*", r"\1", summary[1])
    if text.startswith("C++ compile error") and (said := text.partition("Output:")[2].strip().splitlines()):
        return f"C++ compile error: {next((line for line in said if 'error' in line.lower()), said[0])}"
    useful = [
        line
        for line in lines
        if line and not line.startswith(("File ", "From user code", "from user code", "⬆", "<class", "## "))
    ]
    cause = next((line for line in useful if "Caused by" in line or "not supported" in line.lower()), None)
    head = useful[0] if useful else ""
    return head if cause is None or cause == head else f"{head} ({cause})"


def _remedy(text: str) -> str | None:
    if "Constraints violated" in text:
        return SIZES if _ROUNDED.search(text) else _LIMITS
    return next((remedy for pattern, remedy in _REMEDIES if re.search(pattern, text)), None)
