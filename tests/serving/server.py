"""A tritonserver for a test: real processes, on free ports of 127.0.0.1."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import sysconfig
import time
import urllib.error
import urllib.request
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import tritonclient.grpc as grpc_client
import tritonclient.http as http_client

ROOT = Path(__file__).resolve().parents[2]
BUNDLES = ROOT / "build" / "bundles"
BACKEND = ROOT / "build" / "release" / "lib" / "triton" / "chiasm"
VENV = ROOT / ".deps" / "triton"


def site_packages() -> Path:
    return next(VENV.glob("lib/python3.*/site-packages"))


def stub(server: Path) -> Path:
    """The stub process of Triton's Python backend, for the Python of these tests."""
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    return server / "python_backend_stubs" / version / "triton_python_backend_stub"


def free_ports(count: int) -> list[int]:
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


def environment() -> dict[str, str]:
    """No variables for chiasm: the backend finds its libraries itself. The Python backend needs libpython,
    and uses the packages of the first Python on PATH."""
    library = next((ROOT / ".venv").glob("lib/python3.*/site-packages/onnxruntime/capi/libonnxruntime.so*"))
    return {
        "PATH": f"{VENV}/bin:/usr/bin:/bin",
        "LD_LIBRARY_PATH": sysconfig.get_config_var("LIBDIR"),
        "CHIASM_ONNXRUNTIME_LIBRARY": str(library),
    }


class Server:
    """A server of the repository `folder`/models, which loads models on request."""

    def __init__(self, folder: Path, *arguments: str, variables: Mapping[str, str] | None = None) -> None:
        self.repository = folder / "models"
        self.repository.mkdir(exist_ok=True)
        backends = folder / "backends"
        backends.mkdir()
        (backends / "chiasm").symlink_to(BACKEND)
        binary = site_packages() / "pytriton" / "tritonserver"
        python = backends / "python"
        python.mkdir()
        for part in (*(binary / "backends" / "python").iterdir(), stub(binary)):
            (python / part.name).symlink_to(part)
        self.http_port, self.grpc_port, self.metrics_port = free_ports(3)
        self.log_path = folder / "server.log"
        command = [str(binary / "bin" / "tritonserver"), f"--model-repository={self.repository}"]
        command += [f"--backend-directory={backends}", *arguments]
        for kind in ("http", "grpc", "metrics"):
            command += [f"--{kind}-address=127.0.0.1", f"--{kind}-port={getattr(self, f'{kind}_port')}"]
        with self.log_path.open("w") as log:
            self.process = subprocess.Popen(
                command, stdout=log, stderr=log, env=environment() | dict(variables or {})
            )
        try:
            self._wait()
        except BaseException:
            self.process.kill()
            raise
        self.http = http_client.InferenceServerClient(f"127.0.0.1:{self.http_port}", concurrency=8)
        self.grpc = grpc_client.InferenceServerClient(f"127.0.0.1:{self.grpc_port}")

    def _wait(self) -> None:
        for _ in range(1200):
            assert self.process.poll() is None, self.log()
            try:
                if urllib.request.urlopen(self.url("v2/health/ready"), timeout=5).status == 200:
                    return
            except (urllib.error.URLError, OSError):
                time.sleep(0.05)
        raise AssertionError(f"the server is not ready: {self.log()}")

    def url(self, path: str) -> str:
        return f"http://127.0.0.1:{self.http_port}/{path}"

    def log(self) -> str:
        return self.log_path.read_text(errors="replace")

    def add(self, model: str, *bundles: str | Path, config: str = "") -> Path:
        """Write a model into the repository, replacing one of that name; returns its version's folder."""
        return write_model(self.repository / model, *bundles, config=config)

    def serve(self, model: str, *bundles: str | Path, config: str = "") -> dict[str, Any]:
        """Write a model, load it, and return its configuration as the server completed it."""
        self.add(model, *bundles, config=config)
        self.http.load_model(model)
        return self.http.get_model_config(model)

    def unload(self, model: str) -> None:
        """Unload a model, and wait until it is gone, because the server unloads asynchronously."""
        self.http.unload_model(model)
        for _ in range(2000):
            states = [m for m in self.http.get_model_repository_index() if m["name"] == model]
            if all(m.get("reason") == "unloaded" for m in states):
                return
            time.sleep(0.002)
        raise AssertionError(f"{model} is not unloaded: {states}")

    def metrics(self) -> str:
        return urllib.request.urlopen(f"http://127.0.0.1:{self.metrics_port}/metrics").read().decode()

    def memory(self) -> dict[str, int]:
        """The resident bytes of the process, and the bytes of its own data, touched or not."""
        lines = Path(f"/proc/{self.process.pid}/status").read_text().splitlines()
        fields = {line.split(":")[0]: line.split()[1] for line in lines if line.endswith("kB")}
        return {kind: int(fields[kind]) << 10 for kind in ("VmRSS", "VmData")}

    def statistics(self, model: str) -> dict[str, Any]:
        return self.http.get_inference_statistics(model)["model_stats"][0]

    def stop(self) -> int:
        self.http.close()
        self.grpc.close()
        self.process.send_signal(signal.SIGTERM)
        try:
            return self.process.wait(60)
        finally:
            self.process.kill()

    def __enter__(self) -> Server:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        status = self.stop()
        assert kind is not None or status == 0, "\n".join(self.log().splitlines()[-20:])


def write_model(folder: Path, *bundles: str | Path, config: str = "") -> Path:
    """Write a model's folder, replacing an existing one; returns its version's folder."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "1").mkdir(parents=True)
    for bundle in bundles:
        path = bundle if isinstance(bundle, Path) else BUNDLES / f"{bundle}.chiasm"
        shutil.copytree(path, folder / "1" / path.name)
    (folder / "config.pbtxt").write_text(f'backend: "chiasm"\n{config}')
    return folder / "1"


def tensors(module: Any, inputs: Mapping[str, np.ndarray]) -> list[Any]:
    """Inputs for the client `module`, tritonclient.http or .grpc."""
    from tritonclient.utils import np_to_triton_dtype

    made = []
    for name, array in inputs.items():
        each = module.InferInput(name, list(array.shape), np_to_triton_dtype(array.dtype))
        made.append(each.set_data_from_numpy(array) or each)
    return made


def parameter(name: str, value: str) -> str:
    """A line of a config.pbtxt."""
    return f'parameters {{ key: "{name}" value {{ string_value: "{value}" }} }}\n'


def cores() -> int:
    return len(os.sched_getaffinity(0))


def post(server: Server, model: str, body: bytes, header: int | None = None) -> tuple[int, str]:
    """Post a hand-made request; returns status and text."""
    headers = {} if header is None else {"Inference-Header-Content-Length": str(header)}
    request = urllib.request.Request(server.url(f"v2/models/{model}/infer"), body, headers)
    try:
        with urllib.request.urlopen(request) as answer:
            return answer.status, answer.read().decode(errors="replace")
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode(errors="replace")
