"""The building blocks of the ops: checks, borders, stencils, sampling, selection, ranking, small linear
algebra. Only these modules may give an engine another form of a computation, by ``lowering.primitive``: a
definition with lowerings. ``padding.stencil`` turns a stencil on a padded image into a filter of a whole
image; ``loops.repeated`` and ``loops.until_stable`` turn a step into a loop. tests/ops/test_targets.py
compares every lowering with its definition, and checks that no other module asks for the target.
"""

try:
    import torch as _torch  # noqa: F401
except ModuleNotFoundError as error:
    if error.name != "torch":
        raise
    raise ImportError(
        'the ops of chiasm need PyTorch, which is not installed: pip install "chiasm[ops]" (bundles run'
        " without it: chiasm.runtime)",
        name="torch",
    ) from None
