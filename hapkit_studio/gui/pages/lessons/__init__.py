"""The view Lessons: its name, and the column that is built when it is first shown."""

from typing import TYPE_CHECKING

from hapkit_studio.gui.pages.base import Page, View

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.state.studio import Studio


def _build(studio: "Studio", live: "Live") -> Page:
    # imported late because reading the lessons takes a while
    from hapkit_studio.gui.pages.lessons.page import LessonsPage

    return LessonsPage(studio, live)


VIEW = View("lessons", "Lessons", 75, _build)
