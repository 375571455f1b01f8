"""The formats to which a method is exported. Each has a module with `lower(job, method)`, which yields
artifacts.

| module | makes | for the backend |
|---|---|---|
| `torchscript.py` | `forward.pt` | torch |
| `native.py` (for the CPUs and GPUs of `../isas.py`) | `METHOD.ISA.pt2`: AOTInductor's code | native |
| `onnx.py` | `METHOD.onnx` and, as one function (`../onnx_function.py`), `METHOD.fused.onnx` | onnx |
"""
