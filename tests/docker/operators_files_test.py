"""The Grafana dashboard and the manifest for KEDA ask for what there is: metrics that a running server has with the labels
they are asked by, and tables of a catalogue in PostgreSQL."""
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest
import urllib.request

from postgres_server import PostgresServer, find_binaries

ROOT = pathlib.Path(__file__).resolve().parents[2]
BINARY = pathlib.Path(os.environ.get("SKYQUILT_BINARY", ROOT / "build/release/bin/skyquilt")).resolve()
DASHBOARD = json.loads((ROOT / "docker/grafana-skyquilt.json").read_text())
TARGETS = [target for panel in DASHBOARD["panels"] for target in panel["targets"]]
IN_POSTGRES = [target["rawSql"] for target in TARGETS if "rawSql" in target]
IN_PROMETHEUS = [target["expr"] for target in TARGETS if "expr" in target]


class Server:
    """`skyquilt serve` without workers, on a folder that goes with it."""

    def __init__(self, *arguments):
        self.folder = tempfile.TemporaryDirectory(prefix="skyquilt_operators_")
        self.process = subprocess.Popen([BINARY, "serve", "--data", f"{self.folder.name}/data", "--listen", "127.0.0.1:0", "--workers", "0",
                                         "--no-previews", *arguments], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.url = re.search(r"http://[\d.:]+", self.process.stdout.readline()).group()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(timeout=60)
        self.process.stdout.close()
        self.folder.cleanup()


class Dashboard(unittest.TestCase):
    def test_every_metric_and_label_is_one_that_a_server_has(self):
        with Server() as server:
            text = urllib.request.urlopen(f"{server.url}/metrics", timeout=60).read().decode()
        values = {}  # by metric and label
        for name, labels in re.findall(r"^(\w+)(?:\{(.*)\})? \S+$", text, re.M):
            for label, value in re.findall(r'(\w+)="([^"]*)"', labels) or [(None, None)]:
                values.setdefault(name, {}).setdefault(label, set()).add(value)
        asked = set()
        for expression in IN_PROMETHEUS:
            names = re.findall(r"\b(skyquilt_\w+)(?:\{([^}]*)\})?", expression)
            self.assertTrue(names, expression)
            for name, labels in names:
                self.assertIn(name, values, expression)
                asked.add(name)
                for label, wanted in re.findall(r'(\w+)=~?"([^"]*)"', labels):
                    self.assertLessEqual(set(wanted.split("|")), values[name][label], expression)
                by = re.search(r"by \(([^)]*)\)", expression)
                for label in by.group(1).split(", ") if by else []:
                    self.assertIn(label, [*values[name], "instance"], expression)
        self.assertEqual(asked, set(values), "a metric that nobody looks at")

    def test_panels_are_whole_and_do_not_overlap(self):
        sources = {f"${{{variable['name']}}}" for variable in DASHBOARD["templating"]["list"]}
        taken = set()
        for panel in DASHBOARD["panels"]:
            for target in panel["targets"]:
                self.assertEqual(target["datasource"], panel["datasource"])
            self.assertIn(panel["datasource"]["uid"], sources)
            place = panel["gridPos"]
            self.assertLessEqual(place["x"] + place["w"], 24)
            cells = {(x, y) for x in range(place["x"], place["x"] + place["w"]) for y in range(place["y"], place["y"] + place["h"])}
            self.assertEqual(cells & taken, set(), panel["title"])
            taken |= cells
        self.assertEqual(len(TARGETS), len(IN_POSTGRES) + len(IN_PROMETHEUS))


@unittest.skipIf(find_binaries() is None, "PostgreSQL is not installed")
class Catalogue(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.postgres = PostgresServer()
        cls.server = Server("--catalogue", cls.postgres.url)
        for _ in range(4):
            asked = urllib.request.Request(f"{cls.server.url}/api/v1/flights", b"{}", {"Content-Type": "application/json"})
            urllib.request.urlopen(asked, timeout=60).close()

    @classmethod
    def tearDownClass(cls):
        cls.server.__exit__()
        cls.postgres.close()

    def rows(self, sql):
        said = subprocess.run(["psql", "-X", "-q", "-A", "-t", "-d", self.postgres.url, "-v", "ON_ERROR_STOP=1", "-c", sql],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.assertEqual(said.returncode, 0, said.stdout)
        return said.stdout.split()

    def setUp(self):
        self.rows("DELETE FROM job; DELETE FROM stage_cost")

    def add_job(self, name, state, worker="", lease=0):
        self.rows(f"INSERT INTO job(id, flight_id, state, worker, lease_until_us, created_us)"
                  f" SELECT '{name}', id, '{state}', '{worker}', {lease}, 0 FROM flight ORDER BY id LIMIT 1")

    def add_units(self, job, state, count):
        self.rows(f"INSERT INTO unit(job_id, kind, number, items, state) SELECT '{job}', 'look', coalesce(max(number), 0) + n, 9, '{state}'"
                  f" FROM generate_series(1, {count}) n LEFT JOIN unit ON job_id = '{job}' GROUP BY n")

    def test_the_dashboard_asks_for_tables_that_there_are(self):
        self.add_job("a", "running", "units", 1 << 53)
        self.add_units("a", "waiting", 3)
        self.rows("INSERT INTO stage_cost VALUES('a', 'check', 10, 5), ('b', 'check', 10, 15), ('b', 'render', 10, 40)")
        self.assertEqual(len(IN_POSTGRES), 2)
        self.assertEqual([self.rows(sql) for sql in IN_POSTGRES], [["look|waiting|3|0"], ["render|4", "check|1"]])

    def test_a_node_counts_the_units_of_all(self):
        self.add_job("cut", "running", "units", 1 << 53)
        self.add_units("cut", "waiting", 3)
        self.rows("UPDATE unit SET waiting_us = now_us() - 90000000 WHERE number = 1; UPDATE unit SET waiting_us = now_us() WHERE number > 1")
        self.add_units("cut", "running", 2)
        self.rows("UPDATE unit SET attempts = 3, lease_until_us = now_us() + 60000000 WHERE state = 'running'")
        self.add_units("cut", "done", 4)
        self.rows("UPDATE unit SET attempts = 1 WHERE state = 'done'")
        text = urllib.request.urlopen(f"{self.server.url}/metrics", timeout=60).read().decode()
        values = {key: float(value) for key, value in re.findall(r"^(skyquilt_unit\S+) (\S+)$", text, re.M)}
        self.assertGreaterEqual(values.pop('skyquilt_unit_longest_waiting_seconds{kind="look"}'), 90)
        self.assertEqual(values, {
            'skyquilt_units{kind="look",state="waiting"}': 3, 'skyquilt_units{kind="look",state="running"}': 2,
            'skyquilt_units{kind="look",state="done"}': 4, 'skyquilt_unit_failed_attempts{kind="look"}': 4,
            'skyquilt_units{kind="render",state="waiting"}': 0, 'skyquilt_units{kind="render",state="running"}': 0,
            'skyquilt_units{kind="render",state="done"}': 0, 'skyquilt_unit_failed_attempts{kind="render"}': 0,
            'skyquilt_unit_longest_waiting_seconds{kind="render"}': 0})

    def test_kubernetes_starts_one_worker_for_each_thing_to_do(self):
        try:
            import yaml
        except ImportError:
            self.skipTest("python3-yaml is not here")
        secret, scaled = yaml.safe_load_all((ROOT / "docker/keda-worker.yaml").read_text())
        trigger, = scaled["spec"]["triggers"]
        self.assertEqual(trigger["authenticationRef"]["name"], secret["metadata"]["name"])
        query = trigger["metadata"]["query"]
        self.assertEqual(self.rows(query), ["0"])
        for name, state in (("done", "successful"), ("w1", "accepted"), ("w2", "accepted")):
            self.add_job(name, state)
        self.add_job("r", "running", "someone", 1 << 50)
        self.assertEqual(self.rows(query), ["3"])
        self.add_job("cut", "running", "units", 1 << 53)  # its parts are at work, it is not
        self.add_units("cut", "waiting", 5)
        self.add_units("cut", "running", 2)
        self.add_units("cut", "done", 4)
        self.assertEqual(self.rows(query), ["10"])
        self.rows("UPDATE unit SET state = 'done'; UPDATE job SET lease_until_us = 0 WHERE id = 'cut'")
        self.assertEqual(self.rows(query), ["4"])  # all parts are done: somebody goes on with the job
        said = subprocess.run([BINARY, "worker", "--help"], capture_output=True, text=True, check=True).stdout
        container, = scaled["spec"]["jobTargetRef"]["template"]["spec"]["containers"]
        for option in re.findall(r" (--[\w-]+)", container["command"][-1]):
            self.assertRegex(said, rf"[ ,]{option}\b")


class Worker(unittest.TestCase):
    """What Kubernetes starts, with a program that ends as it is told in place of ours."""

    def setUp(self):
        try:
            import yaml
        except ImportError:
            self.skipTest("python3-yaml is not here")
        _, scaled = yaml.safe_load_all((ROOT / "docker/keda-worker.yaml").read_text())
        container, = scaled["spec"]["jobTargetRef"]["template"]["spec"]["containers"]
        self.command = container["command"]
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def start(self, script):
        program = self.folder / "skyquilt"
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)
        return subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True,
                                env={**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"})

    def test_nothing_to_do_is_no_failure_and_a_failure_is_one(self):
        for code, told in ((0, 0), (3, 0), (1, 1)):
            with self.start(f"exit {code}") as started:
                self.assertEqual(started.wait(timeout=60), told, code)

    def test_a_worker_that_is_to_end_is_told_and_waited_for(self):
        with self.start("trap 'sleep 0.2; echo given back; exit 0' TERM; echo works; while :; do sleep 0.1; done") as started:
            self.assertEqual(started.stdout.readline(), "works\n")
            started.terminate()
            self.assertEqual((started.stdout.read(), started.wait(timeout=60)), ("given back\n", 0))
