"""A new view needs only one file. It gets a tab, a menu entry, and a shortcut if one is left."""

import pytest

from tests.project_copy import copy_with, run_program, run_tests

NEW = '''"""Pulse: how long the handle takes to come back from a push."""

from hapkit_studio.gui.pages.base import Page, SidePanel, View
from hapkit_studio.gui.widgets.parts import hint, label


class PulsePage(Page):
    def __init__(self, studio, live):
        super().__init__()
        self.side = SidePanel("Pulse", "A push, and how long the handle takes to come back.")
        self.time = label("Nothing was measured yet", "headline")
        self.column.addWidget(self.time)
        self.column.addWidget(hint("Push the handle, then release it."))


VIEW = View("pulse", "Pulse", 80, PulsePage, scene=False)
'''
OF_ALL = (
    "tests/gui/pages/test_every_view.py",
    "tests/gui/pages/test_pages.py",
    "tests/gui/shell/test_actions.py",
    "tests/gui/shell/test_command_palette.py",
    "tests/gui/shell/test_layout.py",
    "tests/gui/shell/test_texts.py",
    "tests/lessons/test_parse.py",
)


@pytest.mark.slow
def test_a_new_view_needs_one_file(tmp_path):
    copy = copy_with(tmp_path, "hapkit_studio/gui/pages/pulse.py", NEW)
    output = run_tests(copy, "-m", "not alone", "-k", "pulse or sessions or not slow", *OF_ALL)
    for key in ("sessions", "pulse"):  # the eighth view has the last shortcut, the ninth has none
        assert f"if_one_is_free[{key}] PASSED" in output
    listed = run_program(copy, "-m", "hapkit_studio", "texts").splitlines()
    assert "Pulse view: label | Push the handle, then release it." in listed
