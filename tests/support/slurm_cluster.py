"""Slurm on this machine, one node, as this user: munged, slurmctld and slurmd on a configuration of their own in a temporary
folder, on free ports. Needs Debian's slurmctld, slurmd, slurm-client and munge."""
import os
import pathlib
import shutil
import socket
import subprocess
import tempfile
import time

from nginx import free_port

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol", "squeue", "sinfo")
PATIENCE_S = 60


def missing_programs():
    return [name for name in PROGRAMS if shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin") is None]


class SlurmCluster:
    def __init__(self):
        # Short: a socket's path has room for 107 bytes.
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_slurm_", dir="/tmp"))
        self.folder.chmod(0o755)  # munged goes into no folder that others may write to
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        (self.folder / "key").write_bytes(os.urandom(128))
        (self.folder / "key").chmod(0o600)
        user, host = "root" if os.geteuid() == 0 else os.environ["USER"], socket.gethostname().split(".")[0]
        cpus = len(os.sched_getaffinity(0))
        (self.folder / "slurm.conf").write_text(f"""
ClusterName=skyquilt
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={self.folder}/munge.socket
StateSaveLocation={self.folder}/state
SlurmdSpoolDir={self.folder}/spool
SlurmctldPidFile={self.folder}/slurmctld.pid
SlurmdPidFile={self.folder}/slurmd.pid
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
""")
        self.environment = {**os.environ, "SLURM_CONF": f"{self.folder}/slurm.conf", "PATH": os.environ["PATH"] + ":/usr/sbin"}
        self.processes = []
        try:
            self._start("munged", "--foreground", "--force", f"--socket={self.folder}/munge.socket", f"--key-file={self.folder}/key",
                        f"--log-file={self.folder}/munged.log", f"--pid-file={self.folder}/munged.pid", f"--seed-file={self.folder}/seed")
            self._until(lambda: (self.folder / "munge.socket").exists(), "munged")
            self._start("slurmctld", "-D", "-i")
            self._start("slurmd", "-D")
            self._until(lambda: self.run("sinfo", "-h", "-o", "%T").strip() == "idle", "slurmctld and slurmd")
        except BaseException:
            self.stop()
            raise

    def _start(self, *words):
        with open(self.folder / "log", "a") as log:
            self.processes.append(subprocess.Popen(words, env=self.environment, stdout=log, stderr=log, start_new_session=True))

    def _until(self, has_come, who):
        deadline = time.monotonic() + PATIENCE_S
        while not has_come():
            if time.monotonic() > deadline:
                raise RuntimeError(f"{who} did not start: {(self.folder / 'log').read_text()[-2000:]}")
            time.sleep(0.2)

    def run(self, *words):
        """What a program of Slurm's says."""
        done = subprocess.run(words, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=PATIENCE_S)
        if done.returncode != 0 and words[0] != "sinfo":
            raise RuntimeError(f"{' '.join(map(str, words))}: {done.stderr}")
        return done.stdout

    def submit(self, *words):
        """The job's number."""
        return self.run("sbatch", "--parsable", f"--output={self.folder}/%A_%a.out", *words).strip()

    def ended(self, job):
        """The exit codes of a job's tasks, in order; None while any of them is not over."""
        tasks = [dict(word.split("=", 1) for word in line.split() if "=" in word)
                 for line in self.run("scontrol", "-o", "show", "job", job).splitlines()]
        if any(task["JobState"] in ("PENDING", "CONFIGURING", "RUNNING", "COMPLETING") for task in tasks):
            return None
        return sorted(int(task["ExitCode"].split(":")[0]) for task in tasks)

    def stop(self):
        for process in reversed(self.processes):
            process.terminate()
            try:
                process.wait(timeout=20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


def cluster_for(test_class):
    """A cluster for as long as the test class."""
    cluster = SlurmCluster()
    test_class.addClassCleanup(cluster.stop)
    return cluster
