"""The module that every format is exported from: the op with its configuration bound and its tensors as named
arguments."""

from __future__ import annotations

import keyword
import linecache
import zlib
from collections.abc import Callable, Sequence
from typing import Any

import torch
from torch import nn

from ..errors import ExportError


def bind(
    fn: Callable | nn.Module,
    arguments: list[str],
    config: dict[str, Any],
    name: str,
    copied: Sequence[bool] = (),
) -> nn.Module:
    """An nn.Module whose `forward(arguments...)` calls `fn` with them and with `config`.

    `copied` says of each result whether it is an input itself, or another result: a graph's outputs are
    tensors of their own.

    It is written as source text because torch.jit.script reads source, and because the arguments' names
    become the tensors' names in ONNX.
    """
    for argument in arguments:
        if not argument.isidentifier() or keyword.iskeyword(argument):
            raise ExportError(f"{name}: input name {argument!r} is not a Python identifier")
    is_module = isinstance(fn, nn.Module)
    passed = [a if is_module else f"{a}={a}" for a in arguments] + [
        f"{k}={v!r}" for k, v in sorted(config.items())
    ]
    callee = "self.fn" if is_module else "_op"
    typed = ", ".join(f"{a}: Tensor" for a in arguments)
    # The class carries the op's name, so that TorchScript's and ONNX's graphs do.
    class_name = "Op_" + "".join(c if c.isalnum() else "_" for c in name)
    call = f"{callee}({', '.join(passed)})"
    lines = [f"return {call}"]
    if any(copied):
        results = [f"_result{i}" for i in range(len(copied))]
        lines = [
            f"{', '.join(results)} = {call}",
            f"return {', '.join(f'{r}.clone()' if c else r for r, c in zip(results, copied, strict=True))}",
        ]
    body = "".join(f"        {line}\n" for line in lines)
    source = f"class {class_name}(nn.Module):\n    def forward(self, {typed}):\n{body}"
    # TorchScript keeps this name in the file, so it must be the same in every export of the same op.
    filename = f"<chiasm {name} {zlib.crc32(source.encode()):08x}>"
    linecache.cache[filename] = (len(source), None, source.splitlines(keepends=True), filename)
    namespace: dict[str, Any] = {"nn": nn, "Tensor": torch.Tensor, "_op": fn, "__name__": "chiasm_op"}
    exec(compile(source, filename, "exec"), namespace)
    module = namespace[class_name]()
    if is_module:
        module.fn = fn
    return module.eval()
