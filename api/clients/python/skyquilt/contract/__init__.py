"""Every operation of the server's contract.

Written by generate.py from api/openapi.json; changes belong there."""
from .downloads import Downloads
from .events import Events
from .files import Files
from .flights import Flights
from .jobs import Jobs
from .ops import Ops
from .tiles import Tiles


class Operations(Downloads, Events, Files, Flights, Jobs, Ops, Tiles):
    """All operations; `skyquilt.Client.api` is one."""
