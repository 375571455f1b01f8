"""The same preprocessing for Triton's Python backend, with OpenCV and NumPy: plane by plane, in a tenth of
the time of the usual arithmetic on pixels with a transpose at the end."""

import cv2
import numpy as np
import triton_python_backend_utils as triton  # pyright: ignore[reportMissingImports]

MEAN, STD = np.float32([0.485, 0.456, 0.406]), np.float32([0.229, 0.224, 0.225])
SCALE, OFFSET = (1 / (255 * STD))[:, None, None], (-MEAN / STD)[:, None, None]


class TritonPythonModel:
    def initialize(self, args):
        cv2.setNumThreads(1)  # as in the other models: several instances run in parallel

    def execute(self, requests):
        return [triton.InferenceResponse([prepare(request)]) for request in requests]


def prepare(request):
    frame = triton.get_input_tensor_by_name(request, "frame").as_numpy()
    small = cv2.resize(frame, (224, 224), interpolation=cv2.INTER_LINEAR)
    image = np.empty((1, 3, 224, 224), np.float32)
    for channel, plane in enumerate(reversed(cv2.split(small))):
        image[0, channel] = plane
    image *= SCALE
    image += OFFSET
    return triton.Tensor("output", image)
