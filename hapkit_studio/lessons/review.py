"""Peer review: points and comments on a classmate's handed-in file are stored in a small separate file.

The handed-in file is never changed. A review contains a hash of the answers that were reviewed, so that a
review of different answers is detected. The author's replies are added to the review's file.
"""

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from hapkit_studio.errors import FileError
from hapkit_studio.files import (
    MOST_BYTES,
    checked_integer,
    checked_number,
    checked_table,
    checked_text,
    parse_json,
    read_text,
    replacing,
)
from hapkit_studio.formatting import number
from hapkit_studio.lessons.hand_in import HandedIn
from hapkit_studio.lessons.lesson import MOST_CRITERIA, Lesson

SUFFIX = ".review"
VERSION = 1
LONGEST = 1_000  # maximum number of characters of a comment
_NAME, _CRITERION = 100, 1_000
MOST_COMMENTS, MOST_REPLIES = 100, 50
MOST_REVIEWS = 100  # maximum number of reviews of a handed-in file
_MOST_FILES = 2_000  # maximum number of files in a folder
_LATEST = 31 * 86_400.0  # s: maximum time of a comment


class ReviewError(FileError):
    """A review cannot be read or written; the text gives the reason in one line."""


@dataclass(frozen=True)
class Row:
    """A criterion with the reviewer's points (None if not given yet) and comment."""

    criterion: str
    most: int
    points: int | None = None
    comment: str = ""


@dataclass(frozen=True)
class Comment:
    """A comment on a time in s since the session's start, on a step (from 1), or on the whole session."""

    text: str
    time: float | None = None
    step: int | None = None

    @property
    def place(self) -> str:
        """Return a text with the comment's time or step; "" for a comment on the whole session."""
        if self.time is not None:
            return f"at {number(self.time, 2)} s"
        return f"step {self.step}" if self.step is not None else ""


@dataclass(frozen=True)
class Review:
    """The review by one reviewer; ``session`` is the file's name, ``answers`` the hash of the answers."""

    session: str
    answers: str
    lesson: str
    reviewer: str
    rows: tuple[Row, ...]
    comments: tuple[Comment, ...] = ()
    replies: tuple[str, ...] = ()

    @property
    def points(self) -> int:
        """Return the sum of the points given."""
        return sum(row.points or 0 for row in self.rows)

    @property
    def most(self) -> int:
        """Return the largest possible sum of points."""
        return sum(row.most for row in self.rows)

    @property
    def complete(self) -> bool:
        """Return whether every row has points."""
        return all(row.points is not None for row in self.rows)


def answers_hash(handed: HandedIn) -> str:
    """Return a hash of the student and the answers, which differs for different answers."""
    answers = [[a.key, a.result.state, a.result.stamp, a.given] for a in handed.answers.values()]
    text = json.dumps([handed.lesson, handed.student, sorted(answers)])
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def blank(handed: HandedIn, lesson: Lesson, reviewer: str) -> Review:
    """Return an empty review; raise ReviewError if the reviewer's name cannot be stored."""
    name = _checked(checked_text, " ".join(reviewer.split()), "The reviewer's name", _NAME)
    if not name:
        raise ReviewError("Enter your name first: a review needs the reviewer's name.")
    rows = tuple(Row(one.text, one.points) for one in lesson.rubric)
    return Review(handed.path.name, answers_hash(handed), lesson.key, name, rows)


def _checked(check: Any, value: object, place: str, *limits: Any) -> Any:
    try:
        return check(value, place, *limits)
    except FileError as error:
        raise ReviewError(str(error)) from None


# --- files


def path_of(session: Path, reviewer: str) -> Path:
    """Return the path of a reviewer's review beside a session: "ada reviewed by bob.review"."""
    name = "".join(c if c.isalnum() or c in " -_" else "_" for c in reviewer).strip() or "reviewer"
    return session.with_name(f"{session.stem:.80} reviewed by {name:.60}{SUFFIX}")


def write(path: str | Path, review: Review, replace_file: bool = False) -> None:
    """Check a review and write it.

    Raise ReviewError if the review is invalid, if it cannot be written, or if the file exists and may not be
    replaced.
    """
    path = Path(path)
    text = json.dumps({"version": VERSION, **asdict(review)}, ensure_ascii=False, indent=1)
    parse(text, path.name)
    if (size := len(text.encode())) > MOST_BYTES:
        raise ReviewError(
            f"{path.name} would have {size:,} bytes; the limit is {MOST_BYTES:,} bytes. Shorten the comments."
        )
    if path.exists() and not replace_file:
        raise ReviewError(f"{path.name} exists already. Choose another name.")
    try:
        with replacing(path) as part:
            part.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ReviewError(f"{path.name} cannot be written: {error.strerror}.") from None


def read(path: str | Path) -> Review:
    """Return the review in a file; raise ReviewError if the file is invalid."""
    try:
        return parse(read_text(path), Path(path).name)
    except ReviewError:
        raise
    except FileError as error:
        raise ReviewError(str(error)) from None


def reply(path: str | Path, text: str) -> Review:
    """Add the author's reply to a review's file and return the review.

    Raise ReviewError for an empty reply, or if the file is invalid or cannot be written.
    """
    found = read(path)
    message = " ".join(text.split())
    if not message:
        raise ReviewError("Enter the text of the reply first.")
    changed = replace(found, replies=(*found.replies, message))
    write(path, changed, replace_file=True)
    return changed


def parse(text: str, name: str) -> Review:
    """Check every value of a review's JSON text and return the review.

    Raise ReviewError for an invalid value; the message names the file and the value.
    """
    try:
        table = checked_table(parse_json(text, name), name)
        checked_integer(table.get("version"), f"{name}: version", 1, VERSION)
        names = {
            key: checked_text(table.get(key), f"{name}: {key}", longest)
            for key, longest in (("session", 255), ("answers", 64), ("lesson", _NAME), ("reviewer", _NAME))
        }
        rows = tuple(
            _row(one, f"{name}: row {at}") for at, one in _records(table, "rows", name, MOST_CRITERIA)
        )
        comments = tuple(
            _comment(one, f"{name}: comment {at}")
            for at, one in _records(table, "comments", name, MOST_COMMENTS)
        )
        replies = tuple(
            checked_text(one, f"{name}: reply {at}", LONGEST)
            for at, one in _records(table, "replies", name, MOST_REPLIES)
        )
    except ReviewError:
        raise
    except FileError as error:
        raise ReviewError(str(error)) from None
    return Review(**names, rows=rows, comments=comments, replies=replies)


def _records(table: Mapping[str, Any], key: str, name: str, most: int) -> Sequence[tuple[int, Any]]:
    found = table.get(key, [])
    if not isinstance(found, list) or len(found) > most:
        raise ReviewError(f"{name}: {key} must be a list of at most {most} values.")
    return list(enumerate(found, 1))


def _row(value: object, place: str) -> Row:
    table = checked_table(value, place)
    most = checked_integer(table.get("most"), f"{place}: most", 1, 100)
    points = table.get("points")
    return Row(
        checked_text(table.get("criterion"), f"{place}: criterion", _CRITERION),
        most,
        None if points is None else checked_integer(points, f"{place}: points", 0, most),
        checked_text(table.get("comment", ""), f"{place}: comment", LONGEST),
    )


def _comment(value: object, place: str) -> Comment:
    table = checked_table(value, place)
    time, step = table.get("time"), table.get("step")
    return Comment(
        checked_text(table.get("text"), f"{place}: text", LONGEST),
        None if time is None else checked_number(time, f"{place}: time", 0.0, _LATEST, "s"),
        None if step is None else checked_integer(step, f"{place}: step", 1, 1_000),
    )


# --- the reviews of a handed-in file


@dataclass(frozen=True)
class Reviews:
    """The reviews in the folder of a handed-in file, by path; the paths are in alphabetical order.

    ``errors`` has one line for each review that is unreadable or refers to different answers.
    """

    found: Mapping[Path, Review]
    errors: tuple[str, ...] = ()

    @property
    def mean(self) -> float:
        """Return the mean fraction of points of the complete reviews; NaN for fewer than two such reviews."""
        shares = [one.points / one.most for one in self.found.values() if one.complete and one.most]
        return sum(shares) / len(shares) if len(shares) > 1 else math.nan


def reviews_of(handed: HandedIn) -> Reviews:
    """Return the reviews of a handed-in file, which are in the same folder."""
    answers, found, errors = answers_hash(handed), dict[Path, Review](), list[str]()
    for path in sorted(handed.path.parent.glob(f"*{SUFFIX}"))[:_MOST_FILES]:
        try:
            one = read(path)
        except ReviewError as error:
            errors.append(str(error))
            continue
        if one.answers == answers:
            found[path] = one
        elif one.session == handed.path.name:
            errors.append(
                f"{path.name} was written for different answers, not for those that are now in {one.session}."
            )
        if len(found) >= MOST_REVIEWS:
            break
    return Reviews(found, tuple(errors))


def hidden_names(reviews: Reviews) -> Reviews:
    """Return the reviews without file names, with numbers in place of the reviewers' names."""
    found = {
        path: replace(one, reviewer=f"Reviewer {at}", session="this work")
        for at, (path, one) in enumerate(reviews.found.items(), 1)
    }
    errors = tuple("A review could not be used." for _ in reviews.errors)
    return Reviews(found, errors)


def lines(review: Review) -> list[str]:
    """Return a review as lines of text: the sum, then each criterion, the comments and the replies."""
    found = [f"{review.reviewer} on {review.session}: {review.points} of {review.most} points"]
    for row in review.rows:
        points = "–" if row.points is None else str(row.points)
        text = f"{row.criterion}: {row.comment}" if row.comment else row.criterion
        found.append(f"  {points:>3} of {row.most:>3}  {text}")
    found += [f"  {comment.place or 'comment'}: {comment.text}" for comment in review.comments]
    return [*found, *(f"  reply: {text}" for text in review.replies)]
