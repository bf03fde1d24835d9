#!/usr/bin/env python3
"""`relnav montecarlo` as a user meets it, with a stand-in for the runs: killed and resumed, as a Slurm array job on a Slurm of
our own, with GNU parallel. The summary has the same bytes each time.

    tests/system/montecarlo_campaign.py RELNAV [CASE...]        Packages: slurm-wlm, munge (and root), parallel
"""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]
STAND_IN = SOURCE / "tests/support/sim_stand_in.sh"
MONTECARLO = SOURCE / "hil/montecarlo"
REDUCED = ("summary.json", "report.html", "failures.csv")
RUNS = 1200  # one packed thousand and a rest


class Skipped(Exception):
    pass


class Case:
    def __init__(self, relnav, folder):
        self.folder = folder
        self.scenario = folder / "spin.yaml"
        self.scenario.write_text("name: spin\ncrash 17 1100\nlost 40 41\nsilent 1003\n")
        self.other = folder / "other.yaml"
        tools = folder / "bin"
        tools.mkdir()
        # The scripts call `relnav`; the runs are the stand-in's.
        self.relnav = tools / "relnav"
        self.relnav.write_text(f'#!/bin/sh\nexec "{relnav}" "$@" --program "{STAND_IN}"\n')
        self.relnav.chmod(0o755)
        self.environment = dict(os.environ, PATH=f"{tools}:{os.environ['PATH']}")

    def command(self, out, runs=RUNS, jobs=2, scenario=None):
        return [self.relnav, "montecarlo", "--scenario", scenario or self.scenario, "--runs", str(runs), "--jobs", str(jobs),
                "--out", self.folder / out]

    def run(self, command, status, **options):
        done = subprocess.run([str(c) for c in command], env=self.environment, capture_output=True, text=True, timeout=200,
                              **options)
        assert done.returncode == status, f"{command}: exit status {done.returncode}, {done.stdout}{done.stderr}"
        return done

    def reduced(self, out):
        return {name: (self.folder / out / name).read_bytes() for name in REDUCED}

    def local(self):
        """The summary that all others must be like. Errors are among the runs: exit status 1."""
        if not (self.folder / "local").exists():
            self.run(self.command("local"), 1)
        return self.reduced("local")

    def check_same(self, out, wanted):
        for name, content in self.reduced(out).items():
            assert content == wanted[name], f"{out}/{name} is not that of the local run"


def one_and_two_jobs(case):
    wanted = case.local()
    case.run(case.command("one", jobs=1), 1)
    case.check_same("one", wanted)
    assert (case.folder / "one/runs/0.jsonl").is_file() and not (case.folder / "one/runs/0").exists()
    rows = wanted["failures.csv"].decode().splitlines()
    assert [r.split(",")[0] for r in rows[1:]] == ["17", "40", "41", "1003", "1100"], rows


def killed_and_resumed(case):
    wanted = case.local()
    kills = 0
    for after in [0.05, 0.2, 0.6, 1.0] * 15:
        campaign = subprocess.Popen([str(c) for c in case.command("killed")], env=case.environment,
                                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            campaign.wait(after)
            break
        except subprocess.TimeoutExpired:
            campaign.kill()
            campaign.wait()
            kills += 1
    assert kills >= 3, f"only {kills} kills met a campaign at work"
    case.run(case.command("killed"), 1)
    case.check_same("killed", wanted)


def interrupted(case):
    case.other.write_text("name: spin\nhang 30\n")
    campaign = subprocess.Popen([str(c) for c in case.command("stopped", runs=40, scenario=case.other)], env=case.environment,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    results = case.folder / "stopped/runs/0"
    until = time.monotonic() + 60
    while len(list(results.glob("*.json"))) < 39 and time.monotonic() < until:
        time.sleep(0.05)
    hanging = running_stand_ins(case.folder)
    assert hanging, "nothing is running"
    campaign.send_signal(signal.SIGINT)
    _, said = campaign.communicate(timeout=20)
    assert campaign.returncode == 1 and said.count("\n") == 1 and "interrupted with 1 runs to do" in said, said
    assert not running_stand_ins(case.folder), "a run was left behind"
    assert len(list(results.glob("*.json"))) == 39 and not (case.folder / "stopped/summary.json").exists()
    # Killed, it takes its runs along.
    campaign = subprocess.Popen([str(c) for c in case.command("stopped", runs=40, scenario=case.other)], env=case.environment,
                                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while not running_stand_ins(case.folder) and time.monotonic() < until:
        time.sleep(0.05)
    campaign.kill()
    campaign.wait()
    until = time.monotonic() + 10
    while running_stand_ins(case.folder) and time.monotonic() < until:
        time.sleep(0.05)
    assert not running_stand_ins(case.folder), "a run outlived the campaign"


def running_stand_ins(folder):
    """Processes of runs in this folder."""
    found = []
    for entry in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = entry.read_bytes().split(b"\0")
        except OSError:
            continue
        if str(STAND_IN).encode() in words and any(str(folder).encode() in w for w in words):
            found.append(entry.parent.name)
    return found


def refused(case):
    def check(arguments, piece):
        done = case.run([case.relnav, "montecarlo", *arguments], 2)
        assert piece in done.stderr and done.stderr.count("\n") == 1, done.stderr

    case.other.write_text("name: spin\n")
    scenario, out = ["--scenario", case.other], ["--out", case.folder / "r"]
    check([*scenario, *out, "--runs", "0"], "--runs: Value 0 not in range")
    check([*scenario, *out], "--runs is required")
    check([*out, "--runs", "3"], "--scenario is required")
    check([*out, "--merge"], "holds no campaign")
    check(["--scenario", case.folder / "nowhere.yaml", *out, "--runs", "3"], "nowhere.yaml: cannot be opened")
    check([*scenario, *out, "--runs", "3", "--first", "1"], "--first requires --count")
    check([*scenario, *out, "--runs", "3", "--time-limit", "0"], "expected a positive number of seconds")
    case.run([case.relnav, "montecarlo", *scenario, *out, "--runs", "3"], 0)
    check([*scenario, *out, "--runs", "2"], "holds a campaign of 3 runs")
    check([*scenario, *out, "--runs", "3", "--first", "3", "--count", "1"], "there is no run 3")
    (case.folder / "mine").mkdir()
    (case.folder / "mine/notes.txt").write_text("mine")
    check([*scenario, "--out", case.folder / "mine", "--runs", "3"], "is not empty and holds no campaign")
    case.other.write_text("name: spin\nlost 1\n")
    check([*scenario, *out, "--runs", "3"], "holds another campaign")
    case.other.write_text("name: spin\nunusable 1\n")
    check([*scenario, "--out", case.folder / "u", "--runs", "3"], "run 1: " + str(case.other) + ":7: the inertia is negative")


def gnu_parallel(case):
    if not shutil.which("parallel"):
        raise Skipped("GNU parallel is not installed (apt-get install parallel)")
    wanted = case.local()
    case.run([MONTECARLO / "relnav.parallel", case.scenario, RUNS, case.folder / "it's parallel", 200, "-j2"], 1)
    case.check_same("it's parallel", wanted)


class Slurm:
    """One node, everything in a folder of its own, on ports that are free."""
    def __init__(self, folder):
        self.folder = folder
        self.processes = []
        for name in ("state", "spool", "log"):
            (folder / name).mkdir(parents=True)
        ports = []
        for _ in range(2):
            s = socket.socket()
            s.bind(("127.0.0.1", 0))
            ports.append((s, s.getsockname()[1]))
        for s, _ in ports:
            s.close()
        conf = folder / "slurm.conf"
        conf.write_text(f"""ClusterName=relnav
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort={ports[0][1]}
SlurmdPort={ports[1][1]}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.sock
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
NodeName=localhost NodeAddr=127.0.0.1 CPUs=2 RealMemory=500 State=UNKNOWN
PartitionName=mc Nodes=localhost Default=YES MaxTime=INFINITE State=UP
""")
        self.environment = {"SLURM_CONF": str(conf)}

    def __enter__(self):
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        try:
            self.start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={self.folder}/munge.sock",
                       f"--pid-file={self.folder}/munged.pid", f"--seed-file={self.folder}/munge.seed",
                       f"--log-file={self.folder}/log/munge")
            self.wait_for(lambda: (self.folder / "munge.sock").exists(), "munged")
            self.start("slurmctld", "-D", "-c", "-L", f"{self.folder}/log/slurmctld")
            self.start("slurmd", "-D", "-N", "localhost", "-L", f"{self.folder}/log/slurmd")
            self.wait_for(lambda: b"idle" in self.ask("sinfo"), "a node that is idle")
        except BaseException:
            self.__exit__()
            raise
        return self

    def start(self, name, *arguments):
        log = open(self.folder / "log" / f"{name}.out", "wb")
        environment = dict(os.environ, **self.environment)
        self.processes.append(subprocess.Popen([name, *arguments], env=environment, stdout=log, stderr=log))

    def ask(self, *command):
        return subprocess.run(command, env=dict(os.environ, **self.environment), capture_output=True, timeout=20).stdout

    def wait_for(self, condition, what):
        until = time.monotonic() + 30
        while not condition():
            if time.monotonic() > until:
                logs = "".join(f"{p.name}: {p.read_text(errors='replace')[-800:]}\n" for p in (self.folder / "log").iterdir())
                raise AssertionError(f"Slurm: {what} did not come\n{logs}")
            time.sleep(0.2)

    def __exit__(self, *_):
        for process in reversed(self.processes):
            process.terminate()
            try:
                process.wait(15)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def slurm_array(case):
    missing = [name for name in ("munged", "slurmctld", "slurmd", "sbatch") if not shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin")]
    if missing:
        raise Skipped(f"{', '.join(missing)} not installed (apt-get install slurm-wlm munge)")
    if os.geteuid() != 0:
        raise Skipped("a Slurm of our own needs root")
    os.environ["PATH"] += ":/usr/sbin"
    wanted = case.local()
    with Slurm(case.folder / "slurm") as slurm:
        case.environment.update(slurm.environment)
        out = case.folder / "array"
        job = ["sbatch", "--wait", "--mem=100", f"--output={case.folder}/%A_%a.txt"]
        script = [MONTECARLO / "relnav.sbatch", case.scenario, RUNS, out, 200]
        case.run([*job, "--array=0-2", *script], 0)
        case.run([case.relnav, "montecarlo", "--merge", "--out", out], 1)
        assert b'"missing": 600' in (out / "summary.json").read_bytes()
        case.run([*job, "--array=2-5", *script], 0)  # one of them is done already
        case.run([case.relnav, "montecarlo", "--merge", "--out", out], 1)
    case.check_same("array", wanted)
    tasks = sorted(p.name.split("_")[1] for p in case.folder.glob("*_*.txt"))
    assert tasks == ["0.txt", "1.txt", "2.txt", "2.txt", "3.txt", "4.txt", "5.txt"], tasks


CASES = [one_and_two_jobs, killed_and_resumed, interrupted, refused, gnu_parallel, slurm_array]


def main():
    relnav = pathlib.Path(sys.argv[1]).resolve()
    failed = 0
    folder = pathlib.Path(tempfile.mkdtemp(prefix="relnav_campaign_"))
    try:
        case = Case(relnav, folder)
        for test in [c for c in CASES if not sys.argv[2:] or c.__name__ in sys.argv[2:]]:
            start = time.monotonic()
            try:
                test(case)
                said = "passed"
            except Skipped as why:
                said = f"SKIPPED: {why}"
            except (AssertionError, subprocess.TimeoutExpired) as why:
                said = f"FAILED: {why}"
                failed += 1
            print(f"{test.__name__}: {said} ({time.monotonic() - start:.1f} s)", flush=True)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
