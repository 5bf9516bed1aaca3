"""The tables are those of the native rows, and the stub is what the native module has."""

import ast
import dataclasses
import inspect
from pathlib import Path

import barnard as bn
import pytest
import write_tables
from barnard import _barnard, tables


def test_the_tables_are_of_the_rows():
    written = Path(tables.__file__).read_text(encoding="utf-8")
    assert written == write_tables.text(), "run: python python/write_tables.py"


def test_choices_are_checked_when_they_are_set():
    for wrong, key in [
        (lambda: bn.Observation("10 20", frame="b1950"), "observation.frame"),
        (lambda: bn.Observation("10 20", unit="Jy"), "observation.unit"),
        (lambda: bn.Grid("cloud.npy", axes="xyw"), "field.axes"),
    ]:
        with pytest.raises(bn.SceneError, match="known: ") as refused:
            wrong()
        assert refused.value.key == key


def test_parameters_have_values_units_and_ranges():
    scene = bn.Scene.builtin("pleiades")
    scene.stars[0].temperature = "12 kK"
    found = scene.parameters()
    temperature = found["star[0].temperature"]
    assert (temperature.value, temperature.unit, temperature.is_default) == (12.0, "kK", False)
    assert (temperature.low, temperature.high) == pytest.approx((1e-3, 1e6)) and "temperature between" in temperature.type
    assert found["method.bounces"].low == 1 and found["camera.position"].unit == "pc" and len(found["camera.position"].value) == 3


def test_every_key_of_every_table_has_a_keyword():
    for path, name in write_tables.CLASSES:
        keywords = inspect.signature(getattr(bn, name)).parameters
        missing = [key for key in write_tables.ROWS[path].all_keys() if key not in keywords]
        assert not missing, (name, missing)


def names(body) -> set[str]:
    found = {node.name for node in body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    return found | {node.target.id for node in body if isinstance(node, ast.AnnAssign)}


def test_the_stub_is_the_native_module():
    stub = ast.parse(Path(tables.__file__).with_name("_barnard.pyi").read_text(encoding="utf-8"))
    native = {name for name in dir(_barnard) if not name.startswith("__") or name == "__version__"}
    classes = {node.name: node for node in stub.body if isinstance(node, ast.ClassDef)}
    dictionaries = {name: names(node.body) for name, node in classes.items() if any(ast.unparse(base) == "TypedDict" for base in node.bases)}
    assert names(stub.body) - set(dictionaries) == native
    for name in set(classes) - set(dictionaries):
        if not issubclass(getattr(_barnard, name), Exception):
            native = {name for name in vars(getattr(_barnard, name)) if not name.startswith("__")}
            assert names(classes[name].body) - {"__new__"} == native, name
    # Dictionaries have the keys of what is made of them.
    shown = {"ReportFacts": bn.Report, "SpatialFacts": bn.SpatialReport, "CertificateFacts": bn.Certificate, "ParameterFacts": bn.Parameter}
    assert {name: dictionaries[name] for name in shown} == {name: {field.name for field in dataclasses.fields(cls)} for name, cls in shown.items()}


def test_everything_public_has_words():
    for name in bn.__all__:
        assert inspect.getdoc(getattr(bn, name)), name


def test_the_reference_is_of_the_docstrings():
    import write_reference

    page = Path(write_reference.__file__).parents[1] / "docs" / "python-reference.md"
    assert page.read_text(encoding="utf-8") == write_reference.text(), "run: python python/write_reference.py"
    shown = {name for names in write_reference.CHAPTERS.values() for name in names}
    assert shown == set(bn.__all__) | {"map"}
