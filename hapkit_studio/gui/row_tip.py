"""What a parameter's row says under the mouse."""

from collections.abc import Iterable


def tip(sentences: Iterable[str], formula: str) -> str:
    """Return the sentences that are not empty, each with its full stop, and the formula below, as HTML."""
    words = " ".join(sentence.rstrip(".") + "." for sentence in sentences if sentence)
    return "".join(f"<p>{part}</p>" for part in (words, formula) if part)
