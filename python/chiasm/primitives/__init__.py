"""What the ops share: checks, borders, stencils, sampling, selection, ranking, small linear algebra.

Only these modules may choose a different form of the same computation per export target (see ``target``);
tests/ops/test_targets.py proves the forms equal.
"""
