"""The bundle in Triton's Python backend: shows the gain of the C++ backend."""

import sys

import numpy as np
import triton_python_backend_utils as triton  # pyright: ignore[reportMissingImports]


class TritonPythonModel:
    def initialize(self, args):
        sys.path.insert(0, "@SOURCES@")
        import chiasm.runtime

        self.method = chiasm.runtime.open("@BUNDLE@").method(backend="native", num_threads=1)

    def execute(self, requests):
        return [triton.InferenceResponse([self.prepare(request)]) for request in requests]

    def prepare(self, request):
        frame = triton.get_input_tensor_by_name(request, "frame").as_numpy()
        return triton.Tensor("output", np.asarray(self.method(frame)))
