"""The parts of PyTorch and onnxscript that chiasm replaces during an export, for the versions in `VERSIONS`.

Each replacement is declared here, with its reason and a digest of the source that it replaces. `replaced`
accepts only declared replacements. `tests/export/test_patches.py` compares the digests with the installed
packages: an upgrade that changes one of the sources fails there. Then read the new source and adapt the
replacement before you record its digest.

| module | replaces |
|---|---|
| `tracing.py` | parts of torch.export: speed, and what its errors need |
| `inductor.py` | parts of AOTInductor: speed, the compiler, minima without NaN |
| `index_checks.py` | AOTInductor's indices and divisors that come from data: checked |
| `cuda.py` | what AOTInductor asks a GPU, while it compiles for one |
| `onnx.py` | parts of torch.onnx: speed, exact constants |
| `recurrent.py` | how torch.export finds the shapes of recurrent layers' results |
"""

from __future__ import annotations

import hashlib
import importlib
import inspect
from collections.abc import Generator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any, NamedTuple, cast
from unittest.mock import patch

#: The packages that the replacements were written for.
VERSIONS = {"torch": "2.13", "onnxscript": "0.7"}


class Patch(NamedTuple):
    """A replacement: why it is there, and the first digits of SHA-256 of the source that it replaces
    (`source_digest`)."""

    reason: str
    source: str


#: By `module:attribute`.
PATCHES: Mapping[str, Patch] = {
    "torch.export._trace:print": Patch(
        "a failed trace prints its graph to standard output; the error says what is needed", "242b3d917aee"
    ),
    "torch.fx.experimental.symbolic_shapes:ShapeEnv._log_guard": Patch(
        "an error names the user's line that made an assumption about a size", "9b31e41e4e6c"
    ),
    "torch._subclasses.fake_impls:is_contiguous_for_memory_format_or_false": Patch(
        "asks of every operand whether its channels are last, by arithmetic on symbols: most of the time of a"
        " trace",
        "ef05bf3b858e",
    ),
    "torch._subclasses.fake_tensor:get_fast_op_impls": Patch(
        "compares the sizes of operands by arithmetic on symbols at each sum and product, though most are"
        " alike: a fifth of the time of a gradient's trace",
        "5a2680a750ef",
    ),
    "torch._inductor.sizevars:sympy": Patch(
        "calls sympy.simplify to see whether an index is linear: most of the time of a compilation; expanding"
        " does as well",
        "d89165e1cc27",
    ),
    "torch._inductor.ir:Pointwise.make_loader": Patch(
        "evaluates what is used twice twice, and so on: minutes for 180 operations",
        "c60d89ceeb98",
    ),
    "torch._inductor.ir:is_contiguous_for_memory_format_or_false": Patch(
        "takes planes to be stacked for interleaved: they are written so, and separated again", "ef05bf3b858e"
    ),
    "torch._inductor.cpp_builder:run_compile_cmd": Patch(
        "compilers run beside the exporter, with precompiled headers and files of the same names in every"
        " export",
        "55c6dba787f4",
    ),
    "torch._inductor.cpu_vec_isa:valid_vec_isa_list": Patch(
        "compiles and loads a program for each form of AVX-512, though it is told to take none",
        "4decee9d515e",
    ),
    "torch._inductor.codegen.cpp:CppVecKernel._get_vec_load_line": Patch(
        "takes eight bytes to a vector by way of the stack", "874c8487f4c1"
    ),
    "torch._inductor.codegen.cpp:CppVecKernel.reduction_combine_vec": Patch(
        "takes the zeros behind eight bytes for values, in the minimum and the maximum", "eff5f4325b9b"
    ),
    "torch._inductor.lowering:fallback_handler": Patch(
        "leaves `cat` of bytes to libtorch, which native code is to do without", "b1ba13a8d1aa"
    ),
    "torch._inductor.lowering:require_channels_last": Patch(
        "turns planes of bytes into interleaved ones before `cat`", "ad860042e0f2"
    ),
    "torch._inductor.codegen.cpp:CppVecOverrides.minimum": Patch(
        "passes NaN on, in three instructions; clamps, and ops without NaN, need one", "afbde6927b51"
    ),
    "torch._inductor.codegen.cpp:CppVecOverrides.maximum": Patch("as minimum", "5e9af95a20e4"),
    "torch._inductor.codegen.cpp:CppOverrides.truncdiv": Patch(
        "a division by zero, or of the least integer by -1, ends the process", "c2e7b8cc83e9"
    ),
    "torch._inductor.codegen.cpp:CppVecOverrides.truncdiv": Patch("as the scalar form", "0eb65b3e4579"),
    "torch._inductor.codegen.cpp:CppVecOverrides.remainder": Patch(
        "divides by 0 in lanes beyond a row's end", "a6d4443eabfe"
    ),
    "torch._inductor.codegen.cpp:KernelGroup.codegen_group": Patch(
        "notes a division by zero in a global pointer, which concurrent runs overwrite", "35eab46941b9"
    ),
    "torch._inductor.codegen.common:CSEProxy.indirect_indexing": Patch(
        "trusts an index from data, or ends the process: here it is checked", "17af97d9adc4"
    ),
    "torch._inductor.index_propagation:IndexPropagation.indirect_indexing": Patch(
        "trusts an index that is an expression of sizes", "730f2d5667e1"
    ),
    "torch._inductor.codegen.cpp_wrapper_cpu:CppWrapperCpu._generate_scatter_fallback": Patch(
        "ignores whether libtorch's call failed", "249b94d36f52"
    ),
    "torch._inductor.codegen.cpp_wrapper_cpu:CppWrapperCpu._generate_index_put_fallback": Patch(
        "as _generate_scatter_fallback", "104e1b0a9b8b"
    ),
    "torch._inductor.codegen.cpp_wrapper_cpu:CppWrapperCpu._write_aoti_interface_header": Patch(
        "what is needed of that header is compiled with the package", "74a66899070f"
    ),
    "torch._inductor.codegen.cpp_wrapper_cpu:CppWrapperCpu.generate_input_output_runtime_checks": Patch(
        "rejects sizes that the spec allows, such as a batch of 1, where AOTI_RUNTIME_CHECK_INPUTS is set;"
        " and it is most of the wrapper's code",
        "82995f13a658",
    ),
    "torch.cuda:is_available": Patch("a GPU is compiled for that is not here", "b91a896857c1"),
    "torch.cuda:device_count": Patch("as is_available", "efd183354fc3"),
    "torch.cuda:current_device": Patch("as is_available", "6e9804168a5c"),
    "torch.cuda:get_device_properties": Patch("known from the compute capability", "cb006011f5d1"),
    "torch.cuda:get_device_capability": Patch("as get_device_properties", "6809539b0a67"),
    "torch.cuda:synchronize": Patch("there is nothing to wait for", "7055e6143ffe"),
    "torch.cuda:get_rng_state": Patch("the GPU's is kept where there is one", "1190f97901d7"),
    "torch.cuda:set_rng_state": Patch("as get_rng_state", "2aaed350f20b"),
    "torch.cuda:_exchange_device": Patch("makes a device current", "0dd55462968d"),
    "torch.cuda:_maybe_exchange_device": Patch("as _exchange_device", "0dd55462968d"),
    "torch._dynamo.device_interface:CudaInterface.get_device_properties": Patch(
        "Inductor's way to the same", "cb006011f5d1"
    ),
    "torch._dynamo.device_interface:CudaInterface.current_device": Patch(
        "as get_device_properties", "6e9804168a5c"
    ),
    "torch._dynamo.device_interface:CudaInterface.device_count": Patch(
        "as get_device_properties", "efd183354fc3"
    ),
    "torch._dynamo.device_interface:CudaInterface.synchronize": Patch(
        "as get_device_properties", "7055e6143ffe"
    ),
    "torch._dynamo.device_interface:CudaInterface.exchange_device": Patch(
        "as get_device_properties", "a92a5c4945fb"
    ),
    "torch._dynamo.device_interface:CudaInterface.maybe_exchange_device": Patch(
        "as get_device_properties", "a92a5c4945fb"
    ),
    "torch._dynamo.device_interface:CudaInterface.get_raw_stream": Patch(
        "as get_device_properties", "a92a5c4945fb"
    ),
    "torch._dynamo.device_interface:CudaInterface.Worker.get_device_properties": Patch(
        "as get_device_properties", "9dc0592acd9d"
    ),
    "torch._dynamo.device_interface:CudaInterface.Worker.current_device": Patch(
        "as get_device_properties", "436367a8b55f"
    ),
    "torch._subclasses.fake_tensor:init_gpu_context": Patch("starts the GPU", "e6e85bdf6631"),
    "torch._subclasses.fake_tensor:FakeTensorMode.avoid_device_init": Patch(
        "is asked of the GPU; where it is not true, copies of constants are made there at once",
        "1b79326f4bb6",
    ),
    "torch._inductor.codegen.triton:signature_to_meta": Patch(
        "gives sizes 64 bits in case that a product of them needs more than 32: tensors here do not",
        "4802bfc8500c",
    ),
    "torch._inductor.sizevars:_optimization_hint_base": Patch(
        "sizes blocks for the example that was traced", "071b55dfe398"
    ),
    "torch._inductor.runtime.triton_heuristics:CachingAutotuner.precompile": Patch(
        "compiles every form of a loop, to time them", "f6d602556638"
    ),
    "torch._inductor.codegen.block_analysis:BlockPatternMatcher.match_mod_div_block_expr": Patch(
        "matches an index by patterns each time that it looks whether loops can be one: minutes",
        "02f6b98fc59c",
    ),
    "torch._inductor.codegen.triton:TritonPrinter._print_min_max_helper": Patch(
        "multiplies by comparisons, in case that both are constants of the compiler", "f2f5150a1998"
    ),
    "torch._inductor.ir:ConstantBuffer.constant_to_device": Patch(
        "copies a constant to the GPU", "5daba211fdd3"
    ),
    "torch._inductor.fx_passes.joint_graph:lazy_init": Patch(
        "makes its patterns of tensors on the GPU; they are the same on the CPU", "0d2451027503"
    ),
    "torch._inductor.runtime.triton_helpers:set_driver_to_gpu": Patch("opens the driver", "ebdce95fb1da"),
    "triton.compiler.compiler:CompiledKernel._init_handles": Patch(
        "loads what was compiled into the GPU", "4ba7e2f0375f"
    ),
    "triton.compiler.compiler:CompiledKernel.run": Patch("as _init_handles", "51d8e4a32625"),
    "torch._inductor.codegen.wrapper:PythonWrapperCodegen.generate_and_run_autotune_block": Patch(
        "times the forms of a loop on the GPU", "02e49876799d"
    ),
    "torch.utils.cpp_extension:CUDA_HOME": Patch(
        "the toolkit, of which only headers are used: chiasm has its own", "1494e212b205"
    ),
    "torch.onnx._internal.exporter._registration:ONNXRegistry.from_torchlib": Patch(
        "reads 1500 definitions of operators at each export; here once a process", "ae3ff9e7e5d3"
    ),
    "torch.onnx._internal.exporter._fx_passes:decompose_with_registry": Patch(
        "traces the whole graph again to take apart a few operators", "c75b83e770a1"
    ),
    "torch.onnx._internal.fx.passes.type_promotion:_TypePromotionInterpreter.run_node": Patch(
        "runs the whole graph again to see which types are promoted", "51dc1e6c8a9b"
    ),
    "onnxscript.values:TracedOnnxFunction.function_ir": Patch(
        "reads the source of 600 functions for the domain of each, which is the opset's", "63be6ada86b5"
    ),
}


@contextmanager
def replaced(replacements: Mapping[str, Any]) -> Generator[None]:
    """Replace the attributes (`module:attribute`, as declared in `PATCHES`) inside the block."""
    with ExitStack() as stack:
        for name, replacement in replacements.items():
            assert name in PATCHES, (
                f"{name}: a replacement is declared in chiasm/export/patches/__init__.py, with its reason"
            )
            owner, attribute = _owner(name)
            # torch.export._trace calls the builtin `print`, which is not an attribute of the module
            stack.enter_context(patch.object(owner, attribute, replacement, create=attribute == "print"))
        yield


def source_digest(name: str) -> str:
    """The first digits of SHA-256 of the installed source that a replacement replaces."""
    owner, attribute = _owner(name)
    found: Any = inspect.getattr_static(owner, attribute, None)
    if isinstance(found, property):
        found = found.fget
    elif isinstance(found, (staticmethod, classmethod)):
        found = cast("Any", found).__func__
    # For a builtin, a value or another package's function, the calling module counts
    source: Any = inspect.unwrap(found) if callable(found) else found
    if not inspect.isclass(source) and not inspect.isfunction(source):
        source = inspect.unwrap(owner)
    return hashlib.sha256(inspect.getsource(source).encode()).hexdigest()[:12]


def _owner(name: str) -> tuple[Any, str]:
    module, _, path = name.partition(":")
    *classes, attribute = path.split(".")
    owner: Any = importlib.import_module(module)
    for each in classes:
        owner = getattr(owner, each)
    return owner, attribute
