"""What Tab, Enter and Backspace do to a line of Python: four spaces, and the depth of the line before."""

import re

from PySide6.QtGui import QTextBlock, QTextCursor

STEP = 4
_LEAVES = re.compile(r"\s*(return|break|continue|pass|raise)\b")
_OPENS = re.compile(r".*:\s*(#.*)?$")


def _depth(text: str) -> int:
    return len(text) - len(text.lstrip(" "))


def newline(cursor: QTextCursor) -> None:
    """Break the line; the next one starts as deep, deeper after a colon, less deep after a return."""
    before = cursor.block().text()[: cursor.positionInBlock()]
    depth = _depth(before)
    if _OPENS.match(before):
        depth += STEP
    elif _LEAVES.match(before):
        depth = max(0, depth - STEP)
    cursor.insertText("\n" + " " * depth)


def indent(cursor: QTextCursor) -> None:
    """Move the selected lines one step to the right, or fill up to the next step."""
    if cursor.hasSelection():
        _each_line(cursor, lambda line: _insert(line, STEP))
    else:
        cursor.insertText(" " * (STEP - cursor.positionInBlock() % STEP))


def dedent(cursor: QTextCursor) -> None:
    """Move the selected lines, or the cursor's own, one step to the left."""
    _each_line(cursor, lambda line: _remove(line, min(STEP, _depth(line.block().text()))))


def unstep(cursor: QTextCursor) -> bool:
    """Delete one step left of the cursor if only spaces stand before it; say whether it did."""
    place = cursor.positionInBlock()
    if cursor.hasSelection() or place == 0 or cursor.block().text()[:place].strip(" "):
        return False
    back = (place - 1) % STEP + 1
    cursor.movePosition(QTextCursor.MoveOperation.Left, QTextCursor.MoveMode.KeepAnchor, back)
    cursor.removeSelectedText()
    return True


def home(cursor: QTextCursor, keep: bool) -> None:
    """Go to the line's first word, or from there to its beginning; keep what is selected on the way."""
    depth = _depth(cursor.block().text())
    place = 0 if cursor.positionInBlock() == depth else depth
    mode = QTextCursor.MoveMode.KeepAnchor if keep else QTextCursor.MoveMode.MoveAnchor
    cursor.setPosition(cursor.block().position() + place, mode)


def _each_line(cursor: QTextCursor, change) -> None:
    """Call change with a cursor at the start of every line touched, as one step of undo."""
    document = cursor.document()
    first, last = document.findBlock(cursor.selectionStart()), document.findBlock(cursor.selectionEnd())
    if last != first and cursor.selectionEnd() == last.position():
        last = last.previous()
    numbers = range(first.blockNumber(), last.blockNumber() + 1)
    cursor.beginEditBlock()
    for number in numbers:
        change(_at_start(document.findBlockByNumber(number)))
    cursor.endEditBlock()


def _at_start(block: QTextBlock) -> QTextCursor:
    return QTextCursor(block)


def _insert(line: QTextCursor, count: int) -> None:
    if line.block().text().strip():
        line.insertText(" " * count)


def _remove(line: QTextCursor, count: int) -> None:
    line.movePosition(QTextCursor.MoveOperation.Right, QTextCursor.MoveMode.KeepAnchor, count)
    line.removeSelectedText()
