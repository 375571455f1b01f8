"""Networks in native code: convolutions, linear layers and attention, compared with PyTorch's own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from torch import Tensor, nn

import chiasm.runtime
from chiasm.export import Spec, TensorSpec, export
from chiasm.export.manifest import read_manifest


def convolved(inputs: int, outputs: int, size: int = 3, stride: int = 1, groups: int = 1) -> nn.Sequential:
    """Convolution, normalisation, clamp, which kernels compute in one pass."""
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, size, stride, size // 2, groups=groups, bias=False),
        nn.BatchNorm2d(outputs),
        nn.ReLU6(inplace=True),
    )


class Mobile(nn.Module):
    """Depthwise convolutions, residuals, a mean, a linear layer (like MobileNetV2)."""

    def __init__(self) -> None:
        super().__init__()
        self.first = convolved(3, 16, 3, 2)
        self.wide, self.deep = convolved(16, 40, 1), convolved(40, 40, 3, groups=40)
        self.narrow = nn.Sequential(nn.Conv2d(40, 16, 1, bias=False), nn.BatchNorm2d(16))
        self.head = nn.Linear(16, 10)

    def forward(self, image: Tensor) -> Tensor:
        x = self.first(image)
        x = x + self.narrow(self.deep(self.wide(x)))
        return self.head(F.adaptive_avg_pool2d(x, 1).flatten(1))


class Detector(nn.Module):
    """SiLU, pools, concatenation, nearest upsampling, grouped and dilated convolutions (like YOLO)."""

    def __init__(self) -> None:
        super().__init__()
        self.first, self.second = nn.Conv2d(3, 12, 6, 2, 2), nn.Conv2d(12, 24, 3, 2, 1, groups=3)
        self.pooled = nn.Conv2d(48, 20, 1)
        self.merged = nn.Conv2d(32, 18, 3, padding="same", dilation=2)
        self.head = nn.Conv2d(18, 7, 1)

    def forward(self, image: Tensor) -> Tensor:
        fine = F.silu(self.first(image))
        x = F.silu(self.second(fine))
        x = F.silu(self.pooled(torch.cat([x, F.max_pool2d(x, 5, 1, 2)], 1)))
        x = torch.cat([F.interpolate(x, fine.shape[2:]), fine], 1)
        # The same weights are used twice
        return torch.sigmoid(self.head(self.merged(x)) - self.head(x[:, :18]))


class Segmentation(nn.Module):
    """Transposed convolutions, group normalisation, a separate clamp (like U-Net)."""

    def __init__(self) -> None:
        super().__init__()
        self.down, self.norm = nn.Conv2d(3, 8, 3, 2, 1), nn.GroupNorm(2, 8)
        self.up = nn.ConvTranspose2d(8, 6, 2, 2)
        self.up_more = nn.ConvTranspose2d(6, 8, 3, (2, 1), 1, output_padding=(1, 0), groups=2)
        self.kept = nn.ConvTranspose2d(8, 8, 5, 1, 2, groups=8, bias=False)
        self.last = nn.Sequential(nn.Conv2d(8, 2, 1), nn.Hardtanh(-0.5, 0.25))

    def forward(self, image: Tensor) -> Tensor:
        x = F.leaky_relu(self.norm(self.down(image)), 0.1)
        return self.last(self.kept(F.relu(self.up_more(self.up(x)))))


class Transposed(nn.Module):
    """Transposed convolutions of every kind: windows smaller than the stride, larger, far apart, cut off."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = nn.ModuleList(
            nn.ConvTranspose2d(4, 6, size, stride, padding, more, groups, bias, dilation)
            for size, stride, padding, more, groups, bias, dilation in [
                (3, 2, 1, 0, 1, True, 1),
                (4, 2, 1, 0, 2, False, 1),
                ((1, 5), (3, 2), (0, 3), (2, 1), 1, True, 1),
                (2, (2, 1), 1, 0, 2, True, 1),
                (3, 3, 0, 1, 1, False, (2, 3)),
                ((3, 1), 4, (2, 0), 3, 1, True, 1),
                (1, 1, 1, 0, 1, True, 1),
            ]
        )
        self.norm, self.row = nn.BatchNorm2d(6), nn.ConvTranspose1d(4, 3, 4, 3, 2, 1)

    def forward(self, image: Tensor) -> Tensor:
        results = [F.relu(self.norm(layer(image))) for layer in self.layers]
        return torch.cat([r.flatten(1) for r in [*results, self.row(image.flatten(2))]], 1)


class Transformer(nn.Module):
    """Patches, attention of two kinds, layer normalisation, GELU (like ViT)."""

    def __init__(self) -> None:
        super().__init__()
        self.patches = nn.Conv2d(3, 32, 8, 8)
        self.attention = nn.MultiheadAttention(32, 4, batch_first=True)
        self.norm, self.more = nn.LayerNorm(32), nn.Linear(32, 64)
        self.less, self.read = nn.Linear(64, 32, bias=False), nn.Conv1d(32, 5, 3, padding=1)

    def forward(self, image: Tensor) -> Tensor:
        x = self.patches(image).flatten(2).transpose(1, 2)
        x = x + self.attention(x, x, x, need_weights=False)[0]
        x = x + self.less(F.gelu(self.more(self.norm(x))))
        heads = x.unflatten(2, (4, 8)).transpose(1, 2)
        x = x + F.scaled_dot_product_attention(heads, heads, heads, is_causal=True).transpose(1, 2).flatten(2)
        products = torch.softmax(x @ x.transpose(1, 2), -1) @ x
        return self.read(products.transpose(1, 2)).amax(2)


class Recurrent(nn.Module):
    """Columns of an image read by LSTM and GRU layers (like CRNN): stacked, in both directions, with given
    states."""

    def __init__(self) -> None:
        super().__init__()
        self.columns = nn.Conv2d(3, 11, 3, (4, 2), 1)
        self.both = nn.LSTM(11, 9, 2, batch_first=True, bidirectional=True)
        self.plain = nn.LSTM(18, 7, bias=False)
        self.gated = nn.GRU(7, 6, 2, bidirectional=True)
        self.more = nn.GRU(12, 7, bias=False, batch_first=True)
        self.start, self.last = nn.Linear(11, 7), nn.Linear(7, 5)

    def forward(self, image: Tensor) -> Tensor:
        x = F.relu(self.columns(image)).mean(2).transpose(1, 2)
        read, (states, cells) = self.both(x)
        first = self.start(x.mean(1))[None]
        plain, (state, cell) = self.plain(read.transpose(0, 1), (first, -first))
        gated, gates = self.gated(plain)
        more, end = self.more(gated.transpose(0, 1), first)
        ends = torch.cat([*states, *cells, *state, *cell, *gates, *end], 1)
        return torch.cat([self.last(more).amax(1), ends], 1)


class Parametrised(nn.Module):
    """Weights that are computed from parameters."""

    def __init__(self) -> None:
        super().__init__()
        self.first = nn.utils.parametrizations.weight_norm(nn.Conv2d(3, 4, 3))
        self.second = nn.utils.parametrizations.spectral_norm(nn.Linear(4, 5))

    def forward(self, image: Tensor) -> Tensor:
        return self.second(F.relu(self.first(image)).mean((2, 3)))


class Vectors(nn.Module):
    """No image: layers of (B, 20), with normalisation, also along another axis."""

    def __init__(self) -> None:
        super().__init__()
        self.first, self.norm, self.second = nn.Linear(20, 33), nn.BatchNorm1d(33), nn.Linear(11, 7)
        self.third, self.last = nn.BatchNorm1d(3), nn.Linear(3, 3)

    def forward(self, x: Tensor) -> Tensor:
        x = torch.relu(self.norm(self.first(x)))
        return self.last(self.third(self.second(x.unflatten(1, (3, 11)))).mean(2))


class Halved(nn.Module):
    """Layers of `Mobile` and `Detector`, and clamps in place: of what nobody else reads, and of what another
    reads."""

    def __init__(self) -> None:
        super().__init__()
        self.mobile, self.detector, self.last = Mobile(), Detector(), nn.Conv2d(7, 7, 1)

    def forward(self, image: Tensor) -> Tensor:
        x = self.detector(image)
        clamped = self.last(x)
        seen = clamped * 2
        both = F.relu_(clamped) + seen + self.last(clamped)
        return torch.cat([self.mobile(image), F.relu6(both, inplace=True).amax((2, 3))], 1)


class Volumes(nn.Module):
    """Convolutions of volumes: strided, dilated, in groups, with different paddings, normalised."""

    def __init__(self) -> None:
        super().__init__()
        self.first, self.norm = (
            nn.Conv3d(2, 8, (3, 5, 3), (2, 1, 2), (1, 2, 0), bias=False),
            nn.BatchNorm3d(8),
        )
        self.second = nn.Conv3d(8, 12, 3, padding="same", dilation=(2, 1, 1), groups=4)
        self.third = nn.Conv3d(12, 12, (2, 1, 3), padding=(1, 0, 1), groups=12)
        self.last = nn.Conv3d(12, 3, 1, padding="valid")
        self.weight = nn.Parameter(torch.rand(12, 12, 3, 3, 3) / 100)

    def forward(self, volume: Tensor) -> Tensor:
        x = F.relu(self.norm(self.first(volume)))
        x = F.conv3d(self.second(x), self.weight, None, (1,), (1,))  # one number for all axes
        return self.last(F.silu(self.third(x)))


def settled(network: nn.Module) -> nn.Module:
    """The network with statistics as after training."""
    torch.manual_seed(3)
    for module in network.modules():
        if isinstance(module, (nn.BatchNorm1d, nn.BatchNorm2d, nn.BatchNorm3d)):
            assert module.running_mean is not None and module.running_var is not None
            nn.init.normal_(module.weight, 1, 0.2)
            nn.init.normal_(module.bias, 0, 0.2)
            module.running_mean.normal_(0, 0.2)
            module.running_var.uniform_(0.5, 1.5)
    return network.eval()


IMAGE = TensorSpec("image", ("B", 3, "H", "W"))
SIZES = {"D": (4, 4096), "H": (16, 4096), "W": (16, 4096)}
WHOLE = TensorSpec("image", ("B", 3, 32, 48))
SHAPES = [(1, 3, 16, 16), (2, 3, 32, 48), (3, 3, 66, 38)]
NETWORKS = [
    pytest.param(Mobile, IMAGE, SHAPES, id="mobile"),
    pytest.param(Detector, IMAGE, [(1, 3, 16, 16), (2, 3, 32, 48), (1, 3, 64, 36)], id="detector"),
    pytest.param(Segmentation, IMAGE, SHAPES, id="segmentation"),
    pytest.param(
        Transposed, TensorSpec("image", ("B", 4, 5, 7)), [(1, 4, 5, 7), (3, 4, 5, 7)], id="transposed"
    ),
    pytest.param(Transformer, WHOLE, [(1, 3, 32, 48), (3, 3, 32, 48)], id="transformer"),
    pytest.param(Recurrent, IMAGE, SHAPES, id="recurrent"),
    pytest.param(Parametrised, IMAGE, SHAPES, id="parametrised"),
    pytest.param(Vectors, TensorSpec("x", ("B", 20)), [(1, 20), (5, 20), (40, 20)], id="vectors"),
    pytest.param(
        Volumes,
        TensorSpec("volume", ("B", 2, "D", "H", "W")),
        [(1, 2, 7, 16, 18), (2, 2, 12, 33, 21)],
        id="volumes",
    ),
]


def exported(network: nn.Module, tensor: TensorSpec, folder: Path, dtype: str = "float32") -> Path:
    spec = Spec(
        "my.network",
        [tensor],
        [TensorSpec("result")],
        gradients=(),
        symbols=SIZES if "H" in tensor.shape else {},
        dtypes=(dtype,),
    )
    return export(network, spec, folder, formats=["native"])


def artifacts(bundle: Path) -> list[dict]:
    return read_manifest(bundle)["methods"]["forward"]["artifacts"]


def assert_is_network(bundle: Path, network: nn.Module, shapes: list[tuple[int, ...]], limit: float) -> None:
    """Assert that native code needs no libtorch, and agrees with the network in float64."""
    [artifact] = artifacts(bundle)
    assert artifact["needs"] == []
    method = chiasm.runtime.open(bundle).method(backend="native")
    dtype = next(network.parameters()).dtype
    for shape in shapes:
        x = torch.rand(shape, generator=torch.Generator().manual_seed(5), dtype=torch.float64).to(dtype)
        with torch.no_grad():
            expected = network.double()(x.double()).numpy()
        result = torch.as_tensor(method(x)).double().numpy()
        np.testing.assert_allclose(result, expected, atol=limit, rtol=5 * limit)


@pytest.mark.parametrize("make, tensor, shapes", NETWORKS)
def test_a_network_needs_no_libtorch(
    make: type[nn.Module], tensor: TensorSpec, shapes: list[tuple[int, ...]], tmp_path: Path
) -> None:
    network = settled(make())
    before = {name: value.clone() for name, value in network.state_dict().items()}
    bundle = exported(network, tensor, tmp_path)
    assert all(torch.equal(value, before[name]) for name, value in network.state_dict().items())
    assert_is_network(bundle, network, shapes, 2e-5)


def test_of_doubles(tmp_path: Path) -> None:
    network = settled(Mobile()).double()
    assert_is_network(exported(network, IMAGE, tmp_path, "float64"), network, SHAPES, 1e-12)


@pytest.mark.parametrize("dtype, limit", [("float16", 4e-3), ("bfloat16", 3e-2)])
@pytest.mark.parametrize(
    "make, tensor, shapes",
    [
        pytest.param(Halved, IMAGE, SHAPES, id="convolutions"),
        pytest.param(Transformer, WHOLE, [(1, 3, 32, 48), (3, 3, 32, 48)], id="transformer"),
    ],
)
def test_of_half_precision(
    make: type[nn.Module],
    tensor: TensorSpec,
    shapes: list[tuple[int, ...]],
    dtype: str,
    limit: float,
    tmp_path: Path,
) -> None:
    """Layers compute in float32, as PyTorch's do inside, and round their results."""
    network = settled(make()).to(getattr(torch, dtype))
    assert_is_network(exported(network, tensor, tmp_path, dtype), network, shapes, limit)


def test_samples_of_a_batch_are_what_they_are_alone(tmp_path: Path) -> None:
    method = chiasm.runtime.open(exported(settled(Mobile()), IMAGE, tmp_path)).method(backend="native")
    images = torch.rand(5, 3, 40, 56, generator=torch.Generator().manual_seed(0)).numpy()
    together = method(images)
    for image, result in zip(images, together, strict=True):
        np.testing.assert_array_equal(method(image[None])[0], result)


def test_an_artifact_has_its_weights_once(tmp_path: Path) -> None:
    network = nn.Sequential(
        nn.Conv2d(3, 512, 3), nn.ReLU(), nn.Conv2d(512, 1024, 1), nn.BatchNorm2d(1024)
    ).eval()
    [artifact] = artifacts(exported(network, IMAGE, tmp_path))
    weights = sum(4 * p.numel() for p in network.parameters())
    assert 2_000_000 < weights < artifact["size"] < weights + 1_000_000


def attention(query: Tensor, seen: Tensor, score: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Attention with a boolean mask, with scores that are partly minus infinity, and causal."""
    hidden = torch.where(score > 0.3, 0.0, float("-inf"))
    return (
        F.scaled_dot_product_attention(query, query, query, seen),
        F.scaled_dot_product_attention(query, query, query, hidden),
        F.scaled_dot_product_attention(query, query, query, is_causal=True),
    )


def test_a_query_that_sees_nothing_gets_zeros(tmp_path: Path) -> None:
    """Padding in a batch of sequences."""

    def sample(g: torch.Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        score = torch.rand(sizes["N"], sizes["N"], generator=g)
        score[0] = 0.0
        query = torch.rand(sizes["B"], 2, sizes["N"], 8, generator=g)
        return {"query": query, "seen": score > 0.5, "score": score}

    inputs = [
        TensorSpec("query", ("B", 2, "N", 8)),
        TensorSpec("seen", ("N", "N"), "bool"),
        TensorSpec("score", ("N", "N"), "float32"),
    ]
    names = [TensorSpec(name) for name in ("first", "second", "third")]
    spec = Spec(
        "networks.attention", inputs, names, symbols={"N": (1, 100)}, gradients=(), make_inputs=sample
    )
    method = chiasm.runtime.open(export(attention, spec, tmp_path, formats=["native"])).method("forward")
    made = sample(torch.Generator().manual_seed(3), {"B": 3, "N": 33}, torch.float32)
    for mine, eager in zip(method(*made.values()), attention(*made.values()), strict=True):
        torch.testing.assert_close(torch.as_tensor(mine), eager)
    assert not attention(*made.values())[0][:, :, 0].any()


class Computed(nn.Module):
    """Weights that are computed from the image, after a layer that has a kernel."""

    def __init__(self) -> None:
        super().__init__()
        self.first, self.second = nn.Conv2d(3, 3, 1), nn.Parameter(torch.rand(4, 3, 3, 3))

    def forward(self, image: Tensor) -> Tensor:
        return F.conv2d(F.relu(self.first(image)), self.second * image.mean())


def test_what_has_no_kernel_says_so(tmp_path: Path) -> None:
    network = Computed().eval()
    bundle = exported(network, IMAGE, tmp_path)
    [artifact] = artifacts(bundle)
    assert artifact["needs"] == ["libtorch"] and "aoti_torch_cpu_convolution" in artifact["why"]
    image = torch.rand(2, 3, 20, 30)
    result = chiasm.runtime.open(bundle).method(backend="torch")(image.numpy())
    np.testing.assert_allclose(result, network(image).detach(), atol=1e-5)


class Changed(nn.Module):
    """Weights that are computed from parameters, and then changed through a view."""

    def __init__(self) -> None:
        super().__init__()
        self.weight = nn.Parameter(torch.rand(4, 3, 3, 3))

    def forward(self, image: Tensor) -> Tensor:
        weight = self.weight * 2
        weight.flatten().add_(1)
        return F.conv2d(image, weight)


def test_weights_that_are_changed_in_place(tmp_path: Path) -> None:
    network = Changed().eval()
    bundle = exported(network, IMAGE, tmp_path)
    image = torch.rand(2, 3, 20, 30)
    result = chiasm.runtime.open(bundle).method(backend="torch")(image.numpy())
    np.testing.assert_allclose(result, network(image).detach(), rtol=1e-5)


class Stretched(nn.Module):
    """The pixels of one block read different pixels of the image, none, and only pixels outside it."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = nn.ModuleList(
            nn.ConvTranspose2d(4, 4, size, stride, padding, 0, groups, True, dilation)
            for size, stride, padding, groups, dilation in [
                (3, 2, 1, 1, 1),
                (4, 2, 1, 4, 1),
                (2, 3, 0, 1, 1),
                (2, 2, 1, 1, 1),
                (3, 2, 0, 2, (2, 3)),
                (3, 1, 3, 1, 2),
            ]
        )

    def forward(self, image: Tensor) -> Tensor:
        return torch.cat([layer(image).flatten(1) for layer in self.layers], 1)


def test_a_transposed_convolution_multiplies_no_zeros_of_its_own(tmp_path: Path) -> None:
    torch.manual_seed(3)
    network = Stretched().eval()
    spec = Spec("test.stretched", [TensorSpec("image", ("B", 4, 9, 7))], gradients=())
    method = chiasm.runtime.open(export(network, spec, tmp_path, formats=["native"])).method("forward")
    assert method.backend == "native"
    image = torch.randn(2, 4, 9, 7)
    image[0, 1, 4, 3], image[1, 0, 0, 0], image[1, 3, 8, 6] = float("nan"), float("inf"), -float("inf")
    expected = network(image).detach()
    assert 0 < expected.isnan().sum() < expected.isfinite().sum()
    torch.testing.assert_close(torch.as_tensor(method(image)), expected, equal_nan=True, atol=1e-5, rtol=1e-5)
