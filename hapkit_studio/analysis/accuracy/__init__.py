"""Speed charted against accuracy: what each method's error costs, and which one a scene should use."""

from hapkit_studio.analysis.accuracy.points import Point
from hapkit_studio.analysis.accuracy.sheet import Accuracy, Answer, Chart, Default, Method, Scene, Sheet

__all__ = ["Accuracy", "Answer", "Chart", "Default", "Method", "Point", "Scene", "Sheet"]
