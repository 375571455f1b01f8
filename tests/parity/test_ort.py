"""The plug-in in ONNX Runtime, on the exported bundles: which code ran, on which threads, and the errors."""

import json
import os
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
import torch
from skimage import data

import chiasm.onnx
import chiasm.runtime
from chiasm.export.manifest import read_manifest

ROOT = Path(__file__).resolve().parents[2]
EXPORTED = Path(os.environ.get("CHIASM_TEST_BUNDLES", ROOT / "build" / "bundles"))
SOBEL = EXPORTED / "filters.sobel.chiasm"
FUSED = "forward.float32.fused.onnx"
IMAGE = np.random.default_rng(0).random((1, 3, 61, 83), np.float32)


def options(*bundles: Path, threads: int = 2) -> onnxruntime.SessionOptions:
    made = onnxruntime.SessionOptions()
    made.intra_op_num_threads = threads
    if bundles:
        chiasm.onnx.register(made, bundles)
    return made


def profiled(
    model: str | bytes, made: onnxruntime.SessionOptions, inputs: dict[str, np.ndarray], tmp_path: Path
) -> tuple[set[str], list[np.ndarray]]:
    """The types of the nodes that ran, by ONNX Runtime's own profile, and the outputs."""
    made.enable_profiling = True
    made.profile_file_prefix = str(tmp_path / "profile")
    session = onnxruntime.InferenceSession(model, made)
    outputs = session.run(None, inputs)
    events = json.loads(Path(session.end_profiling()).read_text())
    return {
        e["args"]["op_name"] for e in events if e.get("cat") == "Node" and e["name"].endswith("_kernel_time")
    }, outputs


def fused_artifacts() -> list[tuple[str, str, str]]:
    """(bundle, method, file) for each fused artifact whose native code can run here."""
    found = []
    for folder in sorted(EXPORTED.glob("*.chiasm")):
        for name, method in read_manifest(folder)["methods"].items():
            native = [a["dtypes"] for a in method["artifacts"] if a["backend"] == "native"]
            found += [
                (folder.name, name, a["file"])
                for a in method["artifacts"]
                if "function" in a and a["dtypes"] in native
            ]
    return found


@pytest.mark.parametrize(("bundle", "method", "file"), fused_artifacts())
def test_the_plugin_runs_the_node_and_stock_onnx_runtime_its_body(
    bundle: str, method: str, file: str, tmp_path: Path
) -> None:
    from safetensors.numpy import load_file

    folder = EXPORTED / bundle
    manifest = read_manifest(folder)
    [case] = [
        c
        for c in manifest["golden"]["cases"]
        if c["method"] == method and (c["dtype"] is None or f".{c['dtype']}." in file)
    ]
    golden = load_file(folder / "golden.safetensors")
    inputs = {
        t["name"]: golden[f"{case['prefix']}/{t['name']}"] for t in manifest["methods"][method]["inputs"]
    }
    [function] = {a["function"] for a in manifest["methods"][method]["artifacts"] if "function" in a}
    with_plugin, _ = profiled(str(folder / file), options(folder), inputs, tmp_path)
    assert with_plugin == {function}
    without, _ = profiled(str(folder / file), options(), inputs, tmp_path)
    assert without and function not in without


def test_there_is_native_code_for_what_is_tested() -> None:
    assert len(fused_artifacts()) > 30


def test_the_onnx_backend_takes_the_node_unless_told_otherwise() -> None:
    bundle = chiasm.runtime.open(SOBEL)
    fused, flat = bundle.method(backend="onnx"), bundle.method(backend="onnx", fused=False)
    assert (fused.artifact, flat.artifact) == (FUSED, "forward.float32.onnx")
    assert bundle.method(backend="onnx", allow_native_code=False).artifact == "forward.float32.onnx"
    np.testing.assert_array_equal(fused(IMAGE), bundle.method(backend="native")(IMAGE))
    np.testing.assert_allclose(fused(IMAGE), flat(IMAGE), atol=1e-6)


def test_an_input_that_the_manifest_forbids_is_an_error_and_the_session_goes_on() -> None:
    session = onnxruntime.InferenceSession(SOBEL / FUSED, options(SOBEL))
    with pytest.raises(Exception, match=r"'input'.*H.*at least 8|'input'.*8"):
        session.run(None, {"input": IMAGE[:, :, :5]})
    assert session.run(None, {"input": IMAGE})[0].shape == IMAGE.shape


def test_several_bundles_in_one_session_and_one_process(tmp_path: Path) -> None:
    grey = EXPORTED / "color.rgb_to_grayscale.chiasm"
    model = chiasm.onnx.prepend(grey, SOBEL / FUSED)
    ran, [both] = profiled(model.SerializeToString(), options(SOBEL, grey), {"image": IMAGE}, tmp_path)
    assert ran == {"color_rgb_to_grayscale", "filters_sobel"}
    one, [half] = profiled(model.SerializeToString(), options(grey), {"image": IMAGE}, tmp_path)
    assert "color_rgb_to_grayscale" in one and "filters_sobel" not in one
    np.testing.assert_allclose(both, half, atol=1e-6)


def copy_of(bundle: Path, folder: Path) -> Path:
    return Path(shutil.copytree(bundle, folder / bundle.name))


def test_two_bundles_of_one_op_are_refused(tmp_path: Path) -> None:
    with pytest.raises(Exception, match=r"both .*filters\.sobel.* and .* have the function filters_sobel"):
        options(SOBEL, copy_of(SOBEL, tmp_path))


def test_native_code_that_was_tampered_with_is_not_run(tmp_path: Path) -> None:
    bundle = copy_of(SOBEL, tmp_path)
    file = bundle / "forward.float32.x86-64-v3.pt2"
    code = bytearray(file.read_bytes())
    code[len(code) // 2] ^= 1
    file.write_bytes(code)
    with pytest.raises(Exception, match=r"forward\.float32\.x86-64-v3\.pt2.*sha256"):
        onnxruntime.InferenceSession(bundle / FUSED, options(bundle))


@pytest.mark.parametrize("reason", ["missing", "CUDA"])
def test_without_native_code_for_this_machine_the_body_runs_and_standard_error_says_so(
    reason: str, tmp_path: Path, capfd: pytest.CaptureFixture
) -> None:
    bundle = copy_of(SOBEL, tmp_path)
    if reason == "missing":
        (bundle / "forward.float32.x86-64-v3.pt2").unlink()
    else:
        text = (bundle / "manifest.json").read_text()
        manifest = json.loads(text)
        for artifact in manifest["methods"]["forward"]["artifacts"]:
            if artifact["backend"] == "native":
                artifact["device"] = "cuda"
        (bundle / "manifest.json").write_text(json.dumps(manifest))
    ran, [edges] = profiled(str(bundle / FUSED), options(bundle), {"input": IMAGE}, tmp_path)
    assert "filters_sobel" not in ran
    assert (
        f"'forward' of {bundle} runs as standard operators" in (said := capfd.readouterr().err)
        and reason in said
    )
    np.testing.assert_allclose(edges, chiasm.onnx.session(SOBEL).run(None, {"input": IMAGE})[0], atol=1e-6)


def test_a_server_that_takes_a_file_name_only(tmp_path: Path) -> None:
    shutil.copy(chiasm.onnx.library(), tmp_path / "libchiasm_ort.so")
    bundle = copy_of(SOBEL, tmp_path)
    made = options()
    made.register_custom_ops_library(str(tmp_path / "libchiasm_ort.so"))
    ran, _ = profiled(str(bundle / FUSED), made, {"input": IMAGE}, tmp_path)
    assert ran == {"filters_sobel"}


def test_a_damaged_bundle_is_an_error_of_the_registration(tmp_path: Path) -> None:
    made = options()
    made.add_session_config_entry("chiasm.bundles", str(tmp_path / "none.chiasm"))
    with pytest.raises(Exception, match=r"none\.chiasm"):
        made.register_custom_ops_library(str(chiasm.onnx.library()))


def test_in_a_network_of_ones_own_on_a_photograph(tmp_path: Path) -> None:
    torch.manual_seed(0)
    preprocess = EXPORTED / "pipelines.preprocess.chiasm"
    body = torch.nn.Sequential(
        torch.nn.Conv2d(3, 8, 3, stride=2), torch.nn.ReLU(), torch.nn.AdaptiveAvgPool2d(1), torch.nn.Flatten()
    ).eval()
    network = torch.nn.Sequential(chiasm.onnx.Node(preprocess), body)
    photograph = torch.from_numpy(np.ascontiguousarray(data.astronaut()[:, :, ::-1]))
    file = tmp_path / "network.onnx"
    onnx.save(chiasm.onnx.export(network, (photograph,), dynamic_shapes=({0: "H", 1: "W"},)), file)
    frame = np.ascontiguousarray(data.chelsea()[:, :, ::-1])  # of another size than in the export
    model = onnx.load(file)
    inputs = {model.graph.input[0].name: frame}
    ran, [features] = profiled(str(file), options(preprocess), inputs, tmp_path)
    assert "pipelines_preprocess" in ran and "Resize" not in ran
    [stock] = onnxruntime.InferenceSession(file, options()).run(None, inputs)
    with torch.no_grad():
        eager = network(torch.from_numpy(frame)).numpy()
    np.testing.assert_allclose(features, stock, atol=1e-5)
    np.testing.assert_allclose(features, eager, atol=1e-5)


def document(language: str, with_words: str) -> str:
    [found] = [
        b
        for b in re.findall(rf"```{language}\n(.*?)```", (ROOT / "docs" / "onnx.md").read_text(), re.DOTALL)
        if with_words in b
    ]
    return found


def test_the_documents_example_in_python(tmp_path: Path) -> None:
    (tmp_path / "bundles").symlink_to(EXPORTED)
    done = subprocess.run(
        [sys.executable, "-c", document("python", "needs the plug-in")],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "standard operators" not in done.stderr


def test_the_documents_example_in_cpp(tmp_path: Path) -> None:
    (tmp_path / "bundles").symlink_to(EXPORTED)
    snippet = document("cpp", "RegisterCustomOpsLibrary").replace(
        '"libchiasm_ort.so"', f'"{chiasm.onnx.library()}"'
    )
    (tmp_path / "main.cpp").write_text(f"""#include <onnxruntime_cxx_api.h>
#include <cstdio>
#include <vector>
int main() {{
  Ort::Env env(ORT_LOGGING_LEVEL_WARNING, "test");
  {snippet}
  std::vector<float> image(3 * 40 * 60, 0.5f);
  const std::vector<int64_t> shape{{1, 3, 40, 60}};
  auto memory = Ort::MemoryInfo::CreateCpu(OrtDeviceAllocator, OrtMemTypeDefault);
  auto input = Ort::Value::CreateTensor<float>(memory, image.data(), image.size(), shape.data(),
                                                   shape.size());
  const char* in = "input";
  const char* out = "output";
  auto outputs = session.Run(Ort::RunOptions(nullptr), &in, &input, 1, &out, 1);
  const float* edges = outputs[0].GetTensorData<float>();
  for (size_t i = 0; i < image.size(); ++i)
    if (edges[i] < 0.0009f || edges[i] > 0.0011f) return 1;  // sqrt(eps): a flat image has no edges
  try {{
    const std::vector<int64_t> small{{1, 3, 4, 60}};
    auto refused = Ort::Value::CreateTensor<float>(memory, image.data(), image.size(), small.data(),
                                                     small.size());
    session.Run(Ort::RunOptions(nullptr), &in, &refused, 1, &out, 1);
  }} catch (const Ort::Exception& error) {{
    std::puts(error.what());
    return 0;
  }}
  return 2;
}}
""")
    runtime = ROOT / ".deps" / "onnxruntime"
    flags = [
        f"-I{runtime / 'include'}",
        f"-L{runtime / 'lib'}",
        "-l:libonnxruntime.so.1",
        f"-Wl,-rpath,{runtime / 'lib'}",
    ]
    subprocess.run(["g++", "-std=c++17", "main.cpp", *flags, "-o", "main"], cwd=tmp_path, check=True)
    done = subprocess.run(["./main"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and "standard operators" not in done.stderr, (done.returncode, done.stderr)
    assert "'input'" in done.stdout


def test_the_kernel_works_on_the_sessions_threads_and_makes_none() -> None:
    """Runs in a separate process, in which nothing else creates threads."""
    code = f"""
import os, resource, sys, time
import numpy as np, onnxruntime, chiasm.onnx
threads = int(sys.argv[1])
options = onnxruntime.SessionOptions()
options.intra_op_num_threads = threads
options.add_session_config_entry("session.intra_op.allow_spinning", "0")
chiasm.onnx.register(options, {str(SOBEL)!r})
session = onnxruntime.InferenceSession({str(SOBEL / FUSED)!r}, options)
image = np.random.default_rng(0).random((4, 3, 512, 512), np.float32)
before = len(os.listdir("/proc/self/task"))
started, used = time.perf_counter(), time.process_time()
for _ in range(30):
    [out] = session.run(None, {{"input": image}})
cores = (time.process_time() - used) / (time.perf_counter() - started)
print(len(os.listdir("/proc/self/task")) - before, cores, out.tobytes().hex()[:64], hash(out.tobytes()))
"""
    results = {}
    for threads in (1, 2, 4):
        done = subprocess.run(
            [sys.executable, "-c", code, str(threads)],
            capture_output=True,
            text=True,
            check=True,
            env=os.environ | {"PYTHONHASHSEED": "0"},
        )
        made, cores, *values = done.stdout.split()
        assert int(made) == 0
        results[threads] = (float(cores), values)
    assert results[1][1] == results[2][1] == results[4][1]
    # One thread must use only itself; how much more two use depends on the machine's other work
    assert results[1][0] < 1.1


def test_a_session_with_more_threads_than_the_machine_has_cores(tmp_path: Path) -> None:
    # Kernels have memory for each thread of a region; this ended the process.
    code = """
import os, sys, numpy as np, onnxruntime, chiasm.onnx, chiasm.runtime
options = onnxruntime.SessionOptions()
options.intra_op_num_threads = 4 * os.cpu_count()
session = chiasm.onnx.session(sys.argv[1], options=options)
x = np.random.default_rng(0).random((1, 3, 1500, 1507), np.float32)
expected = chiasm.runtime.open(sys.argv[1]).method(backend="native")(x)
print(all(np.array_equal(session.run(None, {"input": x})[0], expected) for _ in range(30)))
"""
    done = subprocess.run(
        [sys.executable, "-c", code, str(SOBEL)], capture_output=True, text=True, timeout=200, check=False
    )
    assert done.stdout.strip() == "True", (done.returncode, done.stderr)


def test_many_callers_and_two_sessions_at_once() -> None:
    sessions = [onnxruntime.InferenceSession(SOBEL / FUSED, options(SOBEL, threads=t)) for t in (1, 2)]
    images = [np.random.default_rng(i).random((2, 3, 128, 100 + i), np.float32) for i in range(4)]
    expected = [chiasm.runtime.open(SOBEL).method(backend="native")(i) for i in images]

    def work(index: int) -> bool:
        results = [sessions[(index + k) % 2].run(None, {"input": images[k % 4]})[0] for k in range(40)]
        return all(np.array_equal(r, expected[k % 4]) for k, r in enumerate(results))

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(work, range(8)))
