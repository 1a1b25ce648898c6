import ast
from pathlib import Path

import nbformat
import pytest
from matplotlib.colors import is_color_like
from nbclient import NotebookClient

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.ipynb"))
each_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def read(path):
    return nbformat.read(path, as_version=4)


def test_there_are_notebooks():
    assert NOTEBOOKS


@each_notebook
def test_notebook_runs(path):
    NotebookClient(
        read(path), timeout=240, resources={"metadata": {"path": str(path.parent)}}
    ).execute()  # raises where a cell fails


@each_notebook
def test_notebook_is_clean(path):
    notebook = read(path)
    nbformat.validate(notebook)
    assert notebook.metadata.kernelspec.name == "python3"
    for cell in notebook.cells:
        if cell.cell_type == "code":
            assert cell.outputs == []
            assert cell.execution_count is None


@each_notebook
def test_notebook_has_no_code_of_its_own(path):
    """Helpers and colours stand in the package: a notebook only calls and tells."""
    for cell in read(path).cells:
        if cell.cell_type != "code":
            continue
        for node in ast.walk(ast.parse(cell.source)):
            assert not isinstance(node, ast.FunctionDef | ast.ClassDef), node.name
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                # Single letters are axes, x and y; none is a channel.
                word = len(node.value) < 2 or node.value == "none"
                assert word or not is_color_like(node.value), node.value
