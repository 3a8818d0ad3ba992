"""In a scrolling column, a changed text has its new height from the first painted frame on."""

from hapkit_studio.gui.widgets.parts import AnswerLines, ScrollColumn, label, lay_out


def test_longer_texts_have_their_height_at_once(qtbot):
    column, line, answers = ScrollColumn(), label("One line"), AnswerLines()
    qtbot.addWidget(column)
    column.add(line, answers)
    column.resize(240, 300)
    column.show()
    answers.show_text(("Stable", "check", "ok"))
    lay_out(column)
    short = column.body.height()
    long = "A sentence of many words that needs several lines in a narrow column. " * 8
    line.setText(long)
    answers.show_text((long, "check", "ok"), (long, "check", "ok"))
    lay_out(column)
    assert column.body.height() > max(short, column.height())
    for part in (line, answers):
        assert part.height() >= part.heightForWidth(part.width())
