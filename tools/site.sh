#!/usr/bin/env bash
# Make the site, build/site/html, of the Markdown pages that are there, of a page for each op of the catalog, and of one where ops run live in
# the browser. A link that leads nowhere is an error.
# usage: tools/site.sh
set -euo pipefail
cd "$(dirname "$0")/.."
tools/environment.sh site tools/site/site.txt

source=build/site/source
rm -rf build/site
mkdir -p $source
cp tools/site/index.md $source
# What pages are, and what they lead to
tar c --exclude=python/chiasm/artifact --exclude='*.so' --exclude=__pycache__ --exclude=corpus --exclude=frozen ./*.md LICENSE Makefile bench cmake docs \
  examples gallery include packaging python runtime studies tests tools | tar x -C $source
PYTHONPATH=python .venv/bin/python tools/site/reference.py $source/reference
.deps/site/bin/python -m sphinx -q -W --keep-going -c tools/site $source build/site/html
tools/browser.sh runtime
PYTHONPATH=python:. .venv/bin/python tools/site/live.py build/site/html/live
echo "build/site/html/index.html"
