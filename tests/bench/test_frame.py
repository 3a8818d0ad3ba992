"""The frame of the benchmarks: found, ordered, printed, written."""

import json

from tests.bench import cyclictest, frame


def test_every_file_is_found_in_its_order():
    names = list(frame.discover())
    assert names[:2] == ["lateness", "tick"]
    assert len(names) == len(set(names)) >= 6


def test_table_and_file_hold_the_rows(tmp_path, capsys):
    rows = [
        frame.Row("tick", 41.234, "ns", "MuJoCo", 2345.6, 56.9, "≥ 25 × faster", True),
        frame.Row("start", 2.5, "s", target="< 2 s", ok=False),
    ]
    frame.print_table(rows)
    lines = capsys.readouterr().out.splitlines()
    assert lines[2] == "| tick | 41.2 ns | MuJoCo: 2,350 ns | 56.9 | ≥ 25 × faster | yes |"
    assert lines[3] == "| start | 2.5 s |  |  | < 2 s | NO |"
    written = json.loads(frame.save(rows, tmp_path / "new").read_text())
    assert written["rows"][1]["ok"] is False
    assert written["machine"]["cores"] >= 1


def test_percentile_of_a_printed_histogram():
    lines = [
        "# /dev/cpu_dma_latency set to 0us",
        "# Histogram",
        "000010 000900",
        "000020 000099",
        "000500 000001",
    ]
    text = "\n".join([*lines, "# Total: 000001000", "# Max Latencies: 00500"])
    assert cyclictest.percentile(text, 0.5) == 11.0
    assert cyclictest.percentile(text, 0.999) == 21.0
    assert cyclictest.percentile(text, 1.0) == 501.0
    assert cyclictest.percentile("", 0.5) is None
