"""Notebooks run from beginning to end."""

import pytest

from conftest import PROJECT

NOTEBOOKS = sorted((PROJECT / "examples" / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run(path):
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(path, as_version=4)
    client = nbclient.NotebookClient(notebook, resources={"metadata": {"path": str(PROJECT)}})
    client.execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any("effects are missing" in output.data.get("text/html", "") for output in shown)


def test_there_are_notebooks():
    assert NOTEBOOKS
