import numpy as np
import pytest

from scara_drake.recordings.journal import Journal, read_journal


def write(path, blocks):
    rng = np.random.default_rng(0)
    data = [(np.arange(5.0) + 5 * b, rng.normal(size=(5, 3))) for b in range(blocks)]
    with Journal(path) as journal:
        journal.begin({"seed": 7}, 3)
        for times, values in data:
            journal.append(times, values)
        journal.append(np.empty(0), np.empty((0, 3)))
    return data


def test_what_is_written_is_read_to_the_bit(tmp_path):
    data = write(tmp_path / "a.journal", 4)
    contents, times, values = read_journal(tmp_path / "a.journal")
    assert contents.description == {"seed": 7}
    np.testing.assert_array_equal(times, np.concatenate([t for t, _ in data]))
    np.testing.assert_array_equal(values, np.concatenate([v for _, v in data]))


@pytest.mark.parametrize("cut", range(1, 700, 37))
def test_a_file_cut_at_any_byte_gives_its_whole_blocks(tmp_path, cut):
    path = tmp_path / "a.journal"
    data = write(path, 4)
    whole = path.read_bytes()
    path.write_bytes(whole[:-cut])
    _, times, values = read_journal(path)
    assert len(times) % 5 == 0
    assert len(times) >= 5 * 4 - 5 * np.ceil(cut / 160)
    np.testing.assert_array_equal(times, np.concatenate([t for t, _ in data])[: len(times)])
    np.testing.assert_array_equal(values, np.concatenate([v for _, v in data])[: len(times)])


def test_another_file_is_refused(tmp_path):
    (tmp_path / "x.journal").write_text("something else")
    with pytest.raises(ValueError, match="allowed a journal written by a run"):
        read_journal(tmp_path / "x.journal")
    with pytest.raises(ValueError, match="allowed a journal written by a run"):
        read_journal(tmp_path / "none.journal")


def test_one_that_begins_anew_has_only_what_came_after(tmp_path):
    path = tmp_path / "a.journal"
    with Journal(path) as journal:
        for seed in (1, 2):
            journal.begin({"seed": seed}, 3)
            journal.append(np.arange(5.0), np.full((5, 3), float(seed)))
            journal.end("error: met what only Drake computes", 4.0)
    contents, times, values = read_journal(path)
    assert contents.description == {"seed": 2}
    np.testing.assert_array_equal(times, np.arange(5.0))
    assert (values == 2.0).all()
