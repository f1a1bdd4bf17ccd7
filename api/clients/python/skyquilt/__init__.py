"""Skyquilt from Python: drone photos in, a georeferenced map out.

    from skyquilt import Client
    flight = Client("http://127.0.0.1:8080").upload("DCIM", name="Field 7").wait()
    flight.download("geotiff", "field7.tif")
"""
from . import errors
from .client import Client
from .contract import Operations, models
from .errors import (BadRequest, Conflict, Forbidden, InputError, JobCancelled, JobFailed, NotASkyquilt, NotFound, OutOfSpace,
                     Refused, ServerAway, ServerFailure, SkyquiltError, TooLarge, TooMany, Unauthorized, Unprocessable)
from .flight import DOWNLOADS, Flight
from .progress import OnProgress, Progress

__version__ = "0.1.0"
__all__ = ["DOWNLOADS", "BadRequest", "Client", "Conflict", "Flight", "Forbidden", "InputError", "JobCancelled", "JobFailed",
           "NotASkyquilt", "NotFound", "OnProgress", "Operations", "OutOfSpace", "Progress", "Refused", "ServerAway",
           "ServerFailure", "SkyquiltError", "TooLarge", "TooMany", "Unauthorized", "Unprocessable", "errors", "models"]
