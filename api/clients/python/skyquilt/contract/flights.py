"""Flights and their state.

Written by generate.py from api/openapi.json; changes belong there."""
from typing import Any, Dict, Optional, cast

from . import models
from ..transport import Calls


class Flights(Calls):
    """Flights and their state."""

    def add_share(self, flight: str, body: models.AddShareBody) -> models.AddShareAnswer:
        """Make a token that opens this flight alone, for reading. The token is told here and nowhere again. 409 where
        the server asks nobody for a token, or the flight has 100 shares."""
        return cast("models.AddShareAnswer", self._send("POST", "/api/v1/flights/{flight}/shares", json_body=body,
                                                        path={"flight": flight}))

    def change_flight(self, flight: str, body: models.FlightFields) -> models.Flight:
        """Rename a flight or set its options."""
        return cast("models.Flight", self._send("PATCH", "/api/v1/flights/{flight}", json_body=body,
                                                path={"flight": flight}))

    def create_flight(self, body: models.FlightFields, *, idempotency_key: Optional[str] = None) -> models.Flight:
        """Make a flight; as a form with files, store them and queue the job at once."""
        return cast("models.Flight", self._send("POST", "/api/v1/flights", json_body=body,
                                                headers={"Idempotency-Key": idempotency_key}))

    def delete_flight(self, flight: str) -> None:
        """Delete a flight: into the trash. To everyone it is gone, and a running job of it is cancelled. For as many
        days as the server keeps its trash (serve --trash-days; GET /api/v1/trash says how many) it can be restored
        with its files and map; without a trash it is removed for good."""
        self._send("DELETE", "/api/v1/flights/{flight}", path={"flight": flight})

    def get_access(self) -> models.GetAccessAnswer:
        """What who asks may do here."""
        return cast("models.GetAccessAnswer", self._send("GET", "/api/v1/access"))

    def get_control(self, flight: str) -> models.ControlPoints:
        """The surveyed points of a flight and where they are marked in its photos."""
        return cast("models.ControlPoints", self._send("GET", "/api/v1/flights/{flight}/control",
                                                       path={"flight": flight}))

    def get_flight(self, flight: str) -> models.Flight:
        """One flight."""
        return cast("models.Flight", self._send("GET", "/api/v1/flights/{flight}", path={"flight": flight}))

    def ground_of_pixel(self, flight: str, name: str, x: float, y: float) -> models.GroundOfPixelAnswer:
        """Where a photo's pixel lies."""
        return cast("models.GroundOfPixelAnswer", self._send("GET", "/api/v1/flights/{flight}/photos/{name}/ground",
                path={"flight": flight, "name": name}, query={"x": x, "y": y}))

    def inspect_flight(self, flight: str) -> Dict[str, Any]:
        """What is in the files, what is missing, what a map of them will be and cost; before any map is made."""
        return cast("Dict[str, Any]", self._send("GET", "/api/v1/flights/{flight}/verdict", path={"flight": flight}))

    def list_flights(self, *, limit: Optional[int] = None, cursor: Optional[str] = None) -> models.ListFlightsAnswer:
        """Flights, newest first."""
        return cast("models.ListFlightsAnswer", self._send("GET", "/api/v1/flights",
                                                           query={"limit": limit, "cursor": cursor}))

    def list_shares(self, flight: str) -> models.ListSharesAnswer:
        """The shares of a flight that have not ended. For the token that made the flight, and those of scope admin."""
        return cast("models.ListSharesAnswer", self._send("GET", "/api/v1/flights/{flight}/shares",
                                                          path={"flight": flight}))

    def list_trash(self) -> models.ListTrashAnswer:
        """Deleted flights that can be restored, the latest first."""
        return cast("models.ListTrashAnswer", self._send("GET", "/api/v1/trash"))

    def map_statistics(self, flight: str, body: Dict[str, Any]) -> models.MapStatistics:
        """Area and colours within a polygon."""
        return cast("models.MapStatistics", self._send("POST", "/api/v1/flights/{flight}/statistics", json_body=body,
                                                       path={"flight": flight}))

    def photos_at(self, flight: str, lon: float, lat: float) -> models.PhotosAtAnswer:
        """The photos that see a place, the most vertical view first."""
        return cast("models.PhotosAtAnswer", self._send("GET", "/api/v1/flights/{flight}/at", path={"flight": flight},
                                                        query={"lon": lon, "lat": lat}))

    def point_of_map(self, flight: str, lon: float, lat: float) -> models.PointOfMap:
        """Colour, height and photo of a place."""
        return cast("models.PointOfMap", self._send("GET", "/api/v1/flights/{flight}/point", path={"flight": flight},
                                                    query={"lon": lon, "lat": lat}))

    def put_control(self, flight: str, body: models.ControlPoints, *,
                    if_match: Optional[str] = None) -> models.ControlPoints:
        """Keep these surveyed points and marks in place of those there were. They lie among the flight's files as
        gcp_list.txt, which the stitcher reads. A job with the option place: control brings the finished map to
        them."""
        return cast("models.ControlPoints", self._send("PUT", "/api/v1/flights/{flight}/control", json_body=body,
                                                       path={"flight": flight}, headers={"If-Match": if_match}))

    def remove_flight(self, flight: str) -> None:
        """Remove a deleted flight for good, with its files and map. For the token that made it, and those of scope
        admin."""
        self._send("DELETE", "/api/v1/trash/{flight}", path={"flight": flight})

    def restore_flight(self, flight: str) -> models.Flight:
        """Take a deleted flight back. With its files, its map and the uploads that were still coming. A job that its
        deletion cancelled stays cancelled."""
        return cast("models.Flight", self._send("POST", "/api/v1/flights/{flight}/restore", path={"flight": flight}))

    def revoke_share(self, flight: str, share: str) -> None:
        """End a share; its token opens nothing any more."""
        self._send("DELETE", "/api/v1/flights/{flight}/shares/{share}", path={"flight": flight, "share": share})
