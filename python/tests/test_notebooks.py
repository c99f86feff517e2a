"""Notebooks run from beginning to end."""

import pytest

from conftest import PROJECT

NOTEBOOKS = sorted((PROJECT / "examples" / "notebooks").glob("*.ipynb"))
#: What each shows, and packages that it needs.
SHOWN = {
    "first_diagnosis": ("effects are missing", []),
    "lerobot": ("effects are missing", []),
    "pinocchio": ("largest difference", ["pinocchio"]),
}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run(path):
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    shown, packages = SHOWN[path.stem]
    for package in packages:
        pytest.importorskip(package)
    notebook = nbformat.read(path, as_version=4)
    client = nbclient.NotebookClient(notebook, resources={"metadata": {"path": str(PROJECT)}})
    client.execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    texts = [text for output in outputs for text in output.get("data", {}).values()]
    assert any(shown in text for text in texts if isinstance(text, str)), texts


def test_there_are_notebooks():
    assert [path.stem for path in NOTEBOOKS] == sorted(SHOWN)
