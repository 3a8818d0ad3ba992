"""Write the firmware's laws: the studio's environments, and a person's own where they are named."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from hapkit_studio.errors import LawError
from hapkit_studio.laws import firmware
from hapkit_studio.laws.law import Law
from hapkit_studio.workshop import reading
from hapkit_studio.workshop.own import built_in


def default_folder() -> Path:
    """Return where the sketch lies in a checkout."""
    return Path(__file__).resolve().parents[2] / "firmware" / "hapkit"


def laws(files: Sequence[Path] = ()) -> dict[str, Law]:
    """Return the laws by key, in the order of their numbers; own files are executed. Raise LawError."""
    found = {key: environment.force for key, environment in built_in().items()}
    for file in files:
        own = reading.load(file)
        if own.key in found:
            raise LawError(f"{file}: there is a law {own.key!r} already.")
        found[own.key] = own.force
    return found


def by_hand() -> dict[str, str]:
    """Return the sketch's headers that laws need besides the generated ones, by their names in its folder."""
    laws = ("law.h", "contact.h", "exact_motion.h", "moving.h", "grains.h")
    names = ("fast.h", "fast_bits.h", *(f"laws/{name}" for name in laws))
    return {name: (default_folder() / name).read_text(encoding="utf-8") for name in names}


def main(arguments: list[str] | None = None) -> int:
    """Write the headers; with --check only tell whether they are up to date."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--out",
        type=Path,
        default=default_folder(),
        help="the sketch's folder; another one gets what the laws need",
    )
    parser.add_argument(
        "--with",
        dest="own",
        type=Path,
        nargs="+",
        default=[],
        metavar="FILE",
        help="own environments to add; their files are executed",
    )
    parser.add_argument("--check", action="store_true", help="write nothing, exit 1 if a file differs")
    options = parser.parse_args(arguments)
    try:
        files = firmware.headers(laws(options.own))
    except LawError as error:
        print(error, file=sys.stderr)
        return 2
    if not options.check:
        firmware.write(by_hand() | files, options.out)
        return 0
    changed = firmware.outdated(files, options.out)
    print("\n".join(changed), end="\n" if changed else "")
    return int(bool(changed))


if __name__ == "__main__":
    sys.exit(main())
