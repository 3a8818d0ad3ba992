"""Points and sheets made up by hand."""

from hapkit_studio.analysis.accuracy import Accuracy, Chart, Default, Method, Point, Scene, Sheet
from hapkit_studio.analysis.accuracy.plan import mark_front


def point(method="verlet", error=0.01, ns=1000.0, step_s=1e-3, **more):
    return Point("made", "scene", method, step_s, error, ns, label=method, **more)


def scene(default="verlet", tolerance=0.02, **more):
    return Scene("scene", "A scene", "error / scale", tolerance, "a reason", Default(default), **more)


def sheet(points, **more):
    methods = tuple(Method(key, key.capitalize()) for key in dict.fromkeys(p.method for p in points))
    return Sheet("made", scene(**more), methods, mark_front(points))


def accuracy(*sheets):
    return Accuracy((Chart("made", "Made up", sheets),), 1.0)
