"""docs/mistakes.md quotes what the program really says, and nothing is written by a mistake."""
import os
import pathlib
import re
import shlex
import subprocess
import tempfile
import unittest

BINARY = os.environ["SKYQUILT_BINARY"]
DOCUMENT = pathlib.Path(__file__).resolve().parents[3] / "docs" / "mistakes.md"


class Mistakes(unittest.TestCase):
    def test_answers_are_quoted_word_for_word(self):
        quoted = re.findall(r"```console\n\$ skyquilt ([^\n]*)\n(.*?)```", DOCUMENT.read_text(), re.S)
        self.assertGreaterEqual(len(quoted), 10)
        for command, answer in quoted:
            with self.subTest(command), tempfile.TemporaryDirectory(prefix="skyquilt_mistakes_") as scratch:
                (pathlib.Path(scratch) / "photos").mkdir()
                done = subprocess.run([BINARY, *shlex.split(command)], cwd=scratch, capture_output=True, text=True,
                                      timeout=60)
                self.assertEqual(done.stderr, answer)
                self.assertIn(done.returncode, (1, 64, 105, 106))
                left = {path.name for path in pathlib.Path(scratch).iterdir()} - {"photos", "data"}
                self.assertEqual(left, set())
                if "data" in os.listdir(scratch):  # where the data folder is opened before what is asked of it is refused
                    self.assertFalse([path for path in (pathlib.Path(scratch) / "data").rglob("*.jpg")])

    def test_help_is_a_word_too(self):
        for words, option in ((["help"], ["--help"]), (["help", "stitch"], ["stitch", "--help"]), (["help", "token", "add"], ["token", "add", "--help"])):
            said = subprocess.run([BINARY, *words], capture_output=True, text=True)
            self.assertEqual(said.returncode, 0, said.stderr)
            self.assertEqual(said.stdout, subprocess.run([BINARY, *option], capture_output=True, text=True).stdout)
        unknown = subprocess.run([BINARY, "help", "stich"], capture_output=True, text=True)
        self.assertEqual((unknown.returncode, unknown.stderr.split(" \"sky")[0]), (64, 'skyquilt has no command "stich". Did you mean skyquilt stitch?'))
