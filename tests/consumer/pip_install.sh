#!/usr/bin/env bash
# Installs and uses the wheels from outside the source tree. (ctest covers cmake --install.)
#   alone:  an environment with only chiasm's wheel and NumPy
#   whole:  all three wheels with the packages of .venv, as by `pip install "chiasm[export,onnx,torch]"`
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
  case $wheel in *-manylinux_*) ;; *) echo "$wheel: expected a manylinux wheel" && exit 1 ;; esac
done

say "all three, with the packages of .venv"
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

say "the runtime alone"
"$root/.venv/bin/python" -m venv "$alone"
sed -nE 's/^([A-Za-z0-9_.-]+==[^ ]+).*/\1/p' "$root/requirements.txt" >"$work/constraints.txt"
install() { "$alone/bin/python" -m pip install --quiet --disable-pip-version-check -c "$work/constraints.txt" "$@"; }
install "$dist"/chiasm-*.whl "$work"/packs/*.whl
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
if said=$("$alone/bin/chiasm" export filters.sobel -o "$work/none" 2>&1); then echo "exported without torch" && exit 1; fi
[ "$said" = 'Error: this needs torch, which is not installed: pip install "chiasm[export]"' ] || { echo "$said" && exit 1; }
echo "pip install: passed"
