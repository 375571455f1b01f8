"""Generates functions and classes from source text, which TorchScript reads."""

import inspect
import linecache
import zlib
from typing import Any, Callable, Dict, List, Tuple


def made_from(source: str, filename: str, name: str, scope: Dict[str, Any]) -> Any:
    """The object that ``source`` defines as ``name``; its globals are ``scope``.

    >>> made_from("def twice(x):\\n    return factor * x\\n", "<an example>", "twice", {"factor": 2})(4)
    8
    """
    linecache.cache[filename] = (len(source), None, source.splitlines(keepends=True), filename)
    exec(compile(source, filename, "exec"), scope)
    return scope[name]


def function_from(
    model: Callable[..., Any], parameters: List[inspect.Parameter], body: List[str], scope: Dict[str, Any]
) -> Any:
    """A function with the name, the module, the docstring and the result's type of ``model``, but with other
    parameters and another body.

    Args:
        model: the annotated function that the new one replaces.
        parameters: the new one's, annotated.
        body: its lines, which use the parameters and the names in ``scope``.
    """
    # No __name__: TorchDynamo would look the names up in the model's module.
    scope = dict(scope, result_type=inspect.signature(model).return_annotation)
    header: List[str] = []
    for p in parameters:
        scope[f"type_{p.name}"], scope[f"default_{p.name}"] = p.annotation, p.default
        header.append(f"{p.name}: type_{p.name}" + ("" if p.default is p.empty else f" = default_{p.name}"))
    lines = [f"def {model.__name__}({', '.join(header)}) -> result_type:"] + [f"    {line}" for line in body]
    source = "\n".join(lines) + "\n"
    # Several functions may be generated from one model. TorchScript keeps their names in its files, so they
    # must be the same in every run; it numbers equal ones, in the order in which a process compiles them.
    mark = f"{zlib.crc32(source.encode()):08x}"
    filename = f"<primitive {model.__module__}.{model.__name__} {mark}>"
    made = made_from(source, filename, model.__name__, scope)
    made.__doc__, made.__module__ = model.__doc__, model.__module__
    made._jit_override_qualname = f"__torch__.{model.__module__}.made_{mark}.{model.__name__}"
    return made


def parameters_of(function: Callable[..., Any]) -> Tuple[inspect.Parameter, ...]:
    """The function's parameters, in order."""
    return tuple(inspect.signature(function).parameters.values())


def positional(name: str, annotation: Any, default: Any = inspect.Parameter.empty) -> inspect.Parameter:
    """A parameter for ``function_from``."""
    return inspect.Parameter(
        name, inspect.Parameter.POSITIONAL_OR_KEYWORD, default=default, annotation=annotation
    )
