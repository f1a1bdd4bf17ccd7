"""Archives as uploads: the good ones become their files, the bad ones become an answer and nothing else."""
import base64
import hashlib
import io
import json
import os
import signal
import struct
import tarfile
import threading
import zipfile

from server_support import CHUNK, ServerTestCase, children_called, limits_of, photos_of, tus_metadata, wait_until


def zip_of(*entries, method=zipfile.ZIP_STORED):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as archive:
        for name, content in entries:
            archive.writestr(name, content)
    return buffer.getvalue()


def tar_of(*entries, mode="w"):
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode=mode) as archive:
        for entry, content in entries:
            entry = entry if isinstance(entry, tarfile.TarInfo) else tarfile.TarInfo(entry)
            entry.size = len(content)
            archive.addfile(entry, io.BytesIO(content))
    return buffer.getvalue()


def link(name, target):
    entry = tarfile.TarInfo(name)
    entry.type, entry.linkname = tarfile.SYMTYPE, target
    return entry


class Archives(ServerTestCase):
    def setUp(self):
        super().setUp()
        self.server = self.serve("--workers", "0")
        self.files = f"/api/v1/flights/{self.server.new_flight()}/files"

    def put(self, name, content, headers=None):
        status, _, body = self.server.request("PUT", f"{self.files}/{name}", content, headers)
        return status, json.loads(body)

    def listed(self):
        return {file["name"]: file["bytes"] for file in self.server.json("GET", self.files)[1]["files"]}

    def test_zip_and_tar_become_their_files(self):
        photos = [(f"DCIM/100MEDIA/{name}", content) for name, content in self.photos]
        clutter = [("__MACOSX/DCIM/._a.jpg", b"x"), (".DS_Store", b"x"), ("DCIM/@eaDir/a.jpg/SYNOPHOTO_THUMB_M.jpg", b"x"),
                   ("DCIM/#recycle/old.jpg", b"x"), (".Trashes/501/old.jpg", b"x")]
        status, told = self.put("flight.zip", zip_of(*photos, *clutter))
        self.assertEqual((status, len(told["files"])), (201, 6))
        self.assertEqual(self.listed(), {name: len(content) for name, content in self.photos})
        status, told = self.put("more.tar.gz", tar_of(("logs/a.csv", b"1,2"), ("b.txt", b"hello"), mode="w:gz"))
        self.assertEqual((status, len(self.listed())), (201, 8))
        status, told = self.put("again.tar", tar_of(("b.txt", b"hello"),))
        self.assertIn("note", told["files"][0])

    def test_two_cards_in_one_zip_keep_their_folders(self):
        names = ("100MEDIA/DJI_0001.JPG", "101MEDIA/DJI_0001.JPG", "101MEDIA/positions.csv", "101MEDIA/DJI_0002.JPG")
        self.assertEqual(self.put("cards.zip", zip_of(*((name, name.encode()) for name in names)))[0], 201)
        self.assertEqual(set(self.listed()), {"100MEDIA_DJI_0001.JPG", "101MEDIA_DJI_0001.JPG", "101MEDIA_positions.csv", "DJI_0002.JPG"})

    def test_archives_come_through_every_door(self):
        archive = zip_of(("a.jpg", b"aa"), ("b.jpg", b"bb"))
        status, made = self.server.upload([("flight.zip", archive), ("c.jpg", b"cc")])
        self.assertEqual((status, sorted(file["name"] for file in made["files"])), (202, ["a.jpg", "b.jpg", "c.jpg"]))
        flight = self.files.split("/")[4]
        status, _, _ = self.server.request("POST", "/api/v1/uploads", archive, {**CHUNK, **tus_metadata(flight, "flight.zip"), "Upload-Length": str(len(archive))})
        self.assertEqual((status, self.listed()), (201, {"a.jpg": 2, "b.jpg": 2}))

    def test_what_is_wrong_inside_is_said_and_skipped(self):
        entries = [("../../evil.jpg", b"x"), ("/etc/passwd", b"x"), ("C:/x.jpg", b"x"), ("good.jpg", b"x"),
                   ("inner.zip", zip_of(("a", b"x"))), ("empty.jpg", b""), ("n" * 300, b"x")]
        status, told = self.put("mixed.zip", zip_of(*entries))
        self.assertEqual(status, 201)
        taken = {file["name"] for file in told["files"] if "error" not in file}
        self.assertEqual(taken, {"good.jpg"})
        self.assertEqual(len(told["files"]), len(entries))
        self.assertEqual({file["code"] for file in told["files"] if "error" in file}, {"unprocessable"})
        status, told = self.put("links.tar", tar_of((link("a.jpg", "/etc/passwd"), b""), ("good2.jpg", b"x")))
        self.assertEqual({file["name"] for file in told["files"] if "error" not in file}, {"good2.jpg"})
        self.assertEqual(self.listed(), {"good.jpg": 1, "good2.jpg": 1})

    def test_archives_made_to_harm_leave_nothing(self):
        bomb = zip_of(("a.jpg", bytes(64 << 20)), method=zipfile.ZIP_DEFLATED)
        good = zip_of(("a.jpg", b"x" * 1000), ("b.jpg", b"y" * 1000))
        directory = good.index(b"PK\1\2")
        encrypted = bytearray(good)
        encrypted[6] |= 1
        encrypted[directory + 8] |= 1
        wrong_sum = bytearray(good)
        wrong_sum[40] ^= 1
        lying = bytearray(good)
        for offset in (18, 22):
            struct.pack_into("<I", lying, offset, 0xFFFFFF)
        with_nul = good.replace(b"b.jpg", b"b\0jpg")
        many = zip_of(*((f"{number}.jpg", b"") for number in range(20_100)))
        for name, content in (("bomb", bomb), ("cut", good[: len(good) // 2]), ("nonsense", b"PK\3\4" + b"\xff" * 500),
                              ("encrypted", bytes(encrypted)), ("sum", bytes(wrong_sum)), ("nul", with_nul), ("many", many)):
            status, problem = self.put(f"{name}.zip", content)
            self.assertEqual(status, 422, (name, problem))
            self.assertIn("archive", problem["detail"], name)
            self.assertEqual(self.listed(), {}, name)
        self.assertEqual(self.put("encrypted.zip", bytes(encrypted))[1]["reason"]["code"], "fail_archive")
        self.put("lying.zip", bytes(lying))  # taken or refused: what counts is that no more comes out than went in
        self.assertLessEqual(sum(self.listed().values()), 2000)
        self.assertEqual(self.server.garbage(), [])
        self.assertEqual(len(photos_of(self.server.data, self.files.split("/")[4])), len(self.listed()))

    def unpacker(self):
        """The process that unpacks, once there is one."""
        return wait_until(lambda: self.server.garbage() and children_called(self.server.process.pid, "unpack"), "nothing unpacks")[0]

    def test_an_unpacker_that_dies_leaves_nothing_and_nobody_else_notices(self):
        self.assertEqual(self.put("photos.zip", zip_of(*self.photos))[0], 201)
        before = self.listed()
        many = zip_of(*((f"{number}.jpg", b"x") for number in range(19_000)))
        answers = []
        uploading = threading.Thread(target=lambda: answers.append(self.put("many.zip", many)))
        uploading.start()
        pid = self.unpacker()
        wait_until(lambda: limits_of(pid)["Max file size"] != "unlimited", "the unpacker takes what it likes")
        limits = limits_of(pid)
        self.assertEqual((limits["Max core file size"], limits["Max file size"]), ("0", str(4 << 30)))
        if "ASAN_OPTIONS" not in os.environ:  # its shadow is terabytes of addresses
            self.assertLess(int(limits["Max address space"]), 4 << 30)
        self.assertLess(int(limits["Max cpu time"]), 120)
        os.kill(pid, signal.SIGKILL)
        uploading.join()
        [(status, problem)] = answers
        self.assertEqual(status, 422)
        self.assertIn("archive", problem["detail"])
        self.assertEqual(self.listed(), before)
        self.assertEqual(self.server.garbage(), [])
        self.assertEqual(len(photos_of(self.server.data, self.files.split("/")[4])), len(before))

    def test_a_digest_is_checked(self):
        digest = lambda content: {"Content-Digest": f"sha-256=:{base64.b64encode(hashlib.sha256(content).digest()).decode()}:"}
        self.assertEqual(self.put("a.jpg", b"hello", digest(b"hello"))[0], 201)
        self.assertEqual(self.put("b.jpg", b"hellO", digest(b"hello"))[0], 422)
        self.assertEqual(self.put("b.jpg", b"hello", {"Content-Digest": "sha-256=nonsense"})[0], 400)
        self.assertEqual(self.listed(), {"a.jpg": 5})
