"""Writes the reference: a page for each op of the catalog, an index for each family.

usage: reference.py FOLDER
"""

import inspect
import sys
from pathlib import Path

from chiasm.export.catalog import catalog
from chiasm.export.spec import DEFAULT_TOLERANCES, Spec, TensorSpec


def page(name: str, spec: Spec, function) -> str:
    """The page of one op."""
    doc = inspect.cleandoc(function.__doc__ or "")
    place = function.__module__.removeprefix("chiasm.")
    # Not in the tree of pages, which furo shows on every page
    parts = [
        "---\norphan: true\n---",
        f"# {name}",
        spec.summary or doc.partition("\n")[0],
        f"```python\n# chiasm.{place}\n{function.__name__}{signature(function)}\n```",
        "```text\n" + doc.replace("```", "'''") + "\n```",
        "## As a bundle",
        f"`chiasm export {name}`; version {spec.version}.",
    ]
    if spec.config:
        parts.append("Fixed: " + ", ".join(f"`{key}={value!r}`" for key, value in spec.config.items()) + ".")
    parts.append(tensors(spec))
    parts.append(tolerances(spec))
    if spec.reference:
        parts.append(f"Tested against: {plain(spec.reference)}.")
    if spec.special_values:
        parts.append(f"NaN and infinity: {plain(spec.special_values)}.")
    return "\n\n".join(parts) + "\n"


def signature(function) -> str:
    """The signature as in the source, with short names of types."""
    return str(inspect.signature(function)).replace("torch.", "").replace("typing.", "")


def plain(text: str) -> str:
    """Text, escaped for Markdown."""
    return text.translate({ord(c): f"\\{c}" for c in "\\`*_{}[]<>|$"})


def tensors(spec: Spec) -> str:
    """The table of inputs and outputs."""
    rows = ["| | name | dtype | shape | |", "|---|---|---|---|---|"]
    for kind, some in (("input", spec.inputs), ("output", spec.outputs)):
        rows += [row(kind, tensor, spec) for tensor in some]
    return "\n".join(rows)


def row(kind: str, tensor: TensorSpec, spec: Spec) -> str:
    """One tensor."""
    dtype = ", ".join(spec.dtypes) if tensor.dtype == "T" else tensor.dtype
    shape = f"`({', '.join(map(str, tensor.shape))})`" if tensor.shape else ""
    about = ", ".join(text for text in (tensor.description, tensor.layout, tensor.color) if text)
    return f"| {kind} | `{tensor.name}` | {dtype} | {shape} | {plain(about)} |"


def tolerances(spec: Spec) -> str:
    """The text on the largest differences of backends from eager Python."""
    rows = ["Backends agree with eager Python within", "", "| dtype | absolute | relative |", "|---|---|---|"]
    for dtype, tolerance in (dict(DEFAULT_TOLERANCES) | dict(spec.tolerances)).items():
        if dtype in spec.dtypes or dtype in spec.tolerances:
            rows.append(f"| {dtype} | {tolerance.atol:g} | {tolerance.rtol:g} |")
    return "\n".join(rows) if len(rows) > 4 else "Backends give the bits of eager Python."


def main(folder: Path) -> None:
    """Write all pages."""
    families: dict[str, list[str]] = {}
    for name, entry in sorted(catalog().items()):
        family = name.partition(".")[0]
        families.setdefault(family, []).append(name)
        target = folder / family / f"{name}.md"
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(page(name, entry.spec, entry.function()))
    for family, names in families.items():
        links = [f"* [{name}]({name}.md)" for name in names]
        (folder / family / "index.md").write_text("\n".join([f"# {family}", "", *links, ""]))
    lines = [f"{family}/index" for family in families]
    text = "\n".join(["# Reference", "", "```{toctree}", ":maxdepth: 1", "", *lines, "```", ""])
    (folder / "index.md").write_text(text)
    print(f"{sum(map(len, families.values()))} ops in {len(families)} families")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
