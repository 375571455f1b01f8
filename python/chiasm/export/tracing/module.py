"""The module that every format is exported from: the op with its configuration bound and its tensors as named
arguments."""

from __future__ import annotations

import linecache
import zlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

import torch
from torch import nn

from chiasm.primitives.core.checks import check_rank
from chiasm.primitives.core.layout import in_frames

from ..spec import Spec, TensorSpec


def bind_spec(fn: Callable[..., Any] | nn.Module, spec: Spec, copied: Sequence[bool] = ()) -> nn.Module:
    """An nn.Module whose `forward` takes the spec's inputs, and calls `fn` with them and the configuration.

    An op on planes gets batches of frames as a view (B, C, H, W), and its images are returned as frames. For
    a tensor that stands for sizes, the op gets its shape. `copied` tells for each result whether it is itself
    an input or another result, and must be copied: a graph's outputs must be tensors of their own.
    """
    passed = {t.name: f"{t.name}={t.name}" for t in spec.inputs}
    results = ["{}.clone()" if c else "{}" for c in copied] or ["{}"] * len(spec.outputs)
    checks: list[str] = []
    if spec.interleaved:
        for tensor in spec.inputs:
            if tensor.layout == "NHWC":
                passed[tensor.name] += ".permute(0, 3, 1, 2)"
                checks.append(f"_check_rank({tensor.name}, 4, '(B, H, W, C)', '{tensor.name}')")
        results = [
            f"_in_frames({result})" if t.layout == "NHWC" else result
            for t, result in zip(spec.outputs, results, strict=True)
        ]
    for tensor in spec.inputs:
        if tensor.sizes:
            passed[tensor.name] = _sizes(tensor)
    return bind(fn, passed, spec.config, spec.name, results, checks)


def results_of(returned: Any) -> tuple[Any, ...]:
    """What an op returns, as a tuple: its one result, or its results."""
    return tuple(cast("Sequence[Any]", returned)) if isinstance(returned, (tuple, list)) else (returned,)


def _sizes(tensor: TensorSpec) -> str:
    """The op's arguments that get the sizes of a tensor's shape, as text."""
    numbers = [f"{tensor.name}.shape[{i - len(tensor.shape)}]" for i in range(len(tensor.shape))]
    if len(tensor.sizes) == 1:
        return f"{tensor.sizes[0]}=({', '.join(numbers)})"
    return ", ".join(f"{name}={number}" for name, number in zip(tensor.sizes, numbers, strict=True))


def bind(
    fn: Callable[..., Any] | nn.Module,
    arguments: Mapping[str, str],
    config: dict[str, Any],
    name: str,
    results: Sequence[str] = (),
    checks: Sequence[str] = (),
) -> nn.Module:
    """An nn.Module whose `forward(arguments...)` calls `fn` with them and with `config`.

    `arguments` has, for each argument, the text that is passed to `fn` ("x=x"; a module takes them by
    position); `results` has the text that is returned for each result `{}`, and `checks` the statements
    before the call. All of it is source text because torch.jit.script reads that, and because the arguments'
    names become the tensors' names in ONNX.
    """
    is_module = isinstance(fn, nn.Module)
    passed = [text.partition("=")[2] if is_module else text for text in arguments.values()]
    passed += [f"{k}={v!r}" for k, v in sorted(config.items())]
    callee = "self.fn" if is_module else "_op"
    typed = ", ".join(f"{a}: Tensor" for a in arguments)
    # The class has the op's name, so that TorchScript's and ONNX's graphs have it too.
    class_name = "Op_" + "".join(c if c.isalnum() else "_" for c in name)
    call = f"{callee}({', '.join(passed)})"
    lines = [*checks, f"return {call}"]
    if any(result != "{}" for result in results):
        names = [f"_result{i}" for i in range(len(results))]
        returned = [result.format(name) for name, result in zip(names, results, strict=True)]
        lines = [*checks, f"{', '.join(names)} = {call}", f"return {', '.join(returned)}"]
    body = "".join(f"        {line}\n" for line in lines)
    source = f"class {class_name}(nn.Module):\n    def forward(self, {typed}):\n{body}"
    # TorchScript keeps this name in the file, so it must be the same in every export of the same op.
    filename = f"<chiasm {name} {zlib.crc32(source.encode()):08x}>"
    linecache.cache[filename] = (len(source), None, source.splitlines(keepends=True), filename)
    namespace: dict[str, Any] = {
        "nn": nn,
        "Tensor": torch.Tensor,
        "_op": fn,
        "_check_rank": check_rank,
        "_in_frames": in_frames,
        "__name__": "chiasm_op",
    }
    exec(compile(source, filename, "exec"), namespace)
    module = namespace[class_name]()
    if is_module:
        module.fn = fn
    return module.eval()
