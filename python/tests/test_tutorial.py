"""The tutorial, which runs as it stands; RAGGIO_WRITE_DOCS=1 keeps what it shows."""

from __future__ import annotations

import os

import pytest
from conftest import ROOT

nbformat = pytest.importorskip("nbformat", reason="the tutorial is run by nbclient: pip install nbclient ipykernel")
nbclient = pytest.importorskip("nbclient", reason="the tutorial is run by nbclient: pip install nbclient ipykernel")
pytest.importorskip("ipykernel", reason="the tutorial runs in Jupyter's kernel for Python: pip install ipykernel")

TUTORIAL = ROOT / "docs/tutorial.ipynb"


def shown(cell):
    """Values of a cell; what it says of its progress is not among them."""
    return [output for output in cell.get("outputs", ()) if output["output_type"] == "execute_result"]


def texts(notebook):
    return [output["data"]["text/plain"] for cell in notebook.cells for output in shown(cell)]


def test_tutorial(tmp_path, monkeypatch) -> None:
    committed = nbformat.read(TUTORIAL, as_version=4)
    notebook = nbformat.read(TUTORIAL, as_version=4)
    # On the CPU, whose pictures are the same everywhere.
    monkeypatch.setenv("VK_DRIVER_FILES", "/none")
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    for cell in notebook.cells:
        cell.metadata.clear()
        if cell.cell_type == "code":
            cell.outputs = shown(cell)
    if os.environ.get("RAGGIO_WRITE_DOCS"):
        notebook.metadata = committed.metadata
        nbformat.write(notebook, TUTORIAL)
    else:
        assert texts(notebook) == texts(committed)
