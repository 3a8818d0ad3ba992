"""What becomes of changes that are not saved when a law is closed, or the window. It asks beside the work."""

from collections.abc import Callable

from hapkit_studio.gui.editor.code_page import CodePage


class Leaving:
    """Asks in the page's strip; ``save`` and ``leave`` are the desk's."""

    def __init__(self, page: CodePage, save: Callable[[], None], leave: Callable[[], None]):
        self._page, self._save, self._leave = page, save, leave
        self._asked = False

    def close(self) -> None:
        """Close the law, or first ask."""
        if self._page.unsaved:
            self._ask(("Save", lambda: self._after_saving(self._leave)), ("Discard", self.discard))
        else:
            self._leave()

    def may_quit(self, quit_: Callable[[], object]) -> bool:
        """Say whether the window may go; the first time it asks, and quits after the answer."""
        if not self._page.unsaved or self._asked:
            return True
        self._asked = True
        self._ask(("Save and quit", lambda: self._after_saving(quit_)), ("Quit, keep as draft", quit_))
        return False

    def discard(self) -> None:
        """Give up what is not saved, and the law with it."""
        self._page.note_saved()
        self._leave()

    def _ask(self, *buttons: tuple[str, Callable[[], object]]) -> None:
        name = self._page.path.name if self._page.path else ""
        self._page.strip.say(f"{name} is not saved.", "warn", (*buttons, ("Go on", self._go_on)))
        self._page.strip.buttons[0].setFocus()

    def _go_on(self) -> None:
        self._asked = False
        self._page.strip.say("")
        self._page.code.setFocus()

    def _after_saving(self, then: Callable[[], object]) -> None:
        self._save()
        if not self._page.unsaved:
            then()
