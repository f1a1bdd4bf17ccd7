"""A Skyquilt server as a Python object."""
from __future__ import annotations

import ssl
import uuid
from typing import Iterable, Iterator, List, Optional, Union

from .contract import Operations, models
from .errors import SkyquiltError
from .flight import Flight
from .listing import Path, list_files, name_of
from .progress import OnProgress, Progress, ignore
from .sending import Sender
from .transport import Transport, Waiting

QUESTION_PATIENCE_S = 5.0
PAGE = 200


class Client:
    """A server. `url` as in the browser, `token` where it asks for one (`skyquilt token add`). Questions are tried for some
    seconds; uploads, waits and downloads for `patience_s` from the last byte that got through. `api` has every operation of the
    server's contract as it stands there. Threads may share one."""

    def __init__(self, url: str, token: Optional[str] = None, *, patience_s: float = 600.0, timeout_s: float = 60.0,
                 context: Optional[ssl.SSLContext] = None) -> None:
        self.transport = Transport(url, token, patience_s=min(QUESTION_PATIENCE_S, patience_s), timeout_s=timeout_s, context=context)
        self.patience_s = patience_s
        self.url = self.transport.url
        self.api = Operations(self.transport)

    def close(self) -> None:
        """Closes the connection that this thread keeps; a later call makes another."""
        self.transport.forget()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def patient(self, on_waiting: Optional[Waiting] = None) -> Operations:
        """The operations with the patience of uploads and waits."""
        return Operations(self.transport.patient(self.patience_s, on_waiting))

    @staticmethod
    def new_key() -> str:
        """An idempotency key: a request that is sent again with it is done once."""
        return uuid.uuid4().hex

    def access(self) -> models.GetAccessAnswer:
        """Whether the server asks for tokens, and what this one may do."""
        return self.api.get_access()

    def each_flight(self) -> Iterator[Flight]:
        """All flights that the token opens, newest first, asked for as they are needed."""
        cursor: Optional[str] = None
        while True:
            answer = self.api.list_flights(limit=PAGE, cursor=cursor)
            for record in answer["flights"]:
                yield Flight(self, record)
            cursor = answer["next_cursor"]
            if cursor is None:
                return

    def flights(self) -> List[Flight]:
        """All flights that the token opens, newest first."""
        return list(self.each_flight())

    def flight(self, id: str) -> Flight:
        """One flight. `NotFound` where there is none, or not for this token."""
        return Flight(self, self.api.get_flight(id))

    def upload(self, paths: Union[Path, Iterable[Path]], *, name: Optional[str] = None, flight: Optional[str] = None,
               options: Optional[models.JobOptions] = None, progress: OnProgress = ignore, makes_map: bool = True) -> Flight:
        """Sends photos, films and logs (files or folders, or a list of them) and has a map made; `Flight.wait` waits for it.

        A server that is away is waited for, and what has arrived is not sent again. With the id of a `flight` it gets what it
        lacks: to go on with an upload that ended, or to add photos to a map. An error has that id as `flight_id`."""
        paths = paths if isinstance(paths, str) or hasattr(paths, "__fspath__") else list(paths)
        files = list_files(paths)
        api = self.patient(lambda why: progress(Progress("waiting", 0.0, why)))
        if flight is None:
            fields: models.FlightFields = {"name": name if name is not None else name_of(paths)}
            record = api.create_flight(fields, idempotency_key=self.new_key())
        else:
            record = api.get_flight(flight)
        target = Flight(self, record)
        try:
            Sender(self.transport.patient(self.patience_s), target.id, progress).send(files)
            if makes_map:
                target.start(options)
            return Flight(self, api.get_flight(target.id))
        except SkyquiltError as error:
            error.flight_id = target.id
            raise

    def delete(self, id: str) -> None:
        """Puts a flight into the server's trash."""
        self.api.delete_flight(id)

    def restore(self, id: str) -> Flight:
        """Takes a deleted flight back from the trash."""
        return Flight(self, self.api.restore_flight(id))

    def trash(self) -> List[models.TrashedFlight]:
        """Deleted flights that can be restored."""
        return self.api.list_trash()["flights"]


