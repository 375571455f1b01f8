"""The kernels: C++ loops for ops for which compiled tensor code is measurably slower
(runtime/artifact/kernels).

``declarations`` declares each kernel's arguments and result. The operators that Python calls (``operators``)
are generated from it, and, when the package is built, the C++ header, the checked calls that AOTInductor's
code makes, and docs/kernels.md (runtime/artifact/generate.py). docs/howto/kernel.md describes how to add one.
"""
