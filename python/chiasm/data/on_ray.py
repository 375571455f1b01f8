# pyarrow and Ray are optional, and not in .venv:
# pyright: reportMissingImports=false
"""A `Map` in an actor pool of Ray Data, without deadlocks.

`dataset.map_batches(Map(...))` runs a Map in tasks, and never blocks. An actor pool holds its CPUs while it
lives: a pool that takes all CPUs leaves none for the tasks that read, and Ray waits for ever, without a
message.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .errors import DataError
from .mapping import Map

if TYPE_CHECKING:
    import ray
    import ray.data


def map_batches(
    dataset: ray.data.Dataset, mapping: Map, *, workers: int, num_cpus: float = 1, batch_size: int = 32
) -> ray.data.Dataset:
    """``dataset.map_batches`` with a pool of `workers` actors, each of which keeps the bundle loaded.

    Parameters
    ----------
    dataset
        Its batches have the columns that `mapping` reads.
    workers, num_cpus
        How many actors, and how many CPUs Ray counts for each.
    batch_size
        Rows that an actor gets at once, as an Arrow table.

    Raises
    ------
    DataError
        If the pool does not fit into the cluster beside one CPU for reading.

    Examples
    --------
    >>> import ray
    >>> from chiasm.data import Files, Map
    >>> from chiasm.data.on_ray import map_batches
    >>> preprocess = Map("build/bundles/pipelines.preprocess.chiasm", columns={"frame": Files("path")})
    >>> images = ray.data.from_items([{"path": "photos/0000.jpg"}])
    >>> tensors = map_batches(images, preprocess, workers=1)
    """
    import ray
    from ray.data import ActorPoolStrategy

    if workers < 1 or not num_cpus > 0:
        raise DataError(f"expected workers >= 1 and num_cpus > 0, got {workers} and {num_cpus}")
    nodes = [node["Resources"].get("CPU", 0) for node in ray.nodes() if node["Alive"]]
    fits = _fitting(nodes, num_cpus)
    if workers > fits:
        raise DataError(
            f"workers: {workers} of {num_cpus:g} CPU each do not leave a CPU for reading on a cluster of"
            f" {sum(nodes):g} CPUs, and Ray would wait for ever: use at most {fits}, a smaller num_cpus, or"
            " dataset.map_batches(Map(...)), whose tasks take turns with those that read"
        )
    return dataset.map_batches(
        _Worker,
        # A bundle is too large for the actor's description. As a plain argument, Ray puts it into the object
        # store, from which it may be gone when a killed actor starts again. Here the data set holds a
        # reference to it.
        fn_constructor_args=([ray.put(mapping)],),
        compute=ActorPoolStrategy(size=workers),
        num_cpus=num_cpus,
        batch_size=batch_size,
        batch_format="pyarrow",
        zero_copy_batch=True,
    )


def _fitting(nodes: list[float], num_cpus: float) -> int:
    """How many workers fit on the nodes beside one CPU for reading, which is taken on the node where it costs
    least."""
    room = [int(cpus / num_cpus + 1e-9) for cpus in nodes]
    beside = [int((cpus - 1) / num_cpus + 1e-9) - r for cpus, r in zip(nodes, room) if cpus >= 1]
    return max(0, sum(room) + max(beside)) if beside else 0


class _Worker:
    """The pool's actor, which loads the bundle before its first batch."""

    def __init__(self, mapping: list[ray.ObjectRef]) -> None:
        import ray

        self.mapping: Map = ray.get(mapping[0])
        self.mapping.open()

    def __call__(self, batch: Any) -> Any:
        return self.mapping(batch)
