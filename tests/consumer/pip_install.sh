#!/usr/bin/env bash
# Installs and uses the wheels from outside the source tree. (ctest covers cmake --install.)
#   whole:  all four wheels with the packages of .venv, as by `pip install "chiasm[export,torch]"`
#   ops:    chiasm's and chiasm-ops's wheels with PyTorch and NumPy, as by `pip install "chiasm[ops]"`
#   alone:  an environment with only chiasm's wheel and NumPy
set -euo pipefail
cd "$(dirname "$0")/../.."
root=$PWD work=$PWD/build/pip
dist=$work/dist site=$work/site alone=$work/alone
rm -rf "$work"
mkdir -p "$work"
say() { printf '\033[1mpip install:\033[0m %s\n' "$*"; }

say "building the wheels"
DIST=$dist tools/wheels.sh
tools=$(.venv/bin/python -c 'import sys; print(".deps/wheels-%d.%d/bin" % sys.version_info[:2])')
for wheel in "$dist"/chiasm-*.whl "$dist"/chiasm_torch-*.whl; do
  PATH=$tools:$PATH "$tools/python" -m auditwheel show "$wheel" | tr -s '\n' ' ' | sed -E 's/ The wheel references .*/\n/'
done
for wheel in "$dist"/*.whl; do
  case $wheel in
    *-manylinux_*.whl | */chiasm_ops-*-py3-none-any.whl) ;;
    *) echo "$wheel: expected a manylinux wheel, or chiasm-ops for any machine" && exit 1 ;;
  esac
done
files() { for wheel in "$@"; do .venv/bin/python -m zipfile -l "$wheel" | sed -nE 's/^(chiasm\/[^ ]*[^ \/]) .*/\1/p'; done | sort; }
twice=$(files "$dist"/*.whl | uniq -d)
[ -z "$twice" ] || { echo "in two wheels: $twice" && exit 1; }
sources=$(cd python && find chiasm -path chiasm/artifact -prune -o \( -name '*.py' -o -name '*.pyi' -o -name '*.json' -o -name py.typed \) -print | sort)
nowhere=$(comm -23 <(echo "$sources") <(files "$dist"/*.whl))
[ -z "$nowhere" ] || { echo "in no wheel: $nowhere" && exit 1; }

say "chiasm-ops from another folder: the same bytes"
tree=$work/tree
mkdir "$tree"
cp -r --parents LICENSE packaging pyproject.toml tools/environment.sh tools/wheels.sh tools/wheels.txt "$tree"
xargs -d '\n' -I{} echo python/{} <<<"$sources" | xargs -d '\n' cp --parents -t "$tree"
ln -s "$root/.venv" "$root/.deps" "$tree"
DIST=$tree/dist "$tree/tools/wheels.sh" ops >/dev/null
cmp "$dist"/chiasm_ops-*.whl "$tree"/dist/chiasm_ops-*.whl

say "all four, with the packages of .venv"
.venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --target "$site" "$dist"/*.whl
tests/consumer/run_paths.sh "$root" "$site"
cd / # so that nothing is imported from the current folder
export PYTHONPATH=$site
"$root/.venv/bin/python" - <<'PY'
import os, pathlib
import chiasm, chiasm.export, chiasm.onnx, chiasm.runtime
site = pathlib.Path(os.environ["PYTHONPATH"])
for module in (chiasm, chiasm.export, chiasm.onnx, chiasm.runtime):
    assert pathlib.Path(module.__file__).is_relative_to(site), module.__file__
problems = {b.name: b.problem for b in chiasm.runtime.backends() if not b.available}
assert not problems, problems
assert [b.name for b in chiasm.runtime.backends()] == ["native", "torch", "onnx"]
assert chiasm.onnx.library().is_relative_to(site), chiasm.onnx.library()
PY
chiasm() { "$root/.venv/bin/python" "$site/bin/chiasm" "$@"; }
bundles=$work/bundles
chiasm export filters.sobel --method forward -o "$bundles"
chiasm export color.rgb_to_hsv -f native --method forward -o "$bundles"
chiasm verify "$bundles/filters.sobel.chiasm"
"$root/.venv/bin/python" -W error -c "import chiasm.onnx; chiasm.onnx.session('$bundles/filters.sobel.chiasm')"

say "a pack of bundles: the same bytes again, and left alone where it is there"
chiasm pack some "$bundles"/*.chiasm -o "$work/packs"
chiasm pack some "$bundles"/*.chiasm -o "$work/packs" | grep unchanged
cp -r "$bundles" "$work/elsewhere"
chiasm pack some "$work/elsewhere"/*.chiasm -o "$work/packs2"
cmp "$work"/packs/*.whl "$work"/packs2/*.whl
unset PYTHONPATH

say "the ops, with PyTorch and NumPy alone"
torch=$work/torch
mkdir "$torch"
packages=$("$root/.venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
for package in filelock fsspec functorch jinja2 markupsafe mpmath networkx numpy numpy.libs sympy torch torchgen typing_extensions.py; do
  ln -s "$packages/$package" "$torch"
done
"$root/.venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-deps --target "$work/ops" \
  "$dist"/chiasm-*.whl "$dist"/chiasm_ops-*.whl
PYTHONPATH=$work/ops:$torch "$root/.venv/bin/python" -S - <<'PY'
import importlib
import torch
import chiasm
from chiasm.extras import OPS
for family in OPS:
    importlib.import_module(f"chiasm.{family}")
edges = torch.jit.script(chiasm.filters.sobel)(torch.arange(8.0).expand(1, 1, 8, 8))
torch.testing.assert_close(edges[..., 1:-1], torch.ones(1, 1, 8, 6), rtol=0, atol=1e-5)
PY

say "the runtime alone"
"$root/.venv/bin/python" -m venv "$alone"
sed -nE 's/^([A-Za-z0-9_.-]+==[^ ]+).*/\1/p' "$root/requirements.txt" >"$work/constraints.txt"
install() { "$alone/bin/python" -m pip install --quiet --disable-pip-version-check -c "$work/constraints.txt" "$@"; }
install "$dist"/chiasm-*.whl "$work"/packs/*.whl
# The extension and libraries, sources, what pip compiles of them, folders, and the distribution's own files
folder=$("$alone/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
size=$(du -bc "$folder/chiasm" "$folder"/chiasm-*.dist-info | sed -nE 's/\ttotal$//p')
echo "installed: $size bytes"
[ "$size" -le 5000000 ] || { echo "expected at most 5 MB" && exit 1; }
"$alone/bin/python" "$root/tests/consumer/alone.py"

say "C++ and C from the wheel: CMake by --cmakedir and by the entry point cmake.prefix, pkg-config"
bundle=$("$alone/bin/python" -c 'from chiasm import packs; print(packs.find("filters.sobel"))')
prefix=$("$alone/bin/python" -c '
from importlib.metadata import entry_points
from importlib.util import find_spec
[entry] = entry_points(group="cmake.prefix", name="chiasm")
print(find_spec(entry.value).submodule_search_locations[0])')
for found in "-Dchiasm_DIR=$("$alone/bin/python" -m chiasm --cmakedir)" "-DCMAKE_PREFIX_PATH=$prefix"; do
  rm -rf "$work/cpp"
  cmake -S "$root/tests/consumer/cpp" -B "$work/cpp" "$found" -DCMAKE_BUILD_TYPE=Release >/dev/null
  cmake --build "$work/cpp" >/dev/null
  "$work/cpp/consumer" "$bundle"
done
libraries=$("$alone/bin/chiasm" --libdir)
test -e "$("$alone/bin/chiasm" --includedir)/chiasm/chiasm.h"
# shellcheck disable=SC2046  # one flag per word
cc -std=c11 "$root/tests/consumer/c/consumer.c" -o "$work/consumer_c" \
  $(PKG_CONFIG_PATH="$libraries/pkgconfig" pkg-config --cflags --libs chiasm) "-Wl,-rpath,$libraries"
"$work/consumer_c" "$bundle"

say "the command, with the extra cli and no torch"
install "$(echo "$dist"/chiasm-*.whl)[cli]"
"$alone/bin/chiasm" info "$bundle" >"$work/info.txt"
grep -q native "$work/info.txt"
"$alone/bin/chiasm" verify "$bundle"
"$alone/bin/python" -c 'from PIL import Image; Image.new("RGB", (64, 48), "white").save("'"$work"'/white.png")'
"$alone/bin/chiasm" run "$bundle" "$work/white.png" "$work/edges.png"
missing='which is not installed: pip install' without='(bundles run without it: chiasm.runtime)'
# refused LAST_LINE COMMAND...: it fails with this last line
refused() {
  local said
  if said=$("${@:2}" 2>&1); then echo "expected a failure: ${*:2}" && exit 1; fi
  [ "${said##*$'\n'}" = "$1" ] || { echo "$said" && exit 1; }
}
exporting=("$alone/bin/chiasm" export filters.sobel -o "$work/none")
refused "Error: chiasm.export.catalog belongs to the distribution chiasm-ops, $missing \"chiasm[export]\" $without" "${exporting[@]}"
install --no-deps "$dist"/chiasm_ops-*.whl
refused "Error: this needs torch, $missing \"chiasm[export]\"" "${exporting[@]}"
for family in filters geometry pipelines primitives; do
  refused "ImportError: the ops of chiasm need PyTorch, $missing \"chiasm[ops]\" $without" "$alone/bin/python" -c "import chiasm.$family"
done
echo "pip install: passed"
