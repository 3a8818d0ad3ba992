"""An environment's texts are never interpreted as HTML: no image is loaded, no link created."""

from dataclasses import replace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import Qt as Rich
from PySide6.QtWidgets import QLabel, QWidget

from hapkit_studio import environments
from hapkit_studio.environments.base import Environment
from hapkit_studio.gui.shell.export_dialog import ExportDialog
from hapkit_studio.gui.widgets.dialogs import text_dialog
from hapkit_studio.gui.widgets.parts import label
from hapkit_studio.gui.widgets.text import plain_tip, rich, tip
from hapkit_studio.parameters import Choice, Parameter
from hapkit_studio.workshop import reading
from hapkit_studio.workshop.source import typed
from hapkit_studio.workshop.trying import failed
from tests.gui.own_support import put, spring

IMAGE = "<img src='evil.png'>"


def evil(path) -> Environment:
    """Return an environment with an image tag in every text."""
    made = reading.load(path)
    texts = {
        name: f"{name} {IMAGE}"
        for name in ("title", "summary", "formula", "symbols", "explanation", "drives")
    }
    parameters = (
        Parameter("stiffness", f"K {IMAGE}", f"N {IMAGE}", 1.0, 0.0, 5.0, f"help {IMAGE}", f"k {IMAGE}"),
        Parameter("other", f"L {IMAGE}", f"m {IMAGE}", 1.0, 0.0, 5.0, f"help {IMAGE}"),
        Choice("few", f"Few {IMAGE}", (IMAGE,), help=f"help {IMAGE}"),
        Choice("many", f"Many {IMAGE}", ("a", "b", "c", IMAGE), help=f"help {IMAGE}"),
    )
    functions = {
        "warnings": lambda values, conditions: (f"careful {IMAGE}",),
        "unused": lambda values: {"other": f"not used {IMAGE}", "many": f"not used {IMAGE}"},
    }
    return replace(made, **texts, **functions, parameters=parameters)


def is_html(text: str, form: Qt.TextFormat = Qt.TextFormat.AutoText) -> bool:
    """Return True if Qt interprets a text in a label or tooltip as HTML."""
    auto = form == Qt.TextFormat.AutoText and Rich.mightBeRichText(text)
    return auto or form in (Qt.TextFormat.RichText, Qt.TextFormat.MarkdownText)


def with_image(parent: QWidget) -> list[str]:
    """Return the texts of all widgets that Qt interprets as HTML with an image."""
    widgets = [parent, *parent.findChildren(QWidget)]
    found = [
        label.text()
        for label in widgets
        if isinstance(label, QLabel)
        if is_html(label.text(), label.textFormat())
    ]
    found += [widget.toolTip() for widget in widgets if is_html(widget.toolTip())]
    return [text for text in found if "<img" in text]


@pytest.mark.slow
def test_no_text_of_an_environment_is_interpreted_as_html_in_the_window(home, window, qtbot):
    path = put(home, "mine.py", spring(title=IMAGE).replace("For a test", IMAGE))
    window.own.refresh()
    window.studio.adopt(evil(path))
    for place in range(window.header.tabs.count()):
        window.header.tabs.setCurrentIndex(place)
        assert not with_image(window)
    shown = [label.text() for label in window.findChildren(QLabel)]
    assert sum("evil.png" in text for text in shown) > 8
    assert any("evil.png" in widget.toolTip() for widget in window.findChildren(QWidget))
    # use every part of the window that evaluates, describes or exports the environment
    path = put(home, "mine.py", spring())
    window.editor.edit(path)
    window.own.judged.emit(path, failed(f"wrong {IMAGE}", 3))
    assert IMAGE in window.editor.message.label.text()
    window.editor.editor.source.show_source(typed(path.with_name(f"{IMAGE}.py"), spring()))
    window.studio.adopt(evil(path))
    sheets = [text_dialog(IMAGE, [IMAGE], window), ExportDialog(window.studio, window)]
    for shown in (window, *sheets):
        assert not with_image(shown)


@pytest.mark.parametrize(
    ("text", "html"),
    [
        ("<i>F</i> = <b>k</b> x<sub>n</sub><sup>2</sup>&nbsp;N", None),
        (IMAGE, "&lt;img src='evil.png'&gt;"),
        ("<i onclick=x>F</i>", "&lt;i onclick=x&gt;F</i>"),
        ("<a href='x'>F</a>", "&lt;a href='x'&gt;F&lt;/a&gt;"),
        ("<I>F", "&lt;I&gt;F"),
        ("a < b & c", "a &lt; b &amp; c"),
        ("&lt;img&gt;", "&amp;lt;img&amp;gt;"),
    ],
)
def test_only_italic_bold_and_indices_are_allowed(text, html):
    assert rich(text) == (text if html is None else html)
    assert tip((), text) == f"<p>{text if html is None else html}</p>"


def test_a_tooltip_is_changed_only_if_qt_would_interpret_it_as_html():
    assert plain_tip("k < 3\nm") == "k < 3\nm"
    found = plain_tip(f"k {IMAGE}").replace("\xa0", " ")
    assert found == "<p>k &lt;img src='evil.png'&gt;</p>"


def test_formulas_of_the_library_need_no_other_tag():
    for made in environments.discover().values():
        for text in (made.formula, made.symbols, made.explanation):
            assert rich(text) == text


def test_no_line_breaks_between_a_number_and_its_unit_and_the_joiner_is_invisible(qtbot):
    made = label("Limit 1,002 N/m")
    qtbot.addWidget(made)
    seen, wide = QLabel.text(made), made.fontMetrics().horizontalAdvance
    assert (made.text(), seen) == ("Limit 1,002 N/m", "Limit 1,002\u00a0N/\u2060m")
    assert wide(seen) == wide(made.text())
