#!/usr/bin/env bash
# Make the environment in which chiasm.data is tested and measured: .deps/data, with Ray, Spark, Daft and no
# torch, and the Java that Spark needs.
# usage: tools/data.sh        Safe to run again, quick when nothing has changed.
set -euo pipefail
cd "$(dirname "$0")/.."
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }

if ! command -v java >/dev/null; then
  echo "installing the Debian package default-jre-headless, for Spark"
  as_root apt-get -qq update
  as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends default-jre-headless >/dev/null
fi

ABOUT="Ray, Spark and Daft: 1.6 GB" tools/environment.sh data tools/data.txt
# `import chiasm` from the source tree
site=$(.deps/data/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
echo "$PWD/python" > "$site/chiasm-source.pth"
