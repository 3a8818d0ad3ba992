"""Packaging works on a fresh machine: bundle, wheels, desktop and lab file, with figures.

Run it as ``make acceptance``, which builds bundle and wheelhouse first. With ROOTS="DIR ...", as root, the
bundle also makes its tour in these bare systems (debootstrap --variant=minbase), under Xvfb. With "start" as
the only argument, only measure how fast the built bundle starts.
"""

import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

TESTS = Path(__file__).resolve().parent
BUILD = TESTS.parent / "build"
ARCHIVE, WHEELS = BUILD / "bundle" / "hapkit-studio.tar.gz", BUILD / "wheelhouse"
RUNS = 5
DISPLAY = ":77"
LAB = "force_limit = 1.0\n"


def main(roots: list[str]) -> None:
    with tempfile.TemporaryDirectory() as name:
        place = Path(name) / "Über Labor"  # the path has a space and an umlaut
        place.mkdir()
        subprocess.run(["tar", "-C", place, "-xzf", ARCHIVE], check=True)
        os.chmod(name, 0o755)  # other users must be able to read the folder, too
        bundle = place / "hapkit-studio"
        subprocess.run(["chmod", "-R", "a-w", place], check=True)
        try:
            show(
                "size of the bundle",
                f"{size(bundle) / 1e6:,.0f} MB, packed {ARCHIVE.stat().st_size / 1e6:,.0f} MB",
            )
            start_times(bundle / "hapkit-studio")
            tour("this computer", [bundle / "hapkit-studio"], Path(name))
            no_home(bundle / "hapkit-studio")
            lab_file(bundle / "hapkit-studio", Path(name))
            desktop(bundle / "hapkit-studio", Path(name))
            for root in roots:
                bare(Path(root), bundle)
        finally:
            subprocess.run(["chmod", "-R", "u+w", place], check=True)
        for python in filter(None, map(shutil.which, (f"python3.{minor}" for minor in range(11, 15)))):
            wheels(python, Path(name))


def show(what: str, value: str) -> None:
    print(f"{what}: {value}", flush=True)


def size(folder: Path) -> int:
    return sum(file.lstat().st_size for file in folder.rglob("*"))


def clean(home: Path, **variables: str) -> dict[str, str]:
    """Return the environment variables of a new user without a display."""
    home.mkdir(parents=True, exist_ok=True)
    base = {"HOME": str(home), "PATH": "/usr/bin:/bin", "LANG": "C.UTF-8", "QT_QPA_PLATFORM": "offscreen"}
    return base | variables


def output(command: list, environment: dict[str, str], cwd: Path | None = None, code: int = 0) -> str:
    """Run a program and return its output; exit with its errors if its exit code is not ``code``."""
    done = subprocess.run(
        [str(word) for word in command], env=environment, cwd=cwd, capture_output=True, text=True, timeout=900
    )
    if done.returncode != code:
        sys.exit(f"{' '.join(map(str, command))} ended with {done.returncode}:\n{done.stdout}\n{done.stderr}")
    return done.stdout


def start_times(program: Path) -> None:
    """Measure the first start for new users, alternately with importing Qt and numba in the same bundle."""
    windows, samples, references = [], [], []
    for _ in range(RUNS):
        with tempfile.TemporaryDirectory() as home:
            begin = time.perf_counter()
            output([program, "-m", "import_libraries"], clean(Path(home)), TESTS / "bench")
            references.append(time.perf_counter() - begin)
            begin = time.perf_counter()
            command = [program, "-m", "first_sample"]
            seen = json.loads(output(command, clean(Path(home)), TESTS / "bench").splitlines()[-1])
        windows.append(seen["window"] - begin)
        samples.append(seen["sample"] - begin)
        if seen["notices"]:
            sys.exit(f"The first start says {seen['notices']}: the machine code of the bundle was not used.")
    reference = statistics.median(references)
    for what, values in (("first window", windows), ("first sample", samples)):
        value = statistics.median(values)
        show(f"{what} of a new user", f"{value:.2f} s, {value / reference:.2f} × importing Qt and numba")


def tour(where: str, command: list, folder: Path, environment: dict[str, str] | None = None) -> None:
    """Run the tour: visit every environment, view and lesson; compile, record and export a law."""
    results = folder / "tour"
    results.mkdir()
    environment = environment or clean(folder / "home")
    text = output([*command, "-m", "installed_tour", results, "all"], environment, TESTS)
    check_tour(where, json.loads(text.splitlines()[-1]))


def check_tour(where: str, seen: dict) -> None:
    own, lessons, views = seen["own"], seen["lessons"], seen["views"]
    good = all(
        visit["chosen"] == key and visit["running"] and visit["rows"] >= 200
        for key, visit in seen["visits"].items()
    )
    good &= all(views.values()) and not any(lessons.values())
    good &= not own["problems"] and own["samples"] > 900 and own["force"] > 0.1
    if not good:
        sys.exit(f"{where}: {json.dumps(seen, indent=1)}")
    counts = f"{len(seen['visits'])} environments, {len(views)} views, {len(lessons)} lessons"
    show(
        f"gone through on {where}", f"{counts}, a new law recorded and exported ({own['samples']:,} samples)"
    )


def no_home(program: Path) -> None:
    """Start the window without a writable home directory; root starts it as a different user."""
    other = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"] if os.getuid() == 0 else []
    with tempfile.TemporaryDirectory() as folder:
        os.chmod(folder, 0o777)
        picture = Path(folder) / "window.png"
        command = [*other, program, "--screenshot", picture, "--seconds", "0.5"]
        output(command, clean(Path(folder)) | {"HOME": "/nowhere"})
        show("window without a home directory", f"{picture.stat().st_size:,} bytes of a picture")


def lab_file(program: Path, folder: Path) -> None:
    """Check that a lab's file limits the force, and that no loop starts if the file contains a mistake."""
    settings = folder / "xdg" / "hapkit-studio" / "lab.toml"
    settings.parent.mkdir(parents=True)
    environment = clean(folder / "home-lab", XDG_CONFIG_DIRS=str(folder / "xdg"))
    command = [program, "run", "wall", "--device", "simulated", "--hand", "press", "--seconds", "1", "--json"]
    settings.write_text(LAB)
    limited = json.loads(output(command, environment))
    settings.write_text(LAB.replace("1.0", "'one'"))
    output(command, environment, code=2)
    show(
        "with force_limit = 1.0 in lab.toml",
        f"the loop's limit is {limited['max_force_N']:g} N; a mistake: no loop",
    )


def desktop(program: Path, folder: Path) -> None:
    """Add the studio to a new user's desktop and remove it."""
    environment = clean(folder / "home-desktop")
    written = json.loads(output([program, "integrate", "--yes", "--json"], environment))["written"]
    removed = json.loads(output([program, "integrate", "--remove", "--yes", "--json"], environment))[
        "removed"
    ]
    if sorted(written) != sorted(removed) or any(Path(path).exists() for path in written):
        sys.exit(f"integrate wrote {written} and removed {removed}.")
    show("integrate, integrate --remove", f"{len(written)} files written and removed")


@contextmanager
def mounted(*places: tuple[str, Path]):
    """Mount folders read-only in a bare system, and unmount them at the end."""
    done: list[Path] = []
    try:
        for source, target in places:
            target.mkdir(parents=True, exist_ok=True)
            subprocess.run(["mount", "--rbind", source, target], check=True)
            subprocess.run(["mount", "--make-rslave", target], check=True)
            done.append(target)
        yield
    finally:
        for target in reversed(done):
            subprocess.run(["umount", "-R", "-l", target], check=True)


def bare(root: Path, bundle: Path) -> None:
    """Run the bundle's tour in a bare system; its windows are shown on a display of the present system."""
    if (root / "usr/bin/python3").exists():
        sys.exit(f"{root} has Python: make a new one by debootstrap --variant=minbase.")
    inside, name = root / "opt" / "Über Labor", (root / "etc/debian_version").read_text().strip()
    shutil.rmtree(root / "tmp" / "tour", ignore_errors=True)
    places = [(f"/{part}", root / part) for part in ("proc", "sys", "dev")]
    places += [(str(bundle), inside), (str(TESTS), root / "opt" / "tests")]
    server = subprocess.Popen(["Xvfb", DISPLAY, "-screen", "0", "1920x1080x24"], stderr=subprocess.DEVNULL)
    try:
        time.sleep(1.0)
        with mounted(*places, ("/tmp/.X11-unix", root / "tmp" / ".X11-unix")):
            (root / "tmp" / "tour" / "home").mkdir(parents=True)
            environment = clean(root / "tmp" / "tour" / "home") | {
                "HOME": "/tmp/tour/home",
                "DISPLAY": DISPLAY,
            }
            del environment["QT_QPA_PLATFORM"]
            start = 'cd /opt/tests && "/opt/Über Labor/hapkit-studio" -m installed_tour /tmp/tour all'
            text = output([shutil.which("chroot"), root, "sh", "-c", start], environment)
    finally:
        server.terminate()
        server.wait()
    check_tour(f"bare Debian {name}, {packages(root)} packages, no Python", json.loads(text.splitlines()[-1]))


def packages(root: Path) -> int:
    return (root / "var/lib/dpkg/status").read_text().count("\nPackage: ") + 1


def wheels(python: str, folder: Path) -> None:
    """Install from the wheelhouse without a network, run, uninstall; print what remains installed."""
    home, place = folder / f"home-{Path(python).name}", folder / Path(python).name
    ask = [python, "-c", "import sys; print('cp%d%d' % sys.version_info[:2])"]
    done = subprocess.run(ask, capture_output=True, text=True)
    version = done.stdout.strip()
    if done.returncode:
        show(f"wheels for {Path(python).name}", "not tried: it does not start")
        return
    if not list(WHEELS.glob(f"numba-*-{version}-*")):
        show(
            f"wheels for {Path(python).name}",
            f"none in {WHEELS.name}: make wheelhouse PYTHON={Path(python).name}",
        )
        return
    output([python, "-m", "venv", place], os.environ.copy())
    pip = [place / "bin" / "python", "-m", "pip", "--disable-pip-version-check"]
    nowhere = {"PIP_CONFIG_FILE": os.devnull, "PIP_NO_INDEX": "1"}
    offline = [*pip, "install", "--quiet", "--no-index", "--find-links", WHEELS, "hapkit-studio"]
    output(offline, clean(home, **nowhere))
    run = output([place / "bin" / "hapkit-studio", "run", "wall", "--hand", "press", "--json"], clean(home))
    places = json.loads(output([place / "bin" / "hapkit-studio", "where", "--json"], clean(home)))["places"]
    output([*pip, "uninstall", "--quiet", "--yes", "hapkit-studio"], clean(home))
    inside = [file for file in place.rglob("*hapkit_studio*") if file.exists()]
    kept = {file for file in home.rglob("*") if file.is_file()}
    listed = [Path(found["path"]) for found in places]
    others = [file for file in kept if not any(file == path or path in file.parents for path in listed)]
    if inside or others:
        sys.exit(f"After uninstalling, {inside + others} remain.")
    force = json.loads(run)["peak_force"]
    show(
        f"wheels for {Path(python).name}, offline",
        f"installed, wall pressed with {force:.2f} N, uninstalled cleanly",
    )


if __name__ == "__main__":
    if sys.argv[1:] == ["start"]:
        start_times(BUILD / "bundle" / "hapkit-studio" / "hapkit-studio")
    else:
        main(sys.argv[1:])
