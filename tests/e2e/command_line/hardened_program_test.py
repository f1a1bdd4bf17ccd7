"""The release program as users get it: hardened, and without debug information, with its names."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from program import BINARY, run
from server_support import Server


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
        self.assertRegex(self.read("-d"), r"BIND_NOW|FLAGS.*NOW")
        segments = self.read("-l")
        self.assertIn("GNU_RELRO", segments)
        self.assertNotIn("RWE", next(line for line in segments.splitlines() if "GNU_STACK" in line))
        symbols = self.read("--dyn-syms")
        self.assertIn("__stack_chk_fail", symbols)
        self.assertRegex(symbols, r"__\w+_chk\b")  # FORTIFY
        self.assertIn("__glibcxx_assert_fail", symbols)  # checked containers

    def late(self):
        """Libraries that it loads when they are first needed, as its note says; without any the test is skipped."""
        found = set(re.findall(r'"soname":\["([^"]+)"\]', self.read("-p", ".note.dlopen")))
        if not found:
            self.skipTest("every library is linked: there are no trampolines for this processor")
        return found

    def test_what_it_loads_late_is_not_loaded_at_the_start(self):
        late = self.late()
        self.assertLessEqual({"libgdal.so.32", "libavformat.so.59", "libproj.so.25"}, late)
        traced = run("--version", code=None, env={**os.environ, "LD_TRACE_LOADED_OBJECTS": "1"})
        self.assertEqual({name for name in late if f"{name} =>" in traced.stdout}, set())

    def test_a_server_that_nobody_asked_for_it_does_not_hold_it_either(self):
        late = self.late()
        with tempfile.TemporaryDirectory() as folder:
            with Server(folder, "--workers", "0") as server:
                self.assertEqual(server.request("GET", "/api/v1/flights")[0], 200)
                mapped = pathlib.Path(f"/proc/{server.process.pid}/maps").read_text()
            self.assertEqual({name for name in late if f"/{name}" in mapped}, set())

    def test_a_library_that_is_gone_is_named(self):
        """As where its package was taken away by force: the command that needs it says which, others go on; a server that
        would need it one day does not start."""
        self.late()
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "libgdal.so.32").write_bytes(b"no library")
            environment = {**os.environ, "LD_LIBRARY_PATH": folder}
            self.assertEqual(run("--version", code=None, env=environment).returncode, 0)
            pathlib.Path(folder, "a.tif").write_bytes(b"II*\0" + bytes(100))
            asked = run("validate", f"{folder}/a.tif", code=None, env=environment)
            self.assertNotEqual(asked.returncode, 0)
            self.assertIn("libgdal.so.32 cannot be loaded", asked.stderr)
            served = run("serve", "--data", f"{folder}/data", "--listen", "127.0.0.1:0", code=1, env=environment, timeout=60)
            self.assertRegex(served.stderr, r"cannot be loaded: .*libgdal\.so\.32")  # by it, or by one that needs it

    def test_it_keeps_the_names_of_its_functions(self):
        sections = self.read("-S")
        self.assertNotIn(".debug_info", sections)
        self.assertIn(".symtab", sections)  # a backtrace has names
