"""From an op to graphs: the module that every format starts from (`module.py`), torch.export's graph
(`graph.py`), gradients (`gradient.py`, `gradient_parts.py`), and what operators become in every graph
(`expansion.py`, `forms.py`, `adaptive_means.py`)."""
