"""What each system is asked for, what is obtained and said, and that a runaway thread loses it."""

import ctypes
import os
import resource
import shutil
import subprocess
import sys
import threading

import pytest
from numba import njit

from hapkit_studio.haptics import clib, clock, priority, realtime_macos, realtime_windows

linux_only = pytest.mark.skipif(sys.platform != "linux", reason="the Linux side")
if sys.platform == "linux":
    from hapkit_studio.haptics import realtime_linux

UNPRIVILEGED = ["setpriv", "--bounding-set=-sys_nice,-ipc_lock,-sys_resource"]
KIT = """#!/bin/sh
case "$*" in
*get-property*) printf 'i 20\\nx 200000\\n' ;;
*MakeThreadRealtimeWithPID*)
    echo "$@" >> "{log}"
    grep -i "realtime timeout" /proc/$PPID/limits >> "{log}"
    {grant} ;;
esac
"""


def in_thread(function):
    """Run a function in a thread of its own; return what it returned."""
    found = []
    thread = threading.Thread(target=lambda: found.append(function()))
    thread.start()
    thread.join()
    return found[0]


def in_process(code, *prefix, **environment):
    """Run code in a process of its own, since limits once lowered stay so; return what it prints."""
    command = [*prefix, sys.executable, "-c", code]
    done = subprocess.run(command, env=os.environ | environment, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@linux_only
def test_words_are_what_the_kernel_says():
    def run():
        obtained = priority.obtain()
        policy = os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK
        level = os.sched_getparam(0).sched_priority
        priority.release()
        return obtained, policy, level, os.sched_getscheduler(0)

    obtained, policy, level, after = in_thread(run)
    assert obtained.realtime == (policy in (os.SCHED_FIFO, os.SCHED_RR))
    assert obtained.level == level
    assert (str(level) in obtained.text) == obtained.realtime
    assert bool(obtained.how) == (level < 80)
    assert after & ~os.SCHED_RESET_ON_FORK == os.SCHED_OTHER


@linux_only
def test_timer_slack_is_one_nanosecond_while_obtained():
    get_slack = 30

    def run():
        libc = ctypes.CDLL(None)
        before = libc.prctl(get_slack, 0, 0, 0, 0)
        priority.obtain()
        during = libc.prctl(get_slack, 0, 0, 0, 0)
        priority.release()
        return before, during, libc.prctl(get_slack, 0, 0, 0, 0)

    before, during, after = in_thread(run)
    assert after == before
    # the kernel ignores the slack of real-time threads and may report none at all
    assert during in (0, 1)


@linux_only
def test_processors_are_kept_awake_only_while_obtained(tmp_path, monkeypatch):
    device = tmp_path / "latency"
    monkeypatch.setattr(realtime_linux, "_WAKE_LATENCY", device)

    def run():
        priority.obtain()
        held = realtime_linux._held.file
        open_meanwhile = not held.closed
        priority.release()
        return open_meanwhile, held.closed

    assert in_thread(run) == (True, True)
    assert device.read_bytes() == bytes(4)
    monkeypatch.setattr(realtime_linux, "_WAKE_LATENCY", tmp_path / "no" / "such")
    assert in_thread(realtime_linux.keep_processors_awake) is False


@pytest.mark.slow
@linux_only
@pytest.mark.skipif(shutil.which("setpriv") is None, reason="needs setpriv of util-linux")
def test_without_rights_the_words_say_so_and_how_to_get_more(tmp_path):
    code = (
        "from hapkit_studio.haptics import priority as p; x = p.probe();"
        "print(x.text, x.realtime, x.level, 'rtprio 80' in x.how, 'limits.d' in p.report(), sep='|')"
    )
    prefix = UNPRIVILEGED if os.geteuid() == 0 else []
    text = in_process(code, *prefix, PATH=f"{tmp_path}:{os.environ['PATH']}")
    allowed = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    if allowed == 0 and not shutil.which("rtkit"):
        assert text in ("Normal priority|False|0|True|True", "Raised priority, nice -11|False|0|True|True")


@pytest.mark.slow
@linux_only
@pytest.mark.skipif(os.geteuid() != 0, reason="the fake service needs the right to grant")
@pytest.mark.parametrize("granted", [True, False])
def test_realtime_kit_is_asked_with_its_limits(tmp_path, granted):
    log = tmp_path / "log"
    grant = 'for word; do thread=$level; level=$word; done; chrt --rr --pid "$level" "$thread"'
    grant = grant if granted else "exit 1"
    (tmp_path / "busctl").write_text(KIT.format(log=log, grant=grant))
    (tmp_path / "busctl").chmod(0o755)
    code = (
        "import os, threading; from hapkit_studio.haptics import realtime_linux as r;"
        "tid = threading.get_native_id(); print(os.getpid(), tid, r._ask_realtime_kit(tid))"
    )
    process, thread, *obtained = in_process(code, PATH=f"{tmp_path}:{os.environ['PATH']}").split(maxsplit=2)
    call, *limits = log.read_text().splitlines()
    assert call.split()[-4:] == ["ttu", process, thread, "20"]
    assert obtained == ["('Real-time, RealtimeKit 20', 20)" if granted else "None"]
    assert [line.split()[3:5] for line in limits] == [["100000", "200000"]]


@linux_only
@pytest.mark.skipif(os.geteuid() != 0, reason="needs the right to real-time priority")
def test_thread_that_never_blocks_is_demoted_without_python():
    @njit(nogil=True)
    def spin(seconds):
        end = clock.now() + seconds
        while clock.now() < end:
            pass

    spin(0.0)
    before = realtime_linux.demotions()

    def run():
        assert realtime_linux._take_fifo(threading.get_native_id())
        spin(0.5)
        scheduler = os.sched_getscheduler(0)
        priority.release()
        return scheduler

    assert in_thread(run) & ~os.SCHED_RESET_ON_FORK == os.SCHED_OTHER
    assert realtime_linux.demotions() == before + 1


@linux_only
@pytest.mark.skipif(os.geteuid() != 0, reason="needs the right to real-time priority")
def test_compiled_code_demotes_its_own_thread():
    @njit
    def caller():
        priority.demote()

    def run():
        realtime_linux._set_fifo(10)
        before = realtime_linux.is_realtime(0)
        caller()
        return before, realtime_linux.is_realtime(0)

    assert in_thread(run) == (True, False)


class FakeFunction:
    """One C function of a fake library: remembers its arguments, returns a fixed value."""

    def __init__(self, result, effect=None):
        self.result, self.effect, self.calls = result, effect, []

    def __call__(self, *arguments):
        self.calls.append(arguments)
        if self.effect:
            self.effect(*arguments)
        return self.result


class FakeLibrary:
    def __init__(self, **results):
        for name, result in results.items():
            setattr(self, name, result if isinstance(result, FakeFunction) else FakeFunction(result))


@pytest.mark.parametrize(("status", "words"), [(0, "Real-time, time constraint"), (4, "Normal priority")])
def test_macos_asks_for_the_time_constraint(status, words):
    def fill(reference):
        reference._obj[0], reference._obj[1] = 125, 3

    library = FakeLibrary(
        mach_timebase_info=FakeFunction(0, fill),
        thread_policy_set=status,
        pthread_self=77,
        pthread_mach_thread_np=42,
    )
    assert realtime_macos.obtain(library) == (words, int(status == 0))
    thread, flavor, policy, count = library.thread_policy_set.calls[0]
    assert (thread, flavor, count) == (42, 2, 4)
    assert list(policy) == [24_000, 4_800, 12_000, 1]
    realtime_macos.release(library)
    assert library.thread_policy_set.calls[1][:2] == (42, 1)


@pytest.mark.parametrize(("handle", "words"), [(0x5, "Real-time, Pro Audio"), (0, "Normal priority")])
def test_windows_joins_pro_audio(handle, words):
    library = FakeLibrary(
        AvSetMmThreadCharacteristicsW=handle, AvSetMmThreadPriority=1, AvRevertMmThreadCharacteristics=1
    )
    assert realtime_windows.obtain(library) == (words, int(bool(handle)))
    assert library.AvSetMmThreadCharacteristicsW.calls[0][0] == "Pro Audio"
    assert library.AvSetMmThreadPriority.calls == ([(handle, 2)] if handle else [])
    realtime_windows.release(library)
    assert library.AvRevertMmThreadCharacteristics.calls == ([(handle,)] if handle else [])


@linux_only
def test_other_systems_demote_through_their_documented_calls():
    calls = []
    u64, u32, i32 = ctypes.c_uint64, ctypes.c_uint32, ctypes.c_int32

    def fake(result, *arguments, returns):
        def record(*given):
            calls.append(given)
            return returns

        return ctypes.CFUNCTYPE(result, *arguments)(record)

    library = FakeLibrary()
    library.pthread_mach_thread_np = fake(u32, u64, returns=42)
    library.thread_policy_set = fake(i32, u32, i32, u64, u32, returns=0)
    library.GetCurrentThread = fake(u64, returns=2**64 - 2)
    library.SetThreadPriority = fake(i32, u64, i32, returns=1)
    clib.add_symbols(library, vars(library))
    realtime_macos.demote()
    assert calls[1][:2] == (42, 1)
    assert calls[1][3] == 0
    calls.clear()
    realtime_windows.demote()
    assert calls == [(), (2**64 - 2, 0)]


def test_a_demoted_thread_is_said():
    if not priority.probe().realtime:
        pytest.skip("no real-time priority here")
    said = []

    def work():
        obtained = priority.obtain()
        said.append(priority.held(obtained, threading.get_native_id()))
        priority.demote()
        said.append(priority.held(obtained, threading.get_native_id()))
        priority.release()

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert said[0].realtime
    assert not said[1].realtime
    assert "demoted" in said[1].text
