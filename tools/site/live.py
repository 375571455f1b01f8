"""Makes the live page: its files, the ONNX graphs of its ops, ONNX Runtime for the web, and a photograph.

usage: live.py FOLDER        after tools/browser.sh runtime
"""

import json
import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image

from chiasm.export.workers import export_names
from gallery.photographs import photograph

ROOT = Path(__file__).resolve().parents[2]
PAGE = Path(__file__).with_name("live")
RUNTIME = ROOT / ".deps" / "browser" / "node_modules" / "onnxruntime-web"
#: The files that a page fetches if it imports ort.wasm.min.mjs.
ENGINE = (
    "dist/ort.wasm.min.mjs",
    "dist/ort-wasm-simd-threaded.mjs",
    "dist/ort-wasm-simd-threaded.wasm",
)


def main(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(PAGE, folder)
    (folder / "ort").mkdir()
    for file in ENGINE:
        shutil.copy(RUNTIME / file, folder / "ort")
    Image.fromarray(photograph("astronaut.png")).save(folder / "photograph.jpg", quality=92)
    names = [op["op"] for op in json.loads((PAGE / "ops.json").read_text())]
    with tempfile.TemporaryDirectory() as bundles:
        export_names(names, Path(bundles), ("onnx",), methods=("forward",), jobs=2)
        for name in names:
            shutil.copy(Path(bundles) / f"{name}.chiasm" / "forward.uint8.onnx", folder / f"{name}.onnx")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
