"""The one exception of the exporter, and how it finds the user's own line in an engine's long story."""

from __future__ import annotations

import re
import traceback
from pathlib import Path

import torch

_ENGINE_ROOTS = (str(Path(torch.__file__).parent), str(Path(__file__).resolve().parent), "<chiasm", "<eval_with_key>", "<string>")


class ExportError(RuntimeError):
    """An op could not be exported: the message says to which format, at which line or operator, and why."""


def explain(name: str, target: str, error: BaseException) -> ExportError:
    """An ExportError that names the line of the user's code, or the operator, that `error` comes from."""
    text = str(error)
    where = _line(error, text)
    operator = _operator(text)
    parts = [f"{name}: cannot be exported to {target}"]
    if where:
        parts.append(f"  at {where}")
    if operator:
        parts.append(f"  operator {operator}")
    parts.append(f"  because: {_reason(text) or type(error).__name__}")
    return ExportError("\n".join(parts))


def _line(error: BaseException, text: str) -> str | None:
    # TorchScript and torch.export quote the user's stack in the message, innermost last.
    quoted = [
        (file, int(number))
        for file, number in re.findall(r'File "([^"]+)", line (\d+)', text)
        if not _is_engine(file)
    ]
    if quoted:
        return _quote(*quoted[0 if "torch.jit" in type(error).__module__ else -1])
    chain: BaseException | None = error
    while chain is not None:
        # The frames that called the exporter come first; the op's own come last, below the engine's.
        frames = traceback.extract_tb(chain.__traceback__)
        entered = next((i for i, f in enumerate(frames) if _is_engine(f.filename)), len(frames))
        own = [f for f in frames[entered:] if not _is_engine(f.filename)]
        if own:
            return _quote(own[-1].filename, own[-1].lineno or 0)
        chain = chain.__cause__ or chain.__context__
    return None


def _is_engine(filename: str) -> bool:
    if filename.startswith(_ENGINE_ROOTS) or str(Path(filename).resolve()).startswith(_ENGINE_ROOTS):
        return True
    return any(part in filename for part in ("/onnxscript/", "/onnx_ir/", "/sympy/", "/contextlib.py", "/concurrent/", "/functools.py"))


def _quote(filename: str, number: int) -> str:
    try:
        source = Path(filename).read_text().splitlines()[number - 1].strip()
    except (OSError, IndexError):
        return f"{filename}:{number}"
    return f"{filename}:{number}: {source}"


def _operator(text: str) -> str | None:
    for pattern in (r"No ONNX function found for <OpOverload\(op='([^']+)'", r"undefined symbol: (aoti_torch_\w+)", r"(aten[.:]+\w+(?:\.\w+)?)"):
        found = re.search(pattern, text)
        if found:
            return found.group(1)
    return None


def _reason(text: str) -> str:
    """The first lines that say something."""
    lines = [line.strip() for line in text.splitlines()]
    if "Constraints violated" in text:
        # torch.export lists what the code assumed of a dimension, once per use
        facts = [line[2:].split(" If you're using")[0] for line in lines if line.startswith("- ")]
        return "; ".join(["the code does not allow every size that the spec's symbols do", *dict.fromkeys(facts)])
    useful = [line for line in lines if line and not line.startswith(("File ", "From user code", "from user code", "⬆", "<class", "## "))]
    cause = next((line for line in useful if "Caused by" in line or "not supported" in line.lower()), None)
    head = useful[0] if useful else ""
    return head if cause is None or cause == head else f"{head} ({cause})"
