"""Trust is in a text, not in a file's name: one letter more is another text."""

from hapkit_studio.workshop import trust

TEXT = "import os\nprint('−')\n"


def test_a_text_is_trusted_once_it_was_agreed_to():
    assert not trust.is_trusted(TEXT)
    trust.trust(TEXT)
    assert trust.is_trusted(TEXT)


def test_any_other_text_is_not():
    trust.trust(TEXT)
    for other in (TEXT + " ", TEXT[1:], TEXT.replace("−", "-"), "", TEXT.replace("\n", "\n\n")):
        assert not trust.is_trusted(other)


def test_how_lines_end_is_no_difference():
    trust.trust(TEXT.replace("\n", "\r\n"))
    assert trust.is_trusted(TEXT)
    assert trust.is_trusted("\ufeff" + TEXT)


def test_many_are_remembered_and_none_twice(tmp_path):
    for n in range(5):
        trust.trust(f"x = {n}")
        trust.trust(f"x = {n}")
    assert all(trust.is_trusted(f"x = {n}") for n in range(5))
    assert [len(f.read_text(encoding="ascii").split()) for f in (tmp_path / "data").rglob("trusted")] == [5]


def test_a_list_that_cannot_be_read_trusts_nobody(tmp_path):
    trust.trust(TEXT)
    (file,) = (tmp_path / "data").rglob("trusted")
    file.write_bytes(b"\xff\xfe\x00")
    assert not trust.is_trusted(TEXT)


def test_nothing_hides_in_a_text_that_is_shown():
    shown = trust.shown("a = 1\x1b[2K\r\u202eb\u200b = 2\nN·s/m −\n")
    assert shown == "a = 1\\x1b[2K\\r\\u202eb\\u200b = 2\nN·s/m −\n"
