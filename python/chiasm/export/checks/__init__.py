"""What the exporter refuses: arguments and specs that cannot be (`arguments.py`), ops that are no functions
of their inputs (`purity.py`, `script_purity.py`). And whether the samples of a batch are independent
(`independence.py`)."""
