"""The notebooks of docs/notebooks run from their first cell to their last, and show pictures."""

from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
for needed in ("yt", "scipy", "distributed", "matplotlib"):
    pytest.importorskip(needed)

FOLDER = Path(__file__).parents[2] / "docs" / "notebooks"


@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.glob("*.ipynb")))
def test_notebooks_run(name):
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    client = nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(FOLDER)}})
    client.execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    pictures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert pictures and all(len(output["data"]["image/png"]) > 2000 for output in pictures)


def test_all_four_are_there():
    assert {path.stem for path in FOLDER.glob("*.ipynb")} >= {"first_nebula", "yt_simulation", "sweep_and_fit", "cluster"}
