"""Signed bundles and trust policies: chiasm and the program minisign agree, and no process runs code that its
policy forbids."""

import base64
import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import onnx
import pytest
from click.testing import CliRunner
from scale_bundle import artifact, tensor, write_bundle, write_scale

from chiasm.export import signing
from chiasm.export.cli import main
from chiasm.export.errors import ExportError
from chiasm.export.manifest import BundleError, schema

ROOT = Path(__file__).resolve().parents[2]
EXPORTED = Path(os.environ.get("CHIASM_TEST_BUNDLES", ROOT / "build" / "bundles"))
PASSWORD = "correct horse"


def minisign(*arguments: str | Path, typed: str = "") -> subprocess.CompletedProcess[str]:
    # Its key derivation uses a gigabyte if it can, and less under a memory limit.
    limit = (200 << 20, 200 << 20)
    return subprocess.run(
        ["minisign", *map(str, arguments)],
        input=typed,
        capture_output=True,
        text=True,
        timeout=60,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, limit),
    )


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """plain.key, protected.key and other.key, each with its .pub, all made by minisign."""
    folder = tmp_path_factory.mktemp("keys")
    for name, more in (("plain", ["-W"]), ("other", ["-W"]), ("protected", [])):
        made = minisign(
            "-G",
            *more,
            "-p",
            folder / f"{name}.pub",
            "-s",
            folder / f"{name}.key",
            typed=f"{PASSWORD}\n{PASSWORD}\n",
        )
        assert made.returncode == 0, made.stderr
    (folder / "password").write_text(PASSWORD + "\n")
    return folder


@pytest.fixture
def bundle(tmp_path: Path) -> Path:
    return write_scale(tmp_path)


def chiasm(*arguments: str | Path) -> tuple[int, str]:
    result = CliRunner().invoke(main, [str(a) for a in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.output


def sign(bundle: Path, keys: Path, name: str = "plain") -> None:
    signing.sign(bundle, signing.read_secret_key(keys / f"{name}.key", lambda: PASSWORD))


def child(code: str, **environment: str) -> str:
    """The output of a new process that runs this code, with `np` and `runtime`; asserts that no signal ends
    it."""
    lines = [
        "import numpy as np",
        "import chiasm.runtime as runtime",
        "def attempt(f):",
        "  try: return f()",
        "  except runtime.ChiasmError as e: return f'{e.code.name}: {e}'",
        code,
    ]
    names = {"PYTHONPATH": str(ROOT / "python"), "CHIASM_TRUST_POLICY": "", "CHIASM_TRUSTED_KEYS": ""}
    result = subprocess.run(
        [sys.executable, "-c", "\n".join(lines)],
        env=os.environ | names | environment,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


# Signatures


@pytest.mark.parametrize("name", ["plain", "protected"])
def test_minisign_agrees_with_what_chiasm_signed(bundle: Path, keys: Path, name: str) -> None:
    code, text = chiasm("sign", keys / f"{name}.key", bundle, "--password-file", keys / "password")
    assert code == 0 and "manifest.json.minisig" in text, text
    agreed = minisign("-V", "-p", keys / f"{name}.pub", "-m", bundle / "manifest.json")
    assert agreed.returncode == 0 and "comment signature verified" in agreed.stdout, agreed.stderr
    assert "file:manifest.json" in signing.check_signature(bundle, str(keys / f"{name}.pub"))
    assert minisign("-V", "-p", keys / "other.pub", "-m", bundle / "manifest.json").returncode != 0


@pytest.mark.parametrize("form", ["hashed", "legacy"])
def test_chiasm_agrees_with_what_minisign_signed(bundle: Path, keys: Path, form: str) -> None:
    more = ["-l"] if form == "legacy" else []
    assert (
        minisign(
            "-S", *more, "-s", keys / "plain.key", "-m", bundle / "manifest.json", "-t", "a word of mine"
        ).returncode
        == 0
    )
    key = (keys / "plain.pub").read_text().split()[-1]
    assert signing.check_signature(bundle, key) == "a word of mine"
    assert signing.check_signature(bundle, str(keys / "plain.pub")) == "a word of mine"


def test_several_bundles_are_signed_at_once_and_asked_for_one_password(tmp_path: Path, keys: Path) -> None:
    bundles = []
    for i in range(3):
        (tmp_path / str(i)).mkdir()
        bundles.append(write_scale(tmp_path / str(i)))
    result = CliRunner().invoke(
        main, ["sign", str(keys / "protected.key"), *map(str, bundles)], input=PASSWORD + "\n"
    )
    assert result.exit_code == 0 and result.output.count("signed") == 3, result.output
    for one in bundles:
        signing.check_signature(one, str(keys / "protected.pub"))


def test_without_a_terminal_a_pipe_has_the_password_or_an_error_says_the_option(
    bundle: Path, keys: Path
) -> None:
    command = [sys.executable, "-m", "chiasm.export", "sign", str(keys / "protected.key"), str(bundle)]
    for given, status, words in (
        ("", 1, "there is no terminal to ask: --password-file FILE"),
        ("wrong\n", 1, "the password is wrong"),
        (PASSWORD + "\n", 0, ""),
    ):
        # A session of its own has no terminal
        done = subprocess.run(command, input=given, capture_output=True, text=True, start_new_session=True)
        assert done.returncode == status and words in done.stderr, done.stderr
        assert done.stderr.count("\n") == status, done.stderr
    signing.check_signature(bundle, str(keys / "protected.pub"))


def flip(file: Path, index: int) -> None:
    data = bytearray(file.read_bytes())
    data[index] ^= 1
    file.write_bytes(data)


def test_a_changed_byte_is_found_wherever_it_is(bundle: Path, keys: Path) -> None:
    sign(bundle, keys)
    key = str(keys / "plain.pub")
    signature = (bundle / signing.SIGNATURE).read_text()
    places = [("manifest.json", i) for i in (0, 700, 1500, -1)]
    places += [(signing.SIGNATURE, signature.index("\n") + i) for i in (1, 5, 40, 90)]  # the signature's line
    # The trusted comment
    places += [(signing.SIGNATURE, signature.index("timestamp") + i) for i in (-4, 0, 12)]
    places += [(signing.SIGNATURE, len(signature) - 30)]  # and the trusted comment's signature
    places += [
        (file.name, 20) for file in bundle.iterdir() if file.name not in ("manifest.json", signing.SIGNATURE)
    ]
    for file, index in places:
        flip(bundle / file, index)
        with pytest.raises(BundleError):
            signing.check_signature(bundle, key)
        flip(bundle / file, index)
        signing.check_signature(bundle, key)


def test_what_is_wrong_is_said(bundle: Path, keys: Path, tmp_path: Path) -> None:
    def says(key: str | Path) -> str:
        with pytest.raises(BundleError) as error:
            signing.check_signature(bundle, str(key))
        return str(error.value)

    assert "is not signed" in says(keys / "plain.pub")
    sign(bundle, keys)
    assert "which is not trusted here" in says(keys / "other.pub")
    assert "neither a minisign public key nor a file" in says("nothing")
    assert "not a minisign public key" in says(keys / "password")
    (bundle / "more").write_text("x")
    assert "has 'more', which its manifest does not name" in says(keys / "plain.pub")
    code, text = chiasm("sign", keys / "plain.key", bundle)
    assert code == 1 and "has 'more'" in text  # only a complete bundle is signed
    (bundle / "more").unlink()
    flip(bundle / "golden.safetensors", 100)
    code, text = chiasm("sign", keys / "plain.key", bundle)
    assert code == 1 and "golden.safetensors: sha256 differs" in text


def test_secret_keys_that_are_none(keys: Path, tmp_path: Path) -> None:
    plain = (keys / "plain.key").read_text().splitlines()
    for text in (
        "",
        "x",
        plain[0],
        f"{plain[0]}\n{plain[1][:-8]}",
        f"{plain[0]}\nSSSS{plain[1][4:]}",
        "\n\n",
        "a\n\xff",
    ):
        (tmp_path / "key").write_text(text)
        with pytest.raises(ExportError, match="not a minisign secret key"):
            signing.read_secret_key(tmp_path / "key", lambda: "")
    with pytest.raises(ExportError, match="the password is wrong"):
        signing.read_secret_key(keys / "protected.key", lambda: "wrong")
    greedy = bytearray(base64.b64decode((keys / "protected.key").read_text().splitlines()[1]))
    greedy[38:54] = b"\xff" * 16
    (tmp_path / "key").write_text("c\n" + base64.b64encode(greedy).decode())
    with pytest.raises(ExportError, match="bytes of memory"):
        signing.read_secret_key(tmp_path / "key", lambda: PASSWORD)


def test_a_password_of_other_bytes_is_said(bundle: Path, keys: Path, tmp_path: Path) -> None:
    (tmp_path / "password").write_bytes(b"\xff\xfe\n")
    code, text = chiasm("sign", keys / "protected.key", bundle, "--password-file", tmp_path / "password")
    assert code == 1 and "not text in UTF-8" in text and text.count("\n") == 1, text


def test_a_damaged_key_signs_nothing(bundle: Path, keys: Path, tmp_path: Path) -> None:
    """A key without a password has no checksum."""
    lines = (keys / "plain.key").read_text().splitlines()
    data = bytearray(base64.b64decode(lines[1]))
    for place in (70, 110):  # in the secret and in the public half
        data[place] ^= 1
        (tmp_path / "key").write_text(f"{lines[0]}\n{base64.b64encode(data).decode()}\n")
        data[place] ^= 1
        code, text = chiasm("sign", tmp_path / "key", bundle)
        assert code == 1 and "key: damaged" in text and text.count("\n") == 1, text
        assert not (bundle / signing.SIGNATURE).exists()


def test_a_signature_is_written_whole_and_through_no_link(bundle: Path, keys: Path, tmp_path: Path) -> None:
    signature, victim = bundle / signing.SIGNATURE, tmp_path / "victim"
    victim.write_text("mine")
    signature.symlink_to(victim)
    sign(bundle, keys)
    assert victim.read_text() == "mine" and not signature.is_symlink()
    before = signature.read_bytes()
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, limit[1]))  # as on a full disk
    try:
        with pytest.raises(BundleError, match="minisig: File too large"):
            sign(bundle, keys, "other")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    assert signature.read_bytes() == before
    signing.check_signature(bundle, str(keys / "plain.pub"))  # and no other file was left


def test_links_and_pipes_are_not_signed(bundle: Path, keys: Path, tmp_path: Path) -> None:
    def refused(*arguments: str | Path) -> str:
        command = [sys.executable, "-m", "chiasm.export", *map(str, arguments)]
        environment = os.environ | {"PYTHONPATH": str(ROOT / "python")}
        result = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=30)
        assert result.returncode == 1 and result.stderr.startswith("Error: "), result.stderr
        return result.stderr

    os.mkfifo(tmp_path / "pipe.key")
    assert "pipe.key: not a regular file" in refused("sign", tmp_path / "pipe.key", bundle)
    for name in ("golden.safetensors", "manifest.json"):
        (bundle / name).rename(tmp_path / name)
        (bundle / name).symlink_to(tmp_path / name)
        said = refused("sign", keys / "plain.key", bundle)
        assert f"{name}: is a link that leaves the bundle's folder" in said
        (bundle / name).unlink()
        os.mkfifo(bundle / name)
        assert f"{name}: not a regular file" in refused("sign", keys / "plain.key", bundle)
        (bundle / name).unlink()
        (tmp_path / name).rename(bundle / name)
    sign(bundle, keys)
    said = refused("verify", bundle, "--key", tmp_path / "pipe.key")
    assert "neither a minisign public key nor a file" in said


def test_verify_with_a_key(bundle: Path, keys: Path) -> None:
    command = [sys.executable, "-m", "chiasm.export", "verify", str(bundle), "--key", str(keys / "plain.pub")]
    environment = os.environ | {"PYTHONPATH": str(ROOT / "python")}
    refused = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)
    assert (
        refused.returncode == 1 and refused.stderr.startswith("Error: ") and "is not signed" in refused.stderr
    )
    assert "Traceback" not in refused.stderr
    sign(bundle, keys)
    passed = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)
    assert passed.returncode == 0 and "signed by the key" in passed.stdout and "0 failed" in passed.stdout, (
        passed.stderr
    )


# Policies


def test_policies_of_the_runtime(bundle: Path, keys: Path) -> None:
    load = f"print(attempt(lambda: runtime.open({str(bundle)!r}).method().backend))"
    trusted = {
        "CHIASM_TRUST_POLICY": "signed",
        "CHIASM_TRUSTED_KEYS": f"{keys / 'other.pub'}:{keys / 'plain.pub'}",
    }
    by_call = f"runtime.set_trust('signed', [{str(keys / 'plain.pub')!r}])\n"
    for output in (child(load, **trusted), child(by_call + load)):
        assert output.startswith("UNTRUSTED: ") and "is not signed" in output and output.count("\n") == 1
    assert child("runtime.set_trust('data_only')\nprint(runtime.get_trust())\n" + load) == "data_only\nonnx\n"
    assert child(load, CHIASM_TRUST_POLICY="data_only") == "onnx\n"
    refused = child(
        f"print(attempt(lambda: runtime.open({str(bundle)!r}).method(backend='torch')))",
        CHIASM_TRUST_POLICY="data_only",
    )
    assert refused.startswith("UNTRUSTED: ") and "the trust policy is 'data_only'" in refused
    sign(bundle, keys)
    assert child(load, **trusted) == child(by_call + load) == "torch\n"
    frozen = child(load + "\nprint(attempt(lambda: runtime.set_trust('any')))")
    assert frozen.startswith(
        "torch\nFAILED_PRECONDITION: the trust policy cannot change after the first method was loaded"
    )
    load_by_env = child(load, CHIASM_TRUSTED_KEYS=trusted["CHIASM_TRUSTED_KEYS"])
    assert load_by_env.startswith(
        "INVALID_ARGUMENT: CHIASM_TRUSTED_KEYS is set and CHIASM_TRUST_POLICY is not"
    )
    nonsense = child("print(attempt(lambda: runtime.set_trust('some')))\n" + load, CHIASM_TRUST_POLICY="sign")
    assert nonsense.splitlines()[0].startswith(
        "INVALID_ARGUMENT: policy: expected 'any', 'signed' or 'data_only'"
    )
    assert nonsense.splitlines()[1].startswith("INVALID_ARGUMENT: CHIASM_TRUST_POLICY is 'sign'")


def test_policies_of_the_plugin_in_onnx_runtime(keys: Path, tmp_path: Path) -> None:
    sobel = tmp_path / "filters.sobel.chiasm"
    shutil.copytree(EXPORTED / sobel.name, sobel)
    model = str(sobel / "forward.float32.fused.onnx")
    session = f"""
import chiasm.onnx, onnxruntime, json
def ran():
  options = onnxruntime.SessionOptions()
  try: chiasm.onnx.register(options, [{str(sobel)!r}])
  except Exception as error: return "refused: " + str(error)
  options.enable_profiling, options.profile_file_prefix = True, {str(tmp_path / "profile")!r}
  options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_DISABLE_ALL
  made = onnxruntime.InferenceSession({model!r}, options)
  made.run(None, {{"input": np.ones((1, 3, 32, 32), np.float32)}})
  events = json.load(open(made.end_profiling()))
  nodes = {{e["args"].get("op_name") for e in events if e.get("cat") == "Node" and "args" in e}}
  return "native" if "filters_sobel" in nodes else "standard"
"""
    key = str(keys / "plain.pub")
    trusted = {"CHIASM_TRUST_POLICY": "signed", "CHIASM_TRUSTED_KEYS": key}
    by_call = f"runtime.set_trust('signed', [{key!r}])\n"
    assert child(session + "print(ran())") == "native\n"
    assert child(session + "print(ran())", CHIASM_TRUST_POLICY="data_only") == "standard\n"
    assert child("runtime.set_trust('data_only')\n" + session + "print(ran())") == "standard\n"
    for refused in (child(session + "print(ran())", **trusted), child(by_call + session + "print(ran())")):
        assert (
            refused.startswith("refused: ")
            and "is not signed, and the trust policy is 'signed'" in refused
            and refused.count("\n") == 1
        )
    # The fused form inside chiasm's own onnx backend: the plug-in opens the manifest that the core has
    # checked.
    fused = f"print(attempt(lambda: runtime.open({str(sobel)!r}).method(backend='onnx').artifact))"
    assert child(fused) == "forward.float32.fused.onnx\n"
    assert child(fused, CHIASM_TRUST_POLICY="data_only") == "forward.float32.onnx\n"
    sign(sobel, keys)
    assert (
        child(session + "print(ran())", **trusted) == child(by_call + session + "print(ran())") == "native\n"
    )
    assert child(by_call + fused) == child(fused, **trusted) == "forward.float32.fused.onnx\n"
    flip(sobel / "manifest.json", (sobel / "manifest.json").read_text().index("summary") + 15)
    assert "does not fit" in child(session + "print(ran())", **trusted)


def test_policies_of_chiasm_onnx(bundle: Path, keys: Path) -> None:
    code = f"""
import torch, chiasm.onnx
def node():
  made = chiasm.onnx.Node({str(bundle)!r})
  y, dropped = made(torch.ones(2, 3), torch.tensor(3.0), torch.ones(2, 3, dtype=torch.bool))
  return f"{{'onnx' if made.script is None else 'script'}} {{y.sum().item()}}"
def session():
  chiasm.onnx.session({str(bundle)!r}, fused=False)
  return "session"
def sequence():
  chiasm.onnx.ONNXSequential({str(bundle)!r})
  return "sequence"
def embed():
  chiasm.onnx.prepend({str(bundle)!r}, {str(bundle / "scale32.onnx")!r})
for f in (node, session):
  print(attempt(f))
"""
    more = "for f in (sequence, embed): print(attempt(f))\n"
    trusted = {"CHIASM_TRUST_POLICY": "signed", "CHIASM_TRUSTED_KEYS": str(keys / "plain.pub")}
    assert child(code) == "script 18.0\nsession\n"
    assert child(code, CHIASM_TRUST_POLICY="data_only") == "onnx 18.0\nsession\n"
    by_call = f"runtime.set_trust('signed', [{trusted['CHIASM_TRUSTED_KEYS']!r}])\n"
    for said in (child(code + more, **trusted), child(by_call + code + more)):
        assert said.count("UNTRUSTED: ") == said.count("is not signed, and the trust policy") == 4, said
    assert child(code, CHIASM_TRUST_POLICY="Signed").count("INVALID_ARGUMENT: CHIASM_TRUST_POLICY is") == 2
    sign(bundle, keys)
    assert child(code, **trusted) == "script 18.0\nsession\n"
    flip(bundle / "scale.pt", 100)
    changed = f"""
from chiasm.export.manifest import BundleError
try: chiasm.onnx.Node({str(bundle)!r})
except BundleError as error: print(error)
"""
    assert "scale.pt: sha256 differs" in child("import chiasm.onnx" + changed, **trusted)
    flip(bundle / "manifest.json", (bundle / "manifest.json").read_text().index("summary") + 15)
    assert child(code, **trusted).count("UNTRUSTED: ") == 2


# ONNX


def test_onnx_with_external_data_is_refused(tmp_path: Path) -> None:
    """Written by the onnx library itself, with the data's file next to the model."""
    weight = onnx.numpy_helper.from_array(np.ones((64, 64), np.float32), "w")
    info = onnx.helper.make_tensor_value_info
    graph = onnx.helper.make_graph(
        [onnx.helper.make_node("MatMul", ["x", "w"], ["y"])],
        "g",
        [info("x", 1, ["H", 64])],
        [info("y", 1, ["H", 64])],
        [weight],
    )
    model = onnx.helper.make_model(graph, opset_imports=[onnx.helper.make_opsetid("", 18)], ir_version=8)
    inside = model.SerializeToString()
    onnx.save_model(
        model, str(tmp_path / "m.onnx"), save_as_external_data=True, location="weights.bin", size_threshold=0
    )
    outside = (tmp_path / "m.onnx").read_bytes()
    for data, good in ((inside, True), (outside, False)):
        folder = tmp_path / str(good)
        folder.mkdir()
        method = {
            "inputs": [tensor("x", "float32", ["H", 64])],
            "outputs": [tensor("y", "float32", ["H", 64])],
            "artifacts": [artifact("onnx", "onnx", "forward.onnx", data, [])],
        }
        golden = {"forward/x": np.ones((2, 64), np.float32), "forward/y": np.full((2, 64), 64, np.float32)}
        cases = [{"prefix": "forward", "method": "forward", "dtype": None}]
        bundle = write_bundle(folder, "matmul", {"forward": method}, {"forward.onnx": data}, golden, cases)
        said = child(f"print(attempt(lambda: runtime.open({str(bundle)!r}).method(backend='onnx').backend))")
        if good:
            assert said == "onnx\n"
        else:
            assert said.startswith("CORRUPT: ") and "keeps data of a tensor in another file" in said


# The schema


def test_schema_versions(bundle: Path) -> None:
    import jsonschema

    def changed(version: int, **artifact: object) -> dict:
        result = json.loads((bundle / "manifest.json").read_text()) | {"schema_version": version}
        result["methods"]["forward"]["artifacts"][0].update(artifact)
        return result

    document = {"file": "sbom.cdx.json", "size": 2, "sha256": "0" * 64}
    second = changed(2, why="aten.foo") | {"documents": {"sbom": document}}
    third = changed(3, why="aten.foo", glibc="2.34", options={"device": "0"})
    for one in (changed(1), second, third):
        jsonschema.validate(one, schema())
    bad = [changed(1) | {"documents": {"sbom": document}}, changed(1, why="aten.foo"), changed(4)]
    bad += [changed(2, glibc="2.34"), changed(2, options={}), changed(3, glibc="2")]
    bad += [
        second | {"documents": {"sbom": document | change}}
        for change in ({"more": 1}, {"file": "../x"}, {"size": 0}, {"sha256": "x"})
    ]
    for one in bad:
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(one, schema())
