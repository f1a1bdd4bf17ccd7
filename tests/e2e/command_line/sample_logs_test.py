"""Every sample log through `skyquilt inspect`: it is read, or what is wrong is said; and what is counted in the binary
ones is what an independent reader counts. Prints the listing. Skipped where the samples are not there."""
import functools
import importlib.util
import json
import pathlib
import unittest

from program import DATA, run

LOGS = DATA / "logs"
READER = pathlib.Path(__file__).resolve().parents[2] / "core" / "flight" / "logs" / "count_messages.py"
UNREADABLE = {"sample_appended.ulg": "empty", "Mini_SE.SRT": "empty"}
TLOG_NAMES = {"GPS_RAW_INT": 24, "RAW_IMU": 27, "ATTITUDE": 30, "GLOBAL_POSITION_INT": 33}


def load_reader():
    spec = importlib.util.spec_from_file_location("count_messages", READER)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@functools.cache
def inspect(path):
    done = run("inspect", path, "--json", code=None)
    assert done.returncode == 2, done.stderr  # no photo among them
    return json.loads(done.stdout)


@unittest.skipUnless(LOGS.is_dir(), f"no sample logs in {LOGS}")
class SampleLogs(unittest.TestCase):
    def test_every_file_is_read_or_explained(self):
        for path in sorted(p for p in LOGS.rglob("*") if p.is_file() and p.suffix not in (".md", ".json")):
            with self.subTest(path.name):
                verdict = inspect(path)
                if verdict["logs"]:
                    (log,) = verdict["logs"]
                    series = ", ".join(f"{name} {facts['count']}" for name, facts in log["series"].items())
                    print(f"{path.parent.name}/{path.name}: {log['format']}, {sum(log['messages'].values())} messages; "
                          f"{series or str(log['rows_by_name']) + ' rows by name'}")
                    self.assertTrue(log["series"] or log["rows_by_name"])
                elif verdict["gcp_lists"]:
                    print(f"{path.parent.name}/{verdict['gcp_lists'][0]}")
                else:
                    print(f"{path.parent.name}/{path.name}: {verdict['warnings'][0]}")
                    self.assertIn(path.name, verdict["warnings"][0])
                    self.assertIn(UNREADABLE[path.name], verdict["warnings"][0])

    def test_binary_logs_are_counted_as_by_an_independent_reader(self):
        reader = load_reader()
        for folder, count in (("dataflash", reader.dataflash), ("ulog", reader.ulog), ("tlog", reader.tlog)):
            for path in sorted((LOGS / folder).iterdir()):
                content = path.read_bytes()
                if not content:
                    continue
                with self.subTest(path.name):
                    (log,) = inspect(path)["logs"]
                    ours = {name: number for name, number in log["messages"].items() if number}
                    theirs = dict(count(content))
                    if folder == "tlog":
                        # One names messages, the other numbers them: the well-known ones one by one, the rest as a bag.
                        for name, number in TLOG_NAMES.items():
                            self.assertEqual(ours[name], theirs[f"MSG_{number}"], name)
                        self.assertEqual(sorted(ours.values()), sorted(theirs.values()))
                    else:
                        self.assertEqual(ours, theirs)
