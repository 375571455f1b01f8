"""A bundle before or after an existing model, as one node of it."""

from __future__ import annotations

import io
import os
from dataclasses import replace
from pathlib import Path

import onnx
from google.protobuf import json_format, text_format
from google.protobuf.message import DecodeError
from onnx import TensorProto, helper

from chiasm.export.files import naming
from chiasm.export.manifest import read_manifest
from chiasm.export.onnx_function import DOMAIN, function_name
from chiasm.export.text import free_name
from chiasm.writing import write_whole

from .functions import add_function, at_least, fused_model, names, nodes, opset
from .methods import Method

BundlePath = str | os.PathLike[str]
#: By the file's suffix: onnx, json, textproto, onnxtxt
_PARSE_ERRORS = (DecodeError, json_format.ParseError, text_format.ParseError, onnx.parser.ParseError)


def prepend(
    bundle: BundlePath,
    model: onnx.ModelProto | BundlePath,
    *,
    method: str = "forward",
    dtype: str | None = None,
    connect: dict[str, str] | None = None,
) -> onnx.ModelProto:
    """Put a bundle in front of a model, for example preprocessing before a detector.

    The bundle becomes one node, its function is added to the model, and the result runs in any ONNX Runtime;
    register the bundle with the session (`register`) to run its native code. The bundle's inputs replace the
    connected inputs of the model. An input keeps its name in the bundle unless the model already uses it;
    then the function's name becomes its prefix (``filters_sobel_input``). A size that the model fixes is
    fixed in the bundle's inputs too.

    Args:
        bundle: the folder ``NAME.chiasm``.
        model: the model or its file; it is not changed.
        method: one of the bundle's methods.
        dtype: for a bundle of several dtypes, the one to take; by default that of the model's input.
        connect: from names of the bundle's outputs to names of the model's inputs. Optional if both have only
            one.

    Returns:
        The merged model. Its opset is the higher of the two.

    Raises:
        BundleError: the bundle is damaged, or has no such method or dtype.
        ValueError: the two do not fit together; the message names what was expected and what came.

    Example:
        >>> import chiasm.onnx, onnx
        >>> model = onnx.parser.parse_model(
        ...     '<ir_version: 8, opset_import: ["": 18]> '
        ...     "classifier (float[N, 3, 224, 224] images) => (float[N, 3, 1, 1] scores)"
        ...     "{ scores = GlobalAveragePool(images) }"
        ... )
        >>> merged = chiasm.onnx.prepend("build/bundles/pipelines.preprocess.chiasm", model)
        >>> [node.op_type for node in merged.graph.node], [i.name for i in merged.graph.input]
        (['pipelines_preprocess', 'GlobalAveragePool'], ['frame'])
    """
    given = loaded_model(model)
    initialized = {t.name for t in given.graph.initializer}
    wanted = {v.name: v for v in given.graph.input if v.name not in initialized}
    opened = Method.open(bundle, method, dtype)
    pairs = _pairs(opened, wanted, connect)
    if dtype is None:
        opened = method_of_dtype(opened, [wanted[name] for name in pairs.values()])

    source = fused_model(opened).graph
    merged = at_least(given, opset(fused_model(opened).functions[0]) or 0, str(opened.folder))
    taken = names(merged.graph)
    outputs = {v.name: v for v in source.output}
    links = [(outputs[ours], wanted[theirs]) for ours, theirs in pairs.items()]
    sizes = _fit(opened, links, ("output", "input"), _symbols(merged.graph))

    function = add_function(merged, opened)
    inputs = [_renamed(v, _name(v.name, function.name, taken), sizes) for v in source.input]
    # Outputs that the model does not take keep a name and a type, so that `append` can connect them.
    others = {
        v.name: _renamed(v, free_name(f"{function.name}_{v.name}", taken), sizes)
        for v in source.output
        if v.name not in pairs
    }
    results = [pairs.get(v.name) or others[v.name].name for v in source.output]
    merged.graph.node.insert(0, _call(function.name, [v.name for v in inputs], results, merged))
    kept = [v for v in merged.graph.input if v.name not in pairs.values()]
    replaced = [v for v in merged.graph.input if v.name in pairs.values()]
    del merged.graph.input[:]
    merged.graph.input.extend([*inputs, *kept])
    merged.graph.value_info.extend([*replaced, *others.values()])
    _check(merged, given)
    return merged


def append(
    model: onnx.ModelProto | BundlePath,
    bundle: BundlePath,
    *,
    method: str = "forward",
    dtype: str | None = None,
    connect: dict[str, str] | None = None,
) -> onnx.ModelProto:
    """Put a bundle after a model, for example a detector's decoder.

    The bundle becomes the last node, its function is added to the model, and the result runs in any ONNX
    Runtime; register the bundle with the session (`register`) to run its native code. The bundle's outputs
    replace the connected outputs of the model; unconnected inputs of the bundle become inputs of the merged
    model. A name is kept unless the model already uses it; then the function's name becomes its prefix
    (``ops_decode_yolov8_scores``). To chain bundles, call this once for each.

    Args:
        model: the model or its file; it is not changed.
        bundle: the folder ``NAME.chiasm``.
        method: one of the bundle's methods.
        dtype: for a bundle of several dtypes, the one to take; by default that of the model's output.
        connect: from names of the model's outputs to names of the bundle's inputs. Optional if both have only
            one. Any other value of the model can be named too, such as another output of a bundle in front of
            it (``pipelines_letterbox_to_frame``).

    Returns:
        The merged model. Its opset is the higher of the two.

    Raises:
        BundleError: the bundle is damaged, or has no such method or dtype.
        ValueError: the two do not fit together; the message names what was expected and what came.

    Example:
        >>> import chiasm.onnx, onnx
        >>> model = onnx.parser.parse_model(
        ...     '<ir_version: 8, opset_import: ["": 18]> '
        ...     "denoiser (float[N, 3, H, W] noisy) => (float[N, 3, H, W] clean) { clean = Relu(noisy) }"
        ... )
        >>> merged = chiasm.onnx.append(model, "build/bundles/filters.sobel.chiasm")
        >>> [node.op_type for node in merged.graph.node], [o.name for o in merged.graph.output]
        (['Relu', 'filters_sobel'], ['output'])
    """
    given = loaded_model(model)
    opened = Method.open(bundle, method, dtype)
    offered = {v.name: v for v in [*given.graph.input, *given.graph.value_info, *given.graph.output]}
    pairs = _pairs_after(opened, given.graph, connect)
    if dtype is None:
        opened = method_of_dtype(opened, [offered[name] for name in pairs if name in offered])

    source = fused_model(opened).graph
    merged = at_least(given, opset(fused_model(opened).functions[0]) or 0, str(opened.folder))
    taken = names(merged.graph)
    wanted = {v.name: v for v in source.input}
    links = [(wanted[ours], offered[theirs]) for theirs, ours in pairs.items() if theirs in offered]
    sizes = _fit(opened, links, ("input", "output"), _symbols(merged.graph))

    function = add_function(merged, opened)
    connected = {ours: theirs for theirs, ours in pairs.items()}
    others = {
        v.name: _renamed(v, _name(v.name, function.name, taken), sizes)
        for v in source.input
        if v.name not in connected
    }
    inputs = [connected.get(v.name) or others[v.name].name for v in source.input]
    outputs = [_renamed(v, _name(v.name, function.name, taken), sizes) for v in source.output]
    merged.graph.node.append(_call(function.name, inputs, [v.name for v in outputs], merged))
    kept = [v for v in merged.graph.output if v.name not in pairs]
    replaced = [v for v in merged.graph.output if v.name in pairs]
    del merged.graph.output[:]
    merged.graph.output.extend([*kept, *outputs])
    merged.graph.input.extend(others.values())
    merged.graph.value_info.extend(replaced)
    _check(merged, given)
    return merged


def embed(model: onnx.ModelProto, *bundles: BundlePath, dtype: str | None = None) -> onnx.ModelProto:
    """Add the definitions of bundles' functions to a model that calls them, so that it runs without chiasm.

    For models with a `Node` that were exported with ``torch.onnx.export``. `export` does both steps.

    Args:
        model: is not changed.
        bundles: the bundles whose functions it calls; a bundle that it does not call is an error.
        dtype: for bundles of several dtypes, the one of the calls; by default float32, else the first
            available.

    Returns:
        The complete model.

    Raises:
        BundleError: a bundle is damaged, or has no such dtype.
        ValueError: a call has no bundle, or a bundle no call, or a call has too many inputs or outputs.

    Example:
        >>> import chiasm.onnx, torch
        >>> bundle = "build/bundles/filters.sobel.chiasm"
        >>> program = torch.onnx.export(
        ...     chiasm.onnx.Node(bundle), (torch.zeros(1, 3, 16, 16),), dynamo=True, verbose=False
        ... )
        >>> [f.name for f in chiasm.onnx.embed(program.model_proto, bundle).functions]
        ['filters_sobel']
    """
    if not isinstance(model, onnx.ModelProto):
        raise TypeError(f"model: expected an onnx.ModelProto, got {type(model).__name__}")
    return embed_methods(model, [method for bundle in bundles for method in _called(model, bundle, dtype)])


def embed_methods(model: onnx.ModelProto, methods: list[Method]) -> onnx.ModelProto:
    """`embed` for methods that are opened already."""
    needed = max((opset(fused_model(m).functions[0]) or 0 for m in methods), default=0)
    result = at_least(model, needed, ", ".join(str(m.folder) for m in methods))
    # The exporter invents a version of the domain for the calls; the bundles know the real one.
    imports = [o for o in result.opset_import if o.domain != DOMAIN or result.functions]
    del result.opset_import[:]
    result.opset_import.extend(imports)
    for method in methods:
        add_function(result, method)
    defined = {f.name: f for f in result.functions if f.domain == DOMAIN}
    calls = [n for n in nodes(result.graph) if n.domain == DOMAIN]
    missing = sorted({n.op_type for n in calls} - defined.keys())
    if missing:
        raise ValueError(
            f"the model calls {', '.join(f'{DOMAIN}::{m}' for m in missing)}, which none of the bundles"
            " defines"
        )
    for call in calls:
        function = defined[call.op_type]
        if len(call.input) != len(function.input) or len(call.output) > len(function.output):
            raise ValueError(
                f"the model calls {DOMAIN}::{call.op_type} with {len(call.input)} inputs and"
                f" {len(call.output)} outputs, it has {len(function.input)} and {len(function.output)}"
            )
    _check(result, model)
    return result


def _check(result: onnx.ModelProto, given: onnx.ModelProto) -> None:
    """Check the result, unless the given model does not pass either: engines accept models that ONNX's
    checker rejects."""
    try:
        onnx.checker.check_model(given)
    except onnx.checker.ValidationError:
        return
    onnx.checker.check_model(result)


def _called(model: onnx.ModelProto, bundle: BundlePath, dtype: str | None) -> list[Method]:
    """The methods of the bundle whose functions the model calls."""
    manifest = read_manifest(Path(bundle))
    calls = {n.op_type for n in nodes(model.graph) if n.domain == DOMAIN}
    called = [m for m in manifest["methods"] if function_name(manifest["name"], m) in calls]
    if not called:
        function = f"{DOMAIN}::{function_name(manifest['name'], 'forward')}"
        raise ValueError(
            f"{bundle}: the model does not call {function}; it calls"
            f" {', '.join(sorted(calls)) or 'nothing of chiasm'}"
        )
    return [Method.open(bundle, m, dtype if manifest["dtypes"] else None) for m in called]


def loaded_model(model: onnx.ModelProto | BundlePath) -> onnx.ModelProto:
    """A model, or the one in a file."""
    if isinstance(model, onnx.ModelProto):
        return model
    if not isinstance(model, (str, os.PathLike)):
        raise TypeError(f"model: expected an onnx.ModelProto or a file, got {type(model).__name__}")
    if os.path.isdir(model):
        raise ValueError(
            f"model: expected an ONNX file, got the folder {os.fspath(model)}: `prepend` takes the bundle"
            " first, `append` the model"
        )
    if os.path.exists(model) and not os.path.isfile(model):  # it may have no end
        raise ValueError(f"model: expected an ONNX file, got the pipe or device {os.fspath(model)}")
    try:
        loaded = onnx.load(os.fspath(model))
    # The last two: of tensors in other files
    except (*_PARSE_ERRORS, onnx.checker.ValidationError, ValueError) as error:
        raise ValueError(f"model: expected an ONNX file, got {os.fspath(model)}: {error}") from None
    if not loaded.HasField("graph"):
        raise ValueError(f"model: expected an ONNX file, got {os.fspath(model)}, which has no graph")
    return loaded


def save_model(model: onnx.ModelProto, path: str | os.PathLike[str]) -> None:
    """Write a model to a file, completely or not at all, in the form of its suffix, as `onnx.save` does."""
    file, data = Path(path), io.BytesIO()
    onnx.save(model, data, onnx.serialization.registry.get_format_from_file_extension(file.suffix))
    with naming(file):
        write_whole(file, data.getbuffer(), durable=True)


def _call(function: str, inputs: list[str], outputs: list[str], merged: onnx.ModelProto) -> onnx.NodeProto:
    name = free_name(function, {n.name for n in nodes(merged.graph)})
    return helper.make_node(function, inputs, outputs, name=name, domain=DOMAIN)


def _pairs(
    opened: Method, wanted: dict[str, onnx.ValueInfoProto], connect: dict[str, str] | None
) -> dict[str, str]:
    """From the bundle's outputs to the model's inputs."""
    ours = [t["name"] for t in opened.outputs]
    if connect is None:
        if len(ours) != 1 or len(wanted) != 1:
            raise ValueError(
                f"{opened.folder} has the outputs {', '.join(ours)}, the model the inputs"
                f" {', '.join(wanted) or '(none)'}: say which goes where: connect={{OUTPUT: INPUT}}"
            )
        connect = {ours[0]: next(iter(wanted))}
    _check_pairs(connect, "an input of the model")
    for output, target in connect.items():
        if output not in ours:
            raise ValueError(f"connect: {opened.folder} has no output {output!r}: it has {', '.join(ours)}")
        if target not in wanted:
            raise ValueError(
                f"connect: the model has no input {target!r}: it has {', '.join(wanted) or '(none)'}"
            )
    return dict(connect)


def _pairs_after(opened: Method, graph: onnx.GraphProto, connect: dict[str, str] | None) -> dict[str, str]:
    """From the model's values to the bundle's inputs."""
    ours, offered = [t["name"] for t in opened.inputs], [v.name for v in graph.output]
    if connect is None:
        if len(ours) != 1 or len(offered) != 1:
            raise ValueError(
                f"the model has the outputs {', '.join(offered)}, {opened.folder} the inputs"
                f" {', '.join(ours)}: say which goes where: connect={{OUTPUT: INPUT}}"
            )
        connect = {offered[0]: ours[0]}
    _check_pairs(connect, "an input of the bundle")
    known = {v.name for v in graph.input} | {name for node in graph.node for name in node.output if name}
    for value, target in connect.items():
        if value not in known:
            raise ValueError(
                f"connect: the model has no value {value!r}: its outputs are {', '.join(offered)}"
            )
        if target not in ours:
            raise ValueError(f"connect: {opened.folder} has no input {target!r}: it has {', '.join(ours)}")
    return dict(connect)


def _check_pairs(connect: dict[str, str], target: str) -> None:
    if not isinstance(connect, dict):
        raise TypeError(f"connect: expected a dict of names, got {type(connect).__name__}")
    if not connect:
        raise ValueError("connect: expected at least one pair, got none")
    for name in (name for pair in connect.items() for name in pair):
        if not isinstance(name, str):
            raise TypeError(f"connect: expected a dict of names, got {name!r} in it")
        if not name:  # ONNX's way to leave a value out
            raise ValueError("connect: expected names, got an empty one, which is no value of a model")
    if len(set(connect.values())) != len(connect):
        raise ValueError(f"connect: {target} is named twice: {connect}")


def method_of_dtype(opened: Method, targets: list[onnx.ValueInfoProto]) -> Method:
    """The method in the dtype of the model's inputs, if the bundle is generic and has that dtype."""
    for target in targets:
        candidate = replace(opened, dtype=dtype_name(target))
        if candidate.dtype in opened.manifest["dtypes"] and candidate.flat() is not None:
            return candidate
    return opened


def dtype_name(value: onnx.ValueInfoProto) -> str:
    number = value.type.tensor_type.elem_type
    if number not in TensorProto.DataType.values():
        return f"element type {number}"
    name = TensorProto.DataType.Name(number).lower()
    return {"float": "float32", "double": "float64"}.get(name, name)


def _fit(
    opened: Method,
    links: list[tuple[onnx.ValueInfoProto, onnx.ValueInfoProto]],
    kinds: tuple[str, str],
    taken: set[str],
) -> dict[str, int | str]:
    """The values of the bundle's symbolic sizes in the merged model: a number or a symbol of the model, or a
    new name."""
    sizes: dict[str, int | str] = {}
    limits = opened.manifest["symbols"]
    for ours, theirs in links:
        story = (
            f"{opened.folder}: {kinds[0]} {ours.name!r} is {described(ours)}, the model's {kinds[1]}"
            f" {theirs.name!r} is {described(theirs)}"
        )
        if dtype_name(ours) != dtype_name(theirs):
            raise ValueError(f"{story}: the dtypes differ")
        if not theirs.type.tensor_type.HasField("shape"):
            continue
        mine, yours = ours.type.tensor_type.shape.dim, theirs.type.tensor_type.shape.dim
        if len(mine) != len(yours):
            raise ValueError(f"{story}: the numbers of dimensions differ")
        for a, b in zip(mine, yours):
            size = b.dim_value if b.HasField("dim_value") else b.dim_param or None
            if a.HasField("dim_value"):
                if b.HasField("dim_value") and a.dim_value != b.dim_value:
                    raise ValueError(f"{story}: {a.dim_value} is not {b.dim_value}")
            elif a.dim_param in limits and size is not None:
                low, high = limits[a.dim_param]["min"], limits[a.dim_param]["max"]
                if isinstance(size, int) and not low <= size <= high:
                    raise ValueError(f"{story}: the bundle takes {a.dim_param} from {low} to {high}")
                known = sizes.get(a.dim_param, size)
                if isinstance(known, int) and isinstance(size, int) and known != size:
                    raise ValueError(f"{story}: {a.dim_param} would have to be both {known} and {size}")
                sizes[a.dim_param] = known if isinstance(known, int) else size
    # Engines assume that equal names mean equal sizes, so a symbol that the model uses for another size is
    # renamed.
    function = function_name(opened.manifest["name"], opened.name)
    for symbol in limits:
        if symbol not in sizes:
            sizes[symbol] = symbol if symbol not in taken else free_name(f"{function}_{symbol}", taken)
    return sizes


def described(value: onnx.ValueInfoProto) -> str:
    tensor = value.type.tensor_type
    shape = [str(d.dim_value) if d.HasField("dim_value") else d.dim_param or "?" for d in tensor.shape.dim]
    return f"{dtype_name(value)} ({', '.join(shape) if tensor.HasField('shape') else '...'})"


def _symbols(graph: onnx.GraphProto) -> set[str]:
    return {
        d.dim_param
        for v in [*graph.input, *graph.output, *graph.value_info]
        for d in v.type.tensor_type.shape.dim
        if d.dim_param
    }


def _renamed(value: onnx.ValueInfoProto, name: str, sizes: dict[str, int | str]) -> onnx.ValueInfoProto:
    """A value of the bundle as one of the merged model; a size that is computed from symbols is left open."""
    result = onnx.ValueInfoProto()
    result.CopyFrom(value)
    result.name = name
    for dim in result.type.tensor_type.shape.dim:
        size = sizes.get(dim.dim_param, "")
        if isinstance(size, int):
            dim.dim_value = size
        elif size:
            dim.dim_param = size
        else:
            dim.ClearField("dim_param")
    return result


def _name(name: str, function: str, taken: set[str]) -> str:
    """`name`, with the function's name as a prefix if the model already uses it."""
    return free_name(f"{function}_{name}" if name in taken else name, taken)
