#!/usr/bin/env bash
# Make the site, build/site/html: the Markdown pages, a page for each op of the catalog, and a page on which
# ops run live in the browser. A broken link is an error.
# usage: tools/site.sh
set -euo pipefail
cd "$(dirname "$0")/.."
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }
tools/environment.sh site tools/site/site.txt
if ! command -v doxygen >/dev/null; then
  echo "installing the Debian package doxygen"
  as_root apt-get -qq update
  as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends doxygen >/dev/null
fi

source=build/site/source
rm -rf build/site
mkdir -p $source
cp tools/site/index.md tools/site/interface.md $source
doxygen tools/site/Doxyfile
# The pages, and the files to which they link
tar c --exclude=python/chiasm/artifact --exclude='*.so' --exclude=__pycache__ --exclude=corpus --exclude=frozen ./*.md LICENSE Makefile bench cmake docs \
  examples gallery include packaging python runtime studies tests tools | tar x -C $source
PYTHONPATH=python .venv/bin/python tools/site/reference.py $source/reference
.deps/site/bin/python -m sphinx -q -W --keep-going -c tools/site $source build/site/html
tools/browser.sh runtime
PYTHONPATH=python:. .venv/bin/python tools/site/live.py build/site/html/live
echo "build/site/html/index.html"
