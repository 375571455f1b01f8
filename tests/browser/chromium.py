"""A headless Chromium and the server of its pages; both end with their `with` blocks."""

from __future__ import annotations

import os
import shutil
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING, Any

ROOT = Path(__file__).resolve().parents[2]
DEPS = ROOT / ".deps" / "browser"
#: ONNX Runtime for the web, as pages import it.
ORT = DEPS / "node_modules" / "onnxruntime-web" / "dist"
sys.path.append(str(DEPS / "python"))

if TYPE_CHECKING:
    from playwright.sync_api import Browser


class Handler(SimpleHTTPRequestHandler):
    """Serves files of several folders; the first part of an address chooses the folder."""

    extensions_map = SimpleHTTPRequestHandler.extensions_map | {
        ".mjs": "text/javascript",
        ".wasm": "application/wasm",
    }

    def __init__(self, folders: dict[str, Path], *args: Any) -> None:
        self.folders = folders
        super().__init__(*args)

    def translate_path(self, path: str) -> str:
        first, _, rest = path.lstrip("/").partition("/")
        self.directory = str(self.folders.get(first, "/nonexistent"))
        return super().translate_path(rest)

    def log_message(self, format: str, *args: Any) -> None:
        """Do not log requests."""


@contextmanager
def served(folders: dict[str, Path]) -> Iterator[str]:
    """The address, on this machine only, under which each folder is served by its name."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, folders))
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()
        server.server_close()


@contextmanager
def chromium(*options: str) -> Iterator[Browser]:
    """A headless browser with command-line options."""
    from playwright.sync_api import sync_playwright

    program = os.environ.get("CHIASM_CHROMIUM") or shutil.which("chromium")
    if program is None:
        raise SystemExit("there is no Chromium: run tools/browser.sh")
    # Chromium's own sandbox is not available to root; it opens only this project's pages.
    sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=[*sandbox, *options])
        try:
            yield browser
        finally:
            browser.close()
