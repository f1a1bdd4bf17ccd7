"""More asked of the server than it can do: it answers what is cheap, refuses what is too much, and stops when told to."""
import os
import pathlib
import re
import signal
import socket
import sqlite3
import threading
import time
import unittest

from server_support import AS_JSON, BLOBS, POSTGRES, ServerTestCase, in_catalogue, tile_of, wait_until


class Load(ServerTestCase):
    def with_map(self, *arguments):
        """(a server without workers, a flight with a map, the address of one of its tiles without extension)."""
        server = self.serve("--workers", "1", "--no-previews")
        flight = server.stitched(self.photos)["flight"]["id"]
        _, document = server.json("GET", f"/tiles/{flight}.json")
        lon, lat, _ = document["center"]
        zoom = document["maxzoom"]
        tile = "/tiles/{}/{}/{}/{}".format(flight, zoom, *tile_of(lon, lat, zoom))
        self.bounds = document["bounds"]
        server.stop()
        return self.serve("--workers", "0", *arguments), flight, tile

    def picture(self, flight, side=2000):
        """The address of a picture that takes a while to make."""
        west, south, east, north = self.bounds
        return (f"/wms/{flight}?SERVICE=WMS&VERSION=1.1.1&REQUEST=GetMap&LAYERS=map&STYLES=&SRS=EPSG:4326"
                f"&BBOX={west},{south},{east},{north}&WIDTH={side}&HEIGHT={side}&FORMAT=image/png")

    def at_once(self, server, count, path, headers=None):
        """(status, headers) of so many requests at the same time."""
        answers = []
        threads = [threading.Thread(target=lambda: answers.append(server.request("GET", path, headers=headers)[:2]))
                   for _ in range(count)]
        for thread in threads:
            thread.start()
        return threads, answers

    @unittest.skipIf(POSTGRES is not None, "a lock of SQLite's")
    def test_a_held_write_lock_holds_up_nobody_who_reads(self):
        server, flight, tile = self.with_map()
        server.stop()
        token = self.token("one", "--scope", "admin")
        server = self.serve("--workers", "0")
        self.assertEqual(server.request("GET", tile, headers=token)[0], 200)
        lock = sqlite3.connect(pathlib.Path(self.data, "catalogue.db"), isolation_level=None)
        lock.execute("BEGIN IMMEDIATE")
        written = []
        writers = [threading.Thread(target=lambda: written.append(server.request(
            "POST", "/api/v1/flights", "{}", {**AS_JSON, **token})[0])) for _ in range(3)]
        for writer in writers:
            writer.start()
        try:
            time.sleep(1.5)  # longer than tokens are taken as read
            for path in (tile, tile + "@2x.png", tile + ".webp", "/healthz", "/readyz", "/api/v1/flights", "/metrics",
                         f"/api/v1/flights/{flight}", f"/tiles/{flight}.json", "/api/v1/jobs"):
                self.assertEqual(server.request("GET", path, headers=token)[0], 200, path)
                self.assertEqual(written, [], f"{path} waited for a writer")
        finally:
            lock.execute("ROLLBACK")
            lock.close()
        for writer in writers:
            writer.join()
        self.assertEqual(sorted(written), [201, 201, 201])

    def test_too_many_pictures_are_refused_and_the_rest_is_made(self):
        server, flight, tile = self.with_map("--waiting-requests", "1")
        threads, answers = self.at_once(server, 24, self.picture(flight))
        while any(thread.is_alive() for thread in threads):
            self.assertEqual(server.request("GET", "/healthz")[0], 200)
            self.assertEqual(server.request("GET", tile)[0], 200)
            self.assertEqual(server.request("GET", "/api/v1/flights")[0], 200)
        statuses = [status for status, _ in answers]
        self.assertEqual(set(statuses), {200, 429}, statuses)
        for status, headers in answers:
            if status == 429:
                self.assertGreater(int(headers["Retry-After"]), 0)

    def test_one_address_takes_no_more_than_its_share(self):
        server, flight, _ = self.with_map("--trusted-proxy", "127.0.0.1", "--requests-per-address", "1")
        threads, answers = self.at_once(server, 8, self.picture(flight), {"X-Forwarded-For": "192.0.2.1"})
        self.assertEqual(server.request("GET", self.picture(flight, 100), headers={"X-Forwarded-For": "192.0.2.2"})[0], 200)
        for thread in threads:
            thread.join()
        self.assertEqual({status for status, _ in answers}, {200, 429})

    def test_listeners_of_one_address_are_bounded(self):
        server = self.serve("--workers", "0", "--trusted-proxy", "127.0.0.1", "--listeners-per-address", "2")

        def listen(address):
            """(socket, status, Retry-After or None) of one who follows the events."""
            listener = socket.create_connection(("127.0.0.1", server.port), timeout=60)
            listener.sendall(f"GET /api/v1/events HTTP/1.1\r\nHost: localhost\r\nX-Forwarded-For: {address}\r\n\r\n".encode())
            head = b""
            while b"\r\n\r\n" not in head:
                head += listener.recv(4096)
            found = re.search(rb"Retry-After: (\d+)", head)
            return listener, int(head.split()[1]), found and found.group(1)

        first, second = listen("192.0.2.1"), listen("192.0.2.1")
        self.assertEqual((first[1], second[1]), (200, 200))
        refused = listen("192.0.2.1")
        self.assertEqual(refused[1], 429)
        self.assertIsNotNone(refused[2])
        other = listen("192.0.2.2")
        self.assertEqual(other[1], 200)
        # One that goes makes room at once, although nothing was sent to it.
        first[0].close()
        wait_until(lambda: self.listens(listen, "192.0.2.1"), "a listener that went keeps its place")
        for connection, _, _ in (second, refused, other):
            connection.close()

    def listens(self, listen, address):
        connection, status, _ = listen(address)
        connection.close()
        return status == 200

    def test_all_listeners_hear_of_what_happens(self):
        server = self.serve("--workers", "0")
        listeners = []
        for _ in range(60):
            listener = socket.create_connection(("127.0.0.1", server.port), timeout=60)
            listener.sendall(b"GET /api/v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n")
            listener.recv(64)
            listeners.append(listener)
        job = server.begun(self.photos[:1])[1].encode()
        for listener in listeners:
            heard = b""
            while job not in heard:
                piece = listener.recv(65536)
                self.assertTrue(piece, "the stream ended")
                heard += piece
            listener.close()

    def test_tiles_of_twice_the_size_are_made_once(self):
        server, _, tile = self.with_map()
        first, second = (server.request("GET", tile + "@2x.png") for _ in range(2))
        self.assertEqual((first[0], first[2]), (200, second[2]))
        self.assertEqual(first[1]["ETag"], second[1]["ETag"])
        known = {"If-None-Match": first[1]["ETag"]}
        self.assertEqual(server.request("GET", tile + "@2x.png", headers=known)[0], 304)
        webp, again = (server.request("GET", tile + "@2x.webp") for _ in range(2))
        self.assertEqual((webp[1]["Content-Type"], webp[2]), ("image/webp", again[2]))

    @unittest.skipIf(BLOBS is not None, "photos lie in a store, where there are no pipes")
    def test_the_word_to_stop_ends_it_whatever_hangs(self):
        server, flight, _ = self.with_map()
        # A pipe in the place of a photo: whoever opens it hangs in the kernel, as on a disk that does not answer.
        stored = next(pathlib.Path(self.data, "flights", flight, "files").iterdir())
        stored.unlink()
        os.mkfifo(stored)
        [(name,)] = in_catalogue(self.data, "SELECT name FROM file WHERE stored_name=?", stored.name)
        stuck = socket.create_connection(("127.0.0.1", server.port))
        stuck.sendall(f"GET /api/v1/flights/{flight}/files/{name} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
        waiting = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(24)]
        for client in waiting:
            client.sendall(f"GET {self.picture(flight)} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
        time.sleep(0.5)
        server.process.send_signal(signal.SIGTERM)
        try:
            self.assertEqual(server.process.wait(timeout=60), 0)  # it ends within ten seconds; the machine may be busy
        finally:
            server.process.kill()
            server.close()
        for client in (stuck, *waiting):
            client.close()
        # Nothing is lost, and the next one starts.
        stored.unlink()
        self.assertEqual(self.serve("--workers", "0").json("GET", f"/api/v1/flights/{flight}")[1]["id"], flight)
