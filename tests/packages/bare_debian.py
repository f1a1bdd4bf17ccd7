"""A bare Debian 12 below a folder, to install packages into: made by debootstrap, kept as an archive beside the packages that
were fetched (SKYQUILT_PACKAGE_CACHE, or a folder of root's alone among the temporary ones), thrown away after each test."""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time

from built_package import run

SUITE = "bookworm"
PATIENCE_S = 1200
# Runs a command in the system with processes, mounts and devices of its own; with "alone" as its first word also without
# any network but the loopback, so that every port is free.
ENTER = r"""
set -e
root=$1 net=$2; shift 2
if [ "$net" = alone ]; then ip link set lo up; fi
mount -t proc proc "$root/proc"
mount -t sysfs -o ro sysfs "$root/sys" 2>/dev/null || true
mount -t tmpfs tmpfs "$root/dev"
for device in null zero full random urandom tty; do : > "$root/dev/$device"; mount --bind "/dev/$device" "$root/dev/$device"; done
mkdir "$root/dev/pts" "$root/dev/shm"
ln -s /proc/self/fd "$root/dev/fd"
exec chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
"""

# Starts systemd there, in namespaces of its own.
BOOT = r"""
set -e
mount --bind "$1" "$1"
cd "$1"
mount -t proc proc proc
mount -t sysfs sysfs sys
mount -t cgroup2 cgroup2 sys/fs/cgroup
mount -t tmpfs -o mode=755 tmpfs dev
for device in null zero full random urandom tty; do : > "dev/$device"; mount --bind "/dev/$device" "dev/$device"; done
mkdir dev/pts dev/shm
mount -t devpts -o newinstance,ptmxmode=0666 devpts dev/pts
ln -s pts/ptmx dev/ptmx
ln -s /proc/self/fd dev/fd
mount -t tmpfs tmpfs dev/shm
mount -t tmpfs -o mode=755 tmpfs run
ip link set lo up
exec chroot . /usr/bin/env -i container=bare PATH=/usr/sbin:/usr/bin:/sbin:/bin /lib/systemd/systemd --log-level=err
"""
ENVIRONMENT = ["PATH=/usr/sbin:/usr/bin:/sbin:/bin", "HOME=/root", "LANG=C.UTF-8", "DEBIAN_FRONTEND=noninteractive"]


def why_not():
    """Why no bare system can be made here; None where it can."""
    if os.geteuid() != 0:
        return "making a bare Debian needs root"
    missing = [tool for tool in ("debootstrap", "unshare", "chroot", "ip", "curl", "cpack", "dpkg-deb") if not shutil.which(tool)]
    if missing:
        return f"{', '.join(missing)} not here"
    if subprocess.run(["unshare", "--mount", "--pid", "--net", "--fork", "true"], capture_output=True).returncode != 0:
        return "no namespaces may be made here"
    if mirror() is None:
        return f"this machine's apt has no source for {SUITE}"
    probe = subprocess.run(["curl", "-sSfL", "-o", "/dev/null", "-m", "30", f"{mirror()}/dists/{SUITE}/Release"], capture_output=True)
    return None if probe.returncode == 0 else f"{mirror()} does not answer"


def mirror():
    """Where this machine's apt gets the suite."""
    for source in [pathlib.Path("/etc/apt/sources.list"), *pathlib.Path("/etc/apt/sources.list.d").glob("*")]:
        text = source.read_text() if source.is_file() else ""
        line = re.search(rf"^deb (?:\[.*\] )?(http\S+) {SUITE} ", text, re.M)
        if line:
            return line[1].rstrip("/")
        for part in text.split("\n\n"):
            if re.search(rf"^Suites:.*\b{SUITE}(\s|$)", part, re.M):
                return re.search(r"^URIs: *(\S+)", part, re.M)[1].rstrip("/")
    return None


def cache():
    folder = pathlib.Path(os.environ.get("SKYQUILT_PACKAGE_CACHE", pathlib.Path(tempfile.gettempdir(), "skyquilt-package-cache")))
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if folder.is_symlink() or folder.stat().st_uid != 0:
        raise AssertionError(f"{folder} is not root's: remove it, or name another by SKYQUILT_PACKAGE_CACHE")
    return folder


class BareDebian:
    def __init__(self):
        self.scratch = tempfile.TemporaryDirectory(prefix="skyquilt-bare-")
        self.root = pathlib.Path(self.scratch.name, "root")
        self.root.mkdir()
        archive = cache() / f"{SUITE}.tar"
        if not archive.exists():
            made = pathlib.Path(self.scratch.name, "made")
            run("debootstrap", "--variant=minbase", SUITE, made, mirror())
            run("tar", "-C", made, "--one-file-system", "--exclude=./dev/*", "--exclude=./proc/*", "-cf", f"{archive}.new", ".")
            os.replace(f"{archive}.new", archive)
        run("tar", "-C", self.root, "-xf", archive)
        (self.root / "etc/apt/sources.list").write_text(f"deb {mirror()} {SUITE} main\n")
        shutil.copy("/etc/resolv.conf", self.root / "etc/resolv.conf")
        self.keep_packages()

    def keep_packages(self):
        archives = self.root / "var/cache/apt/archives"
        (cache() / "archives").mkdir(exist_ok=True)
        for package in (cache() / "archives").glob("*.deb"):
            if not (archives / package.name).exists():
                shutil.copy(package, archives)

    def run(self, *words, alone=False, check=True, **more):
        """stdout and stderr together of a command in the system."""
        enter = ["unshare", "--mount", "--propagation", "private", "--pid", "--fork", "--kill-child", *(["--net"] if alone else [])]
        done = subprocess.run([*enter, "sh", "-c", ENTER, "enter", str(self.root), "alone" if alone else "shared",
                               *(str(word) for word in words)],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=PATIENCE_S, **more)
        assert not check or done.returncode == 0, (words, done.stdout)
        return done.stdout

    def apt(self, *words):
        settings = ("APT::Install-Recommends=false", "Binary::apt-get::APT::Keep-Downloaded-Packages=true",
                    "Dpkg::Options::=--force-unsafe-io")  # a system that is thrown away need not reach the disk
        said = self.run("apt-get", *(word for setting in settings for word in ("-o", setting)), "-y", *words)
        for package in (self.root / "var/cache/apt/archives").glob("*.deb"):
            if not package.name.startswith("skyquilt_"):
                kept = cache() / "archives" / package.name
                if not kept.exists():
                    shutil.copy(package, kept)
        return said

    def end(self):
        self.scratch.cleanup()



class Booted:
    """A bare system whose systemd runs, without any network but the loopback. `.started` says whether it came up."""

    def __init__(self, system):
        self.outer = subprocess.Popen(
            ["unshare", "--mount", "--propagation", "private", "--pid", "--fork", "--kill-child", "--net", "--uts", "--ipc", "--cgroup",
             "sh", "-c", BOOT, "boot", str(system.root)], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.started = self.wait_until_up()

    def init(self):
        """The process that is the first of the system."""
        path = pathlib.Path(f"/proc/{self.outer.pid}/task/{self.outer.pid}/children")
        try:
            return int(path.read_text())
        except (OSError, ValueError):
            return None

    def wait_until_up(self):
        end = time.monotonic() + 90
        while time.monotonic() < end and self.outer.poll() is None:
            if self.init() is not None and self.run("systemctl", "is-system-running", check=False).strip() in ("running", "degraded"):
                return True
            time.sleep(0.5)
        return False

    def run(self, *words, check=True):
        inner = self.init()
        enter = ["nsenter", "-t", inner, "-m", "-p", "-n", "-u", "-i", "-C", f"--root=/proc/{inner}/root", f"--wd=/proc/{inner}/root/root"]
        done = subprocess.run([str(word) for word in [*enter, "/usr/bin/env", "-i", *ENVIRONMENT, *words]], stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=PATIENCE_S)
        assert not check or done.returncode == 0, (words, done.stdout)
        return done.stdout

    def end(self):
        inner = self.init()
        if inner is not None:
            os.kill(inner, signal.SIGKILL)  # and with it all processes of its namespace
        self.outer.wait(timeout=60)
