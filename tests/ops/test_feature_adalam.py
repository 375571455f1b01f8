"""Matching by local affine maps: on scenes with known matches, compared with ratio tests, and against loops
in NumPy."""

import math

import numpy as np
import pytest
import torch
from torch import Tensor

from chiasm import feature

HEIGHT, WIDTH = 480, 640
SIZE = (HEIGHT, WIDTH)


class Scene:
    """Frames in one image, and the same frames mapped by ``moved`` into a second image, in another order.
    Some frames of the second image are random instead."""

    def __init__(
        self, count: int, wrong: int, seed: int, moved: object, noise: float = 0.5, difference: float = 1.2
    ) -> None:
        self.random = np.random.default_rng(seed)
        centre = self.random.uniform(0, 1, (count, 2)) * (WIDTH, HEIGHT)
        frame1 = self.frames(centre)
        frame2 = moved(frame1) @ np.eye(3)
        angle, growth = self.random.normal(0, 0.08, count), np.exp(self.random.normal(0, 0.08, count))
        turn = growth * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        frame2[..., :2] = frame2[..., :2] @ turn.transpose(2, 0, 1)
        frame2[..., 2] += self.random.normal(0, noise, (count, 2))
        first = self.unit(self.random.normal(size=(count, 64)))
        second = self.unit(first + difference / 8 * self.random.normal(size=(count, 64)))
        frame2[:wrong] = self.frames(self.random.uniform(0, 1, (wrong, 2)) * (WIDTH, HEIGHT))
        second[:wrong] = self.unit(self.random.normal(size=(wrong, 64)))
        order = self.random.permutation(count)
        self.partner = np.argsort(order)
        self.partner[:wrong] = -1
        self.desc1, self.desc2 = (torch.from_numpy(x).float()[None] for x in (first, second[order]))
        self.lafs1, self.lafs2 = (torch.from_numpy(x).float()[None] for x in (frame1, frame2[order]))

    def frames(self, centre: np.ndarray) -> np.ndarray:
        angle, scale = self.random.uniform(0, 2 * np.pi, len(centre)), self.random.uniform(3, 12, len(centre))
        matrix = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return np.concatenate([matrix.transpose(2, 0, 1), centre[..., None]], -1)

    @staticmethod
    def unit(x: np.ndarray) -> np.ndarray:
        return x / np.linalg.norm(x, axis=-1, keepdims=True)

    def match(self, **settings: object) -> tuple[Tensor, Tensor, Tensor]:
        return feature.match_adalam(
            self.desc1, self.desc2, self.lafs1, self.lafs2, **{"hw1": SIZE, "hw2": SIZE, **settings}
        )

    def judged(self, found: tuple[Tensor, Tensor, Tensor]) -> tuple[float, float]:
        """Precision, and recall of all true matches."""
        valid = found[2][0].numpy()
        right = valid & (self.partner == found[1][0, :, 1].numpy()) & (self.partner >= 0)
        return right.sum() / max(valid.sum(), 1), right.sum() / (self.partner >= 0).sum()


def by_homography(angle: float, scale: float, tilt: float) -> object:
    c, s = scale * math.cos(angle), scale * math.sin(angle)
    middle = np.array([[1, 0, WIDTH / 2], [0, 1, HEIGHT / 2], [0, 0, 1]])
    matrix = middle @ np.array([[c, -s, 9], [s, c, -5], [tilt, -0.5 * tilt, 1]]) @ np.linalg.inv(middle)

    def moved(frame: np.ndarray) -> np.ndarray:
        mapped = matrix[:, :2] @ frame
        mapped[..., 2] += matrix[:, 2]
        depth = mapped[:, 2, 2][:, None]
        centre = mapped[:, :2, 2] / depth
        linear = (mapped[:, :2, :2] - centre[..., None] * mapped[:, 2:, :2]) / depth[..., None]
        return np.concatenate([linear, centre[..., None]], -1)

    return moved


def by_quarters(frame: np.ndarray) -> np.ndarray:
    """Each quarter of the image has its own affine map."""
    out = frame.copy()
    for k, (angle, stretch) in enumerate([(0.0, 1.0), (0.5, 1.3), (-0.4, 0.8), (0.9, 1.1)]):
        middle = np.array([WIDTH * (1 + 2 * (k % 2)) / 4, HEIGHT * (1 + 2 * (k // 2)) / 4])
        matrix = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ np.diag(
            [stretch, 1.0]
        )
        inside = (np.abs(frame[..., 2] - middle) <= (WIDTH / 4, HEIGHT / 4)).all(-1)
        moved = matrix @ frame[inside]
        moved[..., 2] += 0.9 * middle - matrix @ middle
        out[inside] = moved
    return out


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize(
    ("wrong", "moved"),
    [(200, by_homography(0.5, 0.9, 2e-4)), (320, by_homography(-2.0, 1.2, 0.0)), (240, by_quarters)],
)
def test_more_matches_than_by_ratios_and_fewer_wrong_ones(wrong: int, moved: object, seed: int) -> None:
    scene = Scene(400 + wrong, wrong, seed, moved)
    precision, recall = scene.judged(scene.match())
    nearest = scene.judged(feature.match_nn(scene.desc1, scene.desc2))
    assert precision >= 0.99 and recall >= 0.97 * nearest[1], (precision, recall, nearest)
    for th in (0.8, 0.9):
        by_ratio = scene.judged(feature.match_smnn(scene.desc1, scene.desc2, th))
        assert recall > by_ratio[1] + 0.03 and precision >= by_ratio[0] - 0.005, (precision, recall, by_ratio)


def test_one_in_ten_is_enough() -> None:
    scene = Scene(1000, 900, 0, by_homography(0.3, 1.0, 1e-4), difference=1.0)
    precision, recall = scene.judged(scene.match())
    assert precision >= 0.97 and recall >= 0.9, (precision, recall)


def test_images_sizes_are_estimated_and_may_be_tensors() -> None:
    scene = Scene(400, 200, 0, by_homography(0.5, 0.9, 1e-4))
    size = torch.tensor([HEIGHT, WIDTH])
    for same in (scene.match(hw1=size, hw2=size), scene.match(hw1=size[None].float(), hw2=size[None])):
        for actual, expected in zip(same, scene.match(), strict=True):
            assert actual.equal(expected)
    precision, recall = scene.judged(scene.match(hw1=None, hw2=None))
    assert precision >= 0.99 and recall >= 0.97


def test_frames_must_turn_and_grow_alike() -> None:
    """Matches at the right positions; some have a rotation or a scale that differs from match to match."""
    scene = Scene(300, 0, 0, by_homography(0.5, 1.2, 0.0), difference=0.5)
    turned, grown = scene.partner[:30], scene.partner[30:60]
    scene.lafs2[:, turned] = feature.rotate_laf(
        scene.lafs2[:, turned], torch.linspace(60, 300, 30)[None, :, None]
    )
    scene.lafs2[:, grown] = feature.scale_laf(
        scene.lafs2[:, grown], torch.logspace(0.4, 1.4, 30)[None, :, None, None]
    )

    def shares(**settings: float) -> list[float]:
        valid = scene.match(**settings)[2][0].float()
        return [float(part.mean()) for part in (valid[:30], valid[30:60], valid[60:])]

    assert shares() == [0.0, 0.0, pytest.approx(1.0, abs=0.02)]
    assert shares(orientation_difference_threshold=180.0) == [
        pytest.approx(1.0, abs=0.05),
        0.0,
        pytest.approx(1.0, abs=0.02),
    ]
    assert shares(scale_rate_threshold=50.0) == [
        0.0,
        pytest.approx(1.0, abs=0.05),
        pytest.approx(1.0, abs=0.02),
    ]


def test_whole_images_may_be_turned_and_scaled() -> None:
    scene = Scene(400, 250, 3, by_homography(0.2, 1.0, 0.0))
    expected = scene.match()[2]
    scene.lafs2 = torch.tensor([[0.0, -2.0], [2.0, 0.0]]) @ scene.lafs2
    found = scene.match(hw2=(2 * WIDTH, 2 * HEIGHT))[2]
    assert (found == expected).float().mean() > 0.995


def test_matches_to_one_place_are_none() -> None:
    """Half of all descriptors are nearest to one: a map to a single point would explain them all."""
    scene = Scene(300, 0, 0, by_homography(0.5, 1.0, 0.0), difference=0.3)
    scene.desc1[:, :150] = scene.desc2[:, :1] + 0.01 * scene.desc1[:, :150]
    scene.lafs1[:, :150, :, :2], scene.lafs2[:, 0, :, :2] = torch.eye(2), torch.eye(2)
    assert scene.match()[2][0, :150].sum() <= 3
    assert scene.match(mutual=True)[2][0, :150].sum() <= 1


def loop(scene: Scene, settings: dict) -> set[tuple[int, int]]:
    """The same algorithm in loops, with NumPy's sorting and least squares."""
    desc1, desc2, lafs1, lafs2 = (
        x[0].double().numpy() for x in (scene.desc1, scene.desc2, scene.lafs1, scene.lafs2)
    )
    d = np.linalg.norm(desc1[:, None] - desc2, axis=-1)
    nearest, mutual = d.argmin(1), d.argmin(0)[d.argmin(1)] == np.arange(len(d))
    sure = 1 - np.sort(d, 1)[:, 0] / np.sort(d, 1)[:, 1]
    lafs2 = lafs2[nearest]
    p, q = lafs1[..., 2], lafs2[..., 2]
    turn = np.arctan2(lafs2[:, 0, 1], lafs2[:, 0, 0]) - np.arctan2(lafs1[:, 0, 1], lafs1[:, 0, 0])
    growth = 0.5 * np.log(np.linalg.det(lafs2[..., :2]) / np.linalg.det(lafs1[..., :2]))
    radius = math.sqrt(HEIGHT * WIDTH / (math.pi * 100))
    reach = 4 * radius
    seeds = [
        s
        for s in np.flatnonzero(mutual)
        if sure[s] == sure[mutual & (np.linalg.norm(p - p[s], axis=1) <= radius)].max()
    ]
    found = set()
    for s in sorted(seeds, key=lambda s: -sure[s])[: settings["num_seeds"]]:
        angle = np.abs((turn - turn[s] + np.pi) % (2 * np.pi) - np.pi)
        around = (np.linalg.norm(p - p[s], axis=1) <= reach) & (np.linalg.norm(q - q[s], axis=1) <= reach)
        around &= (angle <= np.deg2rad(30)) & (np.abs(growth - growth[s]) <= math.log(1.5))
        near = [k for k in np.argsort(-sure, kind="stable") if around[k] and k != s][
            : settings["num_neighbors"]
        ]
        x, y = p - p[s], q - q[s]

        def limit(r: np.ndarray) -> float:
            r = np.sort(r)
            dense = [v for k, v in enumerate(r) if (k + 1) / len(r) >= 200 * v**2 / reach**2]
            return max(dense, default=-1.0)

        best, kept = -1.0, None
        pairs = sorted(
            ((i, j) for j in range(settings["num_neighbors"]) for i in range(j)),
            key=lambda ij: (sum(ij), ij[0]),
        )
        for i, j in pairs[: settings["ransac_iters"]]:
            if j >= len(near):
                continue
            A = np.linalg.lstsq(x[[near[i], near[j]]], y[[near[i], near[j]]], rcond=None)[0].T
            area = np.linalg.det(A) / math.exp(2 * growth[s])
            if not 1 / 25 <= area <= 25:
                continue
            r = np.linalg.norm(x[near] @ A.T - y[near], axis=1)
            score = (r <= limit(r)).sum() - 0.5 * limit(r) ** 2 * 200 / reach**2
            if score > best:
                best, kept = score, [near[k] for k in np.flatnonzero(r <= limit(r))]
        if kept is not None:
            A = np.linalg.lstsq(x[kept], y[kept], rcond=None)[0].T
            r = np.linalg.norm(x @ A.T - y, axis=1)
            if (r[near] <= limit(r[near])).sum() >= settings["min_inliers"]:
                found |= {(int(k), int(nearest[k])) for k in np.flatnonzero(around & (r <= limit(r[near])))}
    return found


@pytest.mark.parametrize(
    "settings",
    [
        {"num_seeds": 100, "num_neighbors": 64, "ransac_iters": 40, "min_inliers": 6},
        {"num_seeds": 7, "num_neighbors": 9, "ransac_iters": 36, "min_inliers": 3},
    ],
)
def test_loops_find_the_same(settings: dict) -> None:
    scene = Scene(220, 130, 5, by_homography(0.5, 0.9, 2e-4), difference=1.4)
    _, indices, valid = scene.match(**settings)
    actual = {tuple(pair) for pair in indices[valid].tolist()}
    assert len(actual) > 20 and actual == loop(scene, settings)


def test_batches_masks_and_script() -> None:
    scenes = [Scene(120, 40, seed, by_homography(0.5, 0.9, 2e-4)) for seed in (0, 1, 2)]
    inputs = [torch.cat([getattr(s, name) for s in scenes]) for name in ("desc1", "desc2", "lafs1", "lafs2")]
    settings = {"area_ratio": 30.0, "hw1": SIZE, "hw2": SIZE}
    together = feature.match_adalam(*inputs, **settings)
    for k, scene in enumerate(scenes):
        assert together[2][k].sum() > 60
        for actual, expected in zip(together, scene.match(area_ratio=30.0), strict=True):
            assert actual[k].equal(expected[0])
    dm = torch.cdist(inputs[0].double(), inputs[1].double()).float()
    for actual, expected in zip(feature.match_adalam(*inputs, dm=dm, **settings), together, strict=True):
        torch.testing.assert_close(actual, expected)
    scripted = torch.jit.script(feature.match_adalam)
    for _ in range(2):
        for actual, expected in zip(scripted(*inputs, **settings), together, strict=True):
            torch.testing.assert_close(actual, expected)
    single = feature.match_adalam(inputs[0][0], inputs[1][0], inputs[2][:1], inputs[3][:1], **settings)
    assert all(actual.equal(expected[0]) for actual, expected in zip(single, together, strict=True))


@pytest.mark.parametrize("size", [SIZE, None])
def test_what_a_mask_leaves_out_does_not_matter(size: tuple[int, int] | None) -> None:
    scene = Scene(200, 60, 0, by_homography(0.5, 0.9, 2e-4))
    mask1, mask2 = torch.arange(200)[None] % 4 != 0, torch.arange(200)[None] % 5 != 1
    rows, columns = mask1[0].nonzero()[:, 0], mask2[0].nonzero()[:, 0]
    settings = {"area_ratio": 30.0, "hw1": size, "hw2": size}
    _, pairs, valid = feature.match_adalam(
        scene.desc1[:, rows],
        scene.desc2[:, columns],
        scene.lafs1[:, rows],
        scene.lafs2[:, columns],
        **settings,
    )
    expected = {(int(rows[i]), int(columns[j])) for i, j in pairs[valid].tolist()}
    scene.lafs1[~mask1], scene.lafs2[~mask2] = float("nan"), 1e30
    distances, pairs, valid = scene.match(mask1=mask1, mask2=mask2, **settings)
    assert len(expected) > 50 and {tuple(pair) for pair in pairs[valid].tolist()} == expected
    assert torch.isfinite(distances).all() and (pairs[~valid] == -1).all() and (distances[~valid] == 0).all()


def test_nothing_matches_where_there_is_nothing() -> None:
    scene = Scene(300, 300, 0, by_homography(0.0, 1.0, 0.0))
    assert scene.match()[2].sum() <= 6
    nothing = torch.zeros(1, 300, dtype=torch.bool)
    flat = torch.zeros(1, 300, 2, 3)
    for found in (
        scene.match(mask1=nothing),
        scene.match(mask2=nothing, hw1=None, hw2=None),
        scene.match(mask1=nothing, mask2=nothing, hw1=None, hw2=None),
    ):
        assert not found[2].any() and (found[1] == -1).all() and (found[0] == 0).all()
    for hw in (SIZE, None):  # no frames at all
        distances, _, _ = feature.match_adalam(scene.desc1, scene.desc2, flat, flat, hw1=hw, hw2=hw)
        assert torch.isfinite(distances).all()
    one = feature.match_adalam(scene.desc1[:, :1], scene.desc2[:, :1], flat[:, :1], flat[:, :1])
    assert one[0].shape == (1, 1, 1) and not one[2].any()


def test_distances_are_the_nearests_and_have_their_gradients() -> None:
    scene = Scene(150, 30, 0, by_homography(0.5, 0.9, 0.0))
    scene.desc1.requires_grad_()
    distances, _, valid = scene.match(area_ratio=30.0)
    nearest, _, _ = feature.match_nn(scene.desc1, scene.desc2)
    assert valid.sum() > 80
    torch.testing.assert_close(distances[valid], nearest[valid])
    [got], [want] = (
        torch.autograd.grad(d[valid].sum(), scene.desc1, retain_graph=True) for d in (distances, nearest)
    )
    torch.testing.assert_close(got, want)


DESC, FRAME = torch.zeros(1, 5, 4), torch.zeros(1, 5, 2, 3)
WRONG = [
    ({"lafs1": FRAME[:, :3]}, ValueError, "lafs1: expected a frame for each of 1 x 5"),
    ({"lafs2": FRAME[0]}, ValueError, r"lafs2: expected shape \(B, N, 2, 3\)"),
    ({"lafs2": FRAME.int()}, TypeError, "lafs2: expected a floating-point tensor"),
    (
        {"area_ratio": 0.0},
        ValueError,
        "area_ratio, search_expansion, min_confidence: expected positive numbers",
    ),
    (
        {"num_neighbors": 1},
        ValueError,
        "num_seeds, num_neighbors, min_inliers: expected at least 1, 2 and 3, got 128, 1 and 6",
    ),
    ({"num_neighbors": 4, "ransac_iters": 7}, ValueError, "ransac_iters: expected from 1 to 6, got 7"),
    (
        {"orientation_difference_threshold": 0.0},
        ValueError,
        "orientation_difference_threshold: expected a positive number",
    ),
    (
        {"scale_rate_threshold": 0.9},
        ValueError,
        "scale_rate_threshold, detected_scale_rate_threshold: expected at least 1",
    ),
    ({"hw1": torch.ones(3)}, ValueError, r"hw1: expected shape \(2,\) or \(B, 2\), got \[3\]"),
    ({"mask2": torch.ones(1, 5)}, TypeError, "mask2: expected dtype torch.bool"),
]


@pytest.mark.parametrize(("arguments", "error", "message"), WRONG, ids=[w[2][:40] for w in WRONG])
def test_message(arguments: dict, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        feature.match_adalam(**{"desc1": DESC, "desc2": DESC, "lafs1": FRAME, "lafs2": FRAME, **arguments})
