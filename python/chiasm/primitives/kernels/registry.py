"""The kernels that ``declarations`` declares, and what all declarations may name."""

from typing import Dict, Sequence, Tuple

from .schema import DeclarationError, Enumeration, Kernel, kernel

ENUMERATIONS = (
    Enumeration(
        "Border", ("reflect", "replicate", "circular", "constant"), "What is beyond the edge of an image."
    ),
    Enumeration(
        "Padding", ("zeros", "border", "reflection"), "What a position beyond the edge of an image reads."
    ),
    Enumeration(
        "Interpolation", ("nearest", "bilinear", "bicubic"), "How positions between pixels are read."
    ),
)

#: The most rows of the matrices that are inverted, and the most coefficients of a polynomial: they are kept
#: in registers and on the stack.
CONSTANTS = {"MOST_ROWS": 16, "MOST_TERMS": 17}

#: Rows of L values in which neighbours are step apart (layout.as_rows).
ROWS = ("1 <= L <= INT32_MAX", "1 <= step <= L", "L % step == 0")

KERNELS: Dict[str, Kernel] = {}


def declare(
    schema: str,
    source: str,
    doc: str,
    where: Sequence[str] = (),
    *,
    tried: Sequence[Tuple[str, int, int]] = (),
    exact: bool = True,
) -> None:
    """Add a kernel; the arguments are those of ``schema.kernel``."""
    declared = kernel(
        schema,
        source,
        doc,
        where,
        enumerations=ENUMERATIONS,
        constants=CONSTANTS,
        tried=tried,
        exact=exact,
    )
    if declared.name in KERNELS:
        raise DeclarationError(f"kernel {declared.name}: it is declared twice")
    KERNELS[declared.name] = declared
