"""Registration of photographs that were warped by known transforms."""

import math

import pytest
import torch
import torch.nn.functional as F
from photos import photo
from torch import Tensor, nn

from chiasm.geometry.conversions import denormalize_homography
from chiasm.geometry.linalg import transform_points
from chiasm.geometry.registration import Homography, ImageRegistrator, Similarity
from chiasm.geometry.transform import (
    HomographyWarper,
    get_affine_matrix2d,
    get_perspective_transform,
    warp_perspective,
)

HEIGHT, WIDTH = 96, 128
CORNERS = torch.tensor([[[0.0, 0.0], [WIDTH - 1.0, 0.0], [WIDTH - 1.0, HEIGHT - 1.0], [0.0, HEIGHT - 1.0]]])
SHIFTS = torch.tensor(
    [
        [[6.0, -4.0], [-7.0, 5.0], [8.0, 6.0], [-5.0, -6.0]],
        [[-9.0, 3.0], [2.0, 8.0], [-4.0, -5.0], [3.0, 4.0]],
    ]
)


def warped(src: Tensor, to_dst: Tensor) -> Tensor:
    return warp_perspective(src, to_dst, (HEIGHT, WIDTH))


def corner_errors(src_homo_dst: Tensor, to_dst: Tensor) -> Tensor:
    """The errors (B, 4), in pixels, of the corners after mapping them there and back."""
    back = denormalize_homography(src_homo_dst.double(), (HEIGHT, WIDTH), (HEIGHT, WIDTH), False)
    corners = CORNERS.double().expand(len(to_dst), 4, 2)
    return (transform_points(back, transform_points(to_dst.double(), corners)) - corners).norm(dim=-1)


def test_homographies_of_photographs() -> None:
    """Corners that moved by up to 10 pixels, differently for each photograph, are registered to less than a
    tenth of a pixel."""
    src = photo(2, 3, HEIGHT, WIDTH)
    to_dst = get_perspective_transform(CORNERS.expand(2, 4, 2), CORNERS + SHIFTS)
    dst = warped(src, to_dst)
    registrator = ImageRegistrator(pyramid_levels=3, num_iterations=60, lr=2e-3)
    with torch.no_grad():
        found, levels = registrator.register(src, dst, output_intermediate_models=True)
    errors = [corner_errors(level, to_dst).max() for level in levels]
    assert len(levels) == 3 and torch.equal(levels[-1], found) and not found.requires_grad
    assert errors[-1] < 0.1 < errors[0] < corner_errors(torch.eye(3).expand(2, 3, 3), to_dst).max(), errors
    inside = warped(torch.ones_like(src), to_dst) > 0.99
    assert ((registrator.warp_src_into_dst(src) - dst).abs() * inside).mean() < 2e-3
    back = registrator.warp_dst_into_src(dst)
    assert ((back - src).abs() * (back != 0)).mean() < 0.02  # interpolated twice


ANGLE, FACTOR, MOVE = 7.0, 1.1, (4.0, -3.0)  # degrees clockwise, and pixels


@pytest.mark.parametrize("name", ["similarity", "translation", "scale", "rotation"])
def test_similarities(name: str) -> None:
    """On an image that is not square, for which a rotation of normalised coordinates is not a rotation of
    pixels."""
    every = name == "similarity"
    angle, factor = ANGLE * (every or name == "rotation"), FACTOR if every or name == "scale" else 1.0
    move = torch.tensor([MOVE]) * float(every or name == "translation")
    center = torch.tensor([[(WIDTH - 1) / 2, (HEIGHT - 1) / 2]])
    to_dst = get_affine_matrix2d(move, center, torch.full((1, 2), factor), torch.tensor([angle]))
    src = photo(1, 1, HEIGHT, WIDTH)
    registrator = ImageRegistrator(name, pyramid_levels=3, num_iterations=60, lr=2e-3)
    assert corner_errors(registrator.register(src, warped(src, to_dst)), to_dst).max() < 0.1
    # The inverse: the learned transform maps the destination to the source.
    assert math.isclose(registrator.model.rot.item(), -math.radians(angle), abs_tol=1e-3)
    assert math.isclose(registrator.model.scale.item(), 1.0 / factor, abs_tol=1e-3)


class Shift(nn.Module):
    """A model as a user may write it."""

    def reset_model(self, batch_size: int = 1, aspect: float = 1.0) -> None:
        self.by = nn.Parameter(torch.zeros(batch_size, 2, dtype=torch.float64))

    def forward(self) -> Tensor:
        eye = torch.eye(3, dtype=self.by.dtype).expand(len(self.by), 3, 3)
        return torch.cat([eye[:, :, :2], eye[:, :, 2:] + F.pad(self.by, [0, 1])[:, :, None]], 2)


def test_parts_of_ones_own() -> None:
    src, to_dst = photo(1, 1, HEIGHT, WIDTH, torch.float64), torch.eye(3, dtype=torch.float64)[None]
    to_dst[0, :2, 2] = torch.tensor(MOVE)
    sizes = []

    def warper(height: int, width: int) -> HomographyWarper:
        sizes.append((height, width))
        return HomographyWarper(height, width, "bicubic")

    registrator = ImageRegistrator(Shift(), torch.optim.RMSprop, F.mse_loss, 3, 2e-3, 60, 1e-7, warper)
    found = registrator.register(src, warped(src, to_dst))
    assert found.dtype == torch.float64 and corner_errors(found, to_dst).max() < 0.3
    assert set(sizes) == {(24, 32), (48, 64), (96, 128)}


def test_tolerance_ends_a_level() -> None:
    image, steps = photo(1, 1, 32, 32), []
    loss = lambda a, b, reduction: (steps.append(0), F.l1_loss(a, b, reduction=reduction))[1]  # noqa: E731
    for tolerance, expected in ((0.0, 24), (10.0, 4)):
        steps.clear()
        ImageRegistrator(loss_fn=loss, pyramid_levels=2, num_iterations=12, tolerance=tolerance).register(
            image, image
        )
        assert len(steps) == expected


@pytest.mark.parametrize("model", [Homography(), Similarity()], ids=["homography", "similarity"])
def test_models_script_and_invert(model: nn.Module) -> None:
    model.reset_model(2, 1.5)
    torch.testing.assert_close(model(), torch.eye(3).expand(2, 3, 3))
    with torch.no_grad():
        for p in model.parameters():
            p.add_(0.1 * torch.randn(p.shape, generator=torch.Generator().manual_seed(1)))
    scripted = torch.jit.script(model)
    assert torch.equal(scripted(), model())
    there_and_back = scripted.forward_inverse() @ model()
    torch.testing.assert_close(there_and_back / there_and_back[:, 2:, 2:], torch.eye(3).expand(2, 3, 3))
    assert torch.equal(scripted.forward_inverse(), model.forward_inverse())


def test_similarity_is_one_in_pixels() -> None:
    model = Similarity()
    model.reset_model(1, WIDTH / HEIGHT)
    with torch.no_grad():
        model.rot.fill_(0.3), model.scale.fill_(1.2)
    pixels = denormalize_homography(model(), (HEIGHT, WIDTH), (HEIGHT, WIDTH), False)[0, :2, :2]
    expected = 1.2 * torch.tensor([[math.cos(0.3), -math.sin(0.3)], [math.sin(0.3), math.cos(0.3)]])
    torch.testing.assert_close(pixels, expected)


IMAGE = torch.zeros(1, 1, 16, 16)
WRONG = [
    (lambda: ImageRegistrator("affine"), "model_type: expected one of"),
    (lambda: ImageRegistrator(pyramid_levels=0), "pyramid_levels, num_iterations: expected positive"),
    (
        lambda: ImageRegistrator().register(IMAGE, IMAGE[:, :, :8]),
        r"dst_img: expected src_img's shape \[1, 1, 16, 16\]",
    ),
]


@pytest.mark.parametrize(("call", "message"), WRONG, ids=[w[1][:20] for w in WRONG])
def test_message(call, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()


def test_registration_says_how_it_goes(capsys: pytest.CaptureFixture[str]) -> None:
    image = torch.rand(1, 1, 32, 40, generator=torch.Generator().manual_seed(0))
    registrator = ImageRegistrator("similarity", num_iterations=2, pyramid_levels=2)
    registrator.register(image, image, True)
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(":")[0] for line in lines] == ["20 x 16 pixels", "40 x 32 pixels"]
