"""Independent clients from npm, installed once for all tests that hold the server against them."""
import fcntl
import os
import pathlib
import shutil
import subprocess
import tempfile

CLIENTS = pathlib.Path(__file__).resolve().parent / "clients"


def install_clients():
    """The folder with the clients' modules, or None."""
    given = os.environ.get("SKYQUILT_TEST_CLIENTS")
    if given:
        return pathlib.Path(given)
    if not shutil.which("npm"):
        return None
    folder = pathlib.Path(tempfile.gettempdir(), f"skyquilt_test_clients_{os.getuid()}")
    folder.mkdir(exist_ok=True)
    wanted, installed = CLIENTS / "package-lock.json", folder / "installed.json"
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # tests run side by side
        if not installed.exists() or installed.read_text() != wanted.read_text():
            for name in ("package.json", "package-lock.json"):
                shutil.copy(CLIENTS / name, folder)
            done = subprocess.run(["npm", "ci", "--no-audit", "--no-fund"], cwd=folder, capture_output=True)
            if done.returncode != 0:
                return None
            shutil.copy(wanted, installed)
    return folder


def script(folder, name):
    """A module finds its packages beside itself."""
    return shutil.copy(CLIENTS / name, folder)
