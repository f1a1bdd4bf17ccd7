"""A PostgreSQL server of a test's own: a cluster made by initdb in a temporary folder, on a unix socket, with fsync on. The
folder lies in memory where there is room: tests crash the server and not the machine, so nothing they see is different.

usage: postgres_server.py COMMAND...   runs the command with SKYQUILT_TEST_POSTGRES set to the server's URL, and answers
its exit code; 77, which ctest shows as skipped, where PostgreSQL is not installed.

initdb refuses root: then the server runs as postgres, or as nobody where there is no such user."""
import contextlib
import glob
import os
import pathlib
import pwd
import shutil
import signal
import subprocess
import sys
import tempfile
import time


# What is not written before it is confirmed is lost by a crash of the next ten seconds, and a test sees it.
LATE_WRITER = "wal_writer_delay=10s"


def find_binaries():
    """The newest installed version's folder; None where there is none."""
    initdb = shutil.which("initdb")
    found = sorted(glob.glob("/usr/lib/postgresql/*/bin/initdb"), key=lambda path: float(path.split("/")[4]))
    return pathlib.Path(found[-1] if found else initdb).parent if found or initdb else None


def folder_for_clusters():
    """With a short path: a socket's has room for 107 bytes."""
    memory = pathlib.Path("/dev/shm")
    has_room = memory.is_dir() and os.access(memory, os.W_OK) and shutil.disk_usage(memory).free >= 2 << 30
    return memory if has_room else pathlib.Path("/tmp")


class PostgresServer:
    def __init__(self, *settings):
        """`settings`: words such as "max_connections=50"."""
        self.binaries = find_binaries()
        if self.binaries is None:
            raise FileNotFoundError("PostgreSQL is not installed (package postgresql)")
        self.settings = settings
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_pg_", dir=folder_for_clusters()))
        self.user = None
        if os.geteuid() == 0:
            names = [user.pw_name for user in pwd.getpwall()]
            self.user = "postgres" if "postgres" in names else "nobody"
            shutil.chown(self.folder, self.user)
        self.folder.chmod(0o755)
        self._run("initdb", "-D", str(self.folder / "data"), "-U", "skyquilt", "-A", "trust", "-E", "UTF8", "--no-locale")
        self.process = None
        self.start()
        self._run("createdb", "-h", str(self.folder), "-U", "skyquilt", "skyquilt")

    @property
    def url(self):
        return f"postgresql://skyquilt@/skyquilt?host={self.folder}"

    def _words(self, program, *arguments):
        return [str(self.binaries / program), *arguments]

    def _run(self, program, *arguments):
        done = subprocess.run(self._words(program, *arguments), user=self.user, cwd="/", stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"{program} failed: {done.stdout}")

    def start(self):
        words = ["-D", str(self.folder / "data"), "-k", str(self.folder), "-h", "", "-c", "fsync=on",
                 "-c", "max_connections=200"]
        for setting in self.settings:
            words += ["-c", setting]
        self.log = open(self.folder / "log", "a")
        self.process = subprocess.Popen(self._words("postgres", *words), user=self.user, cwd="/", stdout=self.log,
                                        stderr=subprocess.STDOUT)
        end = time.monotonic() + 120
        while subprocess.run(self._words("pg_isready", "-q", "-h", str(self.folder), "-U", "skyquilt", "-d", "postgres"),
                             cwd="/", stderr=subprocess.DEVNULL).returncode != 0:
            if self.process.poll() is not None or time.monotonic() > end:
                raise RuntimeError("postgres did not start: " + (self.folder / "log").read_text()[-2000:])
            time.sleep(0.05)

    def stop(self, how=signal.SIGINT):
        """SIGINT: "fast", connections are cut. SIGQUIT: as a crash."""
        if self.process is None:
            return
        self.process.send_signal(how)
        self.process.wait(timeout=120)
        self.process = None
        self.log.close()

    def signal_all(self, number):
        """To the server and all of its processes: SIGSTOP freezes it, SIGCONT lets it go on."""
        children = pathlib.Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        for pid in (self.process.pid, *map(int, children)):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, number)

    def query(self, sql, schema="public"):
        """The answer of psql, a line a row."""
        done = subprocess.run(self._words("psql", "-X", "-q", "-A", "-t", "-h", str(self.folder), "-U", "skyquilt", "-d",
                                          "skyquilt", "-c", f'SET search_path TO "{schema}"', "-c", sql),
                              cwd="/", stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=True)
        return done.stdout.strip()

    def close(self):
        self.stop()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def server_for(test_class, *settings):
    """A server for as long as the class."""
    server = PostgresServer(*settings)
    test_class.addClassCleanup(server.close)
    return server


def main():
    if find_binaries() is None:
        print("skipped: PostgreSQL is not installed (package postgresql)")
        return 77
    with PostgresServer(LATE_WRITER) as server:
        return subprocess.run(sys.argv[1:], env={**os.environ, "SKYQUILT_TEST_POSTGRES": server.url}).returncode


if __name__ == "__main__":
    sys.exit(main())
