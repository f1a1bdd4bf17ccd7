"""A store of objects for tests: s3rver from npm, on a free port of this machine, with one empty bucket. Run as a
program it prints its endpoint, or why there is none, and ends when its standard input does."""
import contextlib
import http.client
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import npm_clients

BUCKET = "skyquilt-test"
KEY = "S3RVER"  # the only pair that it knows
PATIENCE_S = 60
LISTS = "--openssl-legacy-provider"  # it makes the tokens of its pages with an old cipher


def files_below(folder):
    """All files, in order; folders that go meanwhile are passed over."""
    return sorted(pathlib.Path(where, name) for where, _, names in os.walk(folder) for name in names)


def objects_in(bucket):
    """The files in which the store keeps its objects, by their keys, in order."""
    ending = "._S3rver_object"
    return {str(path.relative_to(bucket)).removesuffix(ending): path for path in files_below(bucket) if path.name.endswith(ending)}


class NoStore(Exception):
    """There is no store here, and why."""


class S3Store:
    def __init__(self):
        modules = npm_clients.installed_clients()
        program = modules and modules / "node_modules" / "s3rver" / "bin" / "s3rver.js"
        if not shutil.which("node") or not program or not program.exists():
            raise NoStore("s3rver is not installed: python3 tests/e2e/npm_clients.py build/release/test_clients")
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_s3_"))
        self.bucket = self.folder / "data" / BUCKET
        self.log = self.folder / "s3rver.log"
        with self.log.open("w") as log:
            self.process = subprocess.Popen(
                ["node", LISTS, program, "--directory", self.folder / "data", "--address", "127.0.0.1", "--port", "0",
                 "--configure-bucket", BUCKET], stdout=log, stderr=log)
        deadline = time.monotonic() + PATIENCE_S
        while not (port := re.search(r"listening on .*:(\d+)\s", self.log.read_text())):
            if self.process.poll() is not None or time.monotonic() > deadline:
                said = self.log.read_text()
                self.stop()
                raise NoStore(f"s3rver does not start: {said}")
            time.sleep(0.05)
        self.port = int(port.group(1))
        self.endpoint = f"http://127.0.0.1:{self.port}"

    def environment(self, endpoint=None):
        """What a program needs to use it."""
        return {"AWS_ENDPOINT_URL": endpoint or self.endpoint, "AWS_ACCESS_KEY_ID": KEY, "AWS_SECRET_ACCESS_KEY": KEY,
                "AWS_REGION": "us-east-1", "AWS_EC2_METADATA_DISABLED": "true"}

    def address(self, prefix=""):
        return f"s3://{BUCKET}/{prefix}"

    def keys(self, prefix=""):
        """What lies in the bucket, by the store's own files."""
        return [name for name in objects_in(self.bucket) if name.startswith(prefix)]

    def pause(self):
        self.process.send_signal(signal.SIGSTOP)

    def resume(self):
        self.process.send_signal(signal.SIGCONT)

    def is_up(self):
        with contextlib.suppress(OSError):
            connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=5)
            connection.request("GET", "/")
            return connection.getresponse().status > 0
        return False

    def stop(self):
        self.process.send_signal(signal.SIGCONT)
        self.process.kill()
        self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


def store_or_skip():
    """A store of a test class's own; the class is skipped where there can be none."""
    try:
        return S3Store()
    except NoStore as none:
        raise unittest.SkipTest(str(none)) from none


def store_for(test_class):
    """A store for as long as the class, in the environment of all that it starts."""
    store = store_or_skip()
    test_class.addClassCleanup(store.stop)
    before = dict(os.environ)

    def restore():
        os.environ.clear()
        os.environ.update(before)

    test_class.addClassCleanup(restore)
    os.environ.update(store.environment())
    return store


if __name__ == "__main__":
    try:
        store = S3Store()
    except NoStore as none:
        sys.exit(str(none))
    print(store.endpoint, flush=True)
    sys.stdin.read()
    store.stop()
    os._exit(0)
