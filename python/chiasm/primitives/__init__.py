"""What the ops share: checks, borders, stencils, sampling, selection, ranking, small linear algebra.

Only these modules may give an engine another form of a computation. ``lowering.primitive`` says how: a
definition, and lowerings beside it. ``padding.stencil`` makes of a stencil on a padded image the filter of a
whole one, ``loops.repeated`` and ``loops.until_stable`` make of a step a loop. tests/ops/test_targets.py
holds every lowering to its definition, and all other modules to asking for no target.
"""

try:
    import torch as _torch  # noqa: F401
except ModuleNotFoundError as error:
    if error.name != "torch":
        raise
    raise ImportError(
        'the ops of chiasm need PyTorch, which is not installed: pip install "chiasm[export]" (bundles run'
        " without it: chiasm.runtime)",
        name="torch",
    ) from None
