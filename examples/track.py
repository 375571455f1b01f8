"""Objects followed through a video: a detector in one thread, a tracker in another.

usage: track.py TRACKER FOLDER FRAMES OUT.png    makes FOLDER/my.squares.chiasm, which track.cpp runs too;
                                                 TRACKER: chiasm export ops.sort_track -o bundles
"""

import sys
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import torch

from chiasm import runtime
from chiasm.export import Spec, TensorSpec, export
from chiasm.geometry.bbox import transform_bbox
from chiasm.ops import decode_yolov8
from chiasm.pipelines import letterbox


def red_squares(frame: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Where your network would be: how red each window of 32 x 32 pixels is, its box and its score."""
    image, to_frame = letterbox(frame, (160, 160))
    red = torch.nn.functional.avg_pool2d(image[:, :1] - image[:, 1:2], 32, 4)
    place = torch.arange(33, device=frame.device) * 4.0 + 16.0
    down, across, side = place[:, None].expand_as(red), place.expand_as(red), torch.full_like(red, 32.0)
    boxes, _, _, found = decode_yolov8(torch.cat([across, down, side, side, red], 1).flatten(2), 0.4, 0.1, 8)
    return transform_bbox(to_frame, boxes), found


if len(sys.argv) != 5:
    sys.exit(__doc__)
tracker, folder, frames, out = sys.argv[1:]
inputs = [TensorSpec("frame", ("B", "H", "W", 3), "uint8", "NHWC", "BGR", (0, 255))]
spec = Spec("my.squares", inputs, [TensorSpec("boxes"), TensorSpec("found")], gradients=())
bundle = export(red_squares, spec, folder, formats=["onnx"])
detector, tracker = (runtime.open(b).method("forward") for b in (bundle, tracker))


def detect(k: int) -> tuple[np.ndarray, ...]:
    frame = np.zeros((320, 320, 3), np.uint8)  # where a camera would write
    for x, y in ((4 * k, 40), (240 - 4 * k, 180)):
        frame[y : y + 64, max(x, 0) : max(x + 64, 0), 2] = 255
    return frame, *detector(frame[None])


thread = ThreadPoolExecutor(1)
detected = thread.submit(detect, 0)
state = [np.zeros((1, 16, 7), np.float32), np.zeros((1, 16, 7, 7), np.float32)]  # no tracks in 16 slots
state += [np.zeros((1, 16, 4), np.int64), np.zeros(1, np.int64)]
for k in range(int(frames)):
    frame, boxes, found = detected.result()
    detected = thread.submit(detect, k + 1)
    *state, tracked, _, shown = tracker(*state, boxes, found)
    for slot in np.flatnonzero(shown):
        box = [round(v) for v in tracked[0, slot].tolist()]
        cv2.rectangle(frame, box[:2], box[2:], (255, 255, 255))
        print(state[2][0, slot, 0], box)
    cv2.imwrite(out, frame) or sys.exit(f"track: cannot write {out}")
