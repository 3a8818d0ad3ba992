"""The reference for wake-up lateness: ``cyclictest`` of rt-tests, one thread at 1 kHz."""

import shutil
import subprocess


def block(seconds: float, level: int) -> float | None:
    """Return its p99.9 in µs at a real-time level (0: normal priority); None where it cannot run.

    At normal priority it may not keep the processors awake either, as nobody without rights may.
    """
    if shutil.which("cyclictest") is None:
        return None
    policy = ["--policy=fifo", f"--priority={level}"] if level else ["--policy=other", "--laptop"]
    command = ["cyclictest", "--quiet", "--threads=1", "--interval=1000", "--histogram=100000", *policy]
    done = subprocess.run(
        [*command, f"--duration={seconds:.0f}"], capture_output=True, text=True, check=False
    )
    return percentile(done.stdout, 0.999) if done.returncode == 0 else None


def percentile(text: str, share: float) -> float | None:
    """Return the upper edge in µs of the bin in which that share of the printed histogram is reached."""
    bins = [line.split() for line in text.splitlines() if line[:1].isdigit()]
    total = sum(int(count) for _, count in bins)
    reached = 0
    for microseconds, count in bins:
        reached += int(count)
        if total and reached >= share * total:
            return float(microseconds) + 1.0
    return None
