"""The site's live page in headless Chromium: each op shows eager Python's result for the same pixels.

    tools/browser.sh && PYTHONPATH=. python tools/site/live.py build/live
    python tests/browser/live.py            # tests build/live; leaves pictures of the page next to it

A photograph is dropped, another is chosen, and the camera is opened, for which Chromium generates a picture.
The last line printed is `live: N ops, M failed`, and the exit status is 1 if something failed.
"""

from __future__ import annotations

import base64
import io
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from PIL import Image

from chiasm.export.catalog import catalog
from chiasm.export.tracing.module import bind_spec

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))

from chromium import chromium, served  # noqa: E402

if TYPE_CHECKING:
    from playwright.sync_api import Page

PAGE = ROOT / "build" / "live"
SHOTS = ROOT / "build" / "live-pictures"
#: The most milliseconds for any step.
LIMIT = 60_000
DTYPES = {"float32": torch.float32, "int64": torch.int64}
CANVAS = """(id) => {
  const canvas = document.getElementById(id);
  const { width, height } = canvas;
  const pixels = canvas.getContext("2d").getImageData(0, 0, width, height).data;
  return { width, height, data: new Uint8Array(pixels.buffer).toBase64() };
}"""
DROP = """([name, data]) => {
  const transfer = new DataTransfer();
  transfer.items.add(new File([Uint8Array.fromBase64(data)], name));
  document.dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true }));
}"""


def main() -> int:
    SHOTS.mkdir(parents=True, exist_ok=True)
    ops = json.loads((PAGE / "ops.json").read_text())
    camera = ("--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream")
    failures: list[str] = []
    with served({"live": PAGE}) as address, chromium(*camera) as browser:
        page = browser.new_page(viewport={"width": 1200, "height": 900})
        page.set_default_timeout(LIMIT)
        page.on("pageerror", lambda error: failures.append(f"the page: {error}"))
        page.goto(f"{address}/live/index.html")
        settled(page, ops[0]["op"])
        page.evaluate(DROP, ["dropped.png", base64.b64encode(encoded(photograph(300, 200))).decode()])
        page.wait_for_function("document.getElementById('before').width === 300")
        for op in ops:
            page.check(f"input[value='{op['op']}']", force=True)
            settled(page, op["op"])
            failures += [f"{op['op']}: {problem}" for problem in differences(page, op)]
            page.screenshot(path=SHOTS / f"{op['op']}.png", full_page=True)
        page.evaluate(DROP, ["words.txt", base64.b64encode(b"no picture").decode()])
        page.wait_for_function("document.getElementById('status').textContent.includes('no picture')")
        page.set_input_files(
            "#file", {"name": "p.png", "mimeType": "image/png", "buffer": encoded(photograph(1280, 720))}
        )
        page.wait_for_function("document.getElementById('before').width === 640")
        page.click("#camera")
        page.wait_for_function("document.getElementById('before').height === 480")
        page.click("#camera")
        settled(page, ops[-1]["op"])
        failures += [f"camera: {problem}" for problem in differences(page, ops[-1])]
        page.set_viewport_size({"width": 390, "height": 844})
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        page.screenshot(path=SHOTS / "phone.png", full_page=True)
    for failure in failures:
        print(f"FAIL {failure}")
    print(f"live: {len(ops)} ops, {len(failures)} failed")
    return 1 if failures else 0


def settled(page: Page, op: str) -> None:
    """Wait until the page shows the op's result for the current picture and settings."""
    page.wait_for_function(
        "(op) => { const { dataset } = document.getElementById('after');"
        " return dataset.op === op && dataset.settled === 'true'; }",
        arg=op,
    )


def photograph(width: int, height: int) -> np.ndarray:
    """Smooth colours, noise, and a dark square."""
    y, x = np.mgrid[:height, :width]
    smooth = np.stack([x * 255 / width, y * 255 / height, (x + y) % 256], -1)
    smooth[height // 4 : height // 2, width // 4 : width // 2] = 20
    noise = np.random.default_rng(0).normal(0, 12, smooth.shape)
    return np.clip(smooth + noise, 0, 255).astype(np.uint8)


def encoded(pixels: np.ndarray) -> bytes:
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "png")
    return file.getvalue()


def canvas(page: Page, name: str) -> torch.Tensor:
    """The pixels shown, (H, W, 3)."""
    shown = page.evaluate(CANVAS, name)
    data = np.frombuffer(base64.b64decode(shown["data"]), np.uint8)
    return torch.from_numpy(data.reshape(shown["height"], shown["width"], 4)[..., :3].copy())


def differences(page: Page, op: dict[str, Any]) -> list[str]:
    """The problems of the picture that is shown for an op."""
    entry = catalog()[op["op"]]
    settings = {s["name"]: s for s in op.get("settings", [])}
    inputs = [
        canvas(page, "before")[None]
        if tensor.name == op["image"]
        else torch.full(
            settings[tensor.name]["shape"],
            settings[tensor.name]["value"],
            dtype=DTYPES[settings[tensor.name]["dtype"]],
        )
        for tensor in entry.spec.inputs
    ]
    results = bind_spec(entry.function(), entry.spec)(*inputs)
    results = results if isinstance(results, tuple) else (results,)
    names = [tensor.name for tensor in entry.spec.outputs]
    expected = results[names.index(op.get("output", "output"))][0].expand(-1, -1, 3)
    shown = canvas(page, "after")
    if shown.shape != expected.shape:
        return [f"the result is {tuple(shown.shape)}, eager Python's {tuple(expected.shape)}"]
    if expected.min() == expected.max():
        return ["eager Python's result is one colour, which tells nothing"]
    worst = int((shown.int() - expected.int()).abs().max())
    return [f"{worst} levels from eager Python"] if worst > 1 else []


if __name__ == "__main__":
    raise SystemExit(main())
