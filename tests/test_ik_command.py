import csv
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

from scara_drake import ik, kinematics, robot
from scara_drake.cli.main import main
from scara_drake.joints import HOME, JOINT_NAMES, LOWER, UPPER

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
import ik_methods
import ik_targets

POSE = ["--position", "1.2", "-0.4", "3", "--rpy", "1.5707963267948966", "0", "0.35"]


def run_line(capsys, *arguments):
    status = main(["ik", *arguments])
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def answers(capsys, *arguments):
    """Return the answers of each pose in the JSON document."""
    status, out, _ = run_line(capsys, *arguments, "--json")
    assert status == 0
    return [pose["answers"] for pose in json.loads(out)["poses"]]


def drake_tool(q):
    """Return the tool pose by Drake's kinematics of the URDF."""
    plant = MultibodyPlant(time_step=0.0)
    robot.add_scara(plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    return plant.GetFrameByName("tool").CalcPoseInWorld(context)


def write_csv(path, rows, header="x,y,z,roll,pitch,yaw"):
    path.write_text("\n".join([header, *(",".join(map(str, row)) for row in rows)]) + "\n")
    return str(path)


def pose_rows(qs):
    X = kinematics.forward_kinematics(qs)
    rpy = kinematics.intrinsic_xyz_from_rotation(X[:, :3, :3])
    return np.hstack([X[:, :3, 3], rpy])


def test_a_pose_is_solved_as_drake_confirms(capsys):
    ((answer,),) = answers(capsys, *POSE)
    tool = drake_tool(answer["q"])
    np.testing.assert_allclose(tool.translation(), [1.2, -0.4, 3.0], atol=5e-3)
    # Rx(90°) Rz(0.35): the tool's z is the world's -y, its x is turned about that.
    R = [[np.cos(0.35), -np.sin(0.35), 0.0], [0.0, 0.0, -1.0], [np.sin(0.35), np.cos(0.35), 0.0]]
    np.testing.assert_allclose(tool.rotation().matrix(), R, atol=0.0175)


def test_units_are_converted(capsys):
    first = answers(capsys, *POSE)
    second = answers(
        capsys, "--unit", "mm", "--angle", "deg", "--position", "1200", "-400", "3e3",
        "--rpy", "90", "0", str(np.degrees(0.35)),
    )  # fmt: skip
    np.testing.assert_allclose(first[0][0]["q"], second[0][0]["q"], atol=1e-9)


def test_numbers_as_python_prints_them(capsys):
    status, out, _ = run_line(
        capsys, "--position", "1.2", "-4e-1", "3", "--rpy", "1.57", "-1e-05", "-.0", "--json"
    )
    assert status == 0
    assert json.loads(out)["poses"][0]["position"] == [1.2, -0.4, 3.0]


def test_the_json_document(capsys):
    _, out, _ = run_line(capsys, *POSE, "--method", "dpso", "--seed", "3", "--json")
    document = json.loads(out)
    assert list(document) == ["method", "joints", "task", "rotation", "poses"]
    assert (document["method"], document["joints"], document["task"]) == ("dpso", "full", "pose")
    (pose,) = document["poses"]
    assert list(pose) == ["position", "rpy", "answers"]
    (answer,) = pose["answers"]
    assert list(answer) == [
        "q", "position_error", "rotation_error", "success", "reason", "evaluations", "iterations",
    ]  # fmt: skip
    X_WE = np.eye(4)
    X_WE[:3, :3] = kinematics.rotation_from_intrinsic_xyz(pose["rpy"])
    X_WE[:3, 3] = pose["position"]
    again = ik.solve(X_WE, "dpso", seed=3)
    assert answer["q"] == again.q.tolist()
    assert answer["success"] is True
    assert answer["evaluations"] == again.evaluations


def test_the_table(capsys):
    status, out, _ = run_line(capsys, *POSE)
    assert status == 0
    assert "1 of 1 poses solved" in out
    ((answer,),) = answers(capsys, *POSE)
    for angle in answer["q"][1:]:
        assert f"{angle:.4f}" in out
        assert f"{np.degrees(angle):.2f}" in out
    assert "converged" in out
    assert "[mrad]" in out


def test_a_file_of_poses_and_a_file_of_answers(capsys, tmp_path):
    qs = np.random.default_rng(0).uniform(LOWER, UPPER, (5, 6))
    poses = write_csv(tmp_path / "poses.csv", pose_rows(qs))
    status, out, _ = run_line(capsys, "--csv", poses, "--output", str(tmp_path / "q.csv"))
    assert status == 0
    assert "5 of 5 poses solved" in out
    with (tmp_path / "q.csv").open() as file:
        rows = list(csv.DictReader(file))
    found = np.array([[float(row[name]) for name in JOINT_NAMES] for row in rows])
    distance, angle = kinematics.pose_error(
        kinematics.forward_kinematics(qs), kinematics.forward_kinematics(found)
    )
    assert distance.max() <= 5e-3
    assert angle.max() <= 0.0175
    assert {row["success"] for row in rows} == {"True"}
    # The answers hold the poses, so they are a file of poses too.
    assert run_line(capsys, "--csv", str(tmp_path / "q.csv"))[0] == 0


def test_a_path_is_followed_without_jumps(capsys, tmp_path):
    s = np.linspace(0.0, 1.0, 20)[:, np.newaxis]
    qs = HOME + s * np.array([0.3, 0.4, 0.3, -0.2, 0.3, 0.5])
    poses = write_csv(tmp_path / "path.csv", pose_rows(qs))
    found = answers(capsys, "--csv", poses, "--path", "--q-seed", *(str(value) for value in HOME))
    assert len(found) == 20
    q = np.array([answer["q"] for (answer,) in found])
    assert np.abs(np.diff(q, axis=0)).max() < 0.1


def test_the_arm_keeps_the_mast(capsys):
    q = np.array([4.2, 0.3, 0.8, -0.6, 1.1, 0.4])
    position, rpy = np.split(pose_rows(q[np.newaxis])[0], 2)
    pose = ["--position", *map(repr, position.tolist()), "--rpy", *map(repr, rpy.tolist())]
    ((answer,),) = answers(capsys, *pose, "--joints", "arm", "--mast", "4.2")
    assert answer["q"][0] == 4.2
    seed = [str(value) for value in q]
    ((near,),) = answers(
        capsys, *pose, "--joints", "arm", "--q-seed", *seed, "--method", "inverse_jacobian"
    )
    np.testing.assert_allclose(near["q"], q, atol=1e-6)


def test_every_solution(capsys):
    ((*found,),) = answers(capsys, *POSE, "--all")
    assert len(found) > 1
    q = np.array([answer["q"] for answer in found])
    assert len(np.unique(np.round(q, 6), axis=0)) == len(q)
    tools = [drake_tool(row) for row in q[:8]]
    for tool in tools:
        np.testing.assert_allclose(tool.translation(), [1.2, -0.4, 3.0], atol=1e-8)
        np.testing.assert_allclose(
            tool.rotation().matrix(), tools[0].rotation().matrix(), atol=1e-8
        )


def test_a_pose_without_a_solution(capsys):
    status, out, err = run_line(
        capsys, "--position", "5", "0", "3", "--rpy", "0", "0", "0", "--all"
    )
    assert status == 1
    assert "no solution" in out
    assert "1 of 1 poses not solved" in err


def test_options_reach_the_method(capsys):
    ((exact,),) = answers(capsys, *POSE, "--method", "dpso")
    ((swarm,),) = answers(capsys, *POSE, "--method", "dpso", "--option", "polish=False")
    assert swarm["position_error"] > 1e-6 > exact["position_error"]
    ((paper,),) = answers(capsys, *POSE, "--method", "dpso", "--option", "parameters=paper")
    assert paper["q"] != exact["q"]


def test_a_pose_that_is_not_solved_is_a_failure_with_a_reason(capsys):
    status, out, err = run_line(capsys, "--position", "5", "0", "3", "--rpy", "0", "0", "0")
    assert status == 1
    assert "out of reach" in out
    assert err == "scara-drake: failed: 1 of 1 poses not solved\n"


BAD = [
    (["--position", "nan", "0", "3", "--rpy", "0", "0", "0"], "--position[0]: nan, allowed any"),
    (["--position", "1", "0", "3"], "--rpy: missing, allowed"),
    ([*POSE, "--unit", "cm"], "--unit: 'cm', allowed m, mm"),
    ([*POSE, "--angle", "grad"], "--angle: 'grad', allowed rad, deg"),
    ([*POSE, "--method", "newton"], "method: 'newton', allowed closed_form, robust"),
    ([*POSE, "--joints", "legs"], "joints: 'legs', allowed full, arm"),
    ([*POSE, "--task", "rest"], "task: 'rest', allowed pose, position"),
    ([*POSE, "--joints", "arm"], "--mast: missing, allowed HEIGHT [m]"),
    ([*POSE, "--joints", "arm", "--mast", "1"], "d1 = 1 m, allowed 2.5 to 10 m"),
    ([*POSE, "--mast", "3"], "--mast: 3, allowed with --joints arm"),
    ([*POSE, "--path"], "--path: given, allowed with --csv"),
    ([*POSE, "--all", "--method", "dpso"], "--all: given, allowed without --method"),
    ([*POSE, "--option", "polish"], "--option: 'polish', allowed NAME=VALUE"),
    (
        [*POSE, "--method", "dpso", "--option", "polish=maybe"],
        "polish: maybe, allowed True",
    ),
    ([*POSE, "--option", "polishing=True"], "polishing: not an option of robust, allowed"),
    ([*POSE, "--option", "seed=3"], "--option: 'seed' has an option of its own, --seed"),
    ([*POSE, "--output", "answers.txt"], "--output: 'answers.txt', allowed a file"),
    (["--csv", "no.csv"], "--csv: 'no.csv', allowed a file that exists"),
]


@pytest.mark.parametrize(("arguments", "message"), BAD)
def test_bad_input_is_one_line(capsys, arguments, message):
    status, out, err = run_line(capsys, *arguments)
    assert status == 2
    assert out == ""
    assert message in err
    assert err.count("\n") == 1


BAD_FILES = [
    ("x,y,z\n1,2,3\n", "no column roll, pitch, yaw, allowed a first line with x,y,z,roll"),
    ("", "no column x, y, z"),
    ("x,y,z,roll,pitch,yaw\n", "0 poses, allowed 1 or more"),
    ("x,y,z,roll,pitch,yaw\n1,2,3,0,0,0\n1,2,3,0,nan,0\n", "line 3, column pitch: 'nan', allowed"),
    ("x,y,z,roll,pitch,yaw\n1,two,3,0,0,0\n", "line 2, column y: 'two', allowed a finite number"),
    ("x,y,z,roll,pitch,yaw\n1,2,3,0,0\n", "line 2, column yaw: '', allowed a finite number"),
    (b"\xff\xfe\x00x", "allowed CSV in UTF-8"),
]


@pytest.mark.parametrize(("text", "message"), BAD_FILES)
def test_a_bad_file_is_one_line(capsys, tmp_path, monkeypatch, text, message):
    monkeypatch.chdir(tmp_path)
    Path("poses.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    status, _, err = run_line(capsys, "--csv", "poses.csv")
    assert status == 2
    assert err.startswith("scara-drake: poses.csv: ")
    assert message in err
    assert err.count("\n") == 1


def test_a_file_of_a_spreadsheet(capsys, tmp_path):
    path = tmp_path / "poses.csv"
    path.write_bytes(
        b"\xef\xbb\xbfname, x, y, z, roll, pitch, yaw\r\nwall, 1200, -400, 3000, 90, 0, 20\r\n\r\n"
    )
    assert run_line(capsys, "--csv", str(path), "--unit", "mm", "--angle", "deg")[0] == 0


def test_the_forward_kinematics_of_the_benchmark():
    q = np.random.default_rng(0).uniform(LOWER, UPPER, (200, 6))
    X = ik_targets.forward_kinematics(q)
    np.testing.assert_allclose(X, kinematics.forward_kinematics(q), atol=1e-14)
    other = q + 1e-3
    for ours, theirs in zip(
        ik_targets.errors(X, other),
        kinematics.pose_error(X, kinematics.forward_kinematics(other)),
        strict=True,
    ):
        np.testing.assert_allclose(ours, theirs, atol=1e-12)


def test_the_targets_of_the_benchmark_have_an_answer():
    for targets in ik_targets.make_targets(30):
        if targets.paths:
            np.testing.assert_allclose(
                ik_targets.forward_kinematics(targets.q), targets.X_WE[:, 0], atol=1e-12
            )
            continue
        assert ik_targets.reached(targets, targets.q).all(), targets.name
        assert not ik_targets.reached(targets, targets.seeds).any()
        assert not ik_targets.reached(targets, np.full_like(targets.q, np.nan)).any()


@pytest.mark.slow
def test_the_benchmark_writes_its_results(capsys, tmp_path):
    ik_methods.main(["--targets", "3", "--output", str(tmp_path)])
    page = (tmp_path / "ik_methods.md").read_text()
    assert str(tmp_path) not in page
    assert (tmp_path / "ik_methods.png").stat().st_size > 10_000
    with (tmp_path / "ik_methods.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["targets"] for row in rows} == {"arm", "mast", "disturbed", "paths"}
    ours = [row for row in rows if row["solver"] in ("robust: solve", "robust: solve_path")]
    assert len(ours) == 4
    for row in ours:
        assert float(row["success"]) == 1.0
        assert f"| {row['solver']} | 100 |" in page
