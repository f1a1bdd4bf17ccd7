"""Deleted flights can be taken back; a full disk can be emptied; no restart and no wrong clock costs anyone anything."""
import calendar
import json
import os
import pathlib
import shutil
import signal
import subprocess
import time
import unittest
import unittest.mock

from server_support import (AS_JSON, BLOBS, CHUNK, FORM, POSTGRES, TUS, ServerTestCase, fill_disk, form, in_catalogue,
                            kept_of_flights, parts_of, preloading, tus_metadata, wait_until)

# The clock that a program sees, moved by CLOCK_AHEAD_S seconds; the kernel's time since its start stays.
WRONG_CLOCK = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>
// Who decodes files has no such variable, and the right clock.
static long ahead(void) { const char* said = getenv("CLOCK_AHEAD_S"); return said ? atol(said) : 0; }
int clock_gettime(clockid_t clock, struct timespec* time) {
  static int (*real)(clockid_t, struct timespec*);
  if (!real) real = (int (*)(clockid_t, struct timespec*))dlsym(RTLD_NEXT, "clock_gettime");
  int result = real(clock, time);
  if (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE) time->tv_sec += ahead();
  return result;
}
int gettimeofday(struct timeval* time, void* zone) {
  struct timespec now;
  (void)zone;
  int result = clock_gettime(CLOCK_REALTIME, &now);
  time->tv_sec = now.tv_sec;
  time->tv_usec = now.tv_nsec / 1000;
  return result;
}
time_t time(time_t* out) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (out) *out = now.tv_sec;
  return now.tv_sec;
}
"""


class TrashCase(ServerTestCase):
    def flight_with_map(self, server):
        flight, job = self.new_flight(server, 6)
        server.ended(job)
        return flight, job

    def new_flight(self, server, photos):
        return server.begun(self.photos[:photos])

    def job_row(self, job):
        rows = in_catalogue(self.data, "SELECT state, attempts, interruptions FROM job WHERE id=?", job)
        return rows[0] if rows else None

    def trash_of(self, server):
        return server.json("GET", "/api/v1/trash", code=200)[1]

    def flights_of(self, server):
        return [flight["id"] for flight in server.json("GET", "/api/v1/flights")[1]["flights"]]


class Trash(TrashCase):
    def names_of(self, flight):
        """All that is kept of the flight, but for its record and its preview, which goes in its own time once there is a map."""
        return [name for name in kept_of_flights(self.data)
                if name.startswith(f"{flight}/") and "/preview-" not in name and not name.endswith("/flight.jsonl")]

    def test_a_deleted_flight_is_gone_and_comes_back_with_its_map(self):
        server = self.serve()
        flight, job = self.flight_with_map(server)
        tilejson = server.json("GET", f"/tiles/{flight}.json")[1]
        before = self.names_of(flight)
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight}")[0], 204)
        for path in (f"/api/v1/flights/{flight}", f"/api/v1/flights/{flight}/files", f"/api/v1/flights/{flight}/report",
                     f"/api/v1/flights/{flight}/files/{self.photos[0][0]}", f"/api/v1/flights/{flight}/verdict",
                     f"/tiles/{flight}.json", f"/tiles/{flight}/0/0/0", f"/api/v1/jobs/{job}", f"/wms/{flight}?request=GetCapabilities&service=WMS",
                     f"/stac/{flight}", f"/ogc/collections/{flight}", f"/api/v1/flights/{flight}/download.mbtiles"):
            self.assertEqual(server.request("GET", path)[0], 404, path)
        self.assertEqual(self.flights_of(server), [])
        self.assertEqual(server.json("GET", "/api/v1/jobs")[1]["jobs"], [])
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight}")[0], 404)
        self.assertEqual(server.request("PUT", f"/api/v1/flights/{flight}/files/x.jpg", b"x")[0], 404)
        trash = self.trash_of(server)
        self.assertEqual(trash["days"], 30)
        self.assertEqual([(kept["id"], kept["days_left"], kept["file_count"]) for kept in trash["flights"]], [(flight, 30, 6)])

        # A restart, however rude, takes nothing away.
        server.kill()
        server = self.serve()
        self.assertEqual(self.names_of(flight), before)
        self.assertEqual(server.json("POST", f"/api/v1/flights/{flight}/restore", code=200)[1]["state"], "ready")
        self.assertEqual(server.json("GET", f"/tiles/{flight}.json")[1]["bounds"], tilejson["bounds"])
        self.assertEqual(self.trash_of(server)["flights"], [])
        self.assertEqual(server.request("POST", f"/api/v1/flights/{flight}/restore")[0], 404)

    def test_only_what_was_deleted_is_removed_for_good(self):
        server = self.serve("--workers", "0")
        flight, _ = self.new_flight(server, 1)
        self.assertEqual(server.request("DELETE", f"/api/v1/trash/{flight}")[0], 404)
        self.assertEqual(self.flights_of(server), [flight])
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight}")[0], 204)
        self.assertEqual(server.request("DELETE", f"/api/v1/trash/{flight}")[0], 204)
        self.assertEqual(parts_of(self.data, flight), [])
        self.assertEqual(server.request("POST", f"/api/v1/flights/{flight}/restore")[0], 404)
        self.assertEqual(server.request("DELETE", f"/api/v1/trash/{flight}")[0], 404)

    def test_without_days_a_flight_goes_at_once(self):
        server = self.serve("--workers", "0", "--trash-days", "0")
        flight, _ = self.new_flight(server, 1)
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight}")[0], 204)
        self.assertEqual(self.trash_of(server), {"days": 0, "flights": []})
        self.assertEqual(parts_of(self.data, flight), [])

    def test_what_has_had_its_days_is_removed_by_the_server(self):
        server = self.serve("--workers", "0", "--trash-days", "3")
        ids = []
        for _ in range(2):
            ids.append(self.new_flight(server, 1)[0])
            server.request("DELETE", f"/api/v1/flights/{ids[-1]}")
        self.assertEqual(server.stop(), 0)
        in_catalogue(self.data, "UPDATE flight SET deleted_age_us=deleted_age_us-4*86400000000 WHERE id=?", ids[0])
        server = self.serve("--workers", "0", "--trash-days", "3")
        wait_until(lambda: [kept["id"] for kept in self.trash_of(server)["flights"]] == [ids[1]], "the old one stayed")
        wait_until(lambda: parts_of(self.data, ids[0]) == [], "its files stayed")
        self.assertNotEqual(parts_of(self.data, ids[1]), [])

    def test_flights_that_nobody_changes_go_to_the_trash_and_come_back(self):
        def age(days):
            in_catalogue(self.data, f"UPDATE idle_flight SET since_us=since_us-{days}*86400000000")

        def seen():
            return sorted(row[0] for row in in_catalogue(self.data, "SELECT flight_id FROM idle_flight"))

        def empty(name):
            return server.json("POST", "/api/v1/flights", {"name": name})[1]["id"]

        words = ("--workers", "0", "--keep-days", "30")
        server = self.serve("--workers", "0")
        idle, changed, busy = empty('A "quiet" field'), empty("changed"), self.new_flight(server, 1)[0]
        kept = server.json("POST", "/api/v1/flights", {"name": "kept", "keep": True})[1]["id"]
        self.assertEqual(server.json("GET", "/api/v1/access")[1]["keep_days"], 0)
        self.assertEqual(server.stop(), 0)
        self.assertEqual(seen(), [])
        # The first start with the option only begins to count.
        server = self.serve(*words)
        wait_until(lambda: seen() == sorted([idle, changed, busy, kept]), "the flights were not looked at")
        self.assertEqual(self.trash_of(server)["flights"], [])
        self.assertEqual(server.json("PATCH", f"/api/v1/flights/{changed}", {"name": "renamed"})[0], 200)
        self.assertEqual(server.stop(), 0)
        age(31)
        server = self.serve(*words)
        wait_until(lambda: f"/api/v1/flights/{idle}/restore" in server.errors(), "it stayed, or the log is silent")
        self.assertIn("quiet", server.errors())
        self.assertEqual([(put["id"], put["days_left"]) for put in self.trash_of(server)["flights"]], [(idle, 30)])
        self.assertEqual(sorted(self.flights_of(server)), sorted([changed, busy, kept]))
        self.assertEqual(server.json("POST", f"/api/v1/flights/{idle}/restore")[0], 200)
        self.assertEqual(server.stop(), 0)
        # Restored: its days begin anew. Those of the one that was renamed are over now.
        age(31)
        server = self.serve(*words)
        wait_until(lambda: [kept["id"] for kept in self.trash_of(server)["flights"]] == [changed], "it stayed")
        wait_until(lambda: seen() == sorted([idle, busy, kept]), "the restored one was not looked at")
        self.assertEqual(server.stop(), 0)
        # Without the option nothing goes, and nothing is counted.
        age(31)
        server = self.serve("--workers", "0")
        wait_until(lambda: seen() == [], "days were counted")
        self.assertEqual([kept["id"] for kept in self.trash_of(server)["flights"]], [changed])

    def test_days_to_keep_need_a_trash(self):
        self.assertIn("--trash-days 1 or more", self.refusal("--keep-days", "5", "--trash-days", "0"))
        self.assertIn("--keep-days", self.refusal("--keep-days", "-1"))

    def test_a_running_job_of_a_deleted_flight_is_cancelled(self):
        server = self.serve()
        flight, job = self.new_flight(server, 6)
        server.wait_for_job(job, until=lambda job: job["state"] != "accepted")
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight}")[0], 204)
        # One that was about to end may have got there first.
        wait_until(lambda: self.job_row(job)[0] in ("dismissed", "successful"), "the job went on")

    def test_a_node_puts_removed_tasks_into_the_same_trash(self):
        server = self.serve("--workers", "0")
        uuid = json.loads(server.request("POST", "/task/new", form(files=self.photos[:1], part="images"), FORM)[2])["uuid"]
        flight = self.flights_of(server)[0]
        _, _, answer = server.request("POST", "/task/remove", f"uuid={uuid}", {"Content-Type": "application/x-www-form-urlencoded"})
        self.assertEqual(json.loads(answer), {"success": True})
        self.assertIn("error", server.json("GET", f"/task/{uuid}/info")[1])
        self.assertEqual([kept["id"] for kept in self.trash_of(server)["flights"]], [flight])
        self.assertEqual(server.json("POST", f"/api/v1/flights/{flight}/restore")[0], 200)
        self.assertEqual(server.json("GET", f"/task/{uuid}/info")[1]["uuid"], uuid)


@unittest.skipUnless(os.geteuid() == 0 and BLOBS is None, "only root can mount a small disk, and a store has none")
class FullDisk(TrashCase):
    def setUp(self):
        super().setUp()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=96m", "tmpfs", self.data], capture_output=True, text=True)
        if mounted.returncode != 0:
            self.skipTest(f"no small disk can be mounted: {mounted.stderr}")
        self.addCleanup(subprocess.run, ["umount", "-l", self.data], check=True)

    def fill(self):
        """Others take all that is left, to the last byte."""
        fill_disk(pathlib.Path(self.data, "others"))

    def test_a_full_disk_can_be_emptied(self):
        server = self.serve("--workers", "0")
        ids = []
        for _ in range(3):
            ids.append(self.new_flight(server, 6)[0])
        large = os.urandom(4 << 20)
        self.assertIn(server.request("PUT", f"/api/v1/flights/{ids[0]}/files/large.bin", large)[0], (200, 201))
        self.fill()
        self.assertEqual(os.statvfs(self.data).f_bavail, 0)
        self.assertEqual(server.request("PUT", f"/api/v1/flights/{ids[1]}/files/more.jpg", self.photos[0][1])[0], 507)
        for flight in ids:
            self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight}")[0], 204, flight)
        for flight in ids:
            server.request("DELETE", f"/api/v1/trash/{flight}", code=204)
        self.assertGreater(os.statvfs(self.data).f_bavail * os.statvfs(self.data).f_frsize, 4 << 20)
        self.assertEqual(kept_of_flights(self.data), {})

    def test_a_server_starts_on_a_full_disk(self):
        server = self.serve("--workers", "0")
        flight, _ = self.new_flight(server, 6)
        self.assertEqual(server.stop(), 0)
        self.fill()
        server = self.serve("--workers", "0")
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight}")[0], 204)
        self.assertEqual(server.request("DELETE", f"/api/v1/trash/{flight}")[0], 204)


@unittest.skipUnless(shutil.which("cc"), "no compiler for a wrong clock")
class WrongClock(TrashCase):
    def setUp(self):
        super().setUp()
        self.shim = pathlib.Path(self.scratch, "wrong_clock.so")
        subprocess.run(["cc", "-shared", "-fPIC", "-o", self.shim, "-x", "c", "-", "-ldl"], input=WRONG_CLOCK, text=True, check=True)

    def serve_with_clock_ahead(self, days, *arguments):
        with unittest.mock.patch.dict(os.environ, preloading(self.shim), CLOCK_AHEAD_S=str(days * 86400)):
            return self.serve(*arguments)

    def begin_upload(self, server, flight):
        photo = self.photos[0][1]
        _, headers, _ = server.request("POST", "/api/v1/uploads", photo[:1000], {**CHUNK, **tus_metadata(flight, "late.jpg"), "Upload-Length": str(len(photo))}, code=201)
        return headers["Location"]

    def offset(self, server, upload):
        status, headers, _ = server.request("HEAD", upload, None, TUS)
        return status, headers["Upload-Offset"]

    def test_a_clock_that_is_a_month_ahead_for_one_start_expires_nothing(self):
        server = self.serve("--workers", "0")
        flight, _ = self.new_flight(server, 1)
        upload = self.begin_upload(server, flight)
        gone, _ = self.new_flight(server, 2)
        server.request("DELETE", f"/api/v1/flights/{gone}")
        key = {"Idempotency-Key": "once", **AS_JSON}
        first = server.request("POST", "/api/v1/flights", b'{"name":"once"}', key)[2]
        self.assertEqual(server.stop(), 0)

        ahead = self.serve_with_clock_ahead(40, "--workers", "0")
        self.assertEqual(self.offset(ahead, upload), (200, "1000"))
        self.assertEqual(len(self.trash_of(ahead)["flights"]), 1)
        self.assertEqual(ahead.request("POST", "/api/v1/flights", b'{"name":"once"}', key)[2], first)
        # What is deleted under the wrong clock has its days as well.
        self.assertEqual(ahead.request("DELETE", f"/api/v1/flights/{json.loads(first)['id']}")[0], 204)
        self.assertEqual(self.trash_of(ahead)["flights"][0]["days_left"], 30)
        self.assertEqual(ahead.stop(), 0)

        server = self.serve("--workers", "0")
        self.assertEqual(self.offset(server, upload), (200, "1000"))
        self.assertEqual(sorted(kept["days_left"] for kept in self.trash_of(server)["flights"]), [30, 30])

    def test_the_wrong_clock_is_really_seen(self):
        ahead = self.serve_with_clock_ahead(40, "--workers", "0")
        made = ahead.upload(self.photos[:1])[1]["flight"]
        self.assertGreater(calendar.timegm(time.strptime(made["created_at"][:19], "%Y-%m-%dT%H:%M:%S")), time.time() + 38 * 86400)


class Restarts(TrashCase):
    def cut_power(self, server, job):
        """The machine goes down while the job runs: server and worker at once."""
        wait_until(lambda: self.job_row(job)[0] != "accepted", "nobody took the job")
        pids = [server.process.pid, *server.workers()]
        for pid in pids:
            os.kill(pid, signal.SIGKILL)
        server.process.wait()
        server.close()

    def test_power_cuts_are_not_attempts(self):
        server = self.serve()
        _, job = self.new_flight(server, 6)
        cuts = 0
        for _ in range(5):
            if self.job_row(job)[0] not in ("accepted", "running"):
                break
            self.cut_power(server, job)
            cuts += 1
            server = self.serve()
        self.assertGreater(cuts, 3, "the job was over before it could be cut off")
        server.ended(job)
        self.assertLessEqual(self.job_row(job)[1], 1)
        self.assertEqual(server.stop(), 0)

    @unittest.skipIf(POSTGRES, "a server that shares its catalogue knows its own workers by other names")
    def test_a_job_that_ends_in_a_restart_every_time_ends(self):
        server = self.serve("--workers", "0")
        _, job = self.new_flight(server, 1)
        self.assertEqual(server.stop(), 0)
        in_catalogue(self.data, "UPDATE job SET state='running', worker='serve-1-0-1', attempts=1, interruptions=9, lease_token=1")
        server = self.serve("--workers", "0")
        ended = server.json("GET", f"/api/v1/jobs/{job}")[1]
        self.assertEqual(ended["state"], "failed")
        self.assertIn("interrupted 10 times by restarts", ended["error"]["message"])
