"""The notebooks: executed once, by `docs/run_notebooks.py`; what is said in them is true."""

from __future__ import annotations

import ast
import base64
import gzip
import re
from html import unescape
from pathlib import Path
from typing import Any

import nbformat
import pytest
import run_notebooks
from browser import chromium, count_hue, needs_chromium, open_page
from matplotlib.colors import is_color_like
from nbconvert import HTMLExporter

NAMES = run_notebooks.names()
each_notebook = pytest.mark.parametrize("name", NAMES)
SCENES = {"01_robot_and_diagram", "05_haptic_loop"}
# To write a block is what this notebook teaches; all others call what the package has.
OWN = {"06_your_own_block": ["Spring"]}
# What is false as a notebook stands, and true after the line that its question changes.
ANSWERS = {
    "01_robot_and_diagram": "abs(np.hypot(*p_WE[:2]) - 2.3) < 1e-9",
    "02_inverse_kinematics": "not answer.success and abs(answer.rotation_error - 0.072) < 2e-3",
    "03_sliding_mode_control": "abs(hangs - 0.61) < 0.01",
    "04_delay_and_passivity": "apart > 10.0 and energy_margin(runs['watched']) > -1e-9",
    "05_haptic_loop": "abs(force - 2.72) < 0.03",
    "06_your_own_block": "abs(hangs - 1.0) < 0.01",
    "07_study_on_the_engine": "bears > 4.9",
    "08_paper_reproduced": "judged.verdict == 'reproduced'",
}


def source(name: str) -> Any:
    return run_notebooks.read(run_notebooks.SOURCES / f"{name}.ipynb")


def executed(name: str) -> Any:
    return run_notebooks.read(run_notebooks.execute(name))


def code(notebook: Any) -> list[Any]:
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def texts(notebook: Any) -> list[str]:
    return [cell.source for cell in notebook.cells if cell.cell_type == "markdown"]


def question(notebook: Any) -> tuple[str, str, str]:
    """The last cell, the line that it names, and the one to put in its place."""
    (_, *_), last = notebook.cells[:-1], notebook.cells[-1].source
    old, new = re.findall(r"^```python\n(.*)\n```$", last, re.MULTILINE)
    return last, old, new


def scenes(notebook: Any) -> list[str]:
    """The frames of an executed notebook that hold a packed scene."""
    markup = [
        output.data["text/html"]
        for cell in code(notebook)
        for output in cell.outputs
        if "text/html" in output.get("data", {})
    ]
    return [each for each in markup if "DecompressionStream" in each]


def test_the_course_is_complete():
    assert [name[:2] for name in NAMES] == [f"{number:02d}" for number in range(1, 9)]
    assert set(ANSWERS) == set(NAMES)


@each_notebook
def test_notebook_runs_without_a_word_on_stderr(name):
    notebook = executed(name)  # raises otherwise
    assert all(cell.execution_count is not None for cell in code(notebook))
    assert len(scenes(notebook)) == (name in SCENES)
    for data in (o.get("data", {}) for cell in code(notebook) for o in cell.outputs):
        assert "<Figure" not in data.get("text/plain", "") or "image/png" in data


@each_notebook
def test_notebook_is_clean(name):
    notebook = source(name)
    nbformat.validate(notebook)
    assert notebook.metadata.kernelspec.name == "python3"
    for cell in code(notebook):
        assert cell.outputs == []
        assert cell.execution_count is None


@each_notebook
def test_notebook_has_no_code_of_its_own(name):
    """Helpers and colours stand in the package: a notebook only calls and tells."""
    classes = []
    for cell in code(source(name)):
        tree = ast.parse(cell.source)
        inside = {id(n) for node in tree.body if isinstance(node, ast.ClassDef) for n in node.body}
        classes += [node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
        for node in ast.walk(tree):
            assert not isinstance(node, ast.FunctionDef) or id(node) in inside, node.name
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                # Single letters are axes, x and y; none is a channel.
                word = len(node.value) < 2 or node.value == "none"
                assert word or not is_color_like(node.value), node.value
    assert classes == OWN.get(name, [])


@each_notebook
def test_cells_are_short(name):
    for cell in code(source(name)):
        assert cell.source.count("\n") < 24, cell.source


@each_notebook
def test_it_begins_with_what_will_be_seen_and_tells_what_to_look_at(name):
    first, *others = texts(source(name))
    assert first.startswith(f"# {int(name[:2])} ")
    assert "You will see" in first
    assert sum("*What to look at:*" in text for text in others) >= 3


@each_notebook
def test_equations_are_set_and_balanced(name):
    for text in texts(source(name)):
        plain = re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.DOTALL)
        assert plain.count("$$") % 2 == 0
        shown = re.findall(r"\$\$(.*?)\$\$", plain, re.DOTALL)
        inline = re.sub(r"\$\$.*?\$\$", "", plain, flags=re.DOTALL)
        assert inline.count("$") % 2 == 0, text
        for equation in [*shown, *re.findall(r"\$(.*?)\$", inline, re.DOTALL)]:
            assert equation.count("{") == equation.count("}"), equation
            lefts, rights = (re.findall(rf"\\{s}(?![a-z])", equation) for s in ("left", "right"))
            assert len(lefts) == len(rights), equation
            begun = re.findall(r"\\begin{(\w+)}", equation)
            assert begun == re.findall(r"\\end{(\w+)}", equation)
            assert set(begun) <= {"aligned", "bmatrix"}, equation


@each_notebook
def test_links_lead_somewhere(name):
    for text in texts(source(name)):
        for link in re.findall(r"\]\(([^)\s]+)\)", text):
            assert (run_notebooks.SOURCES / link.split("#")[0]).exists(), link


@each_notebook
def test_the_question_changes_one_line_that_is_there(name):
    last, old, new = question(source(name))
    assert last.startswith("## Question\n")
    assert "<summary>Answer</summary>" in last
    assert last.index("```python") < last.index("<details>")
    lines = [line for cell in code(source(name)) for line in cell.source.splitlines()]
    assert lines.count(old) == 1
    assert new != old
    ast.parse(new)


@pytest.mark.slow
@pytest.mark.timeout(1200)
@each_notebook
def test_the_answer_is_true(name):
    notebook, (_, old, new) = source(name), question(source(name))
    client = run_notebooks.client_of(notebook)
    cells = list(enumerate(notebook.cells))
    changed = next(i for i, cell in cells if old in cell.source.splitlines())
    checks = [f"assert not ({ANSWERS[name]})", f"assert {ANSWERS[name]}"]
    before, after = map(nbformat.v4.new_code_cell, checks)
    notebook.cells += [before, after]
    with client.setup_kernel():
        for index, cell in cells:
            client.execute_cell(cell, index)
        client.execute_cell(before, len(cells))
        notebook.cells[changed].source = notebook.cells[changed].source.replace(old, new)
        for index, cell in cells[changed:]:
            client.execute_cell(cell, index)
        client.execute_cell(after, len(cells) + 1)


@pytest.mark.parametrize("name", sorted(SCENES))
def test_the_scene_is_in_the_exported_page(name):
    page, _ = HTMLExporter().from_notebook_node(executed(name))
    packed = re.findall(r"atob\((?:&quot;|\")([\w+/=]{1000,})", page)
    assert len(packed) == 1
    shown = gzip.decompress(base64.b64decode(packed[0])).decode()
    assert "viewer.animator" in shown or "MeshCat" in shown
    assert len(packed[0]) < 2.5e6


@pytest.mark.browser
@needs_chromium
def test_the_scene_plays_without_a_network(tmp_path: Path):
    (frame,) = scenes(executed("01_robot_and_diagram"))
    (inner,) = re.findall(r'srcdoc="([^"]*)"', frame)
    page = tmp_path / "scene.html"
    page.write_text(unescape(inner))
    with chromium() as browser, open_page(browser, f"file://{page}", offline=True) as opened:
        opened.wait(1.0)
        assert not opened.messages
        assert count_hue(opened.picture(), 15, 45) > 500  # the orange arm


def test_an_error_names_notebook_and_cell(tmp_path, monkeypatch):
    monkeypatch.setattr(run_notebooks, "SOURCES", tmp_path)
    monkeypatch.setattr(run_notebooks, "EXECUTED", tmp_path / "made")
    cells = nbformat.v4
    for name, line, said in (
        ("raises", "1 / 0", "ZeroDivisionError"),
        ("warns", "import warnings; warnings.warn('so')", "UserWarning: so"),
    ):
        notebook = cells.new_notebook(cells=[cells.new_code_cell("1"), cells.new_code_cell(line)])
        nbformat.write(notebook, tmp_path / f"{name}.ipynb")
        with pytest.raises(run_notebooks.NotebookError, match=f"{name}, cell 1: ") as error:
            run_notebooks.execute(name)
        assert said in str(error.value)
        assert not (tmp_path / "made" / f"{name}.ipynb").exists()


def test_an_unknown_name_is_refused(capsys):
    assert run_notebooks.main(["09_nothing"]) == 2
    assert "09_nothing, allowed 01_robot_and_diagram" in capsys.readouterr().err
    assert run_notebooks.main(["--jobs", "0"]) == 2
    assert capsys.readouterr().err == "--jobs: 0, allowed 1 or more\n"
