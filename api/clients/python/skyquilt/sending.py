"""Files to a flight by tus 1.0, which goes on where a broken connection or a restarted server left off."""
from __future__ import annotations

import base64
import dataclasses
import hashlib
import io
import pathlib
import time
import urllib.parse
import warnings
from typing import BinaryIO, Callable, List, Set, Tuple

from .contract import Operations
from .errors import Conflict, InputError, NotASkyquilt, NotFound, Refused, ServerAway
from .listing import PICTURES, LocalFile
from .progress import OnProgress, Progress, megabytes
from .transport import BLOCK_BYTES, RETRIED, Patience, Transport

VERSION = {"Tus-Resumable": "1.0.0"}
PART_BYTES = 32 << 20  # the share of one request: a proxy between may keep it whole
TELL_EVERY_S = 0.2


class _Part(io.RawIOBase):
    """A part of a file that tells how much of it has been read."""

    def __init__(self, file: BinaryIO, length: int, on_read: Callable[[int], None]) -> None:
        super().__init__()
        self._file, self._left, self._length, self._on_read = file, length, length, on_read

    def readable(self) -> bool:
        return True

    def read(self, size: int = -1) -> bytes:
        wanted = min(self._left, BLOCK_BYTES if size is None or size < 0 else size)
        try:
            content = self._file.read(wanted) if wanted else b""
        except OSError as error:
            raise InputError(f"{getattr(self._file, 'name', 'A file')} cannot be read: {error.strerror}.") from error
        if len(content) < wanted:
            raise InputError(f"{getattr(self._file, 'name', 'A file')} became shorter while it was sent.")
        self._left -= len(content)
        self._on_read(self._length - self._left)
        return content


class Sender:
    """Sends files to one flight and tells how far it is."""

    def __init__(self, transport: Transport, flight_id: str, on_progress: OnProgress) -> None:
        self._transport = transport.patient(transport.patience_s, self._waits)
        self._api = Operations(self._transport)
        self._flight_id, self._on_progress = flight_id, on_progress
        self._files, self._total_bytes = 0, 0
        self._done_files, self._done_bytes, self._told_at = 0, 0, 0.0
        self._last = Progress("upload", 0.0, flight_id=flight_id)

    def send(self, files: List[LocalFile]) -> Tuple[int, int]:
        """(how many were sent, how many the server had). Raises what `Transport.request` does, and `InputError`."""
        there = self._there()
        names = {name for name, _ in there}
        files = [self._told_apart(file, there) if file.name in names else file for file in files]
        lacking = [file for file in files if (file.name, file.bytes) not in there]
        self._files, self._total_bytes = len(lacking), sum(file.bytes for file in lacking)
        for file in lacking:
            try:
                self._send_file(file)
            except Refused as error:
                error.args = (f"{file.name}: {error}",)
                raise
            self._done_files += 1
            self._done_bytes += file.bytes
            self._tell(0, is_due=True)
        return len(lacking), len(files) - len(lacking)

    def _there(self) -> Set[Tuple[str, int]]:
        return {(file["name"], file["bytes"]) for file in self._api.list_files(self._flight_id)["files"]}

    def _told_apart(self, file: LocalFile, there: Set[Tuple[str, int]]) -> LocalFile:
        """A list, log or sidecar whose name is another's there, as where it was edited since, has one by its content, so that it is
        known again."""
        if file.path.suffix.lower() in PICTURES or file.bytes > PART_BYTES:
            return file
        with _opened(file) as content:
            here = content.read()
        own = pathlib.PurePath(file.name)
        marked = f"{own.stem}({hashlib.sha256(here).hexdigest()[:8]}){own.suffix}"
        if (marked, file.bytes) not in there and (file.name, file.bytes) in there and here == self._content(file.name):
            return file
        warnings.warn(f"Another {file.name} is in the flight, and both count: this one is {marked}. If it corrects the other, "
                      f"delete that (client.api.delete_file) and have the map made again.")
        return dataclasses.replace(file, name=marked)

    def _content(self, name: str) -> bytes:
        try:
            with self._api.get_file(self._flight_id, name) as answer:
                return answer.read_all()
        except NotFound:
            return b""  # its bytes are lost there

    def _waits(self, why: str) -> None:
        self._on_progress(Progress("waiting", self._last.fraction, why, self._last.done_bytes, self._total_bytes, self._flight_id))

    def _tell(self, of_this_file: int, is_due: bool = False) -> None:
        now = time.monotonic()
        if not is_due and now - self._told_at < TELL_EVERY_S:
            return
        self._told_at = now
        done = max(self._done_bytes + of_this_file, self._last.done_bytes)  # never backwards
        message = (f"{self._done_files} of {self._files} files, {megabytes(done)} of {megabytes(self._total_bytes)}")
        self._last = Progress("upload", done / max(self._total_bytes, 1), message, done, self._total_bytes, self._flight_id)
        self._on_progress(self._last)

    def _begin(self, file: LocalFile) -> str:
        said = [f"{key} {base64.b64encode(value.encode(errors='surrogateescape')).decode()}"
                for key, value in (("flight", self._flight_id), ("filename", file.name))]
        headers = {**VERSION, "Upload-Length": str(file.bytes), "Upload-Metadata": ",".join(said)}
        # Begun twice, the first one ends unused.
        with self._transport.request("POST", "/api/v1/uploads", headers=headers, is_repeatable=True) as answer:
            answer.read()
            location = answer.headers.get("Location", "")
        if not location:
            raise NotASkyquilt(f"{self._transport.url} takes no uploads.")
        # A server below a path of its host names its addresses with that path, which stands in the URL as well.
        path, base = (urllib.parse.urlsplit(address).path for address in (location, self._transport.url))
        return path[len(base.rstrip("/")):] if path.startswith(base.rstrip("/") + "/") else path

    def _send_file(self, file: LocalFile) -> None:
        with _opened(file) as content:
            place, offset = self._begin(file), 0
            once = self._transport.patient(0.0)
            patience = Patience(self._transport)
            while offset < file.bytes:
                content.seek(offset)
                begun_at = offset
                part = _Part(content, min(PART_BYTES, file.bytes - offset), lambda sent: self._tell(begun_at + sent))
                headers = {**VERSION, "Content-Type": "application/offset+octet-stream", "Upload-Offset": str(offset),
                           "Content-Length": str(min(PART_BYTES, file.bytes - offset))}
                try:
                    with once.request("PATCH", place, body=part, headers=headers) as answer:  # type: ignore[arg-type]
                        answer.read()
                        offset = _offset_of(answer.headers.get("Upload-Offset"))
                    patience.succeeded()
                    continue
                except (ServerAway, Refused) as error:
                    if isinstance(error, NotFound):
                        break  # finished, and its answer was lost; or forgotten
                    if isinstance(error, Refused) and not isinstance(error, Conflict) and error.status not in RETRIED:
                        raise
                    patience.wait(str(error), error)
                known = self._known_offset(once, place)
                if known is None:
                    break
                offset = offset if known < 0 else known
        if offset < file.bytes and (file.name, file.bytes) not in self._there():
            raise ServerAway(f"The server no longer knows the upload of {file.name}. Send it again.")

    @staticmethod
    def _known_offset(once: Transport, place: str) -> "int | None":
        """How much the server has for sure; -1 while it is away, None where it knows nothing of the upload any more."""
        try:
            with once.request("HEAD", place, headers=VERSION) as answer:
                return _offset_of(answer.headers.get("Upload-Offset"))
        except NotFound:
            return None
        except (ServerAway, Refused) as error:
            if isinstance(error, Refused) and error.status not in RETRIED and error.status != 410:
                raise
            return None if isinstance(error, Refused) and error.status == 410 else -1


def _opened(file: LocalFile) -> BinaryIO:
    try:
        return file.path.open("rb")
    except OSError as error:
        raise InputError(f"{file.path} cannot be read: {error.strerror}.") from error


def _offset_of(said: "str | None") -> int:
    if said is None or not said.isdigit():
        raise NotASkyquilt("The server does not say how much of the file it has.")
    return int(said)
