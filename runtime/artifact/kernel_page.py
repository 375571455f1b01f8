"""Makes docs/kernels.md."""

import textwrap
from typing import List

from kernels.declarations import ENUMERATIONS, KERNELS


def page() -> str:
    """docs/kernels.md."""
    out = [
        "# Kernels",
        "",
        "<!-- Made by `make docs` from python/chiasm/primitives/kernels/declarations. -->",
        "",
    ]
    out += [
        *_paragraph(
            "The C++ loops of ops for which compiled tensor code is measurably slower"
            " (`runtime/artifact/kernels`). [architecture.md](architecture.md) describes how an op calls"
            " one, and [howto/kernel.md](howto/kernel.md) how to add one. T is float32 or float64, I is"
            " uint8 or int32, U is uint8 or uint16, S is int16 or uint16, V is uint8, int16 or uint16, P"
            " (of a pixel) is V, float32 or float64, A is P or int64. H and W are 1 to 2^31 - 1. A call"
            " that does not fit its declaration is an error that names the argument, the expected and the"
            " actual value."
        ),
        "",
    ]
    for e in ENUMERATIONS:
        out += [f"* **{e.name}**: {', '.join(f'`{value}`' for value in e.values)}. {e.doc}"]
    for k in KERNELS.values():
        out += ["", f"## {k.name}", "", "```", k.schema, "```", "", *_paragraph(k.doc)]
        if k.where:
            out += ["", *_paragraph(f"Where {', '.join(f'`{text}`' for text in k.where)}.")]
        out += ["", f"Source: [{k.source}](../runtime/artifact/kernels/{k.source})"]
    return "\n".join([*out, ""])


def _paragraph(text: str) -> List[str]:
    """Lines of Markdown."""
    return textwrap.wrap(text, 110, break_long_words=False, break_on_hyphens=False)
