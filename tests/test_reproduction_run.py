"""The command `reproduce`: its processes, its exit status, and the verdicts that are known."""

import json
import os
import re
import signal
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest
import xarray as xr
from matplotlib.figure import Figure
from worker_tasks import do

from scara_drake.cli import reproduce
from scara_drake.cli.main import main
from scara_drake.experiments import EXPERIMENTS, Claim, Criterion, Experiment
from scara_drake.experiments.claim import OURS
from scara_drake.experiments.plots import Picture
from scara_drake.experiments.quantity import quantity
from scara_drake.experiments.reading import OpenQuestion, Reading
from scara_drake.reproduction import baseline, run
from scara_drake.reproduction.index import NUMBERED
from scara_drake.reproduction.workers import Workers

# Those that are drawn, and those that stand in the place of the paper's drawings.
PICTURES = sum(map(len, run.DRAWN.values())) + 7
ROOT = Path(__file__).parents[1]


def drawn(data):
    figure = Figure()
    figure.subplots().plot([0.0, 1.0])
    return figure


def made(name):
    """An experiment that takes no time, with a question and a time by the clock."""

    def experiment(seed):
        claims = [
            Claim(f"{name} < | & holds", "2 s", f"3 {seed}", Criterion("below", True), "As it is."),
            Claim("Our own", None, "1 mm", Criterion("none", False), "So it is.", OURS),
            Claim("Time", None, quantity(0.123, "ms", clock=True), None, "Of this machine."),
        ]
        readings = [
            Reading(n, "As said.", {"error": "1 mm"}, chosen=n == "one") for n in ("one", "2")
        ]
        question = OpenQuestion("Which?", claims[0].statement, tuple(readings))
        return Experiment(name, xr.Dataset(), claims, (question,))

    return experiment


@pytest.fixture
def quick(monkeypatch, tmp_path):
    """The command with experiments that take no time, in this process, and verdicts of its own."""
    for name in EXPERIMENTS:
        monkeypatch.setitem(EXPERIMENTS, name, made(name))
    for pictures in run.DRAWN.values():
        for number, picture in pictures.items():
            quick_one = Picture(picture.experiment, drawn, picture.caption)
            monkeypatch.setitem(pictures, number, quick_one)

    def here(names, seed, jobs, began):
        for name in names:
            began(name)
            yield run.run_one(name, seed)

    known = tmp_path / "baseline.yaml"
    monkeypatch.setattr(reproduce, "run_experiments", here)
    monkeypatch.setattr(reproduce, "compile_all", lambda scenarios: 0)
    monkeypatch.setattr(baseline, "PATH", known)
    monkeypatch.setattr(baseline.read, "__defaults__", (known,))
    monkeypatch.setattr(baseline.write, "__defaults__", (known,))
    return tmp_path


def call(folder, *arguments):
    return main(["reproduce", "--out", str(folder / "out"), *arguments])


def with_verdict(name, met):
    def experiment(seed):
        found = made(name)(seed)
        first = found.claims[0]
        other = Claim(first.statement, first.paper, "4 s", Criterion("below", met), "Changed.")
        return Experiment(name, found.data, [other, *found.claims[1:]])

    return experiment


def test_accepted_verdicts_are_known_from_then_on(quick, capsys):
    assert call(quick) == 1  # all are new
    assert "new: table_1: Our own (not reproduced)" in capsys.readouterr().out
    assert "new: table_1" in (quick / "out" / "reproduction.md").read_text()
    assert call(quick, "--accept") == 0
    assert "new: table_1" in capsys.readouterr().out
    for name in ("reproduction.md", "reproduction.html"):  # what is accepted is no difference
        assert "new: " not in (quick / "out" / name).read_text()
    assert set(baseline.read()) == set(EXPERIMENTS)
    assert call(quick) == 0
    assert call(quick, "--only", "table_10") == 0  # what is not asked for is not gone


def test_a_lost_verdict_has_status_1_and_its_name(quick, monkeypatch, capsys):
    call(quick, "--accept")
    monkeypatch.setitem(EXPERIMENTS, "table_10", with_verdict("table_10", False))
    assert call(quick) == 1
    lost = "lost: table_10: table_10 < | & holds (reproduced -> not reproduced)"
    assert lost in capsys.readouterr().out
    assert lost in (quick / "out" / "reproduction.md").read_text()
    assert "lost: table_10: table_10 &lt;" in (quick / "out" / "reproduction.html").read_text()
    assert call(quick, "--only", "table_9") == 0
    assert call(quick, "--only", "table_10", "--accept") == 0
    assert call(quick) == 0
    monkeypatch.setitem(EXPERIMENTS, "table_10", with_verdict("table_10", True))
    assert call(quick) == 1
    assert "better: table_10" in capsys.readouterr().out


def test_a_claim_or_an_experiment_that_is_gone_is_named(quick, monkeypatch, capsys):
    call(quick, "--accept")
    shorter = made("windup")(0)
    monkeypatch.setitem(
        EXPERIMENTS, "windup", lambda seed: Experiment("w", shorter.data, shorter.claims[:2])
    )
    monkeypatch.delitem(EXPERIMENTS, "couplings")
    assert call(quick) == 1
    told = capsys.readouterr().out
    assert "gone: windup: Time (not comparable)" in told
    assert "gone: couplings: Our own (not reproduced)" in told
    assert call(quick, "--accept") == 0
    assert "couplings" not in baseline.read()


def test_what_raises_is_told_by_name_and_breaks_nothing_else(quick, monkeypatch, capsys):
    call(quick, "--accept")

    def broken(seed):
        raise ZeroDivisionError("the mast\nhas no weight")

    def no_picture(data):
        raise KeyError("time")

    monkeypatch.setitem(EXPERIMENTS, "table_6", broken)
    monkeypatch.setitem(run.DRAWN["figure"], 16, Picture("figures_16_17", no_picture, "None."))
    assert call(quick) == 1
    told = capsys.readouterr().out
    assert "broke off: table_6: the mast has no weight" in told
    assert "raise ZeroDivisionError" in told  # where
    assert "broke off: figures_16_17: figure 16: 'time'" in told
    assert "gone" not in told
    for name in ("reproduction.html", "reproduction.md"):
        page = (quick / "out" / name).read_text()
        assert "the mast has no weight" in page
        assert "figures_16_17 " in page  # its claims are there
    assert call(quick, "--accept") == 1
    assert "table_6" in baseline.read()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--only", "table_13"], "--only: 'table_13', allowed table_1 to table_12"),
        (["--jobs", "0"], "jobs: 0, allowed 1 to"),
        (["--seed", "-1"], "--seed: -1, allowed 0"),
        (["--seed", "1000000001"], "--seed: 1000000001, allowed 0 to 1e+09"),
        (["--seed", "1", "--accept"], "--accept: with --seed 1, allowed with --seed 0"),
    ],
)
def test_bad_arguments_are_one_line_and_write_nothing(quick, capsys, arguments, said):
    assert call(quick, *arguments) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not (quick / "out").exists()


def test_verdicts_that_cannot_be_kept_are_refused_before_anything_runs(quick, monkeypatch, capsys):
    (quick / "file").write_text("")
    monkeypatch.setattr(baseline, "PATH", quick / "file" / "baseline.yaml")
    assert call(quick, "--accept") == 2
    assert "--accept: " in capsys.readouterr().err
    assert not (quick / "out").exists()


def test_only_may_stand_more_than_once(quick, capsys):
    call(quick, "--only", "table_1", "table_2", "--only", "table_3")
    assert "3 experiments in" in capsys.readouterr().out


def test_another_seed_is_said_where_a_verdict_differs(quick, monkeypatch, capsys):
    said = "The known verdicts are those of seed 0; this was seed 7."
    call(quick, "--accept")
    assert call(quick, "--seed", "7") == 0
    assert said not in capsys.readouterr().out
    monkeypatch.setitem(EXPERIMENTS, "table_10", with_verdict("table_10", False))
    assert call(quick, "--seed", "7") == 1
    assert said in capsys.readouterr().out


def test_a_folder_that_cannot_be_written_is_refused_before_the_run(quick, capsys):
    (quick / "file").touch()
    for out in (quick / "file", quick / "file" / "below"):
        assert main(["reproduce", "--out", str(out)]) == 2
        assert "--out: " in capsys.readouterr().err
    (quick / "out").mkdir()
    (quick / "out" / "reproduction").touch()
    assert call(quick) == 2
    if os.getuid():  # nobody refuses root
        (quick / "closed").mkdir(mode=0o500)
        assert main(["reproduce", "--out", str(quick / "closed")]) == 2


class Seen(HTMLParser):
    """The anchors, links and pictures of a page, and whether its tags are closed."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links, self.pictures, self.open = [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.anchors += [found["id"]] if "id" in found else []
        self.links += [found["href"]] if "href" in found else []
        self.pictures += [found["src"]] if "src" in found else []
        if tag not in ("meta", "input", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_page_has_every_number_and_no_broken_link(quick):
    call(quick)
    text = (quick / "out" / "reproduction.html").read_text()
    seen = Seen(text)
    assert not seen.open
    assert len(set(seen.anchors)) == len(seen.anchors)
    assert {link for link in seen.links if link.startswith("#")} == set(seen.links)
    assert {link[1:] for link in seen.links} <= set(seen.anchors)
    for chapter, last in (("Tables", 12), ("Figures", 30), ("Equations", 53)):
        (line,) = re.findall(rf"<p>{chapter} (.*?)</p>", text)
        assert re.findall(r">(\d+)</a>", line) == [str(n) for n in range(1, last + 1)]
    assert all(src.startswith("data:image/") for src in seen.pictures)
    assert len(seen.pictures) == PICTURES
    for name in EXPERIMENTS:
        assert text.count(f"{name} &lt; | &amp; holds</span>") == 1, name
    assert "0.123 ms" in text


def anchors(markdown):
    return [
        re.sub(r"[^\w-]", "", heading.lower().replace(" ", "-"))
        for heading in re.findall(r"^#+ (.*)$", markdown, re.M)
    ]


def test_the_markdown_has_the_same_without_the_clock(quick):
    call(quick)
    folder = quick / "out"
    text = (folder / "reproduction.md").read_text()
    assert set(re.findall(r"\]\(#(.*?)\)", text)) <= set(anchors(text))
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", text)
    assert len(pictures) == PICTURES
    assert {str(p.relative_to(folder)) for p in folder.rglob("*.*g")} == set(pictures)
    for name in EXPERIMENTS:
        assert text.count(f"| {name} < \\| & holds |") == 1, name
    assert "0.123" not in text
    assert "Which? Judged:" in text
    first = {path: path.read_bytes() for path in folder.rglob("*.*") if path.suffix != ".html"}
    call(quick)
    assert first == {path: path.read_bytes() for path in first}


def test_a_process_that_dies_takes_nothing_with_it():
    with Workers(do, 2) as workers:
        found = dict(workers.each(["a", "die", "b", "c"]))
    assert found.pop("die") is None
    assert {task: str(result).partition(" by ")[0] for task, result in found.items()} == {
        task: task for task in ("a", "b", "c")
    }


PROGRAM = """
import os, sys
sys.path.insert(0, sys.argv[1])
from worker_tasks import do
from scara_drake.reproduction.workers import Workers
if __name__ == "__main__":
    with Workers(do, 2) as workers:
        try:
            for _ in workers.each(["sleep", "sleep"], lambda task: print(task, flush=True)):
                pass
        except KeyboardInterrupt:
            print([w.process.pid for w in workers._workers], flush=True)
            raise
"""


def test_ctrl_c_ends_the_processes_too(tmp_path):
    (tmp_path / "program.py").write_text(PROGRAM)
    command = [sys.executable, str(tmp_path / "program.py"), str(ROOT / "tests")]
    started = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    assert started.stdout is not None
    assert [started.stdout.readline() for _ in range(2)] == ["sleep\n", "sleep\n"]
    os.killpg(started.pid, signal.SIGINT)  # as a terminal does
    out, error = started.communicate(timeout=60.0)
    assert "KeyboardInterrupt" in error
    for pid in json.loads(out):
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


def test_the_page_in_docs_and_the_known_verdicts_are_of_the_same_claims():
    text = (ROOT / "docs" / "reproduction.md").read_text()
    known = baseline.read()
    assert set(known) == set(EXPERIMENTS)
    rows = re.findall(r"^\| (.*?) \| .* \| ([a-z ]+) \| .* \|$", text.replace("\\|", "¦"), re.M)
    for name, claims in known.items():
        assert f"Experiment `{name}`:" in text
        for statement, verdict in claims.items():
            assert (statement.replace("|", "¦"), verdict) in rows, (name, statement)
    for entries, last in NUMBERED.items():
        assert f"## {entries.capitalize()}s" in text
        assert last
    pictures = set(re.findall(r"!\[.*?\]\(reproduction/(.*?)\)", text))
    assert pictures == {path.name for path in (ROOT / "docs" / "reproduction").iterdir()}
    drawn = {f"{kind}_{number}.png" for kind, them in run.DRAWN.items() for number in them}
    assert drawn <= pictures


def said(page):
    """What a report says, without the places of its pictures and the versions it was made with."""
    return [line for line in page.splitlines() if not line.startswith(("![", "Made by"))]


@pytest.mark.slow
def test_the_paper_is_reproduced(tmp_path):
    assert main(["reproduce", "--out", str(tmp_path)]) == 0
    page = (tmp_path / "reproduction.md").read_text()
    assert said(page) == said((ROOT / "docs" / "reproduction.md").read_text())
