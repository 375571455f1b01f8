"""Runs the model.onnx beside it: ONNX Runtime in Triton's Python backend. Written by `chiasm triton`."""

import os

import numpy
import onnxruntime
import triton_python_backend_utils as triton  # pyright: ignore[reportMissingImports]


class TritonPythonModel:
    """A network. A request is one run on one thread, because instances already run in parallel."""

    def initialize(self, args):
        folder = os.path.join(args["model_repository"], args["model_version"])
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        self.session = onnxruntime.InferenceSession(
            os.path.join(folder, "model.onnx"), options, providers=["CPUExecutionProvider"]
        )
        self.outputs = [output.name for output in self.session.get_outputs()]

    def execute(self, requests):
        return [self.answer(request) for request in requests]

    def answer(self, request):
        """One request's answer. A request that fails does not affect the others."""
        try:
            inputs = {tensor.name(): tensor.as_numpy() for tensor in request.inputs()}
            arrays = self.session.run(self.outputs, inputs)
            made = [
                triton.Tensor(name, numpy.ascontiguousarray(array))
                for name, array in zip(self.outputs, arrays)
                if name in request.requested_output_names()
            ]
            return triton.InferenceResponse(made)
        except Exception as error:
            return triton.InferenceResponse([], triton.TritonError(str(error)))
