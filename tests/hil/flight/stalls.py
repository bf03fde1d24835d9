"""When the machine itself stood still: one process on each core, of the highest real-time priority, wakes every millisecond and
notes when it woke late. Nothing that runs in the machine can hold it up, so what it notes is the hypervisor's or the kernel's."""
import bisect
import os
import signal
import subprocess
import sys
import time

PERIOD_NS = 1_000_000
LATE_NS = 1_000_000
PRIORITY = 90


def witness(cpu):
    """Until SIGTERM; then the stalls as lines "begin end" (ns, CLOCK_MONOTONIC)."""
    os.sched_setaffinity(0, {cpu})
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    ended = []
    signal.signal(signal.SIGTERM, lambda *_: ended.append(True))
    print("ready", flush=True)
    seen = []
    due = time.monotonic_ns() + PERIOD_NS
    while not ended:
        time.sleep(max(0, due - time.monotonic_ns()) / 1e9)
        now = time.monotonic_ns()
        if now - due > LATE_NS:
            seen.append((due, now))
        due = max(due + PERIOD_NS, now)
    for begin, end in seen:
        print(begin, end)


class Witnesses:
    """One on each core for the length of a `with`; without the right to real-time priority none is `running`."""

    def __init__(self):
        self.processes = []
        self.running = os.geteuid() == 0
        self.stalls = []

    def __enter__(self):
        if self.running:
            self.processes = [subprocess.Popen([sys.executable, __file__, str(cpu)], stdout=subprocess.PIPE, text=True)
                              for cpu in sorted(os.sched_getaffinity(0))]
            self.running = all(p.stdout.readline() == "ready\n" for p in self.processes)
        return self

    def __exit__(self, *_):
        for process in self.processes:
            process.terminate()
            lines = process.communicate()[0].splitlines()
            self.stalls += [tuple(int(word) for word in line.split()) for line in lines]
        self.stalls.sort()

    def any_between(self, begin_ns, end_ns):
        """Whether any core stood still in this time."""
        first_after = bisect.bisect_left(self.stalls, (end_ns,))
        # Cores stall side by side: those that began shortly before may still last.
        return any(end >= begin_ns for _, end in self.stalls[max(0, first_after - 50):first_after])


if __name__ == "__main__":
    witness(int(sys.argv[1]))
