"""README's container, built and started by an engine, makes a map; the same file leaves the Debian package.

SKYQUILT_CONTAINER_ENGINE names another engine than docker or podman, with words that belong to it; SKYQUILT_CONTAINER_BUILD and
SKYQUILT_CONTAINER_RUN add words to its builds and runs (within a container, say, podman needs --isolation=chroot --network=host)."""
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import time
import unittest
import urllib.request

from flights import made_flights

ROOT = pathlib.Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text()
NAMED = [shlex.split(os.environ["SKYQUILT_CONTAINER_ENGINE"])] if "SKYQUILT_CONTAINER_ENGINE" in os.environ else [["docker"], ["podman"]]
ADDRESS = "http://127.0.0.1:8080"
PATIENCE_S = 300


def answers(engine):
    return shutil.which(engine[0]) and subprocess.run([*engine, "info"], capture_output=True).returncode == 0


def engine_here():
    return next((engine for engine in NAMED if answers(engine)), None)


def has(engine, image):
    """Whether the engine has an image, or gets it."""
    return any(subprocess.run([*engine, *words, image], capture_output=True).returncode == 0 for words in (["image", "inspect"], ["pull"]))


def words_of(line, variable, engine):
    """A line of README as this machine's engine takes it."""
    docker, command, *rest = shlex.split(line)
    assert docker == "docker", line
    return [*engine, command, *shlex.split(os.environ.get(variable, "")), *rest]


def asked(path, data=None):
    with urllib.request.urlopen(urllib.request.Request(ADDRESS + path, data, {"Content-Type": "application/json"} if data else {}), timeout=30) as response:
        return response.read()


@unittest.skipUnless(engine_here(), "no container engine answers here (docker, podman)")
class BuiltImage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.engine = engine_here()
        base = re.search(r"^FROM (\S+)$", (ROOT / "docker/Dockerfile").read_text(), re.M)[1]
        if not has(cls.engine, base):
            raise unittest.SkipTest(f"{cls.engine[0]} has no {base}, and no registry answers")
        build, run = re.search(r"^(docker build .* -t skyquilt \.)\n(docker run .* skyquilt)$", README, re.M).groups()
        cls.image = f"skyquilt-test-{os.getpid()}"  # that of whoever works here stays
        cls.run_line = re.sub(r"skyquilt$", cls.image, run)
        cls.execute(words_of(build.replace("-t skyquilt", f"-t {cls.image}"), "SKYQUILT_CONTAINER_BUILD", cls.engine))
        cls.addClassCleanup(subprocess.run, [*cls.engine, "rmi", "-f", cls.image], capture_output=True)

    @classmethod
    def execute(cls, words):
        done = subprocess.run(words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert done.returncode == 0, f"{words}\n{done.stdout[-4000:]}"
        return done.stdout

    def test_it_makes_a_map(self):
        volume, name = f"skyquilt-test-{os.getpid()}", f"skyquilt-test-{os.getpid()}"
        run = words_of(self.run_line.replace("skyquilt-data", volume), "SKYQUILT_CONTAINER_RUN", self.engine)
        run[len(self.engine) + 1:len(self.engine) + 1] = ["--name", name]
        log = tempfile.TemporaryFile("w+")
        container = subprocess.Popen(run, stdout=log, stderr=subprocess.STDOUT)
        self.addCleanup(log.close)
        self.addCleanup(subprocess.run, [*self.engine, "volume", "rm", "-f", volume], capture_output=True)
        self.addCleanup(container.wait)
        self.addCleanup(subprocess.run, [*self.engine, "rm", "-f", name], capture_output=True)
        end = time.monotonic() + PATIENCE_S
        while True:
            log.seek(0)
            self.assertIsNone(container.poll(), log.read())
            try:
                asked("/healthz")
                break
            except OSError:
                self.assertLess(time.monotonic(), end, "it does not answer")
                time.sleep(0.2)
        with tempfile.TemporaryDirectory() as card:
            shutil.copytree(made_flights.small_flight() / "photos", pathlib.Path(card, "DCIM", "100MEDIA"))
            curl = re.search(r"^photos=\(\);.*\ncurl -F name=beach .*flights$", README, re.M)[0]
            made = json.loads(subprocess.run(["bash", "-euo", "pipefail", "-c", curl], cwd=card, check=True, capture_output=True).stdout)
        flight = f"/api/v1/flights/{made['flight']['id']}"
        end = time.monotonic() + PATIENCE_S
        while json.loads(asked(flight))["state"] not in ("ready", "failed"):
            self.assertLess(time.monotonic(), end, "the map does not come")
            time.sleep(0.2)
        self.assertEqual(json.loads(asked(flight))["photos"]["aligned"], 6)
        self.assertIn(b"<html", asked("/"))
        # As the page offers it, so that the program that prints is there too.
        export = json.loads(asked(f"{flight}/exports", b'{"format":"report"}'))
        end = time.monotonic() + PATIENCE_S
        while (state := json.loads(asked(f"{flight}/exports/{export['id']}")))["state"] not in ("successful", "failed"):
            self.assertLess(time.monotonic(), end, "the report does not come")
            time.sleep(0.2)
        self.assertEqual(state["state"], "successful", state)
        self.assertTrue(asked(state["download"]).startswith(b"%PDF-"))

    def test_it_leaves_a_package(self):
        line = re.search(r"^(docker build .* --target deb -o )packages \.", README, re.M)[1]
        with tempfile.TemporaryDirectory() as folder:
            self.execute(words_of(f"{line}{folder} .", "SKYQUILT_CONTAINER_BUILD", self.engine))
            (package,) = pathlib.Path(folder).glob("skyquilt_*.deb")
            self.assertTrue(package.read_bytes().startswith(b"!<arch>"))
