"""What docs/operations.md has its reader type, for tests that replay it: a command that nobody replays fails, and so does a replay of
what the page no longer has."""
import functools
import pathlib
import re
import shlex
import tempfile

from page_commands import code_spans, shell_blocks, table
from program import run
from server_support import ServerTestCase, bearer

AS_JSON = {"Content-Type": "application/json"}
FLIGHTS = "/api/v1/flights"
COMMANDS = [" ".join(words) for block in shell_blocks("operations.md") for words in block]
SPANS = code_spans("operations.md")
LIMITS = table("operations.md", "option of `serve`")
SCOPES = [scope for scope, _ in table("operations.md", "scope")]
OF_LIMITS = [option for row in LIMITS for option in re.findall(r"`(--[\w-]+)`", row[0])]
# Names, which nobody types: of files, programs, headers and values.
NAMES = {"serve", "skyquilt watch", "/etc/skyquilt.conf", "X-Forwarded-For", "X-Forwarded-Proto", "-Host", "-Prefix", "Retry-After", "private",
         "public", "skyquilt-data.json", "lost/", "catalogue.db", "watch/sent.jsonl", "flights/FLIGHT/exports", "X-Request-Id", "?", "webhook",
         "X-Skyquilt-Signature"}
REPLAYED = []


def replays(*patterns):
    """Hands a test what the page has for each of these patterns, whole: all that a pattern finds, which is something."""
    REPLAYED.extend(patterns)

    def of_page(test):
        @functools.wraps(test)
        def run(self):
            found = [[text for text in COMMANDS + SPANS if re.fullmatch(pattern, text)] for pattern in patterns]
            self.assertTrue(all(found), f"the page no longer has all of {patterns}: {found}")
            return test(self, *(texts[0] if len(texts) == 1 else texts for texts in found))
        return run
    return of_page


class OperationsCase(ServerTestCase):
    def run_page(self, command, code=0, **names):
        """A command of the page on this test's folder, with what is put in place of its names: all that it says."""
        words = [names.get(word, word) for word in shlex.split(command)]
        words = [self.data if before == "--data" else word for before, word in zip(["", *words], words)]
        self.assertEqual(words[0], "skyquilt")
        done = run(*words[1:], code=None, timeout=120)
        self.assertEqual(done.returncode, code, (words, done.stdout, done.stderr))
        return (done.stdout + done.stderr).strip()

    def serve_page(self, command, *more):
        """A server by a command of the page, or by its options, at a port that is free."""
        words = shlex.split(command.removeprefix("skyquilt ").removeprefix("serve "))
        options = dict(zip(words, words[1:]))
        words = [word for before, word in zip(["", *words], words) if not {before, word} & {"--data", "--listen"}]
        return self.serve("--workers", "0", *words, *more, listen=options.get("--listen", "127.0.0.1:0").replace("8080", "0"))

    def token(self, scope, *more):
        return bearer(self.run_page(shlex.join(["skyquilt", "token", "add", scope, "--data", "data", "--scope", scope, *more])))

    def status(self, server, path=FLIGHTS, method="GET", body=None, **headers):
        return server.request(method, path, body, {name.replace("_", "-"): value for name, value in headers.items()})[0]

    def photos_in(self, name, count=2):
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.scratch), name)
        folder.mkdir()
        for photo, content in self.photos[:count]:
            (folder / photo).write_bytes(content)
        return folder
