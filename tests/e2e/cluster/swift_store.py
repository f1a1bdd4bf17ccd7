"""OpenStack Swift with its S3 interface on this machine: one proxy, account, container and object server each, one copy of
everything, in a temporary folder on free ports, with one empty bucket. Needs Debian's swift-proxy, swift-account, swift-container,
swift-object and memcached.
A process has a mount of its own, since Swift looks for its hash in /etc alone: it wants root."""
import io
import os
import pathlib
import pwd
import shutil
import socket
import subprocess
import tempfile
import time
import urllib.parse
import urllib.request

BUCKET = "skyquilt-test"
ACCESS, SECRET = "test:tester", "testing"
PROGRAMS = ("swift-proxy-server", "swift-account-server", "swift-container-server", "swift-object-server", "swift-ring-builder",
            "memcached")
PATIENCE_S = 180
PROXY = """
[DEFAULT]
bind_ip = 127.0.0.1
bind_port = {port}
workers = 2
user = {user}
swift_dir = {folder}
log_address = {folder}/no-log
[pipeline:main]
pipeline = catch_errors cache listing_formats bulk s3api tempauth copy slo dlo proxy-server
[app:proxy-server]
use = egg:swift#proxy
allow_account_management = true
account_autocreate = true
[filter:tempauth]
use = egg:swift#tempauth
user_test_tester = {secret} .admin
[filter:s3api]
use = egg:swift#s3api
location = us-east-1
[filter:cache]
use = egg:swift#memcache
memcache_servers = 127.0.0.1:{memcache}
[filter:catch_errors]
use = egg:swift#catch_errors
[filter:listing_formats]
use = egg:swift#listing_formats
[filter:bulk]
use = egg:swift#bulk
[filter:slo]
use = egg:swift#slo
[filter:dlo]
use = egg:swift#dlo
[filter:copy]
use = egg:swift#copy
"""
PART = """
[DEFAULT]
bind_ip = 127.0.0.1
bind_port = {port}
workers = 1
user = {user}
swift_dir = {folder}
devices = {folder}/disks
mount_check = false
log_address = {folder}/no-log
[pipeline:main]
pipeline = {part}-server
[app:{part}-server]
use = egg:swift#{part}
"""


def missing_programs():
    return [name for name in PROGRAMS if shutil.which(name) is None]


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def ask(endpoint, method, query=""):
    """About the bucket, by Swift's own interface, for which any client will do."""
    asked = urllib.request.Request(f"{endpoint}/auth/v1.0", headers={"X-Auth-User": ACCESS, "X-Auth-Key": SECRET})
    with urllib.request.urlopen(asked, timeout=30) as answer:
        token, account = answer.headers["X-Auth-Token"], answer.headers["X-Storage-Url"]
    return urllib.request.urlopen(urllib.request.Request(f"{account}/{BUCKET}{query}", method=method, headers={"X-Auth-Token": token}),
                                  timeout=30)


class StoredObject:
    """What tests read of a file that is kept in the store."""

    def __init__(self, endpoint, key):
        self.endpoint, self.key = endpoint, key

    def read_bytes(self):
        with ask(self.endpoint, "GET", "/" + urllib.parse.quote(self.key)) as answer:
            return answer.read()

    def open(self, _):
        return io.BytesIO(self.read_bytes())


def objects_in(endpoint, prefix):
    with ask(endpoint, "GET", f"?prefix={urllib.parse.quote(prefix)}&limit=10000") as answer:
        return {key: StoredObject(endpoint, key) for key in answer.read().decode().split()}


class SwiftStore:
    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_swift_"))
        self.port, memcache, *parts = free_ports(5)
        self.endpoint = f"http://127.0.0.1:{self.port}"
        user = pwd.getpwuid(os.geteuid()).pw_name
        (self.folder / "disks/d1").mkdir(parents=True)
        (self.folder / "swift.conf").write_text("[swift-hash]\nswift_hash_path_suffix = skyquilt\nswift_hash_path_prefix = test\n"
                                                "[storage-policy:0]\nname = one\ndefault = yes\n")
        self.processes, self.log = [], open(self.folder / "log", "w")
        self._start("memcached", "-l", "127.0.0.1", "-p", str(memcache), "-u", user)
        for part, port in zip(("account", "container", "object"), parts):
            (self.folder / f"{part}.conf").write_text(PART.format(part=part, port=port, folder=self.folder, user=user))
            self._ring(part, "create", "4", "1", "1")
            self._ring(part, "add", f"r1z1-127.0.0.1:{port}/d1", "1")
            self._ring(part, "rebalance")
            self._start_swift(part)
        (self.folder / "proxy.conf").write_text(PROXY.format(port=self.port, folder=self.folder, memcache=memcache, secret=SECRET,
                                                              user=user))
        self._start_swift("proxy")
        deadline = time.monotonic() + PATIENCE_S
        while not self._make_bucket():
            if time.monotonic() > deadline:
                said = (self.folder / "log").read_text()[-3000:]
                self.stop()
                raise RuntimeError(f"Swift did not start: {said}")
            time.sleep(0.5)

    def _ring(self, part, *words):
        subprocess.run(["swift-ring-builder", str(self.folder / f"{part}.builder"), *words], check=True, stdout=self.log)

    def _start(self, *words):
        self.processes.append(subprocess.Popen(words, stdout=self.log, stderr=self.log, start_new_session=True))

    def _start_swift(self, part):
        self._start("unshare", "-m", "sh", "-c", f'mount --bind {self.folder}/swift.conf /etc/swift/swift.conf && exec "$@"', "sh",
                    f"swift-{part}-server", str(self.folder / f"{part}.conf"), "-v")

    def _make_bucket(self):
        try:
            with ask(self.endpoint, "PUT") as answer:
                return answer.status in (201, 202)
        except OSError:  # not yet
            return False

    def environment(self):
        return {"AWS_ENDPOINT_URL": self.endpoint, "AWS_ACCESS_KEY_ID": ACCESS, "AWS_SECRET_ACCESS_KEY": SECRET,
                "AWS_REGION": "us-east-1", "AWS_EC2_METADATA_DISABLED": "true"}

    def address(self, prefix=""):
        return f"s3://{BUCKET}/{prefix}"

    def stop(self):
        for process in reversed(self.processes):
            process.kill()
            process.wait()
        self.log.close()
        shutil.rmtree(self.folder, ignore_errors=True)
