"""The notebooks of docs/notebooks run from their first cell to their last, and show pictures."""

import base64
import io
from pathlib import Path

import numpy as np
import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
for needed in ("yt", "scipy", "distributed", "matplotlib"):
    pytest.importorskip(needed)

import matplotlib.pyplot as plt  # noqa: E402

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
    within = (data.get("text/html", "").partition("data:image/png;base64,") for data in shown)
    pictures += [rest.split('"')[0] for _, found, rest in within if found]
    assert pictures
    for picture in pictures:
        pixels = plt.imread(io.BytesIO(base64.b64decode(picture)), format="png")[..., :3]
        assert min(pixels.shape[:2]) >= 64 and np.ptp(pixels) > 0.3 and len(np.unique(pixels)) > 20, f"{name}: a picture without contents"


def test_all_four_are_there():
    assert {path.stem for path in FOLDER.glob("*.ipynb")} >= {"first_nebula", "yt_simulation", "sweep_and_fit", "cluster"}
