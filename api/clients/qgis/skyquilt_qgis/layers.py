"""Layers of QGIS from a flight's map. Values only: what asks the server is `described`, which a background thread calls; the
layers themselves are made in the main thread from what it answers."""
import dataclasses
from typing import List, Optional
from xml.etree import ElementTree

from qgis.core import QgsFillSymbol, QgsRasterLayer, QgsVectorLayer

from .skyquilt import Conflict

TILES, GEOTIFF, FOOTPRINTS = "tiles", "geotiff", "footprints"


@dataclasses.dataclass(frozen=True)
class Described:
    """Where a flight's map is to be had, for programs that send no headers."""

    name: str
    address: str  # of the server
    flight_id: str
    tiles: str  # as QGIS' provider of tiles takes it
    token: Optional[str]
    bounds: List[float]

    def below(self, path):
        """An address below the flight's, with the token."""
        return f"{self.address}/api/v1/flights/{self.flight_id}/{path}" + (f"?token={self.token}" if self.token else "")


def reading_token(client, flight, known):
    """A token for addresses, which projects keep and others see: the client's own where it only reads, else one made for this
    flight alone (Share on the server's page lists and ends it); None where none is asked for. `known` keeps those made."""
    if client.transport.token is None:
        return None
    access = client.access()
    if not access["needs_token"]:
        return None
    if access["scope"] == "read":
        return client.transport.token
    if flight.id not in known:
        try:
            known[flight.id] = client.api.add_share(flight.id, {"expires_in_days": None})["token"]
        except Conflict:
            return client.transport.token  # as many as there may be; what stands in an address only reads
    return known[flight.id]


def described(client, flight_id, known_tokens):
    """What layers of a flight are made of. Asks the server."""
    flight = client.flight(flight_id)
    token = reading_token(client, flight, known_tokens)
    with client.transport.request("GET", f"/connect/{flight.id}/qgis.qlr" + (f"?token={token}" if token else "")) as answer:
        definition = ElementTree.fromstring(answer.read_all())
    return Described(flight.name, client.url, flight.id, definition.findtext("maplayers/maplayer/datasource"), token,
                     flight.tile_json()["bounds"])


def layer_of(map_of, kind):
    """The layer; its `isValid()` is to be asked."""
    if kind == TILES:
        return QgsRasterLayer(map_of.tiles, map_of.name, "wms")
    if kind == GEOTIFF:
        return QgsRasterLayer("/vsicurl/" + map_of.below("download.tif"), f"{map_of.name} (GeoTIFF)", "gdal")
    layer = QgsVectorLayer("/vsicurl/" + map_of.below("photos.geojson"), f"{map_of.name} (photos)", "ogr")
    if layer.isValid():
        outline = {"style": "no", "outline_color": "#d9a441", "outline_width": "0.4"}
        layer.renderer().setSymbol(QgsFillSymbol.createSimple(outline))
        layer.setDisplayExpression('"name"')
    return layer
