#!/usr/bin/env bash
# The wheel for aarch64, used under qemu: by Debian's Python, with NumPy and ONNX Runtime for aarch64, and by
# a C++ program that a cross-compiler makes with the wheel's CMake package. Bundles are those of
# tests/parity/aarch64.py.
set -euo pipefail
cd "$(dirname "$0")/../.."
root=$PWD work=$PWD/build/aarch64/wheel target=$PWD/.deps/aarch64
libraries=/usr/aarch64-linux-gnu/lib:$target/usr/lib/aarch64-linux-gnu:$target/lib/aarch64-linux-gnu
rm -rf "$work"
tools/aarch64.sh python
DIST=$work/dist tools/wheels.sh aarch64
case $(echo "$work"/dist/*.whl) in *-manylinux_*_aarch64.whl) ;; *) echo "expected one manylinux wheel for aarch64" && exit 1 ;; esac
.venv/bin/python -m zipfile -e "$work"/dist/*.whl "$work/site"
# Check that loaded files are for that CPU: a file for this machine would be skipped silently, with its
# backend.
others=$(find "$work/site" -name '*.so*' ! -exec sh -c 'readelf -h "$1" | grep -q "Machine: *AArch64"' _ {} \; -print)
[ -z "$others" ] || { echo "not for aarch64: $others" && exit 1; }

export() { PYTHONPATH=python .venv/bin/python -m chiasm export "$@" --isa x86-64-v3 --isa armv8.2-a --method forward -o "$work/bundles"; }
export filters.sobel color.rgb_to_hsv.frames -f native -f onnx

qemu() { qemu-aarch64 -L /usr/aarch64-linux-gnu -E LD_LIBRARY_PATH="$libraries" "$@"; }
qemu -E PYTHONHOME="$target/usr" -E PYTHONPATH="$work/site:$target/site" -E PYTHONDONTWRITEBYTECODE=1 \
  "$target"/usr/bin/python3.* tests/consumer/aarch64.py "$work"/bundles/*.chiasm

cmake -S tests/consumer/cpp -B "$work/cpp" -DCMAKE_TOOLCHAIN_FILE="$root/cmake/aarch64.cmake" -DCMAKE_BUILD_TYPE=Release \
  -Dchiasm_DIR="$work/site/chiasm/lib/cmake/chiasm" >/dev/null
cmake --build "$work/cpp" >/dev/null
qemu "$work/cpp/consumer" "$work/bundles/filters.sobel.chiasm"
echo "the wheel for aarch64: passed"
