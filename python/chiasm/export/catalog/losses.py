"""Losses."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import torch
from torch import Generator, Tensor

from ..peer import Peer
from ..spec import InputMaker, Spec, TensorSpec, image
from . import STENCIL, add, rejected_words
from .metrics import PSNR, mean, similarity
from .rigid import uniform

_LOSS = [TensorSpec("loss")]
_PAIR = [image("img1"), image("img2")]


def _plane(sizes: dict[str, int]):
    return sizes["B"], sizes["H"], sizes["W"]


# --- of two images ------------------------------------------------------------------------------------------

add(
    Spec(
        "losses.ssim_loss",
        _PAIR,
        [TensorSpec("loss", description="mean of (1 - SSIM) / 2")],
        config={"window_size": 11, "max_val": 1.0},
        symbols={"H": (16, 32768), "W": (16, 32768)},
        reference="scikit-image structural_similarity (gaussian weights)",
        peer=similarity(lambda found: ((1 - found) / 2).clip(0, 1).mean()),
        picture="comparison",
        errors=rejected_words("reduction", "padding"),
    )
)


def _volume(name: str, channels: str | int = "C"):
    return TensorSpec(
        name, ("B", channels, "D", "H", "W"), layout="NCDHW", range=(0.0, 1.0), description="volumes"
    )


add(
    Spec(
        "losses.ssim3d_loss",
        [_volume("img1"), _volume("img2")],
        [TensorSpec("loss", description="mean of (1 - SSIM) / 2")],
        config={"window_size": 5, "max_val": 1.0},
        symbols={"D": (8, 4096), **STENCIL},
        reference="scikit-image structural_similarity (gaussian weights)",
        picture="comparison",
    )
)

add(
    Spec(
        "losses.ms_ssim_loss",
        _PAIR,
        _LOSS,
        symbols={"H": (34, 32768), "W": (34, 32768)},
        reference="the paper's formula in NumPy float64 with SciPy's correlate1d",
        picture="comparison",
    )
)


def _negative(decibels: float) -> float:
    return -decibels


add(
    Spec(
        "losses.psnr_loss",
        [image("image"), image("target")],
        _LOSS,
        config={"max_val": 1.0},
        peer=replace(PSNR, after=_negative),
        reference="scikit-image peak_signal_noise_ratio",
        picture="comparison",
    )
)

_HUBER = Peer("scipy.special", lambda special, x, y: special.pseudo_huber(1.0, x - y), "batch")
for _name in ("charbonnier", "welsch", "cauchy", "geman_mcclure"):
    _is_huber = _name == "charbonnier"
    add(
        Spec(
            f"losses.{_name}_loss",
            _PAIR,
            _LOSS,
            peer=_HUBER if _is_huber else None,
            reference="the formula in NumPy float64",
            picture="comparison",
        )
    )
    add(
        Spec(
            f"losses.{_name}_loss.mean",
            _PAIR,
            _LOSS,
            config={"reduction": "mean"},
            peer=replace(_HUBER, after=mean) if _is_huber else None,
            reference="the formula in NumPy float64",
            picture="comparison",
        ),
        fn=f"losses.{_name}_loss",
    )

add(
    Spec(
        "losses.total_variation",
        [image("img")],
        _LOSS,
        symbols=STENCIL,
        # torchmetrics sums over the channels of a sample
        peer=Peer(
            "torchmetrics.functional",
            lambda functional, planes, shape: functional.total_variation(planes, "none").reshape(shape),
            "tensors",
            before=lambda x: (x.flatten(0, 1)[:, None], x.shape[:2]),
        ),
        reference="torchmetrics total_variation",
        picture="images with values",
    )
)
add(
    Spec(
        "losses.total_variation.mean",
        [image("img")],
        _LOSS,
        config={"reduction": "mean"},
        symbols=STENCIL,
        reference="the formula in NumPy float64",
        picture="images with values",
    ),
    fn="losses.total_variation",
)

add(
    Spec(
        "losses.inverse_depth_smoothness_loss",
        [image("idepth", 1, description="inverse depth"), image("image")],
        _LOSS,
        symbols=STENCIL,
        reference="the paper's formula in NumPy float64",
        picture="comparison",
    )
)

# --- of distributions ---------------------------------------------------------------------------------------


def _heatmaps(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    shape = (sizes["B"], sizes["N"], sizes["H"], sizes["W"])
    made = {name: uniform(generator, 0.1, 1.0, *shape) for name in ("pred", "target")}
    return {name: (x / x.sum([-2, -1], keepdim=True)).to(dtype) for name, x in made.items()}


_DIVERGENCES = {
    "kl": Peer(
        "scipy.special",
        lambda special, p, q: special.rel_entr(q, p),
        "batch",
        after=lambda d: d.sum((2, 3)).mean(),
        timed=False,
    ),
    "js": Peer(
        "scipy.spatial.distance",
        lambda distance, p, q: distance.jensenshannon(p, q, axis=2),
        "batch",
        before=lambda p, q: (p.reshape(*p.shape[:2], -1), q.reshape(*q.shape[:2], -1)),
        after=lambda roots: (roots**2).mean(),
        timed=False,
    ),
}
for _name in ("kl", "js"):
    add(
        Spec(
            f"losses.{_name}_div_loss_2d",
            [
                TensorSpec(n, ("B", "N", "H", "W"), description="heatmaps, each with sum 1")
                for n in ("pred", "target")
            ],
            _LOSS,
            symbols={"N": (1, 1024)},
            make_inputs=_heatmaps,
            peer=_DIVERGENCES[_name],
            reference="SciPy rel_entr" if _name == "kl" else "SciPy jensenshannon",
            picture="comparison",
        )
    )


def _signals(kind: Sequence[str], masked: bool) -> InputMaker:
    """Pairs of values that depend on each other, and masks with most of the values."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        shape = tuple(sizes[d] for d in kind)
        x = uniform(generator, 0.0, 1.0, *shape)
        made = {
            "input": x.to(dtype),
            "target": (x * x + uniform(generator, 0.0, 0.3, *shape)).to(dtype),
        }
        for name in ("input_mask", "target_mask") if masked else ():
            made[name] = torch.rand(shape, generator=generator) < 0.8
        return made

    return sample


for _kind, _shape, _limits, _picture in (
    ("", ("B", "N"), {"N": (2, 1 << 20)}, "pairs of signals"),
    ("_2d", ("B", "C", "H", "W"), STENCIL, "pairs of planes"),
    ("_3d", ("B", "D", "H", "W"), {"D": (2, 4096), **STENCIL}, "comparison"),
):
    for _name in (f"mutual_information_loss{_kind}", f"normalized_mutual_information_loss{_kind}"):
        for _masked in (False, True):
            _masks = [
                TensorSpec(n, _shape, "bool", description="which values count")
                for n in ("input_mask", "target_mask")
                if _masked
            ]
            add(
                Spec(
                    f"losses.{_name}{'.masked' if _masked else ''}",
                    [
                        TensorSpec("input", _shape, range=(0.0, 1.0)),
                        TensorSpec("target", _shape, range=(0.0, 1.3)),
                        *_masks,
                    ],
                    _LOSS,
                    config={"num_bins": 16},
                    symbols=_limits,
                    make_inputs=_signals(_shape, _masked),
                    reference=(
                        "scikit-learn mutual_info_score where values are bins' centres; the definition in"
                        " NumPy float64"
                    ),
                    picture=_picture,
                ),
                fn=f"losses.{_name}",
            )

# --- of segmentations ---------------------------------------------------------------------------------------

_CLASSES: dict[str, Any] = {"C": (2, 1024)}
_LABELS = TensorSpec(
    "target", ("B", "H", "W"), "int64", description="labels, 0 to C - 1 or -100 for pixels to ignore"
)
_LOGITS = image("pred", description="logits", range=(-3.0, 3.0))


def _segmentation(ignored: float = 0.2, **more: Any) -> InputMaker:
    """Logits, labels with some -100, and further inputs, given as (shape, low, high)."""

    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        logits = uniform(generator, -3.0, 3.0, sizes["B"], sizes["C"], sizes["H"], sizes["W"]).to(dtype)
        labels = torch.randint(0, sizes["C"], _plane(sizes), generator=generator)
        left_out = torch.rand(_plane(sizes), generator=generator) < ignored
        made = {"pred": logits, "target": torch.where(left_out, -100, labels)}
        return made | {name: uniform(generator, 0.5, 2.0, sizes["C"]).to(dtype) for name in more}

    return sample


def _weights(name: str):
    return TensorSpec(name, ("C",), range=(0.5, 2.0), description="a number for each class")


def _add_segmentation(
    name: str, variant: str, reference: str, weight: bool = False, ignored: float = 0.2, **config: Any
):
    add(
        Spec(
            f"losses.{name}{variant}",
            [_LOGITS, _LABELS, *([_weights("weight")] if weight else [])],
            _LOSS,
            config=config,
            symbols=_CLASSES,
            gradients=("pred",),
            make_inputs=_segmentation(ignored, **({"weight": True} if weight else {})),
            reference=reference,
            picture="comparison",
        ),
        fn=f"losses.{name}",
    )


_DEFINITION = "the paper's formula in NumPy float64"
_add_segmentation("dice_loss", "", _DEFINITION)
_add_segmentation("dice_loss", ".macro_weighted", _DEFINITION, True, average="macro")
_add_segmentation("tversky_loss", "", _DEFINITION, alpha=0.3, beta=0.7)
_add_segmentation("tversky_loss", ".micro", _DEFINITION, alpha=0.3, beta=0.7, average="micro")
_add_segmentation(
    "focal_loss", "", "the paper's formula in NumPy float64; torch cross_entropy for gamma = 0", alpha=0.25
)
_add_segmentation("focal_loss", ".mean_weighted", _DEFINITION, True, alpha=0.25, gamma=1.5, reduction="mean")
_add_segmentation(
    "lovasz_softmax_loss", "", "the definition by Jaccard indices of sets in NumPy float64", ignored=0.0
)
_add_segmentation(
    "lovasz_softmax_loss",
    ".weighted",
    "the definition by Jaccard indices of sets in NumPy float64",
    True,
    0.0,
)


def _binary(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
    logits = uniform(generator, -3.0, 3.0, sizes["B"], sizes["C"], sizes["H"], sizes["W"]).to(dtype)
    drawn = torch.rand(logits.shape, generator=generator)
    target = torch.where(drawn < 0.2, -100, (drawn < 0.6).to(torch.int64))
    return {
        "pred": logits,
        "target": target,
        **{n: uniform(generator, 0.5, 2.0, sizes["C"]).to(dtype) for n in ("pos_weight", "weight")},
    }


def _focal(ops: Any, pred: Tensor, target: Tensor) -> Tensor:
    each = ops.sigmoid_focal_loss(pred, target.clamp(0).to(pred.dtype))
    return torch.where(target < 0, 0.0, each)


_MARKS = TensorSpec("target", ("B", "C", "H", "W"), "int64", description="0, 1, or -100 for pixels to ignore")
add(
    Spec(
        "losses.binary_focal_loss_with_logits",
        [_LOGITS, _MARKS],
        _LOSS,
        gradients=("pred",),
        make_inputs=_binary,
        peer=Peer("torchvision.ops", _focal, "tensors"),
        reference=(
            "the paper's formula in NumPy float64; torch binary_cross_entropy_with_logits for gamma = 0"
        ),
        picture="comparison",
    )
)
add(
    Spec(
        "losses.binary_focal_loss_with_logits.mean_weighted",
        [_LOGITS, _MARKS, _weights("pos_weight"), _weights("weight")],
        _LOSS,
        config={"gamma": 1.5, "reduction": "mean"},
        gradients=("pred",),
        make_inputs=_binary,
        reference=_DEFINITION,
        picture="comparison",
    ),
    fn="losses.binary_focal_loss_with_logits",
)

add(
    Spec(
        "losses.lovasz_hinge_loss",
        [
            image("pred", 1, range=(-3.0, 3.0), description="logits"),
            TensorSpec("target", ("B", "H", "W"), "int64", range=(0, 1), description="labels"),
        ],
        _LOSS,
        gradients=("pred",),
        reference="the definition by Jaccard indices of sets in NumPy float64",
        picture="comparison",
    )
)


def _probabilities(channels: str | int, axes: Sequence[str]) -> InputMaker:
    def sample(generator: Generator, sizes: dict[str, int], dtype: torch.dtype) -> dict[str, Tensor]:
        classes, extent = sizes["C"] if channels == "C" else 1, [sizes[d] for d in axes]
        pred = uniform(generator, 0.0, 1.0, sizes["B"], classes, *extent).to(dtype)
        target = torch.randint(0, max(classes, 2), (sizes["B"], 1, *extent), generator=generator)
        # The first third of the rows is one class that the prediction misses, so that erosions have an
        # effect.
        top = max(extent[-2] // 3, 1)
        target[..., :top, :] = 1
        pred[..., :top, :] *= 0.2
        return {"pred": pred, "target": target}

    return sample


for _kind, _axes, _config in (("", ("H", "W"), {}), ("3d", ("D", "H", "W"), {"k": 4})):
    for _variant, _channels, _meaning in (
        ("", "C", "labels, 0 to C - 1"),
        (".binary", 1, "1 in the foreground"),
    ):
        add(
            Spec(
                f"losses.hausdorff_er_loss{_kind}{_variant}",
                [
                    TensorSpec(
                        "pred", ("B", _channels, *_axes), range=(0.0, 1.0), description="probabilities"
                    ),
                    TensorSpec("target", ("B", 1, *_axes), "int64", range=(0, 1), description=_meaning),
                ],
                _LOSS,
                config=_config,
                symbols={**_CLASSES, **STENCIL, "D": (8, 4096)},
                gradients=("pred",),
                make_inputs=_probabilities(_channels, _axes),
                reference="the paper's formula in NumPy float64 with SciPy's convolve",
                picture="comparison",
            ),
            fn=f"losses.hausdorff_er_loss{_kind}",
        )

add(
    Spec(
        "losses.one_hot",
        [TensorSpec("labels", ("B", "H", "W"), "int64", range=(0, 4), description="labels, 0 to 4")],
        [TensorSpec("output")],
        config={"num_classes": 5, "eps": 1e-6},
        peer=Peer(
            "torch.nn.functional",
            lambda F, labels: F.one_hot(labels, 5),
            "tensors",
            after=lambda marks: marks.movedim(-1, 1) + 1e-6,
        ),
        reference="torch one_hot",
        picture="classes",
    )
)
