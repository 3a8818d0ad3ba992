"""Limits of foreign files are checked before parsing, and values before use; each error is one line."""

import json
import math
import os
import socket
import sys
import time
import tomllib

import pytest

from hapkit_studio import files
from hapkit_studio.errors import FileError

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no FIFO in its file system")


@POSIX
@pytest.mark.parametrize("kind", ["FIFO", "folder", "socket", "device", "missing", "null in path"])
def test_only_regular_files_are_read_and_reading_never_blocks(tmp_path, kind, monkeypatch):
    path = tmp_path / "x"
    if kind == "FIFO":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "socket":
        monkeypatch.chdir(tmp_path)  # a socket's path is at most 108 bytes long, so it is relative
        socket.socket(socket.AF_UNIX).bind("x")
    elif kind == "device":
        path = "/dev/zero"
    elif kind == "null in path":
        path = f"{path}\0y"
    with pytest.raises(FileError) as error:
        files.read_bytes(path)
    assert str(error.value).startswith("Cannot read ")
    assert "\n" not in str(error.value)


def test_a_sparse_file_of_3_gb_is_refused_by_its_size_without_being_read(tmp_path):
    path = tmp_path / "huge.toml"
    with open(path, "wb") as file:
        file.truncate(3 << 30)
    with pytest.raises(FileError, match=r"^huge.toml has 3,221,225,472 bytes; the limit is 65,536 bytes\.$"):
        files.read_bytes(path)


def test_a_file_of_exactly_the_limit_is_read(tmp_path):
    path = tmp_path / "x"
    path.write_bytes(b"1" * 10)
    assert files.read_bytes(path, 10) == b"1" * 10
    with pytest.raises(FileError, match="10 bytes; the limit is 9 bytes"):
        files.read_bytes(path, 9)


def test_text_is_utf_8_with_or_without_byte_order_mark_or_refused_with_the_line(tmp_path):
    path = tmp_path / "x.toml"
    for mark in (b"", b"\xef\xbb\xbf"):
        path.write_bytes(mark + "Zoë".encode())
        assert files.read_text(path) == "Zoë"
    path.write_bytes(b"a\nb\xff")
    with pytest.raises(FileError, match=r"^x\.toml, line 2: not text in UTF-8"):
        files.read_text(path)


SLOW_OR_DEEP = {
    "dotted key": "a" + ".a" * 20_000 + " = 1",
    "dotted key with spaces": "a" + " . a" * 15_000 + " = 1",
    "dotted key with quotes": "'a'" + '."a"' * 15_000 + " = 1",
    "dotted table": "[a" + ".a" * 20_000 + "]",
    "nested arrays": "a = " + "[" * 60_000,
    "nested inline tables": "a = " + "{a = " * 12_000,
    "arrays after strings with brackets": "b = ']' # ]\na = " + "[" * 100 + "]" * 100,
    "whole number in hexadecimal": "a = 0x" + "f" * 60_000,
    "whole number": "a = " + "9" * 60_000,
    "letters": "a" * 60_000,
}


@pytest.mark.parametrize("text", SLOW_OR_DEEP.values(), ids=SLOW_OR_DEEP)
def test_deep_or_long_structures_are_refused_with_their_line_before_parsing(tmp_path, text, monkeypatch):
    path = tmp_path / "x.toml"
    path.write_text(text)
    for parser in (tomllib, json):
        monkeypatch.setattr(parser, "loads", lambda text: pytest.fail("parsed"))
    line = text.count("\n") + 1
    with pytest.raises(FileError, match=rf"^x\.toml, line {line}: .*(deeper than 32|limit is 256)\.$"):
        files.read_toml(path)
    if '"."' not in text:  # quoted words joined by dots are a key in TOML only
        with pytest.raises(FileError, match=r"^values, line \d: .*(deeper than 32|limit is 256)\.$"):
            files.parse_json(text, "values")


def test_a_long_key_of_quoted_words_is_refused(tmp_path):
    path = tmp_path / "x.toml"
    path.write_text(".".join(['"a"'] * 129) + " = 1")
    with pytest.raises(FileError, match="has 257 characters; the limit is 256"):
        files.read_toml(path)


@pytest.mark.parametrize("digits", [256, 257])
def test_a_number_in_json_has_at_most_256_digits(digits):
    text = json.dumps({"a": "b"}).replace('"b"', "9" * digits)
    if digits <= 256:
        assert files.parse_json(text, "x") == {"a": 10**256 - 1}
    else:
        with pytest.raises(FileError, match="has 257 characters; the limit is 256"):
            files.parse_json(text, "x")


QUOTED = {
    "basic": '"' + "[" * 100 + '"',
    "literal": "'" + "[" * 100 + "'",
    "multi-line": '"""\n' + "[\n" * 100 + '\\""" "" a"""',
    "multi-line literal": "'''\n" + "[\n" * 100 + "\\'''",
    "escaped quote": '"\\"' + "[" * 100 + '"',
    "comment": "1 # it's " + "[" * 100 + "\n",
    "long text": '"' + "a.b" * 1000 + '"',
}


@pytest.mark.parametrize("value", QUOTED.values(), ids=QUOTED)
def test_brackets_and_dots_in_strings_and_comments_are_ignored(tmp_path, value):
    path = tmp_path / "x.toml"
    path.write_text(f"a = {value}\nb = 2")
    assert files.read_toml(path) == tomllib.loads(path.read_text())
    assert files.read_toml(path)["b"] == 2


def test_structures_within_the_limits_are_parsed():
    nested = "[" * files.MOST_NESTED + "]" * files.MOST_NESTED
    assert files.parse_json(nested, "x") == json.loads(nested)
    assert files.parse_json(json.dumps({"[" * 99: [']\\"['] * 99}), "x") == {"[" * 99: [']\\"['] * 99}


@pytest.mark.slow
def test_no_text_of_limited_size_takes_long_to_refuse_or_parse(tmp_path):
    path, pieces = (
        tmp_path / "x.toml",
        ['"', "'", '"""', "'''", "\\", "a", " ", ".", "[", "=", "#", "1,", "\n"],
    )
    pieces += [a + b for a in pieces for b in pieces] + [f"a{'.a' * 120} = 1\n", f"[{'a.' * 120}a]\n"]
    for piece in pieces:
        path.write_text((piece * files.MOST_BYTES)[: files.MOST_BYTES])
        begin = time.process_time()
        for read in (files.read_toml, lambda path: files.parse_json(path.read_text(), "x")):
            try:
                read(path)
            except FileError:
                continue
        assert time.process_time() - begin < 2.0, piece


@pytest.mark.parametrize("text", ["", "{", '{"a": 1e5', "[1, ]", "nul"])
def test_invalid_json_gives_a_one_line_error(text):
    with pytest.raises(FileError, match=r"^loop: [^\n]+\.$"):
        files.parse_json(text, "loop")


@pytest.mark.parametrize(
    "value", [True, "1", None, [], {}, math.nan, math.inf, -math.inf, 10**400, -0.1, 255.5]
)
def test_a_number_must_be_finite_and_within_its_limits(value):
    with pytest.raises(FileError, match=r"^x\.toml: mass is .+; it must be a number from 0 to 255 kg\.$"):
        files.checked_number(value, "x.toml: mass", 0, 255, "kg")


@pytest.mark.parametrize("value", [True, 1.0, "1", None, math.nan, -1, 256])
def test_integers_are_validated(value):
    with pytest.raises(FileError, match=r"^x\.toml: pins is .+; it must be a whole number from 0 to 255\.$"):
        files.checked_integer(value, "x.toml: pins", 0, 255)


def test_an_integer_with_more_digits_than_python_prints_is_refused_with_a_message():
    with pytest.raises(FileError, match=r"^pins is a very long number; it must be a whole number from 0 to"):
        files.checked_integer(1 << 20_000, "pins", 0, 255)


@pytest.mark.parametrize("value", [1, None, "a\n", "\x1b[2J", "\u202e", "a" * 13, "\ud800"])
def test_a_text_must_be_printable_and_within_its_length_limit(value):
    with pytest.raises(FileError, match=r"^title is [^\n\x1b]+; it must be a line of at most 12 printable"):
        files.checked_text(value, "title", 12)


def test_values_within_their_limits_are_returned():
    assert files.checked_number(3, "x", 3, 3) == 3.0
    assert files.checked_integer(255, "x", 0, 255) == 255
    assert files.checked_text("Zoë 7", "x", 5) == "Zoë 7"
    assert files.checked_table({"a": 1}, "x") == {"a": 1}
    assert files.checked_list([1, 2], "x") == files.checked_list([1, 2], "x", 2) == [1, 2]
    for value, count in (([], None), ((1,), 1), ([1], 2), ("ab", 2)):
        with pytest.raises(FileError, match=r"^table is .*; it must be a list of"):
            files.checked_list(value, "table", count)
    with pytest.raises(FileError, match=r"^board is \[1\]; it must be a table\.$"):
        files.checked_table([1], "board")
