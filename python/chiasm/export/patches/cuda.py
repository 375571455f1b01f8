# What is patched is private, and most of it without types; and PyTorch declares narrower parameter types than
# it uses.
# pyright: reportPrivateUsage=false, reportPrivateImportUsage=false, reportUnknownMemberType=false
# pyright: reportMissingTypeStubs=false
# pyright: reportArgumentType=false, reportAttributeAccessIssue=false
"""AOTInductor for a GPU that this machine does not have. Triton's compiler needs no GPU, and the answers to
PyTorch's queries follow from the compute capability. So CUDA code can be compiled on the machine that
compiles CPU code.

Without a GPU nothing is timed: if a loop has several forms, Inductor's first one is used.
"""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from functools import cache, reduce
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import sympy
import torch
from torch.export import ExportedProgram
from torch.export.graph_signature import InputKind, OutputKind
from torch.utils import _pytree as pytree

from ..formats.index_ranges import IndexRanges
from . import replaced
from .index_checks import checked_propagation, indirect_indexing_with, without_runtime_checks

#: By compute capability: shared memory that a block may have, in KiB, and threads of a multiprocessor (CUDA
#: C++ Programming Guide, "Technical Specifications per Compute Capability"); multiprocessors of a large GPU.
_LIMITS = {
    80: (163, 2048, 108),
    86: (99, 1536, 84),
    89: (99, 1536, 128),
    90: (227, 2048, 132),
    100: (227, 2048, 148),
    120: (99, 1536, 170),
}
_DEVICE = torch.device("cuda", 0)
#: Sizes of the example from `_FEW` on represent sizes that are larger by the factor `_ENLARGED`: those of
#: images, or of as many points.
_FEW, _ENLARGED = 10, 32


class _Driver:
    """The methods of Triton's driver that it calls while it compiles."""

    def __init__(self, sm: int) -> None:
        self.sm = sm

    def get_current_target(self) -> Any:
        from triton.backends.compiler import GPUTarget

        return GPUTarget("cuda", self.sm, 32)

    def get_current_device(self) -> int:
        return 0

    def get_active_torch_device(self) -> torch.device:
        return _DEVICE


class _OnDevice(torch.Tensor):
    """A constant for the GPU: its data is here, and goes to the device when the artifact is loaded."""

    data_here: torch.Tensor

    @staticmethod
    def __new__(cls: type[_OnDevice], data: torch.Tensor) -> _OnDevice:
        made: Any = torch.Tensor._make_wrapper_subclass(cls, data.shape, dtype=data.dtype, device=_DEVICE)
        made.data_here = data.contiguous().clone()
        return made

    def untyped_storage(self) -> torch.UntypedStorage:
        return self.data_here.untyped_storage()

    @classmethod
    def __torch_dispatch__(cls, function: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        raise RuntimeError(f"{function} asks for a constant of the GPU, which is not here")


def _constant_on_device(constant: Any, device: torch.device | None) -> Any:
    """For `ConstantBuffer.constant_to_device`."""
    from torch._inductor import ir
    from torch._inductor.virtualized import V

    name, layout = constant.get_name(), constant.get_layout()
    if device in (None, layout.device):
        return constant
    with torch.utils._python_dispatch._disable_current_modes():
        moved = V.graph.allocate_non_dup_const_name(f"{name}_on_device", _OnDevice(V.graph.constants[name]))
    return ir.ConstantBuffer(name=moved, layout=ir.FixedLayout(device, layout.dtype, layout.size))


class _LargeSizes:
    """A trace's symbols with larger hints, because Triton's block sizes depend on the example, which is
    small."""

    def __init__(self, environment: Any) -> None:
        self._environment = environment
        self.backed_var_to_val = {
            symbol: size
            if size < _FEW
            else sympy.Integer(min(size * _ENLARGED, environment.var_to_range[symbol].upper))
            for symbol, size in environment.backed_var_to_val.items()
        }

    def __getattr__(self, name: str) -> Any:
        return getattr(self._environment, name)


@contextmanager
def gpu_compiler(sm: int, toolkit: Path) -> Generator[None]:
    """Let AOTInductor compile for GPUs of compute capability `sm`, with CUDA's headers from
    `toolkit`/include."""
    from torch._inductor import sizevars
    from torch._inductor.codegen.block_analysis import BlockPatternMatcher
    from torch._inductor.fx_passes import joint_graph
    from torch._inductor.runtime.triton_heuristics import CachingAutotuner
    from triton.runtime import driver

    properties = _properties(sm)
    joint_patterns, hint = joint_graph.lazy_init, sizevars._optimization_hint_base
    compile_all = CachingAutotuner.precompile
    match_blocks = BlockPatternMatcher.match_mod_div_block_expr.__func__
    before = driver.active if driver._active is not None else None
    ranges = IndexRanges()

    large: dict[int, _LargeSizes] = {}

    def hint_at_images(environment: Any, *args: Any, **kwargs: Any) -> int:
        known = large.get(id(environment))
        if known is None or len(known.backed_var_to_val) != len(environment.backed_var_to_val):
            known = large[id(environment)] = _LargeSizes(environment)
        return hint(known, *args, **kwargs)

    @cache
    def blocks_of(matcher: Any, *of: Any) -> tuple[list[sympy.Expr], ...] | None:
        return match_blocks(matcher, *of)

    def match_once(matcher: Any, *of: Any) -> tuple[list[sympy.Expr], ...] | None:
        found = blocks_of(matcher, *of)
        return None if found is None else tuple(map(list, found))

    def compile_first(loop: Any, *args: Any, **kwargs: Any) -> None:
        loop.configs = loop.configs[:1]
        compile_all(loop, *args, **kwargs)

    def nothing(*_: Any) -> None: ...

    def zero(*_: Any) -> int:
        return 0

    def known(*_: Any) -> SimpleNamespace:
        return properties

    def capability(*_: Any) -> tuple[int, int]:
        return divmod(sm, 10)

    def random_state(*_: Any) -> torch.Tensor:
        return torch.get_rng_state()

    def joint_patterns_of_cpu(*_: Any) -> Any:
        return joint_patterns(torch.device("cpu"))

    cuda = "torch._dynamo.device_interface:CudaInterface"
    wrapper = "torch._inductor.codegen.wrapper:PythonWrapperCodegen"
    blocks = "torch._inductor.codegen.block_analysis:BlockPatternMatcher"
    with replaced(
        {
            "torch.cuda:is_available": lambda: True,
            "torch.cuda:device_count": lambda: 1,
            "torch.cuda:current_device": zero,
            "torch.cuda:get_device_properties": known,
            "torch.cuda:get_device_capability": capability,
            "torch.cuda:synchronize": nothing,
            "torch.cuda:get_rng_state": random_state,
            "torch.cuda:set_rng_state": nothing,
            "torch.cuda:_exchange_device": zero,
            "torch.cuda:_maybe_exchange_device": zero,
            f"{cuda}.get_device_properties": staticmethod(known),
            f"{cuda}.current_device": staticmethod(zero),
            f"{cuda}.device_count": staticmethod(lambda: 1),
            f"{cuda}.synchronize": staticmethod(nothing),
            f"{cuda}.exchange_device": staticmethod(zero),
            f"{cuda}.maybe_exchange_device": staticmethod(zero),
            f"{cuda}.get_raw_stream": staticmethod(zero),
            f"{cuda}.Worker.get_device_properties": staticmethod(known),
            f"{cuda}.Worker.current_device": staticmethod(zero),
            "torch._subclasses.fake_tensor:init_gpu_context": nothing,
            "torch._subclasses.fake_tensor:FakeTensorMode.avoid_device_init": property(lambda _: True),
            "torch._inductor.ir:ConstantBuffer.constant_to_device": _constant_on_device,
            "torch._inductor.fx_passes.joint_graph:lazy_init": joint_patterns_of_cpu,
            "torch._inductor.runtime.triton_helpers:set_driver_to_gpu": nothing,
            "triton.compiler.compiler:CompiledKernel._init_handles": nothing,
            "triton.compiler.compiler:CompiledKernel.run": property(nothing),
            f"{wrapper}.generate_and_run_autotune_block": _compile,
            "torch._inductor.runtime.triton_heuristics:CachingAutotuner.precompile": compile_first,
            "torch._inductor.codegen.triton:signature_to_meta": _with_short_sizes,
            f"{blocks}.match_mod_div_block_expr": classmethod(match_once),
            "torch._inductor.codegen.triton:TritonPrinter._print_min_max_helper": _extreme,
            "torch._inductor.sizevars:_optimization_hint_base": hint_at_images,
            "torch.utils.cpp_extension:CUDA_HOME": str(toolkit),
            "torch._inductor.codegen.common:CSEProxy.indirect_indexing": indirect_indexing_with(
                ranges, _clamped
            ),
            "torch._inductor.index_propagation:IndexPropagation.indirect_indexing": checked_propagation(),
            "torch._inductor.codegen.cpp_wrapper_cpu:CppWrapperCpu._write_aoti_interface_header": nothing,
            "torch._inductor.codegen.cpp_wrapper_cpu:CppWrapperCpu.generate_input_output_runtime_checks": (
                without_runtime_checks
            ),
        }
    ):
        _forget_answers()
        driver.set_active(_Driver(sm))
        try:
            yield
        finally:
            _forget_answers()
            if before is not None:
                driver.set_active(before)
            else:
                driver._active = None


def _forget_answers() -> None:
    """Clear PyTorch's caches of GPU queries, most of which it makes once per process."""
    from torch._inductor import utils
    from torch._inductor.codegen.cuda import cuda_env
    from torch._inductor.runtime.hints import DeviceProperties
    from torch.utils import _triton

    found: list[Any] = [value for module in (utils, cuda_env, _triton) for value in vars(module).values()]
    found.append(DeviceProperties.create.__func__)
    for function in found:
        if hasattr(function, "cache_clear"):
            function.cache_clear()


def _properties(sm: int) -> SimpleNamespace:
    """The result of torch.cuda.get_device_properties."""
    shared, threads, count = _LIMITS[sm]
    return SimpleNamespace(
        name=f"sm_{sm}",
        major=sm // 10,
        minor=sm % 10,
        multi_processor_count=count,
        regs_per_multiprocessor=65536,
        max_threads_per_multi_processor=threads,
        max_threads_per_block=1024,
        warp_size=32,
        shared_memory_per_block=48 << 10,
        shared_memory_per_block_optin=shared << 10,
        shared_memory_per_multiprocessor=(shared + 1) << 10,
        total_memory=16 << 30,
        L2_cache_size=32 << 20,
        is_integrated=0,
    )


def _compile(wrapper: Any) -> None:
    """Compile the loops, instead of timing their forms as Inductor would."""
    from torch._inductor.runtime.triton_heuristics import CachingAutotuner

    wrapper.kernel_autotune_defs.splice("async_compile.wait(globals())\ndel async_compile\n")
    scope: dict[str, Any] = {}
    exec(wrapper.kernel_autotune_defs.getvalue(), scope)
    for loop in scope.values():
        if isinstance(loop, CachingAutotuner):
            loop.save_gpu_kernel("stream", loop.launchers[0])


def _with_short_sizes(*args: Any, **kwargs: Any) -> dict[str, str]:
    """The types of a program's arguments: if positions have 32 bits, sizes do too."""
    from torch._inductor.codegen.triton_utils import signature_to_meta

    found = signature_to_meta(*args, **kwargs)
    if kwargs.get("size_dtype") == "tl.int32":
        found = {name: "i32" if name.startswith("ks") and of == "i64" else of for name, of in found.items()}
    return found


def _extreme(printer: Any, expression: sympy.Expr, comparison: str) -> str:
    """The least or greatest of expressions, by one instruction."""
    function = "tl.minimum" if comparison == "<" else "tl.maximum"
    return reduce(lambda a, b: f"{function}({a}, {b})", map(printer._print, expression.args))


def _clamped(kernel: Any, index: Any, size: Any, wrapped: bool) -> str:
    """The Triton expression for `index`, clamped to the nearest element of its axis: a run returns before its
    loops have read the data, so it cannot report an error."""
    limit = kernel.index_to_str(kernel.rename_indexing(sympy.sympify(size)))
    return f"tl.minimum(tl.maximum({index}, 0), {limit} - 1)"


def on_gpu(program: ExportedProgram) -> None:
    """Change a program on CPU tensors to one on GPU tensors. Its results become dense tensors."""
    aten = torch.ops.aten
    signature = program.graph_signature
    constants = {
        s.arg.name
        for s in signature.input_specs
        if s.kind is not InputKind.USER_INPUT and hasattr(s.arg, "name")
    }
    for module in program.graph_module.modules():
        if isinstance(module, torch.fx.GraphModule):
            for node in module.graph.nodes:
                if "device" in node.kwargs:
                    node.kwargs = {**node.kwargs, "device": _DEVICE}
                if node.target is aten.to.device:
                    node.args = (node.args[0], _DEVICE, *node.args[2:])
                if not (node.op == "placeholder" and node.name in constants) and node.op != "get_attr":
                    node.meta["val"] = pytree.tree_map_only(torch.Tensor, _moved, node.meta.get("val"))
    graph = program.graph
    inputs = [n for n in graph.nodes if n.op == "placeholder"]
    values = {
        k: v for k, v in (program.state_dict | program.constants).items() if isinstance(v, torch.Tensor)
    }
    for spec in signature.input_specs:
        node = next(n for n in inputs if n.name == spec.arg.name)
        if node.name not in constants or not isinstance(node.meta.get("val"), torch.Tensor):
            continue
        value: Any = values[str(spec.target)]
        if value.numel() == 1:  # PyTorch would copy it immediately, on the GPU
            options = {"dtype": value.dtype, "device": _DEVICE}
            _replaced(graph, node, inputs[-1], aten.full.default, (list(value.shape), value.item()), options)
        else:
            _replaced(graph, node, inputs[-1], aten._to_copy.default, (node,), {"device": _DEVICE})
    output = next(iter(reversed(graph.nodes)))
    for result, spec in zip(output.args[0], signature.output_specs, strict=True):
        if spec.kind is OutputKind.USER_OUTPUT and isinstance(result, torch.fx.Node):
            options = {"memory_format": torch.contiguous_format}
            copy = _replaced(graph, result, output.prev, aten.clone.default, (result,), options, only=output)
            spec.arg.name = copy.name
    program.graph_module.recompile()
    examples = tuple(n.meta["val"] for n in inputs if n.name in signature.user_inputs)
    program._example_inputs = (examples, {})


def _moved(tensor: torch.Tensor) -> torch.Tensor:
    with tensor.fake_mode:
        return torch.empty_strided(tensor.shape, tensor.stride(), dtype=tensor.dtype, device=_DEVICE)


def _replaced(
    graph: torch.fx.Graph,
    node: torch.fx.Node,
    place: torch.fx.Node,
    target: Any,
    args: tuple[Any, ...],
    options: dict[str, Any],
    only: torch.fx.Node | None = None,
) -> torch.fx.Node:
    """Insert `target(*args, **options)` after `place`, and use it in place of `node`, in `only` or in all
    users."""
    with graph.inserting_after(place):
        new = graph.call_function(target, args, options)
    value = node.meta["val"]
    with value.fake_mode:
        strides = torch.empty(value.shape, device="meta").stride()
        new.meta = {"val": torch.empty_strided(value.shape, strides, dtype=value.dtype, device=_DEVICE)}
    node.replace_all_uses_with(new, lambda user: user is not new and (only is None or user is only))
    return new
