"""A file from the server, which goes on where it broke off: in the same call, or in a later one."""
from __future__ import annotations

import os
import pathlib
import re
from typing import Callable, Mapping

from .errors import Refused, ServerAway
from .progress import OnProgress, Progress, megabytes
from .transport import Answer, BrokenOff, Patience, Transport

BLOCK_BYTES = 1 << 18
Open = Callable[[Mapping[str, str]], Answer]


def fetch(transport: Transport, open_at: Callable[[Transport], Open], path: pathlib.Path, on_progress: OnProgress) -> None:
    """Writes the file to `path`. Until it is whole it lies beside it as `.part`, with the server's mark of its content in
    `.part.etag`; a later call goes on from there while the server's file is the same. Raises `ServerAway`, `Refused`, OSError."""
    part, mark = path.with_name(path.name + ".part"), path.with_name(path.name + ".part.etag")
    last = Progress("download", 0.0)

    def waits(why: str) -> None:
        on_progress(Progress("waiting", last.fraction, why, last.done_bytes, last.total_bytes))

    patience = Patience(transport.patient(transport.patience_s, waits))
    open_once = open_at(transport.patient(transport.patience_s, waits))
    while True:
        have = part.stat().st_size if part.exists() and mark.exists() else 0
        headers = {"Range": f"bytes={have}-", "If-Range": mark.read_text()} if have else {}
        try:
            with open_once({**headers, "Accept-Encoding": "identity"}) as answer:
                begin = _begin_of(answer, have)
                length = answer.headers.get("Content-Length", "")
                total = begin + int(length) if length.isdigit() else 0
                with part.open("r+b" if begin else "wb") as file:
                    file.seek(begin)
                    file.truncate()
                    _remember(mark, answer.headers.get("ETag", ""))
                    done = begin
                    while True:
                        content = answer.read(BLOCK_BYTES)
                        if not content:
                            break
                        file.write(content)
                        done += len(content)
                        last = Progress("download", done / total if total else 0.0, f"{megabytes(done)} of {megabytes(total)}", done, total)
                        on_progress(last)
                        patience.succeeded()
                if total and done < total:
                    raise BrokenOff(f"{megabytes(total - done)} of it are lacking")
            break
        except Refused as error:
            if error.status != 416 or not have:
                raise
            mark.unlink()  # nothing is left of what was to come: begin anew
        except BrokenOff as error:
            patience.wait(str(error), error)
    os.replace(part, path)
    mark.unlink(missing_ok=True)


def _begin_of(answer: Answer, have: int) -> int:
    """Where in the file the answer begins."""
    if answer.status != 206:
        return 0
    found = re.match(r"bytes (\d+)-", answer.headers.get("Content-Range", ""))
    if found is None or int(found.group(1)) != have:
        raise ServerAway("The server answered another part of the file than it was asked for. Remove the .part file.")
    return have


def _remember(mark: pathlib.Path, etag: str) -> None:
    """A weak mark, or none, promises nothing of the bytes: then the next try begins anew."""
    if etag and not etag.startswith("W/"):
        mark.write_text(etag)
    else:
        mark.unlink(missing_ok=True)
