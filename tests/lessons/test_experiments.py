"""Experiments in session files: every trial is stored as an event; its results follow from the samples."""

import json
import sqlite3
from contextlib import closing

import pytest

from hapkit_studio.analysis import pointing
from hapkit_studio.analysis.discrimination import Observer
from hapkit_studio.analysis.pointing import CONDITIONS, Subject
from hapkit_studio.cli import main
from hapkit_studio.lessons import experiments, library
from hapkit_studio.lessons.grade import grade_file
from hapkit_studio.lessons.hand_in import hand_in
from hapkit_studio.sessions.file import SessionError, checksum
from hapkit_studio.sessions.session import Session
from hapkit_studio.sessions.settings_events import log


@pytest.fixture(scope="module")
def pointed(tmp_path_factory):
    path = tmp_path_factory.mktemp("pointing") / "ada.hapkit"
    targets = pointing.plan(CONDITIONS[:2], rounds=1, seed=1)
    return path, targets, experiments.save_pointing(path, Subject(), targets, seed=1)


def copied(pointed, tmp_path):
    path = tmp_path / "ada.hapkit"
    path.write_bytes(pointed[0].read_bytes())
    return path


def edit(path, kind, change, only=0):
    """Change event number ``only`` among the events of a kind, and correct its checksum."""
    with closing(sqlite3.connect(path)) as database:
        found = database.execute("SELECT id, time, what FROM event WHERE kind = ?", (kind,)).fetchall()
        row, time, what = found[only]
        text = json.dumps({**json.loads(what), **change}, ensure_ascii=False)
        values = (text, checksum((time, kind, text)), row)
        database.execute("UPDATE event SET what = ?, crc = ? WHERE id = ?", values)
        database.commit()


def test_every_trial_is_in_the_file_with_its_condition_in_force(pointed):
    path, targets, done = pointed
    found = experiments.read(path)
    assert found.trials == tuple(done)
    assert found.remarks == ()
    assert [(t.condition, t.distance, t.width) for t in found.trials] == [
        (t.condition.name, t.distance, t.width) for t in targets
    ]
    with closing(Session(path)) as session:
        for trial in found.trials:
            (_, settings), *changes = log(session.events, trial.begin, trial.stop)
            assert settings["parameters"]["kinetic_force"] == trial.force
            assert not changes


@pytest.mark.parametrize("change", [{"seconds": 0.4}, {"end": 0.0}])
def test_an_edited_trial_is_detected(pointed, tmp_path, change):
    path = copied(pointed, tmp_path)
    edit(path, "pointing", change, only=4)
    (remark,) = experiments.read(path).remarks
    assert remark.startswith("For pointing trial 5, the file says ")
    assert "its samples give" in remark


@pytest.mark.parametrize("name", ["start", "distance"])
def test_an_edited_place_of_a_trial_is_detected(pointed, tmp_path, name):
    path = copied(pointed, tmp_path)
    given = getattr(experiments.read(path).trials[2], name) + 0.0002
    edit(path, "pointing", {name: given}, only=2)
    (remark,) = experiments.read(path).remarks
    assert f"For pointing trial 3, the file says that the {name} is {1e3 * given:.2f} mm" in remark


def test_grading_names_an_edited_trial(pointed, tmp_path):
    lessons = library().lessons
    path = copied(pointed, tmp_path)
    edit(path, "pointing", {"seconds": 0.4}, only=4)
    hand_in(path, lessons["virtual_spring"], "Ada", {})
    (row,) = [row for row in grade_file(path, lessons) if row.state == "edited"]
    assert row.reason.startswith("For pointing trial 5, the file says 0.400 s")


def test_a_damaged_trial_gives_one_line(pointed, tmp_path, capsys):
    path = copied(pointed, tmp_path)
    edit(path, "pointing", {"width": "<script>"})
    assert main(["experiment", "pointing", str(path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_session_without_an_experiment_is_reported(pointed, tmp_path, capsys):
    path = tmp_path / "ada.hapkit"
    experiments.save_comparisons(path, Observer(), seed=0)
    assert main(["experiment", "pointing", str(path)]) == 2
    assert "no pointing trials" in capsys.readouterr().err
    with pytest.raises(SessionError, match="no just-noticeable difference"):
        experiments.own_threshold(pointed[0])


def test_the_command_saves_a_virtual_subjects_session_and_recovers_the_result(tmp_path, capsys):
    path = tmp_path / "new.hapkit"
    assert main(["experiment", "pointing", str(path), "--virtual", "--seed", "2", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [line["condition"] for line in found["conditions"]] == ["none", "low", "high"]
    assert len(found["trials"]) == 108
    for line in found["conditions"]:
        for name, true in (("intercept", Subject().intercept), ("slope", Subject().slope)):
            assert abs(line[name]["value"] - true) < 2.0 * line[name]["half"]
    # existing files are never overwritten
    assert main(["experiment", "pointing", str(path), "--virtual"]) == 2
    assert "exists already" in capsys.readouterr().err


def test_the_command_recovers_a_virtual_observers_threshold_and_draws_it(tmp_path, capsys):
    path, plot = tmp_path / "new.hapkit", tmp_path / "new.png"
    assert main(["experiment", "threshold", str(path), "--virtual", "--plot", str(plot)]) == 0
    output = capsys.readouterr().out
    assert "Weber fraction" in output
    assert "True Weber fraction: 11.6 %" in output
    assert plot.stat().st_size > 10_000
    assert experiments.own_threshold(path).weber.holds(Observer().threshold)


def test_a_scenes_needs_use_a_persons_own_threshold(tmp_path, monkeypatch, capsys):
    """The relative threshold of the force comes from the session, not from the literature."""
    path, given = tmp_path / "new.hapkit", []
    experiments.save_comparisons(path, Observer(), seed=0)
    from hapkit_studio.analysis import accuracy

    def compute(_environment, _progress=None, force_share=0.06):
        given.append(force_share)
        raise SessionError("enough")

    monkeypatch.setattr(accuracy.needs, "compute", compute)
    main(["accuracy", "spring", "--needs", "--thresholds", str(path)])
    main(["accuracy", "spring", "--needs"])
    assert given == [experiments.own_threshold(path).weber.value, 0.06]
    assert main(["accuracy", "spring", "--thresholds", str(path)]) == 2
    assert "--needs" in capsys.readouterr().err
