"""Every public function is in the catalog or listed with a reason, and docs/coverage.md can be written for
the whole catalog.

The page's numbers come from parity matrices of many days (`make coverage`): no test requires that they are
current.
"""

from coverage import add, add_aarch64, add_browser, add_peers, declared, page, public_functions
from peers import apart

from chiasm.export.catalog import NO_GRADIENT, NOT_DEPLOYED, catalog


def test_every_public_function_is_deployed_or_excused() -> None:
    public = public_functions()
    assert public["filters.sobel"]
    assert {name for name, deployed in public.items() if not deployed} == set(NOT_DEPLOYED)


def test_excuses_say_why() -> None:
    assert [name for name, reason in (NOT_DEPLOYED | NO_GRADIENT).items() if len(reason.split()) < 3] == []


def test_ops_without_a_gradient_are_in_the_catalog_and_have_none() -> None:
    entries = catalog()
    assert not [name for name in NO_GRADIENT if entries[name].spec.differentiated()]


def test_a_row_of_the_page_says_what_the_catalog_says() -> None:
    for name, entry in catalog().items():
        row = declared(entry)
        assert row[0] == f"`{name}`" and all(isinstance(cell, str) and cell for cell in row), row


def test_an_op_is_recorded_where_it_was_run_in_every_way() -> None:
    ways = (
        ("C++ torch", "forward.pt"),
        ("C++ onnx", "forward.onnx"),
        ("Python onnx", "forward.onnx"),
        ("C++ native", "forward.pt2"),
        ("C++ onnx fused", "forward.onnx"),
    )
    name = "color.bgr_to_rgb.frames"  # bytes have no gradient
    row = {"op": name, "method": "forward", "message": ""}
    checks = [row | {"backend": b, "artifact": a, "error": 1e-7 * i} for i, (b, a) in enumerate(ways)]
    entries = {name: catalog()[name], "filters.sobel": catalog()["filters.sobel"]}
    record: dict = {}
    assert add(record, checks[:-1], entries) == 0 and record == {}
    assert add(record, checks + [c | {"op": "filters.sobel"} for c in checks], entries) == 1
    assert record[name]["forward"]["native (C++)"] == 3e-7
    text = page(entries, record)
    assert "natively with its gradient yet: `filters.sobel`." in text and "None failed" in text
    add_browser(record, [{"op": name, "message": "", "error": error} for error in (0.0, 2e-7)])
    assert record[name]["browser"] == 2e-7 and "| 2e-07 |" in page(entries, record)
    assert "| 2e-07 | 0 = |" not in page(entries, record)
    add_aarch64(record, {name: {"error": 0.0, "same_bits": True, "message": ""}, "of.another.day": {}})
    assert "| 2e-07 | 0 = |" in page(entries, record)
    add_aarch64(record, {name: {"error": 3e-6, "same_bits": False, "message": ""}})
    assert "| 2e-07 | 3e-06 |" in page(entries, record)
    add_aarch64(record, {name: {"error": None, "same_bits": False, "message": "no native code"}})
    assert "| 2e-07 | **failed** |" in page(entries, record)
    add_peers(record, {name: {"most": 0.0, "differing": 0.0}, "of.another.day": {}})
    assert f"{declared(entries[name])[-1]} | 0 | " in page(entries, record)
    add_peers(record, {name: {"most": 2.0, "differing": 0.00314}})
    assert f"{declared(entries[name])[-1]} | 2 (0.31 %) | " in page(entries, record)
    checks[0] |= {"message": "differs"}
    add(record, checks, entries)
    assert f"Failed: `{name}`" in page(entries, record) and "**failed**" in page(entries, record)
    record[name]["source"] = "of another day"
    assert f"| `{name}`\\* |" in page(entries, record)


def test_levels_beside_the_peer() -> None:
    """OpenCV flips and blurs to the same bytes; its bicubic resize rounds some values in another way."""
    for name in ("geometry.transform.hflip.frames", "filters.box_blur.frames"):
        assert apart(catalog()[name]) == {"most": 0.0, "differing": 0.0}
    found = apart(catalog()["geometry.transform.resize.bicubic.frames"])
    assert found is not None and found["most"] == 1.0 and 0.0 < found["differing"] < 0.1
    assert apart(catalog()["filters.sobel"]) is None
