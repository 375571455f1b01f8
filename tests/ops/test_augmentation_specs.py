"""What is tested of every op in the catalog, of the augmentations."""

import pytest
import test_bounds
import test_catalog
import test_not_a_tensor
import test_refusals
from augmentation_specs import SPECS

from chiasm.export.catalog import Entry

every_op = pytest.mark.parametrize("entry", SPECS.values(), ids=SPECS)
DIFFERENTIABLE = {name: e for name, e in SPECS.items() if e.spec.differentiated()}


@every_op
def test_script_equals_eager(entry: Entry) -> None:
    test_catalog.test_script_equals_eager(entry)


@every_op
def test_target_forms_equal_eager(entry: Entry) -> None:
    test_catalog.test_target_forms_equal_eager(entry)


@pytest.mark.parametrize("entry", DIFFERENTIABLE.values(), ids=DIFFERENTIABLE)
def test_gradient(entry: Entry) -> None:
    test_catalog.test_gradient(entry)


@every_op
def test_wrong_tensor_is_named(entry: Entry) -> None:
    test_refusals.test_wrong_tensor_is_named(entry)


@every_op
def test_what_is_no_tensor_is_named(entry: Entry) -> None:
    test_not_a_tensor.test_what_is_no_tensor_is_named(entry)


@every_op
def test_the_cost_of_values_far_outside(entry: Entry) -> None:
    test_bounds.test_the_cost_of_values_far_outside(entry, "-1e6")
