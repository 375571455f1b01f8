"""chiasm's own contenders: eager Python, and the bundle in ONNX Runtime and as native code."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from bench.images.ops import Agreement
from bench.wheel import onnx_options, room

from .ways import Images, Ready, Setup, Way

EAGER, FLAT, FUSED, NATIVE = (
    "chiasm eager",
    "chiasm in ONNX Runtime",
    "chiasm in ONNX Runtime, plug-in",
    "chiasm native",
)


def ways(bundle: str, eager: Callable[[Setup], Callable], frames: bool, agrees: Agreement) -> dict[str, Way]:
    """`eager(setup)` is the function of tensors from which the bundle was exported; `frames`: whether it
    takes one camera frame, not a batch."""

    def inputs(images: Images) -> list[np.ndarray]:
        return images.frames if frames else [images.floats]

    def planes(results: Iterable[np.ndarray]) -> np.ndarray:
        together = np.concatenate([r[None, None] if r.ndim == 2 else r for r in results])
        return together.astype(np.float32, copy=False)

    def in_eager(images: Images, setup: Setup) -> Ready:
        import torch

        torch.set_num_threads(setup.threads)
        tensors, function = [torch.from_numpy(x) for x in inputs(images)], eager(setup)

        def call() -> list[torch.Tensor]:
            with torch.inference_mode():
                return [function(t) for t in tensors]

        return Ready(call, lambda results: planes([r.numpy() for r in results]))

    def in_onnx_runtime(fused: bool) -> Callable[[Images, Setup], Ready]:
        def make(images: Images, setup: Setup) -> Ready:
            import chiasm.onnx

            session = chiasm.onnx.session(
                setup.bundles / f"{bundle}.chiasm", fused=fused, options=onnx_options(setup.threads)
            )
            bindings, outputs = zip(*(_bound(session, x) for x in inputs(images)), strict=True)

            def call(given=images) -> tuple[np.ndarray, ...]:  # keeps the bound memory alive
                for binding in bindings:
                    session.run_with_iobinding(binding)
                return outputs

            return Ready(call, planes)

        return make

    def natively(images: Images, setup: Setup) -> Ready:
        import chiasm.runtime

        if chiasm.runtime.get_num_threads() != setup.threads:  # it cannot change after a method is loaded
            chiasm.runtime.set_num_threads(setup.threads)
        method = chiasm.runtime.open(setup.bundles / f"{bundle}.chiasm").method("forward", backend="native")
        given = inputs(images)
        outputs = [room(method, [x]) for x in given]

        def call() -> None:
            for x, out in zip(given, outputs, strict=True):
                method.run_into([x], out)

        return Ready(call, lambda _: planes([out[0] for out in outputs]))

    contenders = {
        EAGER: in_eager,
        FLAT: in_onnx_runtime(fused=False),
        FUSED: in_onnx_runtime(fused=True),
        NATIVE: natively,
    }
    return {name: Way(make, agrees) for name, make in contenders.items()}


def _bound(session: Any, x: np.ndarray) -> tuple[Any, np.ndarray]:
    """A binding of a session's one input to x, and of its one output to memory that is reused."""
    source, target = session.get_inputs()[0], session.get_outputs()[0]
    output = np.empty_like(session.run(None, {source.name: x})[0])
    binding = session.io_binding()
    binding.bind_input(source.name, "cpu", 0, x.dtype, x.shape, x.ctypes.data)
    binding.bind_output(target.name, "cpu", 0, output.dtype, output.shape, output.ctypes.data)
    return binding, output
