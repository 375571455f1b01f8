"""Bundles in a browser: the flat ONNX graphs of every `forward` in ONNX Runtime for the web, in headless
Chromium.

    tools/browser.sh                                     # installs the browser
    python tests/browser/replay.py [FOLDER ...]          # folders of bundles; build/bundles by default

Every graph is run on the bundle's golden vectors, by WebAssembly on one thread, and compared within the
manifest's tolerances. Known failures are listed below, with the reason; an entry that no longer fails is a
failure, so that the list stays correct. The results are written to build/browser.json, in the form of the
parity matrix's checks. The last line printed is `browser: N checks of K ops, M failed`, and the exit status
is 1 if something failed.
"""

from __future__ import annotations

import base64
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from safetensors import safe_open

from chiasm.export.manifest import read_manifest

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(ROOT / "tests" / "parity")]

from chromium import ORT, chromium, served  # noqa: E402
from other_runtimes_worker import compare  # noqa: E402

if TYPE_CHECKING:
    from playwright.sync_api import Page

REPORT = ROOT / "build" / "browser.json"
#: The most seconds for loading and running a graph.
LIMIT = 60

#: (op, file) -> why ONNX Runtime for the web cannot do it.
KNOWN: dict[tuple[str, str], str] = {}


def main(folders: list[Path]) -> int:
    console = Console(width=None if sys.stdout.isatty() else 160)
    bundles = sorted(
        {
            b.name: b for f in reversed(folders) for b in f.glob("*.chiasm") if (b / "manifest.json").exists()
        }.values(),
        key=lambda b: b.name,
    )
    checks: list[dict[str, Any]] = []
    roots = {f"bundles{i}": folder.resolve() for i, folder in enumerate(folders)}
    columns = TextColumn("{task.description:56}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with served({"tests": HERE, "ort": ORT, **roots}) as address, chromium() as browser:
        page = browser.new_page()
        page.goto(f"{address}/tests/replay.html")
        with Progress(*columns, console=console) as progress:
            task = progress.add_task("", total=len(bundles))
            for bundle in bundles:
                progress.update(task, description=bundle.stem)
                checks += [judge(check) for check in replay(page, bundle, roots)]
                progress.advance(task)
        version = browser.version
    REPORT.parent.mkdir(exist_ok=True)
    REPORT.write_text(json.dumps(checks, indent=1))
    failed = [c for c in checks if c["message"] and not c["known"]]
    for c in checks:
        if c["known"]:
            reason = KNOWN[c["op"], c["artifact"]]
            console.print(f"[yellow]known[/] {c['op']} {c['artifact']}: {reason}", highlight=False)
    for c in failed[:40]:
        console.print(
            f"[red]FAIL[/] {c['op']} {c['artifact']}: {escape(c['message'][:600])}", highlight=False
        )
    engine = json.loads((ORT.parent / "package.json").read_text())["version"]
    print(f"Chromium {version}, onnxruntime-web {engine}: {REPORT.relative_to(ROOT)}")
    print(f"browser: {len(checks)} checks of {len({c['op'] for c in checks})} ops, {len(failed)} failed")
    return 1 if failed or not checks else 0


def replay(page: Page, bundle: Path, roots: dict[str, Path]) -> Iterator[dict[str, Any]]:
    """A check for each golden case of `forward` and each flat graph that serves it."""
    manifest = read_manifest(bundle)
    method = manifest["methods"]["forward"]
    [address] = [f"/{name}/{bundle.name}" for name, root in roots.items() if root == bundle.resolve().parent]
    graphs = [a for a in method["artifacts"] if a["format"] == "onnx" and "function" not in a]
    with safe_open(str(bundle / manifest["golden"]["file"]), "numpy") as golden:
        for case in manifest["golden"]["cases"]:
            for graph in graphs:
                if case["method"] != "forward" or case["dtype"] not in (None, *graph["dtypes"]):
                    continue
                inputs, expected = (
                    {t["name"]: golden.get_tensor(f"{case['prefix']}/{t['name']}") for t in method[side]}
                    for side in ("inputs", "outputs")
                )
                request = {
                    "graph": f"{address}/{graph['file']}",
                    "inputs": [packed(name, array) for name, array in inputs.items()],
                }
                answer = page.evaluate(
                    "([request, limit]) => replay(request, limit)", [request, LIMIT * 1000]
                )
                if "refused" in answer:
                    error, message = float("inf"), "refused: " + " ".join(answer["refused"].split())
                else:
                    results = [unpacked(output) for output in answer["outputs"]]
                    error, message = compare(results, list(expected.values()), method)
                yield {
                    "op": manifest["name"],
                    "method": "forward",
                    "dtype": case["dtype"] or "",
                    "backend": "browser",
                    "artifact": graph["file"],
                    "shape": "golden",
                    "error": error,
                    "message": message,
                    "load_ms": answer.get("load_ms"),
                    "run_ms": answer.get("run_ms"),
                }


def packed(name: str, array: np.ndarray) -> dict[str, Any]:
    data = base64.b64encode(np.ascontiguousarray(array).tobytes()).decode()
    return {"name": name, "dtype": str(array.dtype), "shape": list(array.shape), "data": data}


def unpacked(output: dict[str, Any]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(output["data"]), output["dtype"]).reshape(output["shape"])


def judge(check: dict[str, Any]) -> dict[str, Any]:
    """Apply the list of known failures."""
    reason = KNOWN.get((check["op"], check["artifact"]))
    check |= {"known": bool(reason and check["message"])}
    if reason and not check["message"]:
        check["message"] = f"passes, though it is listed as known not to ({reason}): take it off the list"
    return check


if __name__ == "__main__":
    raise SystemExit(main([Path(f) for f in sys.argv[1:]] or [ROOT / "build" / "bundles"]))
