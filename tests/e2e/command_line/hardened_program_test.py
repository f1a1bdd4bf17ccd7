"""The release program as users get it: hardened, and without debug information, with its names."""
import pathlib
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY  # noqa: E402


@unittest.skipUnless(shutil.which("readelf"), "readelf is not here")
class HardenedProgram(unittest.TestCase):
    def read(self, *arguments):
        return subprocess.run(["readelf", "-W", *arguments, BINARY], capture_output=True, text=True, check=True).stdout

    def setUp(self):
        if "__asan_init" in self.read("--dyn-syms") or "__tsan_init" in self.read("--dyn-syms"):
            self.skipTest("a sanitizer's program")

    def test_the_release_is_hardened(self):
        head = self.read("-h")
        self.assertIn("DYN (Position-Independent Executable", head)
        dynamic = self.read("-d")
        self.assertRegex(dynamic, r"BIND_NOW|FLAGS.*NOW")
        segments = self.read("-l")
        self.assertIn("GNU_RELRO", segments)
        stack = next(line for line in segments.splitlines() if "GNU_STACK" in line)
        self.assertNotIn("RWE", stack)
        symbols = self.read("--dyn-syms")
        self.assertIn("__stack_chk_fail", symbols)
        self.assertRegex(symbols, r"__\w+_chk\b")  # FORTIFY
        self.assertIn("__glibcxx_assert_fail", symbols)  # checked containers

    def test_it_keeps_the_names_of_its_functions(self):
        sections = self.read("-S")
        self.assertNotIn(".debug_info", sections)
        self.assertIn(".symtab", sections)  # a backtrace has names


if __name__ == "__main__":
    unittest.main(verbosity=2)
