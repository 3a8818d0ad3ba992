"""Build the bundle of the studio with PyInstaller, avrdude and the licences. `make bundle` runs this script.

The interpreter that runs this script needs the studio and PyInstaller.
"""

import compileall
import hashlib
import os
import py_compile
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
from importlib import metadata
from pathlib import Path

HERE = Path(__file__).resolve().parent
BUILD = HERE.parents[1] / "build"
BUNDLE = BUILD / "bundle" / "hapkit-studio"
INSIDE = BUNDLE / "_internal"
LICENCES = BUNDLE / "licences"
PROGRAM = BUNDLE / ("hapkit-studio.exe" if os.name == "nt" else "hapkit-studio")
AVRDUDE_NOTE = """\
avrdude is a separate program under the GNU General Public License, version 2 or later (copyright, beside).
Hapkit Studio starts it to write the firmware. It was copied unchanged from {where}.
Its complete source: {source}. Who gave you this folder gives you the source, too, on request,
for three years, at no more than the cost of copying.
"""
QT_NOTE = """\
Qt and PySide6 are under the GNU Lesser General Public License, version 3. They are the separate libraries
libQt6* and PySide6 in _internal: replace them by versions of your own that are compatible with them.
"""


def main() -> None:
    folders = ("--distpath", BUNDLE.parent, "--workpath", BUILD / "pyinstaller")
    words = ("--noconfirm", "--log-level", "ERROR", *folders, HERE / "hapkit-studio.spec")
    BUILD.mkdir(exist_ok=True)
    run(sys.executable, "-m", "PyInstaller", *words)
    LICENCES.mkdir()
    copy_licences()
    copy_avrdude()
    compile_sources()
    compile_machine_code()
    archive = BUNDLE.with_suffix(".tar.gz")
    with tarfile.open(archive, "w:gz", compresslevel=6) as file:
        file.add(BUNDLE, BUNDLE.name)
    print(f"{BUNDLE}: {size(BUNDLE) / 1e6:,.0f} MB; {archive.name}: {archive.stat().st_size / 1e6:,.0f} MB")


def run(*command: object, **variables: str) -> None:
    """Run a command in the build folder, so that Python does not import packages from the checkout."""
    subprocess.run([str(word) for word in command], env=os.environ | variables, cwd=BUILD, check=True)


def copy_licences() -> None:
    """Copy the licence of the studio and of each package."""
    shutil.copy(HERE.parents[1] / "LICENSE", LICENCES / "hapkit-studio.txt")
    text = Path(sysconfig.get_path("stdlib"), "LICENSE.txt")
    if text.is_file():
        shutil.copy(text, LICENCES / "python.txt")
    (LICENCES / "qt.txt").write_text(QT_NOTE, encoding="utf-8")
    for package in metadata.distributions():
        texts = [
            file for file in package.files or () if re.match(r"(LICEN[CS]E|COPYING|NOTICE)", file.name, re.I)
        ]
        for number, text in enumerate(texts):
            if text.locate().is_file():
                shutil.copy(text.locate(), LICENCES / f"{package.name}{number or ''}.txt")


def copy_avrdude() -> None:
    """Copy avrdude and its libraries if a Debian package installed it; otherwise print a message."""
    found = shutil.which("avrdude")
    package = "" if found is None else owner(Path(found))
    if not package:
        print(
            "avrdude is not bundled: it is not installed here as a Debian package. Flashing will use "
            "the computer's own."
        )
        return
    place = INSIDE / "avrdude"
    for folder in ("bin", "lib", "etc"):
        (place / folder).mkdir(parents=True)
    shutil.copy(found, place / "lib" / "avrdude")
    shutil.copy("/etc/avrdude.conf", place / "etc")
    listed = subprocess.run(["ldd", found], capture_output=True, text=True, check=True).stdout
    for name, path in re.findall(r"(\S+) => (\S+)", listed):
        if not re.match(r"lib(c|m|pthread|dl|rt)\.so", name):
            shutil.copy(path, place / "lib" / name)
    script = place / "bin" / "avrdude"
    script.write_text(
        '#!/bin/sh\nplace=$(dirname "$(readlink -f "$0")")/../lib\n'
        'LD_LIBRARY_PATH=$place exec "$place/avrdude" "$@"\n'
    )
    script.chmod(0o755)
    folder = LICENCES / "avrdude"
    folder.mkdir()
    shutil.copy("/usr/share/doc/avrdude/copyright", folder)
    note = AVRDUDE_NOTE.format(
        where=f"Debian's package {package}", source=f"Debian's source package {package}"
    )
    (folder / "readme.txt").write_text(note, encoding="utf-8")


def owner(path: Path) -> str:
    """Return the name and version of the Debian package that contains a file; "" for a file of no package."""
    if shutil.which("dpkg-query") is None:
        return ""
    found = subprocess.run(["dpkg-query", "-S", path], capture_output=True, text=True, check=False).stdout
    name = found.partition(":")[0]
    words = ["dpkg-query", "-W", "-f", "${source:Package} ${source:Version}", name]
    return name and subprocess.run(words, capture_output=True, text=True, check=True).stdout


def compile_sources() -> None:
    """Compile the studio to bytecode that does not depend on the modification times of the files."""
    mode = py_compile.PycInvalidationMode.UNCHECKED_HASH
    if not compileall.compile_dir(INSIDE / "hapkit_studio", quiet=1, force=True, invalidation_mode=mode):
        sys.exit("The bytecode of the bundle could not be compiled.")


def compile_machine_code() -> None:
    """Run the bundle once, so that it compiles the loop, the laws and the analysis into its own folder."""
    sources = sorted((INSIDE / "hapkit_studio").rglob("*.py"))
    digest = hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()
    folder = INSIDE / "machine-code"
    folder.mkdir()
    (folder / "stamp").write_text(digest, encoding="ascii")
    with tempfile.TemporaryDirectory() as home:
        places = {name: home for name in ("HOME", "XDG_CACHE_HOME", "LOCALAPPDATA")}
        places |= {"HAPKIT_STUDIO_FILL_BUNDLE": "1", "NUMBA_CACHE_DIR": ""}
        run(PROGRAM, "-P", "-m", "hapkit_studio.gui.state.prepare", "all", **places)


def size(folder: Path) -> int:
    return sum(file.lstat().st_size for file in folder.rglob("*"))


if __name__ == "__main__":
    main()
