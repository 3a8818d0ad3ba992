"""The priority of the loop's thread on each operating system: request, description, and loss if it hangs."""

import ctypes
import os
import shutil
import subprocess
import sys
import threading
from unittest.mock import Mock, call

import pytest
from numba import njit

from hapkit_studio.haptics import clock, priority
from tests.haptics.support import FakeLibrary
from tests.waiting import PATIENCE

linux_only = pytest.mark.skipif(sys.platform != "linux", reason="the Linux side")
if sys.platform == "linux":
    import resource

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
    """Run a function in a separate thread; return its result."""
    found = []
    thread = threading.Thread(target=lambda: found.append(function()))
    thread.start()
    thread.join()
    return found[0]


def in_process(code, *prefix, **environment):
    """Run code in a separate process, because lowered limits stay lowered; return its output."""
    command = [*prefix, sys.executable, "-c", code]
    done = subprocess.run(
        command, env=os.environ | environment, capture_output=True, text=True, timeout=PATIENCE
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@linux_only
def test_the_description_agrees_with_the_kernel_and_everything_is_restored(tmp_path, monkeypatch):
    """Policy, level, timer slack and the processors' sleep limit are changed only until the release."""
    device, get_slack = tmp_path / "latency", 30
    monkeypatch.setattr(realtime_linux, "_WAKE_LATENCY", device)

    def run():
        slack = [ctypes.CDLL(None).prctl(get_slack, 0, 0, 0, 0)]
        obtained = priority.obtain()
        slack.append(ctypes.CDLL(None).prctl(get_slack, 0, 0, 0, 0))
        policy = os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK
        level, file = os.sched_getparam(0).sched_priority, realtime_linux._thread_data.file
        assert not file.closed
        priority.release()
        assert file.closed
        slack.append(ctypes.CDLL(None).prctl(get_slack, 0, 0, 0, 0))
        return obtained, policy, level, os.sched_getscheduler(0), slack

    obtained, policy, level, after, slack = in_thread(run)
    assert obtained.realtime == (policy in (os.SCHED_FIFO, os.SCHED_RR))
    assert obtained.level == level
    assert (str(level) in obtained.text) == obtained.realtime
    assert bool(obtained.how) == (level < 80)
    assert after & ~os.SCHED_RESET_ON_FORK == os.SCHED_OTHER
    assert slack[2] == slack[0]
    assert slack[1] in (0, 1)  # the kernel ignores the timer slack of real-time threads; it may report 0
    assert device.read_bytes() == bytes(4)
    monkeypatch.setattr(realtime_linux, "_WAKE_LATENCY", tmp_path / "no" / "such")
    assert in_thread(realtime_linux.keep_processors_awake) is False


@pytest.mark.slow
@linux_only
@pytest.mark.skipif(shutil.which("setpriv") is None, reason="needs setpriv of util-linux")
def test_without_permission_the_description_tells_how_to_get_a_higher_priority(tmp_path):
    code = (
        "from hapkit_studio.haptics import priority as p; x = p.probe();"
        "print(x.text, x.realtime, x.level, 'rtprio 80' in x.how, 'limits.d' in p.report(), sep='|')"
    )
    prefix = UNPRIVILEGED if os.geteuid() == 0 else []
    text = in_process(code, *prefix, PATH=f"{tmp_path}:{os.environ['PATH']}")
    allowed = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    if allowed == 0 and not shutil.which("rtkit"):
        assert text in ("Normal priority|False|0|True|True", "Raised priority (nice -11)|False|0|True|True")


@pytest.mark.slow
@linux_only
@pytest.mark.skipif(os.geteuid() != 0, reason="the fake service needs the right to grant")
@pytest.mark.parametrize("granted", [True, False])
def test_realtime_kit_is_requested_within_its_limits(tmp_path, granted):
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
    assert obtained == ["('Real-time priority (level 20 of 99)', 20)" if granted else "None"]
    assert [line.split()[3:5] for line in limits] == [["100000", "200000"]]


@linux_only
@pytest.mark.skipif(os.geteuid() != 0, reason="needs the right to real-time priority")
def test_a_thread_that_never_blocks_is_demoted_without_python():
    @njit(nogil=True)
    def spin(seconds):
        end = clock.now() + seconds
        while clock.now() < end:
            pass

    spin(0.0)
    before = realtime_linux._table[0]

    def run():
        assert realtime_linux._take_fifo(threading.get_native_id())
        spin(0.5)
        scheduler = os.sched_getscheduler(0)
        priority.release()
        return scheduler

    assert in_thread(run) & ~os.SCHED_RESET_ON_FORK == os.SCHED_OTHER
    assert realtime_linux._table[0] == before + 1


@pytest.mark.parametrize(("status", "text"), [(0, "Real-time priority"), (4, "Normal priority")])
def test_macos_requests_the_time_constraint_policy(status, text):
    def fill(reference):
        reference._obj[0], reference._obj[1] = 125, 3

    library = Mock()
    library.mach_timebase_info.side_effect = fill
    library.thread_policy_set.return_value = status
    library.pthread_mach_thread_np.return_value = 42
    assert priority.macos_obtain(library) == (text, int(status == 0))
    thread, flavor, policy, count = library.thread_policy_set.call_args.args
    assert (thread, flavor, count) == (42, 2, 4)
    assert list(policy) == [24_000, 4_800, 12_000, 1]
    priority.macos_release(library)
    assert library.thread_policy_set.call_args.args[:2] == (42, 1)


@pytest.mark.parametrize(("handle", "text"), [(0x5, "Real-time priority"), (0, "Normal priority")])
def test_windows_joins_the_pro_audio_task(handle, text):
    library = Mock()
    library.AvSetMmThreadCharacteristicsW.return_value = handle
    assert priority.windows_obtain(library) == (text, int(bool(handle)))
    assert library.AvSetMmThreadCharacteristicsW.call_args.args[0] == "Pro Audio"
    assert library.AvSetMmThreadPriority.call_args_list == ([call(handle, 2)] if handle else [])
    priority.windows_release(library)
    assert library.AvRevertMmThreadCharacteristics.call_args_list == ([call(handle)] if handle else [])


@linux_only
def test_other_systems_demote_by_their_documented_calls():
    """The table has an entry for each system; the entries of other systems cannot be loaded here."""
    fake, u64, u32, i32 = FakeLibrary(), ctypes.c_uint64, ctypes.c_uint32, ctypes.c_int32
    fake.add("pthread_mach_thread_np", u32, u64)(lambda thread: 42)
    fake.add("thread_policy_set", i32, u32, i32, u64, u32)(lambda *given: 0)
    fake.add("GetCurrentThread", u64)(lambda: 2**64 - 2)
    fake.add("SetThreadPriority", i32, u64, i32)(lambda *given: 1)
    priority.SYSTEMS["darwin"].demote()
    assert fake.calls[1][:3] == ("thread_policy_set", 42, 1)
    assert fake.calls[1][4] == 0
    fake.calls.clear()
    priority.SYSTEMS["win32"].demote()
    assert fake.calls == [("GetCurrentThread",), ("SetThreadPriority", 2**64 - 2, 0)]


def test_a_demoted_thread_is_reported():
    if not priority.probe().realtime:
        pytest.skip("no real-time priority here")

    def run():
        obtained = priority.obtain()
        texts = [priority.current(obtained, threading.get_native_id())]
        priority.demote()
        texts.append(priority.current(obtained, threading.get_native_id()))
        priority.release()
        return texts

    before, after = in_thread(run)
    assert before.realtime
    assert not after.realtime
    assert "lowered" in after.text
