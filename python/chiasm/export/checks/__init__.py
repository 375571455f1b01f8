"""What the exporter rejects: invalid arguments and specs (`arguments.py`), and ops that are not functions of
their inputs (`purity.py`, `script_purity.py`). `independence.py` finds whether the samples of a batch are
independent."""
