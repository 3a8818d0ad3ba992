"""Guided labs: lessons are Markdown files with checks, which are evaluated on recorded data.

A lesson is a file in assets/lessons or in an instructor's folder (``library``). ``evaluate`` evaluates a
step's check on the samples recorded so far (``Samples``) and describes the result in a sentence.
"""

from hapkit_studio.lessons.evaluate import Result, evaluate
from hapkit_studio.lessons.lesson import Lesson, LessonError, Step
from hapkit_studio.lessons.library import Library, library
from hapkit_studio.lessons.samples import Samples

__all__ = ["Lesson", "LessonError", "Library", "Result", "Samples", "Step", "evaluate", "library"]
