"""Independent clients from npm that the server is held against. The build installs them (`python3 npm_clients.py FOLDER`); no
test downloads anything. `python3 npm_clients.py FOLDER --native` compiles what one of them wants compiled (SQLite, a minute),
for the long suite."""
import os
import pathlib
import shutil
import subprocess
import sys

CLIENTS = pathlib.Path(__file__).resolve().parent / "clients"
FOLDER = pathlib.Path(os.environ.get("SKYQUILT_TEST_CLIENTS", CLIENTS.parents[2] / "build/release/test_clients"))


def installed_clients():
    """The folder with the clients' modules, or None."""
    return FOLDER if (FOLDER / "installed").exists() else None


def script(folder, name):
    """A module finds its packages beside itself."""
    return shutil.copy(CLIENTS / name, folder)


def install(folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "installed").unlink(missing_ok=True)
    for name in ("package.json", "package-lock.json"):
        shutil.copy(CLIENTS / name, folder)
    try:
        subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"The clients from npm cannot be installed, tests that want them are skipped: {error}")
        return
    (folder / "installed").touch()


def compile_native(folder):
    try:
        subprocess.run(["npm", "rebuild", "sqlite3", "--loglevel=error"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"@mapbox/mbtiles cannot be compiled, its test is skipped: {error}")


if __name__ == "__main__":
    if "--native" in sys.argv[2:]:
        compile_native(pathlib.Path(sys.argv[1]))
    else:
        install(pathlib.Path(sys.argv[1]))
