"""What people type wrongly at curl, through curl itself: each is answered by what to type instead."""
import json
import pathlib
import shutil
import subprocess
import unittest

from server_support import ServerTestCase, wait_until


@unittest.skipIf(shutil.which("curl") is None, "needs curl")
class CurlSlips(ServerTestCase):
    def curl(self, server, path, *arguments):
        done = subprocess.run(["curl", "-sS", *map(str, arguments), f"http://127.0.0.1:{server.port}{path}"],
                              capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def setUp(self):
        super().setUp()
        self.server = self.serve()
        self.folder = pathlib.Path(self.server.data, "..", "card with spaces").resolve()
        self.folder.mkdir(exist_ok=True)
        for name, content in self.photos[:2]:
            (self.folder / f"a {name}").write_bytes(content)
        self.photo = sorted(path.name for path in self.folder.iterdir())[0]
        self.flight = self.curl(self.server, "/api/v1/flights", "-H", "Content-Type: application/json", "-d", '{"name":"x"}')

    def test_a_forgotten_at(self):
        answer = self.curl(self.server, "/api/v1/flights", "-F", "name=x", "-F", f"photo={self.photo}")
        self.assertIn('-F "photo=@', answer["detail"])

    def test_json_without_its_header(self):
        for path in ("/api/v1/flights", f"/api/v1/flights/{self.flight['id']}/jobs"):
            answer = self.curl(self.server, path, "-d", "{}")
            self.assertEqual(answer["status"], 415)
            self.assertIn("-H 'Content-Type: application/json'", answer["detail"])

    def test_a_folder_without_its_slash(self):
        answer = self.curl(self.server, f"/api/v1/flights/{self.flight['id']}/files", "-T", self.photo)
        self.assertEqual(answer["status"], 405)
        self.assertIn(".../files/", answer["detail"])

    def test_names_with_spaces(self):
        sent = self.curl(self.server, f"/api/v1/flights/{self.flight['id']}/files/", "-T", self.photo)
        self.assertEqual(sent["name"], self.photo)
        script = ('photos=(); for photo in *.*; do photos+=(-F "photo=@$photo"); done\n'
                  f'curl -sS -F name=beach "${{photos[@]}}" http://127.0.0.1:{self.server.port}/api/v1/flights')
        done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(json.loads(done.stdout)["flight"]["file_count"], 2, done.stdout)

    def test_a_second_card_of_the_same_names(self):
        (_, first), (_, second) = self.photos[:2]
        cards = self.folder.with_name("cards")
        for folder, content in (("100MEDIA", first), ("101MEDIA", second)):
            (cards / folder).mkdir(parents=True)
            (cards / folder / "DJI_0001.JPG").write_bytes(content)
        files = f"/api/v1/flights/{self.flight['id']}/files/"
        one, other = cards / "100MEDIA/DJI_0001.JPG", cards / "101MEDIA/DJI_0001.JPG"
        self.assertEqual(self.curl(self.server, files, "-T", one)["bytes"], len(first))
        refused = self.curl(self.server, files, "-T", other)
        self.assertEqual((refused["status"], refused["code"]), (409, "conflict"))
        self.assertIn(".../files/101MEDIA_DJI_0001.JPG", refused["detail"])
        self.assertEqual(self.curl(self.server, files, "-T", one)["bytes"], len(first))
        self.assertEqual(self.server.request("GET", files + "DJI_0001.JPG")[2], first)
        self.assertEqual(self.curl(self.server, files, "-T", other, "-H", "If-Match: *")["bytes"], len(second))
        self.assertEqual(self.server.request("GET", files + "DJI_0001.JPG")[2], second)
        # As the manual keeps both.
        script = (f'cd 101MEDIA; for photo in *.JPG; do curl -sS -T "$photo" http://127.0.0.1:{self.server.port}{files}'
                  '101MEDIA_"$photo"; done')
        subprocess.run(["bash", "-c", script], check=True, capture_output=True, cwd=cards)
        self.assertEqual(self.server.request("GET", f"{files}101MEDIA_DJI_0001.JPG")[2], second)

    def test_a_wrong_token_is_told_from_none(self):
        self.token("one")
        wait_until(lambda: self.server.request("GET", "/api/v1/flights")[0] == 401, "the token is not asked for")
        none = self.curl(self.server, "/api/v1/flights")
        wrong = self.curl(self.server, "/api/v1/flights", "-H", "Authorization: Bearer sq_mistyped")
        self.assertIn("asks for a token", none["detail"])
        self.assertIn("mistyped", wrong["detail"])
