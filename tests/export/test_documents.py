"""A bundle's documents on its origin; and bundles are identical wherever they are made."""

import gzip
import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest
import torch
from referencing import Registry, Resource
from torch import Tensor, nn

from chiasm.export import Spec, TensorSpec, documents, export, image
from chiasm.export.documents import sbom
from chiasm.export.manifest import read_manifest
from chiasm.export.verify import verify
from chiasm.filters import box_blur

ROOT = Path(__file__).resolve().parents[2]

MY_OP = '''
from torch import Tensor


def halves(input: Tensor) -> Tensor:
    """Half of it."""
    assert input.dim() == 4, "halves: expected 4 dimensions"
    return input * 0.5
'''


def _validator() -> jsonschema.Validator:
    """CycloneDX's own schemas (github.com/CycloneDX/specification, Apache License 2.0)."""
    schemas = json.loads(
        gzip.decompress((Path(__file__).parent / "data" / "cyclonedx-1.6.json.gz").read_bytes())
    )
    registry = Registry().with_resources((s["$id"], Resource.from_contents(s)) for s in schemas.values())
    return jsonschema.Draft7Validator(
        schemas["bom-1.6"], registry=registry, format_checker=jsonschema.Draft7Validator.FORMAT_CHECKER
    )


def _documents(bundle: Path) -> tuple[dict, dict]:
    return tuple(json.loads((bundle / name).read_text()) for name in ("sbom.cdx.json", "provenance.json"))


def test_the_list_of_parts_is_cyclonedx_and_names_every_file(bundle: Path) -> None:
    parts, _ = _documents(bundle)
    _validator().validate(parts)
    files = {c["name"]: c["hashes"][0]["content"] for c in parts["components"] if c["type"] == "file"}
    assert set(files) == {p.name for p in bundle.iterdir()} - {
        "manifest.json",
        "sbom.cdx.json",
        "provenance.json",
    }
    for name, digest in files.items():
        assert hashlib.sha256((bundle / name).read_bytes()).hexdigest() == digest
    versions = {c["name"]: c.get("version") for c in parts["components"]}
    assert versions["torch"] == torch.__version__.split("+")[0] or versions["torch"] == torch.__version__
    assert (
        versions["g++"]
        == subprocess.run(
            ["g++", "-dumpfullversion"], capture_output=True, text=True, check=True
        ).stdout.strip()
    )
    assert "libc.so.6" in versions and versions["libstdc++"] == versions["libgcc"] == versions["g++"]
    assert not any(
        ".so" in name and not name.startswith(("libc.", "libm.", "libmvec.", "ld-linux")) for name in versions
    )
    assert not any("torch" in name and name != "torch" for name in versions)
    wrong = parts | {"components": [{"type": "nonsense", "name": "x"}]}
    assert not _validator().is_valid(wrong)


def _parts_of(bundle: Path, **artifact: object) -> dict[str, str | None]:
    """The versions in the list of parts if a native artifact of the bundle were another one."""
    manifest = read_manifest(bundle)
    native = next(a for a in manifest["methods"]["forward"]["artifacts"] if "isa" in a)
    file, _ = native["file"], native.pop("isa")
    manifest["methods"] = {"forward": {"artifacts": [native | artifact]}}
    parts = json.loads(sbom(manifest, {file: (bundle / file).read_bytes()}))
    return {c["name"]: c.get("version") for c in parts["components"]}


def test_the_parts_of_code_for_gpus_alone_have_the_compilers_version(bundle: Path) -> None:
    cpu, gpu = _parts_of(bundle, isa="x86-64-v3"), _parts_of(bundle, sm=90)
    assert gpu == cpu and cpu["g++"] and cpu["libstdc++"] == cpu["g++"]


def test_the_parts_of_cross_compiled_code_do_not_have_this_machines_glibc(
    bundle: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(documents, "compiler_command", lambda isa: "g++")  # a cross-compiler may be missing
    here, elsewhere = _parts_of(bundle, isa="x86-64-v3"), _parts_of(bundle, isa="armv8.2-a")
    assert here["libc.so.6"] and elsewhere == here | {
        name: None for name in here if name.startswith(("libc.", "libm.", "libmvec.", "ld-linux"))
    }


def test_the_provenance_is_an_in_toto_statement_of_every_file(bundle: Path) -> None:
    _, statement = _documents(bundle)
    assert (
        statement["_type"] == "https://in-toto.io/Statement/v1"
        and statement["predicateType"] == "https://slsa.dev/provenance/v1"
    )
    subjects = {s["name"]: s["digest"]["sha256"] for s in statement["subject"]}
    assert set(subjects) == {p.name for p in bundle.iterdir()} - {"manifest.json", "provenance.json"}
    for name, digest in subjects.items():
        assert hashlib.sha256((bundle / name).read_bytes()).hexdigest() == digest
    build = statement["predicate"]["buildDefinition"]
    assert (
        set(build) >= {"buildType", "externalParameters"}
        and statement["predicate"]["runDetails"]["builder"]["id"]
    )
    assert build["externalParameters"]["config"] == {"power": 2.0} and build["externalParameters"][
        "formats"
    ] == ["torchscript", "onnx", "native"]
    sources = {d["name"]: d["digest"]["sha256"] for d in build["resolvedDependencies"] if "digest" in d}
    assert sources == {
        "tests.export.conftest": (
            hashlib.sha256((Path(__file__).parent / "conftest.py").read_bytes()).hexdigest()
        )
    }


def test_the_manifest_names_both(bundle: Path) -> None:
    documents = read_manifest(bundle)["documents"]
    for kind, name in (("sbom", "sbom.cdx.json"), ("provenance", "provenance.json")):
        data = (bundle / name).read_bytes()
        assert documents[kind] == {
            "file": name,
            "size": len(data),
            "sha256": hashlib.sha256(data).hexdigest(),
        }


def second(a: Tensor) -> Tensor:
    return torch.kthvalue(a, 2, dim=0)[0]


def blurred(a: Tensor) -> Tensor:
    """A function of libtorch, and a kernel of chiasm."""
    return box_blur(torch.kthvalue(a, 1, dim=0, keepdim=True)[0], 3)


def test_an_artifact_says_what_it_needs_libtorch_for(tmp_path: Path) -> None:
    """AOTInductor leaves the k-th value to libtorch; chiasm's replacement has no such function."""
    spec = Spec("test.second", [TensorSpec("a", ("N",), "uint8", range=(0, 255))], symbols={"N": (2, 1000)})
    bundle = export(second, spec, tmp_path, formats=["native"])
    # Such code has no kernels of chiasm either, which libtorch does not know
    shape = ("B", "C", "H", "W")
    images = TensorSpec("a", shape, "uint8", range=(0, 255))
    rows = verify(export(blurred, Spec("test.blurred", [images]), tmp_path, formats=["native"]))
    assert [(row.backend, row.passed) for row in rows] == [("torch", True)]
    [artifact] = read_manifest(bundle)["methods"]["forward"]["artifacts"]
    assert artifact["needs"] == ["libtorch"] and "aoti_torch_cpu_kthvalue" in artifact["why"]
    parts, _ = _documents(bundle)
    _validator().validate(parts)
    assert {c["name"]: c.get("scope") for c in parts["components"]}["libtorch_cpu.so"] == "required"


def test_a_modules_classes_are_its_sources(tmp_path: Path) -> None:
    class Twice(nn.Module):
        def forward(self, input: Tensor) -> Tensor:
            return input * 2

    bundle = export(
        nn.Sequential(Twice(), nn.ReLU()),
        Spec("test.twice", [image()]),
        tmp_path,
        formats=["onnx"],
        methods=["forward"],
    )
    dependencies = _documents(bundle)[1]["predicate"]["buildDefinition"]["resolvedDependencies"]
    assert [d["name"] for d in dependencies if "digest" in d] == [__name__]


def test_the_same_bytes_wherever_it_is_made(tmp_path: Path) -> None:
    """With other paths of the op, of chiasm and of the bundle, another home, cache and working folder, and
    another user name."""
    program = """
import sys
from my_op import halves
from chiasm.export import Spec, export, image
export(halves, Spec("test.halves", [image()]), sys.argv[1], formats=["torchscript", "onnx"])
"""
    found = []
    for number in ("1", "second/place"):
        place = tmp_path / number
        for folder in ("home", "work", "source"):
            (place / folder).mkdir(parents=True)
        (place / "source" / "my_op.py").write_text(MY_OP)
        python = ROOT / "python"
        if number != "1":
            ignore = shutil.ignore_patterns("__pycache__")
            python = Path(
                shutil.copytree(ROOT / "python" / "chiasm", place / "chiasm_copy" / "chiasm", ignore=ignore)
            ).parent
        environment = {
            "PATH": os.environ["PATH"],
            "HOME": str(place / "home"),
            "CHIASM_CACHE": str(place / "cache"),
            "USER": f"user{len(number)}",
            "PYTHONPATH": f"{place / 'source'}:{python}",
            "SOURCE_DATE_EPOCH": "1700000000",
            "PYTHONHASHSEED": str(len(number)),
        }
        subprocess.run(
            [sys.executable, "-W", "ignore", "-c", program, str(place / "out")],
            cwd=place / "work",
            env=environment,
            check=True,
            timeout=200,
        )
        bundle = place / "out" / "test.halves.chiasm"
        found.append({p.name: p.read_bytes() for p in bundle.iterdir()})
        assert not [
            name
            for name, data in found[-1].items()
            if str(place).encode() in data or str(ROOT).encode() in data
        ]
    assert set(found[0]) == {
        "manifest.json",
        "golden.safetensors",
        "sbom.cdx.json",
        "provenance.json",
        "forward.pt",
        *(f"{m}.float32.{f}" for m in ("forward", "vjp") for f in ("onnx", "fused.onnx")),
    }
    assert [name for name in found[0] if found[0][name] != found[1][name]] == []
    assert json.loads(found[0]["manifest.json"])["created"] == "2023-11-14T22:13:20Z"


def test_the_same_torchscript_whatever_the_process_exported_before() -> None:
    """The ops share primitives, each of which has several functions of the same name."""
    program = """
import hashlib, sys
from chiasm.export.catalog import catalog
from chiasm.export.formats.torchscript import to_torchscript
from chiasm.export.tracing.module import bind_spec
for name in sys.argv[1:]:
    spec = catalog()[name].spec
    print(name, hashlib.sha256(to_torchscript(bind_spec(catalog()[name].function(), spec), spec)).hexdigest())
"""
    names = ["enhance.sharpness", "filters.filter2d", "filters.sobel.frames", "filters.spatial_gradient"]
    found = []
    for order in (names, names[::-1]):
        command = [sys.executable, "-c", program, *order]
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=200)
        found.append(sorted(done.stdout.splitlines()))
    assert len(found[0]) == len(names)
    assert found[0] == found[1]
