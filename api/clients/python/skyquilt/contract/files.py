"""Photos and logs of a flight.

Written by generate.py from api/openapi.json; changes belong there."""
from typing import Mapping, Optional, Union, cast

from . import models
from ..transport import Calls, Answer, Body


class Files(Calls):
    """Photos and logs of a flight."""

    def delete_file(self, flight: str, name: str) -> None:
        """Remove one file."""
        self._send("DELETE", "/api/v1/flights/{flight}/files/{name}", path={"flight": flight, "name": name})

    def get_file(self, flight: str, name: str, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """A file as it was uploaded: photos to look at, others for saving."""
        return self._stream("GET", "/api/v1/flights/{flight}/files/{name}", path={"flight": flight, "name": name},
                            headers=headers)

    def list_files(self, flight: str) -> models.ListFilesAnswer:
        """Files of a flight."""
        return cast("models.ListFilesAnswer", self._send("GET", "/api/v1/flights/{flight}/files",
                                                         path={"flight": flight}))

    def put_file(self, flight: str, name: str, body: Body, *, content_digest: Optional[str] = None,
                 if_match: Optional[str] = None) -> Union[models.File, models.PutFileAnswer2011]:
        """Store one file (curl -T). An archive (.zip, .tar, .tar.gz, .tgz) becomes the files in it. A part of a file
        (Content-Range, 400) and an encoded body (Content-Encoding, 415) are refused. The same bytes under the same
        name again are answered 200 and change nothing. Other bytes, as a second card has under the same name, are
        refused (409) unless If-Match says that they replace what is there."""
        return cast("Union[models.File, models.PutFileAnswer2011]", self._send("PUT",
                "/api/v1/flights/{flight}/files/{name}", body=body, path={"flight": flight, "name": name},
                headers={"Content-Digest": content_digest, "If-Match": if_match}))
