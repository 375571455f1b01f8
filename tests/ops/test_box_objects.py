"""Boxes and key points as objects, compared with torchvision, OpenCV and NumPy."""

import cv2
import numpy as np
import pytest
import torch
import torchvision.ops

from chiasm.geometry.boxes import Boxes, Boxes3D, VideoBoxes
from chiasm.geometry.keypoints import Keypoints, Keypoints3D, VideoKeypoints

BOXES = torch.tensor(
    [[[1.0, 2.0, 4.0, 6.0], [3.0, 4.0, 8.0, 9.0]], [[0.0, 1.0, 5.0, 3.0], [2.0, 2.0, 3.0, 7.0]]]
)
TURN = torch.tensor(
    [
        [[0.0, -1.0, 9.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        [[2.0, 0.0, 1.0], [0.0, 3.0, 2.0], [0.0, 0.0, 1.0]],
    ]
)


def test_formats() -> None:
    made = Boxes.from_tensor(BOXES)
    sizes = torchvision.ops.box_convert(BOXES, "xyxy", "xywh")
    assert made.to_tensor().equal(BOXES) and made.mode == "xyxy"
    assert made.to_tensor("xywh").equal(sizes)
    assert made.to_tensor("xyxy_plus").equal(BOXES - torch.tensor([0.0, 0.0, 1.0, 1.0]))
    for mode in ("xyxy", "xyxy_plus", "xywh", "vertices", "vertices_plus"):
        again = Boxes.from_tensor(made.to_tensor(mode), mode)
        assert again.data.equal(made.data) and again.to_tensor().equal(made.to_tensor(mode))
    assert Boxes.from_tensor(BOXES[0]).to_tensor().equal(BOXES[0])
    assert Boxes.from_tensor(BOXES.long()).dtype == torch.float32
    height, width = made.get_boxes_shape()
    assert width.equal(sizes[..., 2]) and height.equal(sizes[..., 3])
    area = [[cv2.contourArea(v.numpy()) for v in image] for image in made.data]
    np.testing.assert_allclose(made.compute_area(), area)


def test_boxes_move_with_the_image() -> None:
    made = Boxes.from_tensor(BOXES)
    moved = made.transform_boxes(TURN)
    for i in range(2):
        expected = cv2.perspectiveTransform(made.data[i].numpy(), TURN[i].numpy())
        np.testing.assert_allclose(moved.data[i], expected)
    canvas = torch.zeros(2, 16, 40)
    masks = made.to_mask(16, 40)
    for i, boxes in enumerate(BOXES.long()):
        for k, (x1, y1, x2, y2) in enumerate(boxes.tolist()):
            canvas[i].zero_()[y1:y2, x1:x2] = 1
            assert masks[i, k].equal(canvas[i])
    between = Boxes.from_tensor(torch.tensor([[1.6, 2.2, 4.7, 5.1]])).to_mask(8, 8)[0]
    assert between[2:5, 2:5].all() and between.sum() == 9
    assert made.to_tensor().equal(BOXES)
    assert made.transform_boxes_(TURN) is made and made.data.equal(moved.data)
    shift = torch.tensor([[2.0, 5.0]])
    assert moved.translate(shift).to_tensor().equal(moved.to_tensor() + torch.tensor([2.0, 5.0, 2.0, 5.0]))
    border = torch.tensor([[2, 1, 5, 3]])
    padded = moved.clone().pad(border)
    assert padded.data.equal(moved.translate(shift).data) and padded.unpad(border).data.equal(moved.data)


def test_boxes_that_are_kept() -> None:
    made = Boxes.from_tensor(BOXES)
    inside = made.clamp(torch.tensor([[2.0, 3.0]]), torch.tensor([[5.0, 6.0]])).to_tensor("xyxy_plus")
    low, high = torch.tensor([2.0, 3.0, 2.0, 3.0]), torch.tensor([5.0, 6.0, 5.0, 6.0])
    expected = (BOXES - torch.tensor([0.0, 0.0, 1.0, 1.0])).clamp(low, high)
    assert inside.equal(expected)
    large = made.filter_boxes_by_area(min_area=5.0, max_area=10.0)
    kept = ((made.compute_area() >= 5) & (made.compute_area() <= 10))[..., None, None]
    assert large.data.equal(made.data * kept) and 0 < kept.sum() < 4
    both = made.merge(large)
    assert both.shape == (2, 4, 4, 2) and both[1].data.equal(torch.cat([made[1].data, large[1].data]))
    made[0] = large[0]
    assert made.data[0].equal(large.data[0])
    put = made.index_put((torch.tensor([1]), torch.tensor([0])), torch.zeros(1, 4, 2))
    assert not put.data[1, 0].any() and made.data[1, 0].any()


def test_images_with_different_numbers_of_boxes() -> None:
    few = [BOXES[0], BOXES[1][:1]]
    made = Boxes.from_tensor(few)
    assert all(a.equal(b) for a, b in zip(made.to_tensor(), few))
    assert made.to_tensor(as_padded_sequence=True).shape == (2, 2, 4)
    masks = made.to_mask(10, 10)
    assert masks[:, 0].any() and masks[0, 1].any() and not masks[1, 1].any()
    both = made.merge(Boxes.from_tensor(BOXES)).to_tensor()
    assert [len(b) for b in both] == [4, 3] and both[1].equal(torch.cat([few[1], BOXES[1]]))


def test_boxes_of_volumes() -> None:
    boxes = torch.tensor([[1.0, 0.0, 2.0, 3.0, 4.0, 5.0], [0.0, 1.0, 1.0, 2.0, 2.0, 6.0]])
    made = Boxes3D.from_tensor(boxes)
    assert made.to_tensor().equal(boxes) and made.shape == (2, 8, 3)
    for mode in ("xyzxyz", "xyzxyz_plus", "xyzwhd"):
        assert Boxes3D.from_tensor(made.to_tensor(mode), mode).data.equal(made.data)
    masks = made.to_mask(6, 5, 7)
    for mask, (x1, y1, z1, x2, y2, z2) in zip(masks, boxes.long().tolist()):
        expected = torch.zeros(6, 5, 7)
        expected[z1:z2, y1:y2, x1:x2] = 1
        assert mask.equal(expected)
    depth, height, width = made.get_boxes_shape()
    assert torch.stack([width, height, depth], -1).equal(boxes[:, 3:] - boxes[:, :3])
    matrix = torch.diag(torch.tensor([2.0, 1.0, 1.0, 1.0]))
    assert made.transform_boxes(matrix).data.equal(made.data * torch.tensor([2.0, 1.0, 1.0]))


def test_boxes_of_videos() -> None:
    vertices = Boxes.from_tensor(BOXES).data[:, None].repeat(1, 3, 1, 1, 1)
    made = VideoBoxes.from_tensor(vertices)
    assert made.to_tensor().equal(vertices) and made.to_tensor("xyxy").shape == (2, 3, 2, 4)
    assert made[1].to_tensor().equal(vertices[1:]) and made[:1].to_tensor().equal(vertices[:1])
    moved = made.transform_boxes(TURN.repeat_interleave(3, 0))
    expected = Boxes.from_tensor(BOXES).transform_boxes(TURN).to_tensor("vertices_plus")
    assert moved.to_tensor()[:, 2].equal(expected)


def test_key_points() -> None:
    points = torch.rand(2, 5, 2)
    made = Keypoints.from_tensor(points)
    moved = made.transform_keypoints(TURN)
    for i in range(2):
        expected = cv2.perspectiveTransform(points[i].numpy()[:, None], TURN[i].numpy())[:, 0]
        np.testing.assert_allclose(moved.data[i], expected, rtol=1e-6)
    assert made[1].transform_keypoints(TURN[1]).data.equal(moved.data[1])
    border = torch.tensor([[2, 1, 5, 3]])
    padded = made.clone().pad(border)
    assert padded.data.equal(points + torch.tensor([2.0, 5.0]))
    torch.testing.assert_close(padded.unpad(border).data, points)
    video = VideoKeypoints.from_tensor(points[:, None].repeat(1, 3, 1, 1))
    video = video.transform_keypoints(TURN.repeat_interleave(3, 0))
    assert video.to_tensor()[:, 1].equal(moved.data)
    clips = torch.rand(4, 3, 5, 2)
    video = VideoKeypoints.from_tensor(clips.clone())
    assert video[1].to_tensor().equal(clips[1:2]) and video[1:3].to_tensor().equal(clips[1:3])
    for one in (torch.tensor(1), np.int64(1), slice(1, 2)):
        assert video[one].to_tensor().equal(clips[1:2])
    for parts in ((slice(None), 1), None):
        with pytest.raises(
            IndexError, match=r"key: expected one that selects whole videos of \[4, 3, 5, 2\]"
        ):
            video[parts]
    assert video[torch.tensor([True, False, False, True])].to_tensor().equal(clips[[0, 3]])
    video[2:] = video[:2]
    assert video.to_tensor().equal(clips[[0, 1, 0, 1]])
    video[0] = video[1]
    assert video.to_tensor().equal(clips[[1, 1, 0, 1]])
    space = torch.rand(4, 3)
    assert Keypoints3D(space).transform_keypoints(torch.eye(4)).data.equal(space)
    assert Keypoints.from_tensor(torch.tensor([[1, 2]])).dtype == torch.float32


def test_what_is_refused() -> None:
    for call, message in (
        (
            lambda: Boxes.from_tensor(torch.tensor([[4.0, 2.0, 1.0, 6.0]])),
            "expected positive widths and heights",
        ),
        (
            lambda: Boxes.from_tensor(torch.rand(4)),
            r"boxes: expected shape \(N, 4\) or \(B, N, 4\), got \[4\]",
        ),
        (lambda: Boxes.from_tensor(BOXES, "yxyx"), "mode: expected one of"),
        (lambda: Boxes(torch.rand(3, 4, 3)), "boxes: expected shape"),
        (lambda: Boxes.from_tensor(BOXES).transform_boxes(torch.eye(4)), "M: expected shape"),
        (
            lambda: Boxes.from_tensor(BOXES).transform_boxes(torch.eye(3).repeat(3, 1, 1)),
            "M: expected 1 or 2",
        ),
        (lambda: Boxes.from_tensor(BOXES).translate(torch.zeros(3, 2)), "expected numbers for 1 or 2 images"),
        (lambda: Boxes3D.from_tensor(torch.zeros(1, 6)), "expected positive widths, heights and depths"),
        (lambda: VideoBoxes.from_tensor(BOXES), "boxes: expected shape"),
        (lambda: Keypoints(torch.rand(3)), "keypoints: expected shape"),
        (lambda: Keypoints(torch.rand(3, 2)).transform_keypoints(torch.eye(2)), "M: expected shape"),
        (lambda: Keypoints(torch.rand(3, 2)).pad(torch.ones(2, 4)), "padding_size: expected shape"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
    for made in (Boxes, Keypoints):
        with pytest.raises(TypeError, match="expected a floating-point tensor"):
            made(torch.ones(1, 4, 2).long())


def test_padding_of_a_list_is_no_box_in_any_format() -> None:
    for mode in ("xyxy", "xyxy_plus", "xywh", "vertices", "vertices_plus"):
        image = Boxes.from_tensor(BOXES[0]).to_tensor(mode)
        made = Boxes.from_tensor([image, image[:1]], mode)
        assert made.data[0].equal(Boxes.from_tensor(BOXES[0]).data) and not made.data[1, 1:].any()


def test_vertices_of_volumes() -> None:
    made = Boxes3D.from_tensor(torch.tensor([[1.0, 2.0, 3.0, 5.0, 7.0, 9.0]]))
    for mode, end in (("vertices", (5, 7, 9)), ("vertices_plus", (4, 6, 8))):
        (x1, y1, z1), (x2, y2, z2) = (1, 2, 3), end
        face = [(x1, y1), (x2, y1), (x2, y2), (x1, y2)]
        assert made.to_tensor(mode).tolist() == [[[x, y, z] for z in (z1, z2) for x, y in face]]
    assert made.to_tensor("vertices_plus").equal(made.data)
