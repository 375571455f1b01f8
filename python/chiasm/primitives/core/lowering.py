"""Primitives: computations that may have other forms than their definition, for engines that prefer these.

After JAX's ``mlir.register_lowering`` and ``lax.platform_dependent``: the definition and its lowerings are in
one place, and the caller does not know which of them is used.
"""

from typing import Any, Callable, Dict, List, NamedTuple, Optional, ParamSpec, Protocol, Tuple, TypeVar, cast

import torch

from .source import function_from, parameters_of
from .target import TARGETS, current_target

P = ParamSpec("P")
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)


class Lowering(NamedTuple):
    """A form of a primitive for some targets, used if ``when`` is true for the arguments."""

    targets: Tuple[str, ...]
    form: Callable[..., Any]
    when: Optional[Callable[..., bool]]


class Primitive(Protocol[P, R_co]):
    """What ``primitive`` returns: a function, with its definition and its lowerings."""

    definition: Callable[..., Any]
    lowerings: List[Lowering]

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R_co: ...

    def lowering(
        self, *targets: str, when: Optional[Callable[..., bool]] = None
    ) -> Callable[[Callable[..., Any]], Callable[..., Any]]: ...


#: Every primitive, by module and name.
PRIMITIVES: Dict[str, Primitive[..., Any]] = {}


def primitive(definition: Callable[P, R]) -> Primitive[P, R]:
    """Make a function of a definition, to which lowerings can be added.

    The definition is tensor code that TorchScript compiles. It is the reference: eager Python and TorchScript
    run it, and gradients are derived from it. It takes and returns what TorchScript allows, without
    keyword-only arguments::

        @primitive
        def halved(x: Tensor, times: int = 1) -> Tensor:
            '''x divided by 2, so many times.'''
            for _ in range(times):
                x = x / 2
            return x

    A lowering is the same computation, with the same arguments, in a form that an engine runs faster, or runs
    at all. It is plain Python, which only tracers run, and names its targets::

        @halved.lowering("onnx", "native")
        def _halved_by_a_product(x: Tensor, times: int = 1) -> Tensor:
            return x * 0.5**times

    * ``"onnx"`` and ``"native"`` are forward passes: their lowerings need no gradient that could be exported.
      ``"vjp"`` is a backward pass, whose one trace serves all engines: its lowerings use only operators that
      have a gradient in ONNX. Without a lowering for a target, the definition is traced.
    * ``"cuda"`` is native code for a GPU. Without a lowering for it, the one for ``"native"`` is used, unless
      that is a kernel, which runs on the CPU.
    * ``when`` gets the arguments and returns whether the lowering applies: by dtype, by sizes, by whether a
      kernel exists (``kernels.has_kernel``). It must not depend on data or on symbolic sizes. If several
      lowerings for a target apply, the first one is used.
    * tests/ops/test_targets.py compares every lowering with its definition, on its examples for every
      primitive.

    >>> import chiasm.primitives.core.target as target
    >>> @primitive
    ... def halved(x: torch.Tensor) -> torch.Tensor:
    ...     return x / 2
    >>> @halved.lowering("onnx", when=lambda x: x.dtype == torch.float32)
    ... def _(x: torch.Tensor) -> torch.Tensor:
    ...     return x * 0.5
    >>> with target.exporting("onnx"):
    ...     graph = torch.fx.experimental.proxy_tensor.make_fx(halved)(torch.ones(2))
    >>> [node.target for node in graph.graph.nodes if node.op == "call_function"]
    [<OpOverload(op='aten.mul', overload='Tensor')>]
    >>> del PRIMITIVES["chiasm.primitives.core.lowering.halved"]
    """
    lowerings: List[Lowering] = []

    def lowered(*arguments: Any) -> Any:
        target = current_target()
        for name in (target, "native") if target == "cuda" else (target,):
            for rule in lowerings:
                if name in rule.targets and (rule.when is None or rule.when(*arguments)):
                    return rule.form(*arguments)
        return definition(*arguments)  # pyright: ignore[reportCallIssue]

    def lowering(
        *targets: str, when: Optional[Callable[..., bool]] = None
    ) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
        for target in targets:
            if target not in TARGETS[1:]:
                raise ValueError(f"target: expected one of {TARGETS[1:]}, got {target!r}")

        def register(form: Callable[..., Any]) -> Callable[..., Any]:
            lowerings.append(Lowering(targets, form, when))
            return form

        return register

    parameters = parameters_of(definition)
    names = ", ".join(p.name for p in parameters)
    body = [
        "if torch.jit.is_scripting():",
        f"    return definition({names})",
        "else:",
        f"    return lowered({names})",
    ]
    made = function_from(
        definition, list(parameters), body, {"torch": torch, "definition": definition, "lowered": lowered}
    )
    made.definition, made.lowerings, made.lowering = definition, lowerings, lowering
    PRIMITIVES[f"{definition.__module__}.{definition.__name__}"] = made
    return cast("Primitive[P, R]", made)


def carries_derivative(function: Callable[P, R]) -> Primitive[P, R]:
    """The primitive of a function that returns its first argument and only adds a derivative: forward passes
    omit it.

    >>> @carries_derivative
    ... def from_square(root: torch.Tensor, square: torch.Tensor) -> torch.Tensor:
    ...     return root + 0.5 * (square - square.detach()) / root
    >>> from_square(torch.tensor(3.0), torch.tensor(9.0))
    tensor(3.)
    >>> del PRIMITIVES["chiasm.primitives.core.lowering.from_square"]
    """
    made = primitive(function)

    @made.lowering("onnx", "native")
    def _value(value: Any, *_: Any) -> Any:
        return value

    return made
