"""From an op to graphs: the module that every format is made of (`module.py`), torch.export's graph
(`graph.py`), gradients (`gradient.py`, `gradient_parts.py`)."""
