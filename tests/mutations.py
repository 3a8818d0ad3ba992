"""Seeded mutations of the code that the tests catch: proof that tests which were cut or rewritten still look.

    python -m tests.mutations find --count 100    # writes those that are caught to tests/mutations.json
    python -m tests.mutations check               # each of them again, in a copy of the project

A mutation is one line written otherwise; it is found again by its text, so code may move. Not part of
`make test`: most start with nothing compiled, and all together take an hour.
"""

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "hapkit_studio"
LIST = Path(__file__).with_name("mutations.json")
SECONDS, FILES = 400, 5
"""s after which tests that hang have seen a mutation; files of tests that are asked."""
AREAS = {
    "laws": (("environments", "laws"), ("tests/environments", "tests/laws")),
    "tick": (("haptics/tick.py", "haptics/headless.py", "dynamics"), ("tests/haptics", "tests/dynamics")),
    "safety": (
        ("haptics/health.py", "haptics/realtime_linux.py", "haptics/passivity.py"),
        ("tests/haptics",),
    ),
    "codec": (("protocol",), ("tests/protocol",)),
    "analysis": (("analysis",), ("tests/analysis",)),
    "window": (("gui",), ("tests/gui",)),
}
"""What is mutated, below the package, and the tests that look at it."""
INTERPRETED = ("codec", "window")
"""Areas that compile nothing: their mutations share what the tests compile."""
SWAPPED = {
    ast.Lt: ">=", ast.LtE: ">", ast.Gt: "<=", ast.GtE: "<", ast.Eq: "!=", ast.NotEq: "==",
    ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.And: "or", ast.Or: "and",
}  # fmt: skip


@dataclass(frozen=True)
class Mutation:
    """A line of a file under the package, and what it becomes; the tests that see it."""

    area: str
    path: str
    before: str
    after: str
    tests: tuple[str, ...] = ()


def mutations(area: str, path: Path) -> Iterator[Mutation]:
    """Yield every mutation of a file's lines that stand there once."""
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    bare = [line.strip() for line in lines]
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            found = _swap(lines, node.left, node.comparators[0], node.ops[0])
        elif isinstance(node, ast.BinOp):
            found = _swap(lines, node.left, node.right, node.op)
        elif isinstance(node, ast.BoolOp):
            found = _swap(lines, node.values[0], node.values[1], node.op)
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
            value = repr(node.value * 2 if node.value else type(node.value)(1))
            found = node.lineno, node.col_offset, node.end_col_offset, value
        else:
            continue
        if found is None:
            continue
        number, start, end, new = found
        line = lines[number - 1]
        after = line[:start] + new + line[end:]
        if line.isascii() and bare.count(line.strip()) == 1 and after != line:
            yield Mutation(area, str(path.relative_to(PACKAGE)), line.strip(), after.strip())


def _swap(lines, left, right, op):
    """Return line, start, end and new text of an operator between two operands on one line."""
    new = SWAPPED.get(type(op))
    if new is None or left.end_lineno != right.lineno:
        return None
    return left.end_lineno, left.end_col_offset, right.col_offset, f" {new} "


def sources(area: str) -> list[Path]:
    """Return the files of an area."""
    roots = [PACKAGE / name for name in AREAS[area][0]]
    return sorted(f for root in roots for f in (root.rglob("*.py") if root.is_dir() else [root]))


def placed(mutation: Mutation, root: Path) -> tuple[Path, str]:
    """Return the file below a copy of the project where a mutation's line stands once, and its new text."""
    own = root / "hapkit_studio" / mutation.path
    for files in ([own] if own.exists() else [], sorted((root / "hapkit_studio").rglob("*.py"))):
        found = []
        for file in files:
            lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
            found += [(file, lines, i) for i, line in enumerate(lines) if line.strip() == mutation.before]
        if len(found) == 1:
            file, lines, i = found[0]
            lines[i] = lines[i].replace(mutation.before, mutation.after)
            return file, "".join(lines)
    raise LookupError(
        f"{mutation.path}: {mutation.before!r} does not stand once any more. Mutate what stands for it."
    )


def failing(root: Path, area: str, tests: tuple[str, ...]) -> str | None:
    """Return the first file of tests that fails in a copy of the project, None where none does."""
    with tempfile.TemporaryDirectory() as fresh:
        cache = str(root / "cache") if area in INTERPRETED else fresh
        words = [sys.executable, "-m", "pytest", "-qx", "-p", "no:cacheprovider", *tests]
        words += ["-m", "not alone"]
        around = os.environ | {"NUMBA_CACHE_DIR": cache, "QT_QPA_PLATFORM": "offscreen"}
        around |= {"PYTHONPATH": str(root)}
        try:
            done = subprocess.run(
                words, cwd=root, env=around, capture_output=True, text=True, timeout=SECONDS, check=False
            )
        except subprocess.TimeoutExpired:
            return tests[0]
    failed = [w for w in done.stdout.split() if w.startswith("tests/") and "::" in w]
    return failed[0].split("::")[0] if done.returncode == 1 and failed else None


def caught(mutation: Mutation, root: Path, tests: tuple[str, ...]) -> str | None:
    """Return the file of tests that fails with a mutation in a copy of the project, None where none does."""
    file, text = placed(mutation, root)
    was = file.read_text(encoding="utf-8")
    file.write_text(text, encoding="utf-8")
    try:
        return failing(root, mutation.area, tests)
    finally:
        file.write_text(was, encoding="utf-8")


def copied(folder: str) -> Path:
    """Copy what is under version control, and the built firmware."""
    root = Path(folder) / "project"
    subprocess.run(["git", "clone", "-q", str(ROOT), str(root)], check=True)
    if (ROOT / "firmware" / "build").is_dir():
        shutil.copytree(ROOT / "firmware" / "build", root / "firmware" / "build", symlinks=True)
    return root


def tests_of(source: Path, area: str) -> tuple[str, ...]:
    """Return a few files of tests, first those that bear a module's name, then those that name it."""
    files = sorted(f for name in AREAS[area][1] for f in (ROOT / name).rglob("test_*.py"))
    files.sort(key=lambda f: (source.stem not in f.stem, source.stem not in f.read_text(encoding="utf-8")))
    return tuple(str(f.relative_to(ROOT)) for f in files[:FILES])


def find(count: int, seed: int, area: str | None) -> None:
    """Look for mutations that are caught, evenly over the areas; add them to the list."""
    chance = random.Random(seed)
    known = read()
    with tempfile.TemporaryDirectory() as folder:
        root = copied(folder)
        wanted = [area] if area else list(AREAS)
        while len(known) < count:
            name = min(wanted, key=lambda a: sum(m.area == a for m in known))
            source = chance.choice(sources(name))
            choices = [m for m in mutations(name, source) if m.before not in {k.before for k in known}]
            if not choices:
                continue
            mutation = chance.choice(choices)
            by = caught(mutation, root, tests_of(source, name))
            if by and (not caught(mutation, root, (by,)) or failing(root, name, (by,))):
                print(f"{by} does not tell it from the code as it is", flush=True)
                continue
            print(f"{mutation.path}: {mutation.before} -> {mutation.after}: {by or 'not caught'}", flush=True)
            if by:
                known.append(Mutation(**asdict(mutation) | {"tests": (by,)}))
                write(known)


def check(area: str | None) -> int:
    """Try every mutation of the list, or of an area; return how many are caught no more."""
    lost = 0
    with tempfile.TemporaryDirectory() as folder:
        root = copied(folder)
        for mutation in (m for m in read() if area in (None, m.area)):
            tests = tuple(t for t in mutation.tests if (root / t).exists()) or AREAS[mutation.area][1]
            found = caught(mutation, root, tests)
            lost += found is None
            print(f"{'caught' if found else 'LOST'}: {mutation.path}: {mutation.after}", flush=True)
    return lost


def read() -> list[Mutation]:
    """Return the list."""
    found = json.loads(LIST.read_text(encoding="utf-8")) if LIST.exists() else []
    return [Mutation(**m | {"tests": tuple(m["tests"])}) for m in found]


def write(known: list[Mutation]) -> None:
    """Write the list."""
    LIST.write_text(json.dumps([asdict(m) for m in known], indent=1) + "\n", encoding="utf-8")


def main() -> int:
    """Find or check; return how many are lost."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    finding = commands.add_parser("find")
    finding.add_argument("--count", type=int, default=100)
    finding.add_argument("--seed", type=int, default=1)
    for command in (finding, commands.add_parser("check")):
        command.add_argument("--area", choices=AREAS)
    words = parser.parse_args()
    if words.command == "check":
        return check(words.area)
    find(words.count, words.seed, words.area)
    return 0


if __name__ == "__main__":
    sys.exit(main())
