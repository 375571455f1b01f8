"""Putting a bundle's function into a model: opsets, versions and conflicts."""

from __future__ import annotations

from collections.abc import Iterator

import onnx
from google.protobuf.message import DecodeError
from onnx import version_converter

from chiasm.export.manifest import BundleError
from chiasm.export.onnx_function import (
    DOMAIN,
    domain_version,
    external_tensors,
    function_name,
    fuse,
)

from .methods import Artifact, Method

MIN_IR_VERSION = 8  # the first that has functions


def opset(model: onnx.ModelProto | onnx.FunctionProto, domain: str = "") -> int | None:
    """The version of a domain that `model` imports."""
    names = ("", "ai.onnx") if domain == "" else (domain,)
    return next((o.version for o in model.opset_import if o.domain in names), None)


def read_model(method: Method, artifact: Artifact | None) -> tuple[bytes, onnx.ModelProto]:
    """An ONNX artifact of the method, and the model in it, whose names are those of the manifest.

    Raises:
        BundleError: there is none, it is damaged, or it is a model of another method.
    """
    data = method.read(artifact)
    file = method.folder / (artifact or {})["file"]
    try:
        model = onnx.load_from_string(data)
    except DecodeError as error:
        raise BundleError(f"{file}: expected an ONNX model: {error}") from None
    function = function_name(method.manifest["name"], method.name)
    defined = [f.name for f in model.functions]
    if defined != ([function] if "function" in (artifact or {}) else []):
        raise BundleError(
            f"{file}: defines the functions {', '.join(defined) or '(none)'}, the manifest says"
            f" {function if 'function' in (artifact or {}) else '(none)'}"
        )
    for what, ours, *theirs in (
        ("inputs", method.inputs, model.graph.input, *(f.input for f in model.functions)),
        ("outputs", method.outputs, model.graph.output, *(f.output for f in model.functions)),
    ):
        said = [t["name"] for t in ours]
        for values in theirs:
            found = [v if isinstance(v, str) else v.name for v in values]
            if found != said:
                raise BundleError(
                    f"{file}: has the {what} {', '.join(found) or '(none)'}, the manifest says"
                    f" {', '.join(said)}"
                )
    for tensor in external_tensors(model):  # such a path may lead anywhere
        raise BundleError(f"{file}: the tensor {tensor.name!r} is in another file, expected it inside")
    return data, model


def fused_model(method: Method, version: int | None = None) -> onnx.ModelProto:
    """The method's fused model. Its body is raised to the opset `version` if that is given."""
    _, model = read_model(method, method.fused() or method.flat())
    name = function_name(method.manifest["name"], method.name)
    if model.functions and version in (None, opset(model.functions[0])):
        return model
    _, flat = read_model(method, method.flat())
    if version is not None and version != opset(flat):
        try:
            flat = version_converter.convert_version(flat, version)
        except Exception as error:  # the converter's own, of several kinds
            raise ValueError(
                f"{method.folder}: its operators (opset {opset(flat)}) cannot be raised to the model's opset"
                f" {version}: {error}"
            ) from error
    return fuse(flat, name, domain_version(method.manifest["version"]))


def at_least(model: onnx.ModelProto, version: int, bundle: str) -> onnx.ModelProto:
    """A copy of `model` whose opset is at least `version`.

    A function's operators must mean the same to the model that holds it, so the lower opset of the two is
    raised.
    """
    found = opset(model)
    result = onnx.ModelProto()
    if found is None or found >= version:
        result.CopyFrom(model)
    elif model.functions:
        raise ValueError(
            f"the model imports opset {found} and has functions, {bundle} needs opset {version}: export the"
            f" model with opset {version} or later"
        )
    else:
        try:
            result = version_converter.convert_version(model, version)
        except Exception as error:  # the converter's own, of several kinds
            raise ValueError(
                f"the model imports opset {found}, {bundle} needs {version}, and raising the model failed:"
                f" {error}: export it with opset {version} or later"
            ) from error
        del result.metadata_props[:]
        result.metadata_props.extend(model.metadata_props)
    result.ir_version = max(model.ir_version, MIN_IR_VERSION)
    return result


def add_function(model: onnx.ModelProto, method: Method) -> onnx.FunctionProto:
    """Put the method's function and its domain into `model`, whose opset is high enough. A function that is
    already there is not added again.

    Raises:
        ValueError: `model` has another function of this name, or another version of the domain.
    """
    base = opset(model)
    fused = fused_model(method, base)
    function = fused.functions[0]
    if base is None:
        model.opset_import.add(domain="", version=opset(fused))
    wanted, found = opset(fused, DOMAIN), opset(model, DOMAIN)
    if found is None:
        model.opset_import.add(domain=DOMAIN, version=wanted)
    elif found != wanted:
        raise ValueError(
            f"{method.folder} is version {method.manifest['version']} (domain {DOMAIN!r} {wanted}), the model"
            f" holds version {found} of the domain {DOMAIN!r}: a model has one: export the bundles with the"
            " same major version"
        )
    for other in model.functions:
        if (other.domain, other.name) == (DOMAIN, function.name):
            if other.SerializeToString(deterministic=True) != function.SerializeToString(deterministic=True):
                raise ValueError(
                    f"{method.folder}: the model has another function {DOMAIN}::{function.name} (of another"
                    " dtype, configuration or export): give the bundles names of their own"
                )
            return other
    model.functions.append(function)
    return function


def nodes(graph: onnx.GraphProto | onnx.FunctionProto) -> Iterator[onnx.NodeProto]:
    """The nodes of a graph and of its subgraphs."""
    for node in graph.node:
        yield node
        for inner in _subgraphs(node):
            yield from nodes(inner)


def _subgraphs(node: onnx.NodeProto) -> Iterator[onnx.GraphProto]:
    for attribute in node.attribute:
        if attribute.type == onnx.AttributeProto.GRAPH:
            yield attribute.g
        yield from attribute.graphs


def names(graph: onnx.GraphProto) -> set[str]:
    """Every name of a value in a graph and its subgraphs."""
    found = {v.name for v in [*graph.input, *graph.output, *graph.value_info, *graph.initializer]}
    for node in nodes(graph):
        found.update(node.input)
        found.update(node.output)
    return found
