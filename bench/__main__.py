"""make bench [WHAT=NAME], a name in WHAT below: run a benchmark and write docs/benchmarks*.md. Each benchmark
exports only the bundles that it measures."""

from __future__ import annotations

import runpy
import sys

WHAT = (
    "speed",
    "images",
    "geometry",
    "peers",
    "memory",
    "matching",
    "serving",
    "ray",
    "letterbox",
    "networks",
    "augmentation",
    "kernels",
    "cuda",
)

if __name__ == "__main__":
    what, *sys.argv[1:] = sys.argv[1:] or ["speed"]
    if what not in WHAT:
        sys.exit(f"usage: make bench WHAT={'|'.join(WHAT)}; got {what!r}")
    runpy.run_module(f"bench.{what}", run_name="__main__", alter_sys=True)
