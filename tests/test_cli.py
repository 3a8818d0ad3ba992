"""The command line prints text for people, JSON for programs, and one-line errors."""

import json
import os
import shlex
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from hapkit_studio import __version__, commands, environments, resources
from hapkit_studio.cli import main
from hapkit_studio.commands import live_run
from hapkit_studio.devices import DeviceEntry, flash
from hapkit_studio.devices.delays import MeasuredDelay
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.virtual_board import built
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import arrays, rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.haptics.health import Fault, LinkCounts
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import Origin
from tests.devices.fake_board import KIT, FakeKit
from tests.lateness import ATTEMPTS


def run(capsys, *args):
    """Return (exit code, stdout, stderr) of a command."""
    try:
        code = main(args)
    except SystemExit as end:
        code = end.code
    out, err = capsys.readouterr()
    return code, out, err


def as_json(capsys, *args):
    """Return the JSON object that a command prints; fail if it is not one line of standard JSON."""
    code, out, err = run(capsys, *args, "--json")
    assert (code, err) == (0, "")
    assert out.count("\n") == 1
    return json.loads(out, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))


# --- run


def test_run_reports_as_text_and_json(capsys):
    args = "run wall -p stiffness=400 -p damping=2 -p side=left -p damping_mode=both --hand stroke"
    args = f"{args} --seconds 1 --rate 2000 --delay 0.0005 --estimator iir:cutoff=20 --seed 7".split()
    code, out, err = run(capsys, *args)
    assert (code, err) == (0, "")
    assert "wall: 2,000 samples, 1 s" in out
    assert all(unit in out for unit in (" mm", " N", " mJ"))
    found = as_json(capsys, *args)
    assert found["environment"] == "wall"
    given = {"stiffness": 400.0, "damping": 2.0, "position": 0.005, "side": "left", "damping_mode": "both"}
    assert found["parameters"] == given
    assert found["units"] == {"stiffness": "N/m", "damping": "N·s/m", "position": "m"}
    assert (found["hand"], found["seed"], found["estimator"]) == ("stroke", 7, ["iir", {"cutoff": 20.0}])
    assert (found["rate_Hz"], found["delay_s"]) == (2000.0, 0.0005)
    assert (found["samples"], found["seconds"]) == (2000, 1.0)
    assert -0.04 < found["position_min"] <= 0.0 < 0.005 < found["position_max"] < 0.04
    assert 0.5 < found["peak_force"] <= 3.0
    assert found["faults"] == found["written"] == []


@pytest.mark.slow
def test_an_unreadable_environment_file_is_named_once(capsys, tmp_path):
    os.mkfifo(tmp_path / "pipe.py")
    (tmp_path / "large.py").write_bytes(b"#" * 1_000_001)
    for name in ("pipe.py", "large.py", "missing.py"):
        assert main(["run", str(tmp_path / name), "--trust"]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.count(name) == 1


def test_a_run_agrees_with_the_file_it_writes(capsys, tmp_path):
    csv, picture = tmp_path / "a run.csv", tmp_path / "run.png"
    found = as_json(capsys, "run", "spring", "--hand", "press", "--csv", str(csv), "--plot", str(picture))
    assert found["written"] == [str(csv), str(picture)]
    assert picture.read_bytes().startswith(b"\x89PNG")
    names, *rows = [x for x in csv.read_text(encoding="utf-8").splitlines() if not x.startswith("#")]
    table = dict(zip(names.split(","), np.loadtxt(rows, delimiter=",").T, strict=True))
    assert found["position_max"] == pytest.approx(table["position_m"].max())
    assert found["final_force"] == pytest.approx(table["force_applied_N"][-1])
    assert found["energy_given"] == pytest.approx(table["energy_J"][-1])


# --- sketches


def test_export_writes_a_folder_that_the_ide_opens(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "wall", "-p", "stiffness=400", "-o", "mine.ino", "--rate", "500"]) == 0
    text = (tmp_path / "mine" / "mine.ino").read_text("utf-8")
    assert "stiffness = 400.0f" in text
    assert "kRate = 500" in text
    assert "wrote mine/mine.ino" in capsys.readouterr().out
    assert main(["export", "wall", "-o", "mine"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert main(["export", "wall", "-o", "mine", "--force"]) == 0
    assert main(["export", "spring"]) == 0
    assert (tmp_path / "spring" / "spring.ino").is_file()


@pytest.mark.slow
def test_export_names_the_line_of_a_drifting_clock(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = resources.path("templates", "spring.py").read_text("utf-8")
    for old, new in (("return -", "s.t += dt\n    return -s.t * "), ("@law\n", '@law(state={"t": 0.0})\n')):
        text = text.replace(old, new)
    Path("clock.py").write_text(text, "utf-8")
    line = text.splitlines().index("    s.t += dt") + 1
    assert main(["export", "clock.py", "--trust", "-o", "mine"]) == 0
    output = capsys.readouterr().out
    assert f"\nLine {line}: `s.t` becomes inaccurate on the board and in a sketch" in output
    assert "// `s.t` becomes inaccurate" in (tmp_path / "mine" / "mine.ino").read_text("utf-8")
    assert main(["export", "clock.py", "--force", "--json", "-o", "mine"]) == 0
    assert [r["line"] for r in json.loads(capsys.readouterr().out)["remarks"]] == [line]


@pytest.mark.skipif(os.name != "posix", reason="pseudo-terminals")
@pytest.mark.parametrize(("origin", "known"), [(Origin.STORED, True), (Origin.DEFAULT, False)])
def test_export_uses_the_kit_of_a_connected_board(origin, known, tmp_path, monkeypatch, fake_board):
    monkeypatch.chdir(tmp_path)
    kit = FakeKit(replace(KIT, handle_radius=0.0875, zero=377, direction=-1))
    kit.origin = origin
    assert main(["export", "spring", "--port", fake_board(kit).path]) == 0
    text = (tmp_path / "spring" / "spring.ino").read_text("utf-8")
    assert "kHandleRadius = 0.0875f" in text
    assert "kHighIsRight = false" in text
    assert ("kZero = 377" in text) is known
    assert ("fake kit, as calibrated" in text) is known


# --- lists


def test_environments_are_listed_as_json(capsys):
    found = as_json(capsys, "environments")["environments"]
    assert [e["key"] for e in found] == list(environments.discover())
    wall = next(e for e in found if e["key"] == "wall")
    assert wall["title"] == "Wall"
    stiffness, side = wall["parameters"][0], wall["parameters"][3]
    assert (stiffness["unit"], stiffness["range"], stiffness["default"]) == ("N/m", [0.0, 5000.0], 250.0)
    assert (side["key"], side["range"], side["default"]) == ("side", ["right", "left"], "right")


def test_devices_are_listed(capsys):
    found = as_json(capsys, "devices")["devices"]
    assert found[0] == {"key": "simulated", "title": "Simulated Hapkit"}
    _, out, _ = run(capsys, "devices")
    assert [line.split()[0] for line in out.splitlines()] == [d["key"] for d in found]


# --- loop-test


def test_loop_test_measures_the_loop(capsys):
    found = as_json(capsys, "loop-test", "--seconds", "0.4", "--rate", "500")
    assert set(found["lateness_us"]) == {"p50", "p99", "p99.9", "max"}
    late = [found["lateness_us"][name] for name in ("p50", "p99", "p99.9", "max")]
    assert late == sorted(late)
    assert set(found["period_us"]) == {"mean", "min", "max"}
    # on a busy machine the loop misses ticks, and the mean period includes their time
    ticks = found["samples"] + found["missed"]
    assert 1600.0 < found["period_us"]["mean"] < 1.2 * 2000.0 * ticks / found["samples"]
    assert found["priority"]
    assert (found["rate_Hz"], found["device"], found["fault"]) == (500.0, "simulated", "")
    assert found["lost_rows"] == 0
    assert found["delay_us"] == 0.0  # the loop has no added delay


def test_loop_test_reports_that_no_delay_was_measured(capsys, monkeypatch):
    def run_without_answers(*given):
        played = live_run_of(*given)
        return replace(played, health=replace(played.health, delay=None))

    live_run_of = live_run.run
    monkeypatch.setattr(live_run, "run", run_without_answers)
    assert as_json(capsys, "loop-test", "--seconds", "0.1", "--rate", "500")["delay_us"] is None
    _, out, _ = run(capsys, "loop-test", "--seconds", "0.1", "--rate", "500")
    assert "delay not measured" in out


# --- one-line errors

WRONG = [
    ("--bogus", "unrecognized arguments: --bogus"),
    ("--size 10", "a size has the form 1280x720, not '10'"),
    ("run wal", "There is no environment 'wal'; available: free, spring, wall"),
    ("run", "environment"),
    ("run wall -p stiffness=6000", "Stiffness must be between 0 and 5,000 N/m, not 6,000."),
    ("run wall -p stiffness=1e999", "not inf."),
    ("run wall -p side=7", "Side must be one of right, left, not 7.0."),
    ("run wall -p stiffness", "A parameter has the form KEY=VALUE, e.g. stiffness=400, not 'stiffness'."),
    ("run wall -p stiffness=", "KEY=VALUE"),
    ("run wall --rate fast", "invalid float value: 'fast'"),
    ("run wall --delay -1", "The delay must be between 0 and 10 s, not −1."),
    ("run wall --delay -1e-9", "The delay must be between 0 and 10 s, not −10⁻⁹."),
    ("run wall --seconds 86400 --rate 1e6", "A run has 1 to 10,000,000 samples"),
    ("run wall --estimator iir:cutoff=low", "The estimator's cutoff must be a number, not 'low'."),
    ("run wall --estimator iir:", "An option has the form KEY=VALUE, e.g. cutoff=20, not ''."),
    ("run wall --estimator difference:cutoff=5", "has no parameter 'cutoff'"),
    ("run wall --csv /no-such-folder/run.csv", "--csv: there is no folder /no-such-folder."),
    ("run wall --csv .", "--csv takes the path of a file, not '.'"),
    ("run wall --plot run.xyz", "The name of a picture must end in one of"),
    ("loop-test unplugged", "There is no device 'unplugged'. Available devices: simulated"),
    ("loop-test --rate 20", "Servo rate must be between 100 and 10,000 Hz, not 20."),
    ("loop-test --seconds 0", "Seconds must be between 0.1 and 86,400 s, not 0."),
    ("dance", "invalid choice: 'dance'"),
    # commands with and without a board
    ("run wall --render board", "--device"),
    ("run wall --board-rate 4000", "--device"),
    ("run wall --device simulated --render board", "has no board"),
    ("run wall --device simulated --board-rate 500", "--render board"),
    ("loop-test --render board", "has no board"),
    ("run wall --device nothing", "There is no device"),
    ("flash simulated", "needs no flashing. Name a port"),
    ("check /dev/ttyNONE7", "ttyNONE7 does not exist. Plug the board in"),
    ("export wall --port /dev/ttyNONE7", "ttyNONE7 does not exist. Plug the board in"),
    # the wrong folder is reported before the run
    ("run wall --device simulated --csv /no-such-folder/x.csv", "there is no folder"),
    ("run wall --device simulated --csv .", "the path of a file"),
    ("run wall --device simulated --plot x.xyz", "The name of a picture must end in one of"),
    # a script with an unset variable must not flash the only board, or run without one
    ("run wall --device ''", "There is no device ''"),
    ("check ''", ""),
    ("flash ''", ""),
    ("export wall --port ''", ""),
    ("flash /dev/ttyNONE7 --hex ''", ""),
    ("run wall --csv ''", "the path of a file"),
    # errors of sketches
    ("export wall -p stiffness=-1", "N/m"),
    ("export wal", "wal"),
    ("export wall --kit hapkit9", "There is no kit 'hapkit9'. Available kits: hapkit3"),
    ("export wall --rate 3000", "not 3,000 Hz"),
    ("export wall --estimator butterworth", "not butterworth"),
    ("run sketch.ino", "sketch.ino is an Arduino sketch: upload it with the Arduino IDE."),
    ("export mine/wall.ino", "its Python file, as wall.py."),
    ("run wall.cpp", "wall.cpp is an Arduino sketch"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("command", "says"), WRONG, ids=[command for command, _ in WRONG])
def test_invalid_input_gives_a_one_line_error(capsys, tmp_path, monkeypatch, command, says):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(live_run, "play", lambda *_: pytest.fail("its start"))
    if "--csv" in command or "--plot" in command:
        monkeypatch.setattr(Engine, "start", lambda engine: pytest.fail("the device was opened"))
    code, out, err = run(capsys, *shlex.split(command))
    assert code == 2
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("hapkit-studio")
    assert says in err
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_ends_without_a_traceback(capsys, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("hapkit_studio.api.simulate", interrupted)
    assert run(capsys, "run", "wall") == (130, "", "")


# --- live runs and boards


class Gone:
    """An engine whose fault becomes final after three reads."""

    def __init__(self, reason):
        self.looks, self.reason = 0, reason

    @property
    def fault(self):
        self.looks += 1
        return self.reason if self.looks > 3 else None

    def read(self):
        return np.zeros((2, 3))


@pytest.mark.parametrize(
    ("code", "remedy"),
    [
        (arrays.DEVICE_GONE, "Check the USB cable, then try again."),
        (arrays.SLOW_LINK, "Let the board render (--render board), or use a faster port."),
        (arrays.SLOW_LAW, "Simplify the law or lower the servo rate."),
    ],
)
def test_a_final_fault_ends_a_run_and_keeps_its_rows(code, remedy):
    engine = Gone(Fault(code, "It is so."))
    table, played = live_run.play(engine, engine, None, 20.0)
    assert len(table) == 2 * (3 + 1)
    assert played < 20.0
    assert live_run.fault_text(engine.fault) == f"It is so. Force is zero. {remedy}"


def engine_on_bad_link():
    """Return an engine whose spring is too stiff for the link's delay of 5 ms."""
    counts = LinkCounts(1, 2, 3, 4, no_sample=5, away=6, law_blocked=7, cut=8, clock_jumps=9)
    return SimpleNamespace(
        where="computer",
        fault=None,
        device=SimpleNamespace(measures_delay=True, has_board=True, mass=0.044, viscous=0.5, quantum=2e-5),
        loop_of=lambda where, delay, hand="released": LoopSettings(
            1000.0 if where == "computer" else 2000.0, delay, hand=hand
        ),
        environment=environments.discover()["spring"],
        values={"stiffness": 300.0, "damping": 0.0, "center": 0.0},
        max_force=3.0,
        missed_of=lambda where: 0,
        delay_of=lambda where: MeasuredDelay(5e-3, 1e-4, 100),
        health=lambda: SimpleNamespace(link=counts),
    )


TOO_STIFF = "Lower the stiffness, or let the board compute the force."


def test_link_problems_are_in_the_result(capsys, monkeypatch):
    engine, table = engine_on_bad_link(), np.zeros((1000, rows.ROW_WIDTH))
    table[:, rows.BOARD_TIME], table[:, rows.PERIOD] = 1e-3 * np.arange(1000), 1e-3
    table[:250, rows.FLAGS], table[250:300, rows.FLAGS] = rows.STALE, rows.FAULT
    found = live_run._figures(engine, table)
    slower, stiff, jumps, without = remarks = live_run._remarks(engine, found, 4000.0)
    assert slower == "The board renders at 2,000 Hz, not at 4,000 Hz: this law takes too long for more."
    assert stiff.endswith(TOO_STIFF)
    assert jumps == "The board's clock went back or jumped 9 times: time was corrected."
    assert without == (
        "No force for 0.30 s. No sample arrived over USB for 20 ms: 5 times. This computer was busy "
        "with other programs for 20 ms: 6 times. The law blocked the loop for 20 ms: 7 times. The board "
        "switched its motor off, because forces came too late or not at all: 8 times."
    )
    # the fault already says that the link is slow, so the remarks do not repeat it
    engine.fault = Fault(arrays.SLOW_LINK, "Slow.")
    assert live_run._remarks(engine, found, 2000.0) == [jumps, without]
    played = live_run.Played(table, 1.0, found, remarks, None, None, 0)
    monkeypatch.setattr(live_run, "run", lambda *_: played)
    shown = as_json(capsys, "run", "spring", "--device", "simulated", "--seconds", "1")
    assert shown["warnings"] == remarks
    assert shown["link"]["without_force_s"] == pytest.approx(0.3)
    off = {"no_sample": 5, "computer_busy": 6, "law_too_long": 7, "board_watchdog": 8}
    assert shown["link"]["motor_off"] == off
    assert shown["link"]["clock_jumps"] == 9


def test_a_spring_too_stiff_for_the_link_is_reported_once_during_the_run(capsys):
    engine = engine_on_bad_link()
    few, enough = MeasuredDelay(5e-3, 1e-4, 99), engine.delay_of("computer")
    watch = live_run.print_link_warning(engine)
    for delay, now, lines in ((few, 0.1, 0), (enough, 0.2, 1), (enough, 0.3, 0)):
        engine.delay_of = lambda where, delay=delay: delay
        watch(now)
        out, err = capsys.readouterr()
        assert (out, err.count(f"{TOO_STIFF}\n")) == ("", lines)
    engine.fault = Fault(arrays.SLOW_LINK, "Slow.")
    live_run.print_link_warning(engine)(1.0)
    assert capsys.readouterr() == ("", "")


def test_an_interrupted_run_keeps_its_rows(capsys, tmp_path, monkeypatch):
    move, moves = Engine.move_hand, []

    def then_end(engine, target):
        moves.append(target)
        if len(moves) == 30:
            raise KeyboardInterrupt
        move(engine, target)

    monkeypatch.setattr(Engine, "move_hand", then_end)
    args = ("--device", "simulated", "--hand", "press", "--seconds", "600", "--csv", str(tmp_path / "x.csv"))
    code, out, err = run(capsys, "run", "wall", *args)
    assert (code, err) == (130, "")
    assert "s of 600 s by Ctrl+C." in out
    assert len((tmp_path / "x.csv").read_text().splitlines()) > 100
    assert moves[-1] is None


def test_an_interrupted_flash_states_the_remedy(capsys, monkeypatch):
    def ended(*_words):
        raise KeyboardInterrupt

    monkeypatch.setattr(flash, "flash", ended)
    code, _, err = run(capsys, "flash", "/dev/ttyUSB7")
    assert code == 130
    assert "ttyUSB7: interrupted. The firmware on the board may be incomplete: flash it again" in err


def test_a_silent_board_is_reported_with_the_next_step(capsys, monkeypatch, fake_board):
    monkeypatch.setattr(live_run, "_PATIENCE", 0.2)
    args = ("--device", fake_board(FakeKit()).path, "--seconds", "1")
    code, out, err = run(capsys, "run", "wall", *args)
    assert (code, out) == (2, "")
    assert "identified itself, but sent no sample for 0.2 s. Press the board's reset button" in err


def test_old_firmware_names_the_command_that_updates_it(capsys, fake_board):
    old = encode(replace(FakeKit().hello(), version=1))
    board = fake_board(lambda message: old)
    entry = DeviceEntry(board.path, "", partial(HapkitBoard, board.path))
    for text in (run(capsys, "check", board.path)[2], entry.make().probe()["text"]):
        assert f"Update the firmware. Run `hapkit-studio flash {board.path}`." in text


def test_a_fault_ends_a_run_with_its_own_exit_code(capsys, monkeypatch):
    args = ("run", "wall", "--device", "simulated", "--seconds", "0.2")
    assert run(capsys, *args)[0] == 0
    fault = Fault(arrays.OVER_SPEED, "Fault: the handle moved too fast, 5.2 m/s (limit 5.0 m/s).")
    monkeypatch.setattr(Engine, "fault", property(lambda engine: fault if engine.heard else None))
    monkeypatch.setattr(Engine, "heard", False, raising=False)
    play = live_run.play

    def then_fault(engine, *given):
        engine.heard = True
        return play(engine, *given)

    monkeypatch.setattr(live_run, "play", then_fault)
    code, out, err = run(capsys, *args)
    assert (code, err) == (2, "")
    assert fault.text in out


@pytest.mark.alone
@pytest.mark.skipif(not built(), reason="the virtual board is not built")
def test_the_board_renders_with_less_delay(capsys):
    for _ in range(ATTEMPTS):
        code, out, err = run(
            capsys, "run", "wall", "--device", "virtual-board", "--render", "board", "--hand", "press",
            "--seconds", "1", "--estimator", "kalman", "--json",
        )  # fmt: skip
        found = json.loads(out)
        if not found["faults"]:
            break
    assert (code, err) == (0, "")
    assert found["render"] == "board"
    assert found["board"]["delay_us"] < 0.5 * found["computer"]["delay_us"]
    assert found["board"]["rate_Hz"] == 4000.0
    assert found["board"]["stiffness_limit"] > 2.0 * found["computer"]["stiffness_limit"]
    # of 4,000 ticks, a few may overrun, because a busy computer sends its bytes in bursts
    assert found["board_overruns"] <= 4
    assert found["link"]["stale_forces"] == 0


# --- the program itself


def program(tmp_path, *args, **changes):
    environment = {
        k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
    }
    return subprocess.run(
        [sys.executable, "-m", "hapkit_studio", *args],
        capture_output=True,
        text=True,
        timeout=120,
        cwd=tmp_path,
        env={**environment, **changes},
        check=False,
    )


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems always have a display")
def test_without_a_display_runs_the_demo_and_writes_a_picture(tmp_path):
    done = program(tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("There is no display")
    assert "wall: 3,000 samples" in done.stdout
    assert "wrote hapkit-studio-demo.png" in done.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["hapkit-studio-demo.png"]
    assert (tmp_path / "hapkit-studio-demo.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_program_gives_the_exit_code_and_no_traceback(tmp_path):
    done = program(tmp_path, "run", "wal")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr


def test_help_and_version_are_printed(capsys):
    code, out, _ = run(capsys, "--version")
    assert (code, out.strip()) == (0, __version__)
    code, out, _ = run(capsys, "--help")
    assert (code, out.splitlines()[0]) == (0, "usage: hapkit-studio [-h] [--version] COMMAND ...")


@pytest.mark.parametrize("name", commands.discover())
def test_the_help_lists_and_describes_every_command(name, capsys):
    command = commands.discover()[name]
    also = f" ({', '.join(command.aliases)})" if command.aliases else ""
    assert f" {name}{also} {command.help} " in " ".join(run(capsys, "--help")[1].split())
    code, out, err = run(capsys, name, "--help")
    assert (code, err) == (0, "")
    assert out.startswith(f"usage: hapkit-studio {name} ")
    assert "--json" in out


@pytest.mark.slow
def test_a_limited_console_encoding_gets_question_marks(tmp_path):
    done = program(tmp_path, "environments", PYTHONIOENCODING="ascii")
    assert (done.returncode, done.stderr) == (0, "")
    assert "N?s/m" in done.stdout
