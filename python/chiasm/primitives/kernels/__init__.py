"""The kernels: loops in C++ that compiled tensor code measurably cannot reach (runtime/artifact/kernels).

``declarations`` says of each kernel what it takes and makes. From that follow the operators that Python calls
(``operators``), and, when the package is built, the C++ header, the checked calls that AOTInductor's code
makes, and docs/kernels.md (runtime/artifact/generate.py). docs/architecture.md tells how to add one.
"""
