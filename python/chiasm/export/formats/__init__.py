"""The formats that a method is exported to, a module each with `lower(job, method)`, which yields artifacts.

| module | makes | for the backend |
|---|---|---|
| `torchscript.py` | `forward.pt` | torch |
| `native.py` | `METHOD.ISA.pt2`: AOTInductor's code; `compiler.py` runs the C++ compiler, `index_ranges.py` proves indices | native |
| `onnx.py` | `METHOD.onnx` and, as one function (`onnx_function.py`), `METHOD.fused.onnx` | onnx |
"""
