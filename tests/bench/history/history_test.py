"""What history.py calls slower, by lines made up for it, and that the lines kept can be read."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import history

HERE = pathlib.Path(__file__).resolve().parent


def line(cores=2, **ratios):
    return {"commit": "c", "day": "2026-01-01", "cores": cores, "runs": 5,
            "ratios": {name: {"decode": decode, "copy": copy} for name, (decode, copy) in ratios.items()}}


class Compare(unittest.TestCase):
    def test_what_takes_longer_by_both_loops_is_told(self):
        before = [line(align=(1.0, 10.0), render=(2.0, 20.0)), line(align=(1.02, 10.1), render=(2.0, 20.0)), line(align=(0.98, 9.9), render=(2.0, 20.0))]
        self.assertEqual(history.slower([*before, line(align=(1.04, 10.4), render=(2.0, 20.0))], 5), [])
        [(name, times)] = history.slower([*before, line(align=(1.2, 12.0), render=(2.0, 20.0))], 5)
        self.assertEqual(name, "align")
        self.assertAlmostEqual(times, 1.2)
        # The machine's memory was slow in that run, not the program.
        self.assertEqual(history.slower([*before, line(align=(1.3, 10.0), render=(2.0, 20.0))], 5), [])

    def test_other_machines_and_new_stages_say_nothing(self):
        self.assertEqual(history.slower([line(8, align=(1.0, 10.0)), line(2, align=(9.0, 90.0))], 5), [])
        self.assertEqual(history.slower([line(align=(1.0, 10.0)), line(align=(1.0, 10.0), measure=(3.0, 30.0))], 5), [])

    def test_one_bad_run_long_ago_is_forgotten_and_a_stage_of_nothing_is_noise(self):
        before = [line(align=(0.1, 1.0)), *[line(align=(1.0, 10.0))] * 5]
        self.assertEqual(history.slower([*before, line(align=(1.0, 10.0))], 5), [])
        self.assertEqual(history.slower([line(read=(0.001, 0.01)), line(read=(0.01, 0.1))], 5), [])

    def test_the_command_ends_with_1_where_something_is_slower(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "runs.jsonl")
            words = [sys.executable, HERE / "history.py", "compare", "--file", file]
            self.assertEqual(subprocess.run(words, stdout=subprocess.DEVNULL).returncode, 0)
            file.write_text("".join(json.dumps(one) + "\n" for one in (line(align=(1.0, 10.0)), line(align=(1.5, 15.0)))))
            done = subprocess.run(words, stdout=subprocess.PIPE, text=True)
            self.assertEqual((done.returncode, done.stdout), (1, "align: 50 % more than before\n"))

    def test_every_line_that_is_kept_can_be_read(self):
        for one in history.read(history.LINES):
            self.assertTrue(one["commit"] and one["cores"] and one["ratios"], one)
