"""Trust depends on a file's bytes, not on its name, so any change needs new consent."""

from pathlib import Path

from hapkit_studio.workshop.source import is_trusted, trust_source, typed

TEXT = "import os\nprint('−')\n"


def of(text, name="mine.py"):
    return typed(Path(name), text)


def test_any_other_text_is_untrusted():
    trust_source(of(TEXT))
    for other in (TEXT + " ", TEXT[1:], TEXT.replace("−", "-"), "", TEXT.replace("\n", "\n\n")):
        assert not is_trusted(of(other))


def test_the_same_bytes_are_trusted_in_any_folder():
    trust_source(of(TEXT))
    assert is_trusted(of(TEXT, "other.py"))


def test_an_unreadable_list_trusts_no_file(tmp_path):
    trust_source(of(TEXT))
    (file,) = (tmp_path / "data").rglob("trusted")
    file.write_bytes(b"\xff\xfe\x00")
    assert not is_trusted(of(TEXT))
