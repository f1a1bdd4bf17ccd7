"""The Debian package of the build tree, made once per test program."""
import functools
import os
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("SKYQUILT_BUILD", ROOT / "build/release"))
WHY_NOT = None if (BUILD / "CPackConfig.cmake").exists() else f"{BUILD} was not configured to make packages"
SCRATCH = tempfile.TemporaryDirectory()


@functools.cache
def built_package():
    done = subprocess.run(["cpack", "-G", "DEB", "--config", BUILD / "CPackConfig.cmake", "-B", SCRATCH.name],
                          cwd=BUILD, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    (package,) = pathlib.Path(SCRATCH.name).glob("skyquilt_*.deb")
    return package


def run(*command, **more):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **more)
    assert done.returncode == 0, (command, done.stdout, done.stderr)
    return done.stdout
