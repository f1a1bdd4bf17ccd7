"""What a command says to who watches it: at a terminal, into a log, to nobody any more."""
import contextlib
import fcntl
import os
import pty
import re
import struct
import subprocess
import termios

from program import BINARY, ScratchCase


class Terminal(ScratchCase):
    def simulate(self, name):
        """The words of a command that ends within a second and tells how far it is."""
        return [BINARY, "simulate", "-o", self.scratch / name, "--photos", "2", "--size", "320x240", "--no-world"]

    def test_work_goes_on_where_nobody_can_be_told(self):
        reader, without_reader = os.pipe()
        os.close(reader)
        ours, gone_terminal = pty.openpty()
        os.close(ours)
        full_disk = os.open("/dev/full", os.O_WRONLY)
        for name, told in (("without_reader", without_reader), ("gone_terminal", gone_terminal), ("full_disk", full_disk)):
            self.addCleanup(os.close, told)
            done = subprocess.run(self.simulate(name), stdout=subprocess.DEVNULL, stderr=told)
            self.assertEqual(done.returncode, 0, name)
            self.assertEqual(len(list((self.scratch / name / "photos").iterdir())), 2, name)

    def test_how_a_command_ends_is_told_by_its_code_alone_there(self):
        with open("/dev/full", "w") as full_disk:
            refused = subprocess.run([BINARY, "report", self.scratch, "-o", self.scratch / "none.html"], stderr=full_disk)
        self.assertEqual(refused.returncode, 1)

    def test_what_is_printed_is_written_or_said_not_to_be(self):
        for words in (["--version"], self.simulate("printed")[1:]):
            with open("/dev/full", "w") as full_disk:
                done = subprocess.run([BINARY, *words], stdout=full_disk, stderr=subprocess.PIPE, text=True)
            self.assertEqual(done.returncode, 1, words)
            self.assertIn("what it printed could not all be written", done.stderr)
        # Where stdout is closed, nobody asked for it.
        closed = subprocess.run(["sh", "-c", 'exec "$0" --version >&-', BINARY], stderr=subprocess.PIPE, text=True)
        self.assertEqual((closed.returncode, closed.stderr), (0, ""))

    def test_a_line_of_progress_stays_in_its_row(self):
        ours, theirs = pty.openpty()
        self.addCleanup(os.close, ours)
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 40, 0, 0))
        with subprocess.Popen(self.simulate("drawn"), stdout=subprocess.DEVNULL, stderr=theirs) as job:
            os.close(theirs)
            told = b""
            with contextlib.suppress(OSError):  # where its end is gone
                while part := os.read(ours, 1 << 16):
                    told += part
        self.assertEqual(job.returncode, 0)
        rows = re.split(r"\r\x1b\[K|\r\n", told.decode())
        self.assertTrue([row for row in rows if "[...." in row], rows)
        self.assertLess(max(len(row) for row in rows), 40, rows)
