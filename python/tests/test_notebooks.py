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
    shown = [output.get("data", {}) for output in outputs]
    # Plots are PNG; images of Barnard are within HTML.
    pictures = [data["image/png"] for data in shown if "image/png" in data]
    pictures += [data["text/html"] for data in shown if "data:image/png;base64," in data.get("text/html", "")]
    assert pictures and all(len(picture) > 2000 for picture in pictures)


def test_all_four_are_there():
    assert {path.stem for path in FOLDER.glob("*.ipynb")} >= {"first_nebula", "yt_simulation", "sweep_and_fit", "cluster"}
