"""For operators.

Written by generate.py from api/openapi.json; changes belong there."""
from typing import Any, Dict, Mapping, Optional, cast

from . import models
from ..transport import Calls, Answer


class Ops(Calls):
    """For operators."""

    def basemap(self) -> models.BasemapAnswer:
        """What may lie below the maps on the page."""
        return cast("models.BasemapAnswer", self._send("GET", "/basemap.json"))

    def basemap_file(self, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The basemap as a PMTiles file, with Range."""
        return self._stream("GET", "/basemap.pmtiles", headers=headers)

    def contract(self) -> Dict[str, Any]:
        """This document."""
        return cast("Dict[str, Any]", self._send("GET", "/openapi.json"))

    def docs(self, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The contract, to read."""
        return self._stream("GET", "/docs", headers=headers)

    def health(self) -> Dict[str, Any]:
        """Is the server alive."""
        return cast("Dict[str, Any]", self._send("GET", "/healthz"))

    def metrics(self, *, headers: Optional[Mapping[str, str]] = None) -> Answer:
        """Counters as Prometheus text."""
        return self._stream("GET", "/metrics", headers=headers)

    def open_network(self) -> models.OpenNetworkAnswer:
        """Let this network see the server, until it ends. For a server that listens to its own machine alone, and for
        who asks from there (403 for others, also through a proxy). It listens at the machine's addresses besides,
        where every request needs a token, also on a server that asks nobody else for one: a share reads its flight,
        and nobody changes anything who was given no token for it."""
        return cast("models.OpenNetworkAnswer", self._send("POST", "/api/v1/network"))

    def readiness(self) -> Dict[str, Any]:
        """Is the server ready for work."""
        return cast("Dict[str, Any]", self._send("GET", "/readyz"))

    def version(self) -> models.VersionAnswer:
        """Name and version of the server."""
        return cast("models.VersionAnswer", self._send("GET", "/version"))
