"""Whoever takes over a decoder reaches nothing: what sandboxed processes hold and may do, and what becomes of their ends."""
import ctypes
import errno
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import unittest
import unittest.mock

import server_support
from server_support import ServerTestCase, confined_of, limits_of, open_files_of, parts_of, preloading, wait_until


def segment(marker, content):
    return struct.pack(">BBH", 0xFF, marker, len(content) + 2) + content


def slow_photo(photo, side=12_000, coefficients=20):
    """A JPEG of some 300 kB that takes its decoder many seconds: a valid progressive picture in which scan after scan says
    nothing about a million blocks. With the EXIF and XMP data of `photo`, so that it has a place on the map."""
    headers, at = b"", 2
    while photo[at + 1] & 0xF0 == 0xE0:
        length = struct.unpack_from(">H", photo, at + 2)[0] + 2
        headers += photo[at:at + length]
        at += length
    blocks = ((side + 7) // 8) ** 2
    table = lambda kind, symbol: segment(0xC4, bytes([kind, 1] + [0] * 15 + [symbol]))
    quantization = segment(0xDB, bytes([0] + [1] * 64))
    frame = segment(0xC2, struct.pack(">BHHB", 8, side, side, 1) + bytes([1, 0x11, 0]))
    scan = lambda first, last, high, low: segment(0xDA, bytes([1, 1, 0, first, last, high << 4 | low]))

    def packed(bits):
        bits += "1" * (-len(bits) % 8)
        return int(bits, 2).to_bytes(len(bits) // 8, "big").replace(b"\xff", b"\xff\0")
    # One bit a block: no difference. Then runs of 32 767 blocks in which nothing is left to come.
    runs = packed(("0" + "1" * 14) * (blocks // 32_767 + 1))
    out = b"\xff\xd8" + headers + quantization + frame + table(0x00, 0x00) + scan(0, 0, 0, 0) + bytes((blocks + 7) // 8)
    out += table(0x10, 0xE0)
    for coefficient in range(1, coefficients + 1):
        for low in range(9, -1, -1):
            out += scan(coefficient, coefficient, 0 if low == 9 else low + 1, low) + runs
    return out + b"\xff\xd9"


def status_of(pid):
    return dict(line.split(":\t", 1) for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines() if ":\t" in line)


def forbid_landlock():
    """From now on this process and its children live on a kernel without Landlock (as below older Linux, or in containers that
    forbid it)."""
    seccomp = ctypes.CDLL("libseccomp.so.2")
    seccomp.seccomp_init.restype = ctypes.c_void_p
    filters = ctypes.c_void_p(seccomp.seccomp_init(ctypes.c_uint32(0x7FFF0000)))  # SCMP_ACT_ALLOW
    create_ruleset = 444
    if seccomp.seccomp_rule_add(filters, ctypes.c_uint32(0x00050000 | errno.ENOSYS), create_ruleset, 0) or seccomp.seccomp_load(filters):
        os._exit(1)


# Begins threads as OpenBLAS does: as it is loaded, as many as the machine has processors or the variable says.
BEGINS_THREADS = r"""
#include <pthread.h>
#include <stdlib.h>
#include <unistd.h>
static void *wait(void *nothing) { for (;;) pause(); return nothing; }
__attribute__((constructor)) static void begin(void) {
  const char *said = getenv("%s");
  int threads = said ? atoi(said) : 2;
  pthread_t thread;
  while (threads-- > 1) pthread_create(&thread, NULL, wait, NULL);
}
"""


class Confinement(ServerTestCase):
    def serve_with(self, variable):
        """A server on a machine where a library that is always loaded heeds this variable."""
        compiler = shutil.which("cc")
        if compiler is None:
            self.skipTest("no compiler (apt install gcc)")
        library = pathlib.Path(self.data, "..", f"begins_{variable}.so").resolve()
        subprocess.run([compiler, "-shared", "-fPIC", "-o", library, "-x", "c", "-"], input=BEGINS_THREADS % variable, text=True, check=True)
        with unittest.mock.patch.dict(os.environ, preloading(library)):
            return self.serve("--workers", "1")

    def test_a_blas_with_threads_is_kept_to_one(self):
        server = self.serve_with("OPENBLAS_NUM_THREADS")
        self.assertIn("begins_OPENBLAS_NUM_THREADS.so", pathlib.Path(f"/proc/{server.process.pid}/maps").read_text())
        server.ended(server.begun(self.photos[:2])[1])

    def test_where_a_library_begins_threads_the_job_says_so(self):
        _, job = (server := self.serve_with("NOBODY_SETS_THIS")).begun(self.photos[:2])
        # Where machines share the queue, another one may do it, and that of this machine is said meanwhile.
        told = server.wait_for_job(job, until=lambda job: job["error"] or job.get("workers_aside"))
        self.assertIn("begins threads as it is loaded", (told["error"] or told["workers_aside"][0])["message"])

    def find(self, server, kind):
        """The sandboxed process of a kind, once it is confined."""
        found = []

        def is_there():
            found[:] = confined_of(server, kind)
            try:
                return found and status_of(found[0])["Seccomp"].strip() == "2"
            except (FileNotFoundError, ProcessLookupError, KeyError):
                return False
        wait_until(is_there, f"no {kind}: {server.errors()}")
        return found[0]

    def test_the_process_of_a_job_holds_nothing_but_its_folder(self):
        server = self.serve("--no-previews")
        wait_until(lambda: "decoded under seccomp" in server.errors(), "the log does not say what confines decoders")
        flight_id, job_id = server.begun(self.photos + [(f"again_{name}", content) for name, content in self.photos])
        pid = self.find(server, "stitch-sandboxed")
        os.kill(pid, signal.SIGSTOP)
        try:
            status, files, limits = status_of(pid), open_files_of(pid), limits_of(pid)
            self.assertEqual((status["Seccomp"].strip(), status["NoNewPrivs"].strip()), ("2", "1"))
            for held in files:
                self.assertFalse(held.startswith("socket:") or "catalogue.db" in held or "server.lock" in held, files)
            inside = [held for held in files if held.startswith(str(server.data))]
            for held in inside:
                self.assertTrue("/work/" in held or f"/flights/{flight_id}/files/" in held, held)
            self.assertEqual(limits["Max core file size"], "0")
            self.assertNotIn("unlimited", (limits["Max address space"], limits["Max cpu time"], limits["Max file size"]))
        finally:
            os.kill(pid, signal.SIGCONT)
        server.ended(job_id)
        wait_until(lambda: confined_of(server, "stitch-sandboxed") == [], "its process outlived the job")

    def test_a_job_whose_process_is_killed_is_done_again(self):
        server = self.serve("--no-previews")
        flight_id, job_id = server.begun(self.photos)
        pid = self.find(server, "stitch-sandboxed")
        os.kill(pid, signal.SIGKILL)
        job = server.wait_for_job(job_id)
        self.assertEqual((job["state"], job["attempts"]), ("successful", 2), server.errors())
        wait_until(lambda: server.garbage() == [], f"left over: {server.garbage()}")
        self.assertEqual(parts_of(server.data, flight_id), ["files", "r1"])

    def test_a_job_whose_process_is_deaf_is_cancelled_all_the_same(self):
        server = self.serve("--no-previews")
        _, job_id = server.begun(self.photos)
        pid = self.find(server, "stitch-sandboxed")
        os.kill(pid, signal.SIGSTOP)
        self.assertEqual(server.json("DELETE", f"/api/v1/jobs/{job_id}")[0], 200)
        server.ended(job_id, "dismissed")
        wait_until(lambda: not server_support.is_running(pid), "the process of a cancelled job lives on")
        wait_until(lambda: server.garbage() == [], f"left over: {server.garbage()}")

    def test_a_file_made_to_keep_a_decoder_busy_ends_its_job_and_no_other(self):
        server = self.serve("--no-previews", "--job-timeout", "4")
        job = server.ended(server.begun([("slow.jpg", slow_photo(self.photos[0][1], coefficients=45))])[1], "failed")
        self.assertEqual(job["attempts"], 1)
        self.assertRegex(str(job["error"]), r"took more than 4 seconds and was still in the stage \\?\"check")
        self.assertIn("--job-timeout", str(job["error"]))
        wait_until(lambda: server.garbage() == [], f"left over: {server.garbage()}")
        wait_until(lambda: confined_of(server, "stitch-sandboxed") == [], "its process lives on")
        server.stop()
        server = self.serve("--no-previews")
        server.ended(server.begun(self.photos)[1])

    def test_a_job_that_needs_more_memory_than_it_may_is_ended(self):
        server = self.serve("--no-previews", "--job-memory", "150")
        job = server.wait_for_job(server.begun([("slow.jpg", slow_photo(self.photos[0][1], coefficients=5))])[1])
        self.assertEqual((job["state"], job["attempts"]), ("failed", 1), job)
        self.assertIn("needed more than 0.1 GiB of memory in the stage", str(job["error"]))
        wait_until(lambda: server.garbage() == [], f"left over: {server.garbage()}")

    def test_a_photo_that_takes_too_long_is_passed_over_and_the_others_drawn(self):
        server = self.serve("--photo-timeout", "2")
        slow = slow_photo(self.photos[0][1], coefficients=45)
        flight = server.new_flight([self.photos[0], ("slow.jpg", slow), *self.photos[1:]])
        self.wait_for_preview(server, flight, len(self.photos))
        wait_until(lambda: "slow.jpg is not in the preview: it takes more than 2 seconds" in server.errors(), server.errors())
        pid = self.find(server, "preview-sandboxed")
        status, files = status_of(pid), open_files_of(pid)
        self.assertEqual((status["Seccomp"].strip(), status["NoNewPrivs"].strip()), ("2", "1"))
        for held in files:
            self.assertFalse(held.startswith("socket:") or "catalogue.db" in held or "server.lock" in held, files)
        # A server that starts again does not read it again.
        server.kill()
        server = self.serve("--photo-timeout", "2")
        server.put(flight, [("one_more.jpg", self.photos[0][1])])
        self.wait_for_preview(server, flight, len(self.photos) + 1)
        self.assertNotIn("slow.jpg", server.errors())

    def test_a_painter_that_hangs_or_dies_is_replaced(self):
        server = self.serve("--photo-timeout", "1")
        flight = server.new_flight()
        for number, photo in enumerate(self.photos[:3]):
            server.put(flight, [photo])
            self.wait_for_preview(server, flight, number + 1)
            os.kill(self.find(server, "preview-sandboxed"), (signal.SIGKILL, signal.SIGSTOP, signal.SIGABRT)[number])
        server.put(flight, [self.photos[3]])
        self.wait_for_preview(server, flight, 4)

    def test_without_landlock_the_rest_holds_and_the_log_says_so(self):
        popen = subprocess.Popen
        server_support.subprocess.Popen = lambda *words, **more: popen(*words, preexec_fn=forbid_landlock, **more)
        try:
            server = self.serve()
        finally:
            server_support.subprocess.Popen = popen
        wait_until(lambda: "offers no Landlock" in server.errors(), "the log does not say that Landlock is missing")
        flight = server.new_flight(self.photos)
        self.wait_for_preview(server, flight, len(self.photos))
        _, job = server.json("POST", f"/api/v1/flights/{flight}/jobs", {})
        self.assertEqual(status_of(self.find(server, "stitch-sandboxed"))["NoNewPrivs"].strip(), "1")
        server.ended(job["id"])
