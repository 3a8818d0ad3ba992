"""Every benchmark has the name of its file, is listed by the program, and its rows are printed."""

import inspect
import sys

import pytest

from tests.bench import __main__, frame

BENCHMARKS = frame.discover()


@pytest.mark.parametrize("name", BENCHMARKS)
def test_it_is_listed_and_described(name, monkeypatch, capsys):
    module = inspect.getmodule(BENCHMARKS[name])
    assert module.__name__ == f"tests.bench.bench_{name}"
    assert module.__doc__
    # the only argument is the folder for its pictures
    assert len(inspect.signature(BENCHMARKS[name]).parameters) <= 1
    monkeypatch.setattr(sys, "argv", ["bench", "--help"])
    with pytest.raises(SystemExit):
        __main__.main()
    assert name in capsys.readouterr().out.replace(",", " ").split()
