"""Flights and their state.

Written by generate.py from api/openapi.json; changes belong there."""
from typing import Any, Dict, Literal, Mapping, Optional, Union, cast

from . import models
from ..transport import Calls, Answer


class Flights(Calls):
    """Flights and their state."""

    def add_share(self, flight: str, body: models.AddShareBody) -> models.AddShareAnswer:
        """Make a token that opens this flight alone, for reading. The token is told here and nowhere again; it only
        reads also where the server asks nobody for one. 409 where the flight has 100 shares."""
        return cast("models.AddShareAnswer", self._send("POST", "/api/v1/flights/{flight}/shares", json_body=body,
                                                        path={"flight": flight}))

    def change_flight(self, flight: str, body: models.FlightFields) -> models.Flight:
        """Rename a flight, set its options or tags, mark it to be kept."""
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

    def get_notes(self, flight: str) -> models.MapNotes:
        """Notes and measurements on the map of a flight. What somebody wrote on the map for all who open the flight:
        points with words, measured lines and areas."""
        return cast("models.MapNotes", self._send("GET", "/api/v1/flights/{flight}/notes", path={"flight": flight}))

    def ground_heights(self, flight: str, body: Dict[str, Any]) -> models.GroundProfile:
        """The ground's height along a line. Heights of the ground that the map was rendered on, as its alignment or an
        elevation model says, at even steps along the line and at its corners. Metres, counted as those of the
        surveyed points that place the map, else from the zero of the flight's records, as /point has them: what
        lies between two places of one map is much more accurate than where zero lies. A map that was imported, or
        made before cameras were kept, knows none (404)."""
        return cast("models.GroundProfile", self._send("POST", "/api/v1/flights/{flight}/heights", json_body=body,
                                                       path={"flight": flight}))

    def ground_of_pixel(self, flight: str, name: str, x: float, y: float) -> models.GroundOfPixelAnswer:
        """Where a photo's pixel lies."""
        return cast("models.GroundOfPixelAnswer", self._send("GET", "/api/v1/flights/{flight}/photos/{name}/ground",
                path={"flight": flight, "name": name}, query={"x": x, "y": y}))

    def index_legend(self, flight: str, *, index: Optional[str] = None, expression: Optional[str] = None,
                     rescale: Optional[str] = None, colormap: Optional[str] = None,
                     headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The colours of an index with their values, as a picture."""
        return self._stream("GET", "/api/v1/flights/{flight}/legend.svg", path={"flight": flight},
                            query={"index": index, "expression": expression, "rescale": rescale, "colormap": colormap},
                            headers=headers)

    def index_legend_png(self, flight: str, *, index: Optional[str] = None, expression: Optional[str] = None,
                         rescale: Optional[str] = None, colormap: Optional[str] = None,
                         headers: Optional[Mapping[str, str]] = None) -> Answer:
        """The colours of an index with their values, as a picture in pixels, 320 x 64."""
        return self._stream("GET", "/api/v1/flights/{flight}/legend.png", path={"flight": flight},
                            query={"index": index, "expression": expression, "rescale": rescale, "colormap": colormap},
                            headers=headers)

    def inspect_flight(self, flight: str) -> Dict[str, Any]:
        """What is in the files, what is missing, what a map of them will be and cost; before any map is made."""
        return cast("Dict[str, Any]", self._send("GET", "/api/v1/flights/{flight}/verdict", path={"flight": flight}))

    def list_flights(self, *, limit: Optional[int] = None, cursor: Optional[str] = None,
                     tag: Optional[str] = None) -> models.ListFlightsAnswer:
        """Flights, newest first."""
        return cast("models.ListFlightsAnswer", self._send("GET", "/api/v1/flights",
                                                           query={"limit": limit, "cursor": cursor, "tag": tag}))

    def list_shares(self, flight: str) -> models.ListSharesAnswer:
        """The shares of a flight that have not ended. For the token that made the flight, and those of scope admin."""
        return cast("models.ListSharesAnswer", self._send("GET", "/api/v1/flights/{flight}/shares",
                                                          path={"flight": flight}))

    def list_trash(self) -> models.ListTrashAnswer:
        """Deleted flights that can be restored, the latest first."""
        return cast("models.ListTrashAnswer", self._send("GET", "/api/v1/trash"))

    def map_bands(self, flight: str) -> models.MapBands:
        """Bands of a map, and the indices and colours for them."""
        return cast("models.MapBands", self._send("GET", "/api/v1/flights/{flight}/bands", path={"flight": flight}))

    def map_statistics(self, flight: str, body: Dict[str, Any], *, index: Optional[str] = None,
                       expression: Optional[str] = None, max_pixels: Optional[int] = None) -> models.MapStatistics:
        """Area and colours within a polygon."""
        return cast("models.MapStatistics", self._send("POST", "/api/v1/flights/{flight}/statistics", json_body=body,
                                                       path={"flight": flight},
                                                       query={"index": index, "expression": expression, "max_pixels": max_pixels}))

    def map_volume(self, flight: str, body: Dict[str, Any], *, of: Optional[Literal['dsm', 'dtm']] = None,
                   base: Optional[Union[str, float]] = None, since: Optional[str] = None,
                   align: Optional[Literal['auto', 'none']] = None) -> models.MapVolume:
        """Volume above and below a base within a polygon. Of the map's heights (its job's option heights): cut is what
        lies above the base, fill what is missing below it. A map without heights has none (404)."""
        return cast("models.MapVolume", self._send("POST", "/api/v1/flights/{flight}/volume", json_body=body,
                                                   path={"flight": flight},
                                                   query={"of": of, "base": base, "since": since, "align": align}))

    def map_zones(self, flight: str, *, index: Optional[str] = None, expression: Optional[str] = None,
                  classes: Optional[int] = None, resolution_m: Optional[float] = None,
                  format: Optional[Literal['geojson', 'shp']] = None,
                  headers: Optional[Mapping[str, str]] = None) -> Answer:
        """Zones of a map by an index, for spreaders and sprayers. Classes of as much land each, small patches joined,
        with mean value and area of each."""
        return self._stream("GET", "/api/v1/flights/{flight}/zones", path={"flight": flight},
                            query={"index": index, "expression": expression, "classes": classes, "resolution_m": resolution_m, "format": format},
                            headers=headers)

    def photos_at(self, flight: str, lon: float, lat: float) -> models.PhotosAtAnswer:
        """The photos that see a place, the sharpest and most vertical view first."""
        return cast("models.PhotosAtAnswer", self._send("GET", "/api/v1/flights/{flight}/at", path={"flight": flight},
                                                        query={"lon": lon, "lat": lat}))

    def point_of_map(self, flight: str, lon: float, lat: float, *, index: Optional[str] = None,
                     expression: Optional[str] = None,
                     ground: Optional[Literal['true', 'false']] = None) -> models.PointOfMap:
        """Colour, height and photo of a place."""
        return cast("models.PointOfMap", self._send("GET", "/api/v1/flights/{flight}/point", path={"flight": flight},
                                                    query={"lon": lon, "lat": lat, "index": index, "expression": expression, "ground": ground}))

    def put_control(self, flight: str, body: models.ControlPoints, *,
                    if_match: Optional[str] = None) -> models.ControlPoints:
        """Keep these surveyed points and marks in place of those there were. They lie among the flight's files as
        gcp_list.txt, which the stitcher reads. A job with the option place: control brings the finished map to
        them."""
        return cast("models.ControlPoints", self._send("PUT", "/api/v1/flights/{flight}/control", json_body=body,
                                                       path={"flight": flight}, headers={"If-Match": if_match}))

    def put_notes(self, flight: str, body: models.MapNotes, *, if_match: Optional[str] = None) -> models.MapNotes:
        """Keep these notes in place of those there were. They lie among the flight's files as map_notes.geojson, of
        which no map is made. Where there are notes already, If-Match has to say which are replaced: 412 without it,
        so that nobody's are lost. While a job reads the flight's files they cannot be replaced (409)."""
        return cast("models.MapNotes", self._send("PUT", "/api/v1/flights/{flight}/notes", json_body=body,
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
