"""One flight over three machines, catalogue in PostgreSQL and photos in S3, while both and the machines fail in every way and at
every stage of its job: the map has the bytes of one machine alone, is shown once, no attempt is counted but those of workers
that were taken, and a sweep leaves nothing of it all. In each run one answer of twenty of the store is a 500 or a 503.

    python3 tests/e2e/cluster/faults_test.py [--seeds 1-60] [--results faults.jsonl] [--only "restart of 45 s@place"]

Each seed has two of the kinds of fault_kinds.py, each at a stage; 38 seeds have every kind at every stage. Seeds go one after
the other on one database and one store; for several at a time start several programs. --results adds a line for each, of which
faults_table.py makes the table of docs/cluster.md."""
import argparse
import collections
import contextlib
import hashlib
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
import traceback

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
import s3_store
from cluster.fault_kinds import KINDS, OF_WORKERS, small_disk
from cluster.store_proxy import StoreProxy
from flights import made_flights
from postgres_server import LATE_WRITER, PostgresServer
from program import BINARY
from server_support import Server, children_of, kill_if_there, wait_until

PHOTOS, SIZE = 24, "400x300"
CUT = ("--cut-above", "10", "--part-files", "5")
MACHINES = 3
STAGES = ("look", "place", "render", "put together", "publish")
FAULTS_PER_SEED = 2
FAILS = 0.05  # of the store's answers
TWO_DAYS_S = 2 * 86400
# Units go with their job: what they cost is kept here.
KEEP_UNITS = """
CREATE TABLE ended_unit(job_id TEXT, kind TEXT, number BIGINT, attempts BIGINT);
CREATE FUNCTION keep_unit() RETURNS TRIGGER LANGUAGE plpgsql AS $$ BEGIN
  INSERT INTO ended_unit VALUES(OLD.job_id, OLD.kind, OLD.number, OLD.attempts);
  RETURN OLD;
END $$;
CREATE TRIGGER keep_unit BEFORE DELETE ON unit FOR EACH ROW EXECUTE FUNCTION keep_unit();"""

Where = collections.namedtuple("Where", "database store photos alone scratch")


def digests(server, flight):
    """Of the map in each of the formats that it is handed out in."""
    answers = {}
    for ending in ("pmtiles", "tif", "mbtiles"):
        status, _, content = server.request("GET", f"/api/v1/flights/{flight}/download.{ending}")
        answers[ending] = hashlib.sha256(content).hexdigest() if status == 200 else f"{status} {content[:200]}"
    return answers


def stitched_alone(photos, folder):
    """The map of one machine, in one process, in its own folder."""
    with Server(folder, "--workers", "1") as server:
        return digests(server, server.stitched(photos, name="field")["flight"]["id"])


def plan_of(seed):
    """(kind, stage) pairs in the order of the stages."""
    pairs = [(kind, stage) for kind in KINDS for stage in STAGES]
    random.Random("faults").shuffle(pairs)
    first = (seed - 1) * FAULTS_PER_SEED
    mine = [pairs[(first + i) % len(pairs)] for i in range(FAULTS_PER_SEED)]
    return sorted(mine, key=lambda pair: STAGES.index(pair[1]))


class Run:
    """A cluster of a seed's own on the database and the store of all."""

    def __init__(self, where, seed):
        self.database, self.store, self.photos, self.alone, self.scratch = where
        self.name, self.dice = f"seed{seed}", random.Random(seed)
        self.proxy = StoreProxy(self.store.port, s3_store.KEY, seed=seed)
        os.environ.update(self.store.environment(self.proxy.endpoint))
        self.catalogue = ("--catalogue", f"{self.database.url}&schema={self.name}")
        self.blobs = ("--blobs", self.store.address(self.name))
        self.log = pathlib.Path(self.scratch, f"{self.name}.log")
        self.workers, self.stopped, self.gone, self.spoilt, self.cleanups, self.folders = [], [], [], [], [], 0
        self.server = self.serve()
        self.database.query(KEEP_UNITS, self.name)
        self.upload()

    def expect(self, is_so, complaint):
        if not is_so:
            raise AssertionError(complaint)

    def said(self):
        return self.log.read_text()[-4000:]

    def serve(self):
        return Server(f"{self.scratch}/{self.name}", "--workers", "0", *self.catalogue, *self.blobs)

    def folder_of_worker(self):
        self.folders += 1
        return f"{self.scratch}/{self.name}-{self.folders}"

    def start_worker(self, folder=None):
        with open(self.log, "a") as log:
            words = [BINARY, "worker", "--data", folder or self.folder_of_worker(), *self.catalogue, *self.blobs, *CUT]
            self.workers.append(subprocess.Popen(words, stdout=log, stderr=log))
        return self.workers[-1]

    def kill(self, worker):
        children = children_of(worker.pid) if worker.poll() is None else []
        worker.kill()
        for child in children:
            kill_if_there(child)
        worker.wait()
        for kept in (self.workers, self.stopped):
            if worker in kept:
                kept.remove(worker)

    def ask(self, method, path, value=None):
        """What the server says once database and store are there for it."""
        answers = []

        def is_answered():
            answers.append(self.server.json(method, path, value))
            return answers[-1][0] != 503
        wait_until(is_answered, lambda: f"{method} {path} is not answered: {answers[-1:]}")
        return answers[-1]

    def upload(self):
        fails, self.proxy.fails = self.proxy.fails, 0  # uploads have their own tests
        status, made = self.server.upload(self.photos, name="field")
        self.expect(status == 202, made)
        self.flight, self.job = made["flight"]["id"], made["job"]["id"]
        self.proxy.fails = fails

    def stage(self):
        """Of the present job, by what its workers say: its place in STAGES; -1 before the first, their number after the last."""
        said = re.findall(rf"job {self.job}(?: of flight \w+)?:? (look|render|begins|waits|is published)", self.log.read_text())
        if "is published" in said:
            return len(STAGES)
        waits = said.count("waits")
        if waits >= 2 and any(method == "PUT" and f"/flights/{self.flight}/r" in path for method, path, *_ in self.proxy.asked):
            return STAGES.index("publish")
        latest = next((word for word in reversed(said) if word != "waits"), None)
        if latest in ("look", "render"):
            return STAGES.index(latest)
        return {0: -1, 1: STAGES.index("place")}.get(waits, STAGES.index("put together")) if latest else -1

    def reach(self, stage):
        """The stage that the job is at when it is at this one or beyond; None after its end."""
        wait_until(lambda: self.stage() >= STAGES.index(stage), lambda: f"{stage} does not come: {self.said()}")
        now = self.stage()
        return STAGES[now] if now < len(STAGES) else None

    def ended(self):
        wait_until(lambda: self.ask("GET", f"/api/v1/jobs/{self.job}")[1].get("finished_at"),
                   lambda: f"the job does not end: {self.said()}")
        return self.ask("GET", f"/api/v1/jobs/{self.job}")[1]

    def number(self, sql):
        return int(self.database.query(sql, self.name))

    def shown(self):
        """The bytes of the map; while a cache has to read again what came wrong the answer is 503."""
        seen = []

        def has_all():
            seen.append(digests(self.server, self.flight))
            return not any(digest.startswith("503") for digest in seen[-1].values())
        wait_until(has_all, lambda: f"the map is not handed out: {seen[-1:]}")
        return seen[-1]

    def orphans(self):
        """What lies in the store beside the photos and the map that is shown."""
        kept = []
        for key in self.store.keys(f"{self.name}/"):
            parts = key.split("/")
            is_shown = parts[1:3] == ["flights", self.flight] and (parts[3] == "files" or parts[3] == f"r{self.revision}")
            if not is_shown and parts[1:] != ["skyquilt-data.json"]:
                kept.append(key)
        return kept

    def sweep_after_days(self):
        """As two days later."""
        self.expect(self.server.stop() == 0, "the server does not stop well")
        long_ago = time.time() - TWO_DAYS_S
        for path in pathlib.Path(self.store.bucket, self.name).rglob("*"):
            if path.is_file():
                os.utime(path, (long_ago, long_ago))
        self.server = self.serve()
        wait_until(lambda: not self.orphans(), lambda: f"the sweep left {self.orphans()}")

    def fail_by(self, plan):
        """The faults that fell while the job ran, with the stages they fell in."""
        self.proxy.fails = FAILS
        for machine in range(MACHINES):
            has_small_disk = machine == 0 and any(kind == "full disk" for kind, _ in plan)
            self.start_worker(small_disk(self) if has_small_disk else None)
        fell = []
        for kind, stage in plan:
            at = self.reach(stage)
            if at is not None and KINDS[kind](self):
                fell.append({"kind": kind, "stage": at})
        return fell

    def check(self, result):
        job = self.ended()
        result["state"] = job["state"]
        self.expect(job["state"] == "successful", (job, self.said()))
        self.proxy.fails, self.proxy.spoil = 0.0, None
        for worker in self.stopped:  # who wakes up late finds that others did its work
            worker.send_signal(signal.SIGCONT)
        time.sleep(1)
        for worker in [*self.workers, *self.stopped]:
            self.kill(worker)
        result["charged"] = job["attempts"] - 1 + self.number("SELECT coalesce(sum(greatest(attempts-1,0)),0) FROM ended_unit")
        taken = sum(fault["kind"] in OF_WORKERS for fault in result["faults"])
        self.expect(result["charged"] <= taken, f"{result['charged']} attempts for {taken} workers that were taken: {self.said()}")
        self.revision = self.number(f"SELECT active_revision FROM flight WHERE id='{self.flight}'")
        for table in ("revision", "event WHERE kind='map' AND flight_id=(SELECT id FROM flight)"):
            self.expect(self.number(f"SELECT count(*) FROM {table}") == 1, f"not once in {table}")
        self.expect(self.shown() == self.alone, f"other bytes: {self.shown()} than {self.alone}")
        self.sweep_after_days()
        files = self.store.keys(f"{self.name}/flights/{self.flight}/files/")
        self.expect(len(files) == len(self.photos), f"{len(files)} photos are left")
        self.expect(self.shown() == self.alone, "other bytes after the sweep")
        for flight in self.gone:
            self.expect(self.ask("GET", f"/api/v1/flights/{flight}")[0] == 404, "a deleted flight is there")
        self.expect(self.proxy.forged == [], "a signature is wrong")

    def close(self):
        for worker in [*self.workers, *self.stopped]:
            self.kill(worker)
        for cleanup in self.cleanups:
            cleanup()
        self.server.stop()
        self.proxy.stop()


def tried(where, seed, plan):
    """The line of one seed."""
    begun = time.monotonic()
    result = {"seed": seed, "faults": []}
    run = Run(where, seed)
    try:
        result["faults"] = run.fail_by(plan)
        run.check(result)
    except Exception:
        result["failure"] = traceback.format_exc()
    finally:
        run.close()
    result["store_answers_failed"], result["store_answers_spoilt"] = run.proxy.faults, len(run.spoilt)
    result["workers_set_aside"] = run.log.read_text().count("it takes nothing for")
    result["seconds"] = round(time.monotonic() - begun, 1)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default=os.environ.get("SKYQUILT_FAULT_SEEDS", "1-60"), help="such as 7 or 1-15")
    parser.add_argument("--results", type=pathlib.Path, help="a file that gets a line of JSON for each")
    parser.add_argument("--only", help="these faults in each seed: KIND@STAGE, several with commas")
    arguments = parser.parse_args()
    with contextlib.ExitStack() as ends:
        try:
            database = ends.enter_context(PostgresServer(LATE_WRITER))
            store = s3_store.S3Store()
        except (FileNotFoundError, s3_store.NoStore) as none:
            print(f"skipped: {none}")
            return 77
        ends.callback(store.stop)
        scratch = ends.enter_context(tempfile.TemporaryDirectory(prefix="skyquilt_faults_"))
        photos = [(path.name, path.read_bytes()) for path in sorted((made_flights.simulated(PHOTOS, SIZE) / "photos").iterdir())]
        where = Where(database, store, photos, stitched_alone(photos, f"{scratch}/alone"), scratch)
        first, _, last = arguments.seeds.partition("-")
        failed = 0
        for seed in range(int(first), int(last or first) + 1):
            plan = [tuple(pair.split("@")) for pair in arguments.only.split(",")] if arguments.only else plan_of(seed)
            result = tried(where, seed, plan)
            failed += "failure" in result
            line = json.dumps(result)
            print(line, result.get("failure", ""), sep="\n", flush=True)
            if arguments.results:
                with arguments.results.open("a") as file:
                    file.write(line + "\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
