"""What PyODM and WebODM said to the node in their own tests, said again to a live server, whose answers must still hold
what those tests looked at. The transcripts (transcripts) are in our words: requests as they were sent, and of each
answer the part that mattered, as shapes (matches() below). A play counts the tests of the client that it stands for
("passes"); one that cannot pass is under "fails", with the reason and with the answer that it wants: should that answer
ever come, the count is wrong and the test says so."""
import gzip
import io
import json
import pathlib
import re
import urllib.parse
import zipfile

from node_test import form
from server_support import FORM, ServerTestCase, add_token, side_by_side, wait_until

TRANSCRIPTS = pathlib.Path(__file__).resolve().parent / "transcripts"
KINDS = {"any": object, "str": str, "int": int, "list": list, "number": (int, float)}
AS_FORM = FORM["Content-Type"]


def numbers_of(version):
    return [int(number) for number in version.split(".")]


def matches(value, shape):
    """Whether a JSON value has a shape: an object has the keys named (others too), everything else is equal, but for
    {"is": kind}, {"matches": pattern}, {"every": shape}, {"first": shape}, {"at_least": count}, {"not_before": version} and
    {"before": version}."""
    rules = {"is": lambda kind: isinstance(value, KINDS[kind]) and not isinstance(value, bool),
             "matches": lambda pattern: isinstance(value, str) and re.search(pattern, value) is not None,
             "every": lambda inner: isinstance(value, list) and all(matches(one, inner) for one in value),
             "first": lambda inner: isinstance(value, list) and len(value) > 0 and matches(value[0], inner),
             "at_least": lambda count: len(value) >= count,
             "not_before": lambda version: numbers_of(value) >= numbers_of(version),
             "before": lambda version: numbers_of(value) < numbers_of(version)}
    if isinstance(shape, dict) and shape and shape.keys() <= rules.keys():
        return all(rules[rule](wanted) for rule, wanted in shape.items())
    if isinstance(shape, dict):
        return isinstance(value, dict) and all(key in value and matches(value[key], inner) for key, inner in shape.items())
    if isinstance(shape, list):
        return isinstance(value, list) and len(value) == len(shape) and all(map(matches, value, shape))
    return value == shape and isinstance(value, bool) == isinstance(shape, bool)


class Play:
    """One play of a transcript against a server, with what its answers were kept as."""

    def __init__(self, server, headers, known, photos):
        self.server, self.headers, self.known, self.photos = server, headers, known, photos

    def filled(self, value):
        if isinstance(value, str):
            return re.sub(r"\$\{(\w+)\}", lambda name: self.known[name.group(1)], value)
        if isinstance(value, dict):
            return {key: self.filled(inner) for key, inner in value.items()}
        return [self.filled(inner) for inner in value] if isinstance(value, list) else value

    def send(self, exchange, body=b"", kind=None):
        method, path = self.filled(exchange["send"]).split(" ")
        headers = {**self.headers, **({"Content-Type": kind} if kind else {})}
        status, got, content = self.server.request(method, path, body if method == "POST" else None, headers)
        if got.get("Content-Encoding") == "gzip":
            content = gzip.decompress(content)
        return status, got, content

    def answers(self, exchange):
        """What came back, of each request that the exchange stands for."""
        if "photos" in exchange:
            return self.photos_side_by_side(exchange)
        if "form" in exchange:
            return [self.send(exchange, form(self.filled(exchange["form"])), AS_FORM)]
        if "urlencoded" in exchange:
            fields = urllib.parse.urlencode(self.filled(exchange["urlencoded"]))
            return [self.send(exchange, fields.encode(), "application/x-www-form-urlencoded")]
        return [self.send(exchange)]

    def photos_side_by_side(self, exchange):
        files = zip(exchange["photos"], (content for _, content in self.photos))
        return side_by_side([lambda file=file: self.send(exchange, form(files=[file]), AS_FORM) for file in files])

    def complaint(self, wanted, answer):
        """How an answer differs from what an exchange, or a failing test, wants; empty: not at all."""
        status, headers, content = answer
        kind = wanted.get("type", "application/zip" if "archive" in wanted else "application/json")
        if (status, headers["Content-Type"]) != (wanted.get("status", 200), kind):
            return f"{status} {headers['Content-Type']} {content[:300]!r}"
        for name, value in wanted.get("answer_headers", {}).items():
            if headers.get(name) != value:
                return f"{name}: {headers.get(name)}"
        if kind == "application/zip":
            archive = zipfile.ZipFile(io.BytesIO(content))
            missing = [name for name in wanted["archive"] if not any(held.startswith(name) for held in archive.namelist())]
            return f"the archive lacks {missing}" if missing or archive.testzip() else ""
        value = json.loads(content)
        if "lacks" in wanted:
            outer, inner = wanted["lacks"]
            if inner in value[outer]:
                return f"{outer} has {inner}: {value}"
        shape = self.filled(wanted.get("answer", {}))
        return "" if matches(value, shape) else f"{content[:600]!r} is not {shape}"

    def exchange(self, exchange):
        """The last answer, after all were found good."""
        if "until" in exchange:
            last = []

            def has_come():
                last[:] = self.answers(exchange)
                return not self.complaint({"answer": exchange["until"]}, last[0])
            wait_until(has_come, f"{exchange} never came")
            return last[0]
        for answer in self.answers(exchange):
            complaint = self.complaint(exchange, answer)
            if complaint:
                raise AssertionError(f"{exchange['send']}: {complaint}")
            for name, key in exchange.get("keep", {}).items():
                self.known[name] = json.loads(answer[2])[key]
        return answer


class NodeTranscripts(ServerTestCase):
    def run_transcript(self, name, most):
        """(tests of the client that pass, tests that it has); `most` of them need no node at all."""
        transcript = json.loads((TRANSCRIPTS / name).read_text())
        passed, failed, offline = 0, 0, 0
        for number, play in enumerate(transcript["plays"]):
            with self.subTest(client=transcript["client"], test=play["test"]):
                self.assertTrue(play["exchanges"] or play["without_a_node"])
                self.check_play(transcript, play, f"{self.data}/{number}")
            passed += play["passes"]
            failed += len(play.get("fails", ()))
            offline += play["passes"] if not play["exchanges"] else 0
        self.assertLessEqual(offline, most)
        return passed, passed + failed

    def check_play(self, transcript, play, data):
        if not play["exchanges"]:
            return
        known = {}
        if play.get("token"):
            known["token"] = add_token(data, "client", "--scope", "admin")
        self.data, before = data, self.data
        server = self.serve(*transcript["serve"], "--workers", "1")
        self.data = before
        session = Play(server, transcript["headers"], known, self.photos)
        answers = [session.exchange(exchange) for exchange in play["exchanges"]]
        for failing in play.get("fails", ()):
            differs = session.complaint(failing["differs"], answers[failing["exchange"]])
            self.assertTrue(differs, f"This passes by now, count it: {failing['example']}")
        server.stop()

    def test_pyodms_own_tests(self):
        self.assertEqual(self.run_transcript("pyodm.json", most=4), (22, 25))

    def test_webodms_nodeodm_tests(self):
        self.assertEqual(self.run_transcript("webodm.json", most=2), (9, 9))
