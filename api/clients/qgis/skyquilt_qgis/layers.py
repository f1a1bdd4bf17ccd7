"""Layers of QGIS from a flight's map. Values only: what asks the server is `described`, which a background thread calls; the
layers themselves are made in the main thread from what it answers."""
import dataclasses
import re
from typing import List, Optional
from urllib.parse import unquote
from xml.etree import ElementTree

from qgis.core import QgsFillSymbol, QgsLineSymbol, QgsRasterLayer, QgsVectorLayer

from .skyquilt import Client, Unauthorized

TILES, GEOTIFF, FOOTPRINTS = "tiles", "geotiff", "footprints"
SURFACE, HILLSHADE, GROUND, CONTOURS = "surface", "hillshade", "ground", "contours"
# File and name of what a map has whose job was asked for these heights.
OF_HEIGHTS = {SURFACE: ("dsm.tif", "surface", "dsm"), HILLSHADE: ("dsm_hillshade.tif", "hillshade", "dsm"),
              GROUND: ("dtm.tif", "ground", "dtm"), CONTOURS: ("contours.geojson", "contours", "dtm")}


@dataclasses.dataclass(frozen=True)
class Described:
    """Where a flight's map is to be had, for programs that send no headers."""

    name: str
    address: str  # of the server
    flight_id: str
    tiles: str  # as QGIS' provider of tiles takes it
    token: Optional[str]
    has_new_link: bool  # the token was made for it
    bounds: List[float]  # as of a flight's record
    heights: List[str]  # dsm, dtm: those that the map has

    def below(self, path):
        """An address below the flight's, with the token."""
        return f"{self.address}/api/v1/flights/{self.flight_id}/{path}" + (f"?token={self.token}" if self.token else "")


def links_in(url, sources):
    """The tokens of links to this server that addresses of layers hold: by the flight that each reads."""
    link = re.compile(re.escape(url) + r"/(?:wmts|api/v1/flights)/([0-9a-z]{26})[/?]\S*?token=(sq_share_[\w-]+)")
    return {flight_id: token for source in sources for flight_id, token in link.findall(unquote(source))}


def is_good(url, token, flight_id):
    """Whether a link is neither revoked nor at its end. Asks the server."""
    client = Client(url, token)
    try:
        return client.access()["flight"] == flight_id
    except Unauthorized:
        return False
    finally:
        client.close()


def reading_token(client, flight, known):
    """A token for addresses, which projects keep and others see: the client's own where it only reads, else one for this flight
    alone, which does not end by itself, since saved projects would be empty then (Share on the server's page lists and ends it);
    None where none is asked for. `known`: those that there are already, by flight; one that is made is added."""
    if client.transport.token is None:
        return None
    access = client.access()
    if not access["needs_token"]:
        return None
    if access["scope"] == "read":
        return client.transport.token
    if flight.id not in known or not is_good(client.url, known[flight.id], flight.id):
        known[flight.id] = client.api.add_share(flight.id, {"expires_in_days": None})["token"]
    return known[flight.id]


def described(client, flight_id, known_tokens):
    """What layers of a flight are made of. Asks the server."""
    flight = client.flight(flight_id)
    known = known_tokens.get(flight.id)
    token = reading_token(client, flight, known_tokens)
    with client.transport.request("GET", f"/connect/{flight.id}/qgis.qlr" + (f"?token={token}" if token else "")) as answer:
        definition = ElementTree.fromstring(answer.read_all())
    tiles = flight.tile_json()
    return Described(flight.name, client.url, flight.id, definition.findtext("maplayers/maplayer/datasource"), token,
                     known_tokens.get(flight.id) != known, tiles.get("across_bounds", tiles["bounds"]), tiles["heights"])


def sides_of(bounds):
    """West, south, east, north as one or two boxes within -180 and 180 degrees. Across the antimeridian, where the bounds of
    flights go on beyond 180, they are its west and its east."""
    west, south, east, north = bounds
    return [bounds] if east <= 180 else [[west, south, 180, north], [-180, south, east - 360, north]]


def holds(bounds, lon, lat):
    """Whether a place, its longitude within -180 and 180 degrees, lies within bounds."""
    return any(west <= lon <= east and south <= lat <= north for west, south, east, north in sides_of(bounds))


def lacking(map_of, kind):
    """The heights that a layer of this kind needs and the map was made without; None where it has them."""
    needed = OF_HEIGHTS[kind][2] if kind in OF_HEIGHTS else None
    return needed if needed not in map_of.heights else None


def heights_of(map_of, kind):
    """A layer of the map's heights, likewise."""
    path, word, _ = OF_HEIGHTS[kind]
    source, name = "/vsicurl/" + map_of.below(path), f"{map_of.name} ({word})"
    if kind != CONTOURS:
        return QgsRasterLayer(source, name, "gdal")
    layer = QgsVectorLayer(source, name, "ogr")
    if layer.isValid():
        layer.renderer().setSymbol(QgsLineSymbol.createSimple({"line_color": "#8a5a2b", "line_width": "0.25"}))
        layer.setDisplayExpression('"height_m"')
    return layer


def layer_of(map_of, kind):
    """The layer; its `isValid()` is to be asked."""
    if kind == TILES:
        return QgsRasterLayer(map_of.tiles, map_of.name, "wms")
    if kind == GEOTIFF:
        return QgsRasterLayer("/vsicurl/" + map_of.below("download.tif"), f"{map_of.name} (GeoTIFF)", "gdal")
    if kind in OF_HEIGHTS:
        return heights_of(map_of, kind)
    layer = QgsVectorLayer("/vsicurl/" + map_of.below("photos.geojson"), f"{map_of.name} (photos)", "ogr")
    if layer.isValid():
        outline = {"style": "no", "outline_color": "#d9a441", "outline_width": "0.4"}
        layer.renderer().setSymbol(QgsFillSymbol.createSimple(outline))
        layer.setDisplayExpression('"name"')
    return layer
