"""Pose files of `scara-drake ik`: far poses, quaternions, flips of a path, grouped solutions."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scara_drake import kinematics
from scara_drake.cli.joint_steps import largest_step
from scara_drake.cli.main import main
from scara_drake.joints import HOME

X_HOME = kinematics.forward_kinematics(HOME)
ANGLES = kinematics.intrinsic_xyz_from_rotation(X_HOME[:3, :3])


def run(capsys, *arguments):
    status = main(["ik", *map(str, arguments)])
    return status, *capsys.readouterr()


def write(path, header, rows):
    path.write_text("\n".join([header, *(",".join(map(str, row)) for row in rows)]) + "\n")
    return path


@pytest.mark.parametrize("far", ["1e150", "-1e78", "1.1e6"])
def test_a_pose_beyond_all_reach_is_named_with_its_line_and_the_others_are_answered(
    capsys, tmp_path, far
):
    pose = [*X_HOME[:3, 3], *ANGLES]
    file = write(
        tmp_path / "far.csv", "x,y,z,roll,pitch,yaw", [pose, [*pose[:1], far, *pose[2:]], pose]
    )
    status, out, err = run(capsys, "--csv", file, "--json")
    assert status == 1
    assert [len(found["answers"]) for found in json.loads(out)["poses"]] == [1, 0, 1]
    assert "line 3, column y" in err
    assert err.count("\n") == 1
    status, out, err = run(capsys, "--csv", file, "--path", "--json")
    assert (status, out) == (2, "")
    assert "line 3, column y" in err


def test_quaternion_columns_are_the_same_pose(capsys, tmp_path):
    w, x, y, z = Rotation.from_matrix(X_HOME[:3, :3]).as_quat(scalar_first=True)
    rows = [[*X_HOME[:3, 3], *np.round([w, x, y, z], 5)]]
    status, out, _ = run(
        capsys,
        "--csv",
        write(tmp_path / "a.csv", "x,y,z,qw,qx,qy,qz", rows),
        "--json",
        "--angle",
        "deg",
    )
    assert status == 0
    ((answer,),) = [pose["answers"] for pose in json.loads(out)["poses"]]
    _, rotation = kinematics.pose_error(X_HOME, kinematics.forward_kinematics(answer["q"]))
    assert rotation < 1e-4
    rows[0][3] = 0.9
    status, _, err = run(capsys, "--csv", write(tmp_path / "b.csv", "x,y,z,qw,qx,qy,qz", rows))
    assert status == 2
    assert "line 2, columns qw,qx,qy,qz: length" in err


def test_a_flip_is_no_solved_path_and_its_place_is_said(capsys, tmp_path):
    """The tool turned by 2.1 pi about its own axis: no joint has so many turns in a row there."""
    rows = []
    for angle in np.linspace(0.0, 2.1 * np.pi, 220):
        R = X_HOME[:3, :3] @ kinematics.rotation_from_intrinsic_xyz(np.array([0.0, 0.0, angle]))
        rows.append([*X_HOME[:3, 3], *kinematics.intrinsic_xyz_from_rotation(R)])
    header = "x,y,z,roll,pitch,yaw"
    turn = write(tmp_path / "turn.csv", header, rows)
    status, out, err = run(capsys, "--csv", turn, "--path", "--method", "closed_form", "--json")
    document = json.loads(out)
    q = np.array([pose["answers"][0]["q"] for pose in document["poses"]])
    steps = np.abs(np.diff(q, axis=0))
    assert steps.max() > 3.0
    assert status == 1
    assert "no continuous path" in err
    assert document["largest_step"]["pose"] == steps.max(axis=1).argmax() + 1
    assert document["largest_step"]["size"] == steps.max()
    half = write(tmp_path / "half.csv", header, rows[:100])
    status, out, _ = run(capsys, "--csv", half, "--path", "--method", "closed_form")
    assert status == 0
    assert "Largest step: " in out


def test_a_step_that_the_tool_explains_is_no_flip():
    q = np.array([HOME, HOME + np.eye(6)[5] * 2.0])
    step = largest_step(kinematics.forward_kinematics(q), q)
    assert step is not None
    assert (step.joint, step.flip) == ("theta6", False)
    around = largest_step(np.array([X_HOME, X_HOME]), q)
    assert around is not None
    assert around.flip
    assert largest_step(X_HOME[None], q[:1]) is None


def test_every_solution_is_grouped_by_posture_and_the_order_of_angles_is_said(capsys):
    pose = ["--position", *X_HOME[:3, 3], "--rpy", *ANGLES]
    status, out, _ = run(capsys, *pose, "--all", "--json")
    answers = json.loads(out)["poses"][0]["answers"]
    turns = {
        tuple(np.round([a["q"][0], *np.cos(a["q"][1:]), *np.sin(a["q"][1:])], 5) + 0.0)
        for a in answers
    }
    status, out, _ = run(capsys, *pose, "--all")
    assert status == 0
    words = " ".join(out.split())
    assert (
        f"{len(answers)} solutions, which are {len(turns)} postures and their whole turns" in words
    )
    assert "Orientation: Rx(roll) Ry(pitch) Rz(yaw)." in words
    assert len(answers) > len(turns) > 1
