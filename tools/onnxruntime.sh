#!/usr/bin/env bash
# Lay out ONNX Runtime for CMake in .deps/onnxruntime: the library from the wheel, which has no headers, and
# the headers from Debian's libonnxruntime-dev, which is in Debian 13 and later; on an older Debian, this one
# package is taken from Debian 13 on the same mirror. CMake also accepts any onnxruntime release folder
# (-Donnxruntime_ROOT=).
set -euo pipefail
cd "$(dirname "$0")/.."
root=.deps/onnxruntime
wheel=$(.venv/bin/python -c 'import importlib.util, pathlib; print(pathlib.Path(importlib.util.find_spec("onnxruntime").origin).parent / "capi")')
mkdir -p "$root/lib"
library=$(ls "$wheel"/libonnxruntime.so.* | head -n 1)
ln -sfn "$library" "$root/lib/libonnxruntime.so.1"
ln -sfn libonnxruntime.so.1 "$root/lib/libonnxruntime.so"
[ -f "$root/include/onnxruntime_c_api.h" ] && exit 0

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/lists/partial" "$work/cache/archives/partial"
sources=/etc/apt/sources.list.d/debian.sources
[ -f "$sources" ] || sources=/etc/apt/sources.list
sed -E 's/\b(bullseye|bookworm)(-[a-z]+)?\b/trixie\2/g; s/\btrixie-updates\b//g' "$sources" > "$work/debian.${sources##*.}"
apt=(-qq -o Dir::Etc::sourcelist="$work/debian.${sources##*.}" -o Dir::Etc::sourceparts=/dev/null
  -o Dir::State::Lists="$work/lists" -o Dir::Cache="$work/cache" -o APT::Sandbox::User=root)
apt-get "${apt[@]}" update
(cd "$work" && apt-get "${apt[@]}" download libonnxruntime-dev && dpkg -x libonnxruntime-dev_*.deb tree)
rm -rf "$root/include" "$root/include.part"
cp -r "$work/tree/usr/include/onnxruntime" "$root/include.part"
mv "$root/include.part" "$root/include" # whole, or not at all
