"""Runs a file of tests, or some of its cases: cases.py FILE [CASE...]. What tests share lies in their own folder, tests/e2e,
here and in tests/bench."""
import pathlib
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
TEST = pathlib.Path(sys.argv[1]).resolve()

sys.path[:0] = [str(TEST.parent), str(HERE.parent / "e2e"), str(HERE), str(HERE.parent / "bench")]
unittest.main(TEST.stem, argv=sys.argv[1:], verbosity=2)
