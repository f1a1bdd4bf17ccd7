"""Every document of the STAC catalogue against the official schemas, copies of which lie in SKYQUILT_STAC_SCHEMAS
(docs/developers/developing.md): without that folder nothing is tested."""
import copy
import datetime
import json
import os
import pathlib
import re
import tempfile
import unittest
import urllib.parse

import jsonschema

from flights import made_flights
from program import run, without_metadata
from server_support import Server, ServerTestCase, photos_in

FOLDER = os.environ.get("SKYQUILT_STAC_SCHEMAS")
SPEC = "https://schemas.stacspec.org/v1.0.0/"
CORE = {"Catalog": SPEC + "catalog-spec/json-schema/catalog.json", "Collection": SPEC + "collection-spec/json-schema/collection.json",
        "Feature": SPEC + "item-spec/json-schema/item.json"}
# What STAC API adds: the schemas of its OpenAPI documents.
FEATURES = "https://api.stacspec.org/v1.0.0/ogcapi-features/openapi.yaml#/components/schemas/"
SEARCH = "https://api.stacspec.org/v1.0.0/item-search/openapi.yaml#/components/schemas/"
FOLLOWED = {"self", "root", "parent", "collection", "conformance", "data", "child", "items", "search", "next"}
FORMATS = jsonschema.FormatChecker(formats=())


@FORMATS.checks("date-time", raises=ValueError)
def is_time(text):
    if not isinstance(text, str):
        return True
    datetime.datetime.fromisoformat(re.sub(r"(\.\d+)?(Z|[+-]\d\d:\d\d)$", "", text))
    return re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)", text) is not None


@FORMATS.checks("iri-reference")
def is_reference(text):  # the braces of templates are let through
    return not isinstance(text, str) or re.search(r'[\s<>"\\^`|]', text) is None


@FORMATS.checks("uri")
@FORMATS.checks("url")
@FORMATS.checks("iri")
def is_address(text):
    return not isinstance(text, str) or (is_reference(text) and all(urllib.parse.urlsplit(text)[:2]))


def without_nullable(node):
    """OpenAPI 3.0 writes `nullable` where JSON Schema has another type."""
    if isinstance(node, list):
        return [without_nullable(one) for one in node]
    if not isinstance(node, dict):
        return node
    changed = {key: without_nullable(value) for key, value in node.items()}
    return {**changed, "type": [changed["type"], "null"]} if changed.pop("nullable", False) is True else changed


class Schemas(jsonschema.RefResolver):
    """Those of the folder by their addresses; nothing is fetched."""

    def __init__(self, folder):
        found = [json.loads(path.read_text()) for path in sorted(pathlib.Path(folder).rglob("*.json"))]
        kept = {schema["$id"].rstrip("#"): schema if "$schema" in schema else without_nullable(schema) for schema in found}
        super().__init__("", {}, store=kept)
        for schema in kept.values():
            jsonschema.Draft7Validator.check_schema(schema)

    def resolve_remote(self, uri):
        raise jsonschema.RefResolutionError(f"{uri} is not in the folder of schemas")

    def check(self, document, *addresses):
        for address in addresses:
            jsonschema.Draft7Validator({"$ref": address}, resolver=self, format_checker=FORMATS).validate(document)

    def check_entity(self, document):
        """A catalogue, collection or item, by itself and by the extensions that it names."""
        self.check(document, CORE[document["type"]], *document.get("stac_extensions", []))

    def check_page(self, document, address):
        self.check(document, address)
        for item in document["features"]:
            self.check_entity(item)

    def check_document(self, path, document):
        if path.endswith("/conformance"):
            self.check(document, FEATURES + "conformanceClasses")
        elif path.endswith("/collections"):
            self.check(document, FEATURES + "collections")
            for collection in document["collections"]:
                self.check_entity(collection)
        elif path.endswith("/items"):
            self.check_page(document, FEATURES + "featureCollectionGeoJSON")
        elif path.endswith("/search"):
            self.check_page(document, SEARCH + "itemCollection")
        else:
            self.check_entity(document)
            self.check(document, FEATURES + {"Catalog": "landingPage", "Collection": "collection", "Feature": "item"}[document["type"]])


@unittest.skipUnless(FOLDER, "SKYQUILT_STAC_SCHEMAS names no folder with the official schemas")
class StacSchemas(ServerTestCase):
    """A flight, one that nothing places in space or time, and a map of others."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.schemas = Schemas(FOLDER)
        data = tempfile.mkdtemp(dir=cls.scratch)
        cls.run_program("import", made_flights.small_map() / "mosaic.mbtiles", "--data", data, "--name", "Fields & <woods>")
        cls.server = Server(data, "--workers", "1")
        cls.addClassCleanup(cls.server.stop)
        cls.imported = cls.server.json("GET", "/api/v1/flights")[1]["flights"][0]["id"]
        cls.flown = cls.made(cls.server, cls.photos)
        cls.placeless = cls.made(cls.server, [(name, without_metadata(photo)) for name, photo in cls.photos])

    @classmethod
    def run_program(cls, *words):
        run(*words)

    @staticmethod
    def made(server, photos):
        return server.stitched(photos)["flight"]["id"]

    def item(self, flight):
        return self.server.json("GET", f"/stac/{flight}")[1]

    def walk(self, server):
        """The documents that links lead to from the root on, by method, address and body; lists are asked for one at a time."""
        found, left = {}, [("GET", "/stac", None)]
        while left:
            method, path, body = key = left.pop()
            if key in found:
                continue
            _, document = server.json(method, path, json.loads(body) if body else None, code=200)
            self.schemas.check_document(urllib.parse.urlsplit(path).path, document)
            found[key] = document
            within = [*document.get("features", []), *document.get("collections", [])]
            for link in (link for entity in (document, *within) for link in entity.get("links", []) if link["rel"] in FOLLOWED):
                to = link["href"].removeprefix(f"http://127.0.0.1:{server.port}")
                if link.get("method") == "POST":
                    left.append(("POST", to, json.dumps({"limit": 1, **link.get("body", {})})))
                else:
                    left.append(("GET", to + "?limit=1" * (link["rel"] in ("items", "search")), None))
        return found

    def test_every_document_from_the_root_on(self):
        found = self.walk(self.server)
        flights = {self.flown, self.imported}  # what lies nowhere is in no list
        items = {f"/stac/collections/flights/items/{self.item(flight)['id']}" for flight in flights}
        self.assertLessEqual({"/stac", "/stac/conformance", "/stac/collections", "/stac/collections/flights", *items},
                             {path for method, path, _ in found if method == "GET"})
        for method, list_path in (("GET", "/stac/collections/flights/items"), ("GET", "/stac/search"), ("POST", "/stac/search")):
            pages = [page for (how, path, body), page in found.items()
                     if how == method and urllib.parse.urlsplit(path).path == list_path and "limit" in path + str(body)]
            listed = [item["id"].split("-")[0] for page in pages for item in page["features"]]
            self.assertEqual(sorted(listed), sorted(flights), (method, list_path))
        self.assertEqual(found["GET", "/stac/conformance", None]["conformsTo"], found["GET", "/stac", None]["conformsTo"])

    def test_a_catalogue_without_maps(self):
        self.assertEqual(self.walk(self.serve())["GET", "/stac/search?limit=1", None]["features"], [])

    def test_what_no_camera_knew_has_the_time_it_was_made(self):
        for flight in (self.placeless, self.imported):
            told = self.item(flight)["properties"]
            self.assertEqual(told["datetime"], told["created"])
            self.assertNotIn("start_datetime", told)
        self.assertIn("start_datetime", self.item(self.flown)["properties"])

    def test_a_map_across_the_antimeridian(self):
        """No schema says that its box goes on from the west of it to the east, and that its shape is cut there (RFC 7946)."""
        photos = pathlib.Path(self.scratch, "fiji/photos")
        self.run_program("simulate", "-o", photos.parent, "--photos", "4", "--size", "640x480", "--no-world", "--lat", "-17", "--lon", "180")
        server = self.serve("--workers", "1")
        flight = self.made(server, photos_in(photos))
        self.walk(server)
        item = server.json("GET", f"/stac/{flight}")[1]
        west, _, east, _ = item["bbox"]
        self.assertTrue(179.9 < west < 180 and -180 < east < -179.9, item["bbox"])
        self.assertEqual((item["geometry"]["type"], len(item["geometry"]["coordinates"])), ("MultiPolygon", 2))
        self.assertEqual(server.json("GET", "/stac/collections/flights")[1]["extent"]["spatial"]["bbox"], [item["bbox"]])

    def refused(self, document, check, *steps, value=None):
        """That the document without what the steps lead to, or with another value there, fails its schema."""
        spoilt = copy.deepcopy(document)
        node = spoilt
        for step in steps[:-1]:
            node = node[step]
        if value is None:
            del node[steps[-1]]
        else:
            node[steps[-1]] = value
        with self.assertRaises((jsonschema.ValidationError, jsonschema.RefResolutionError), msg=(steps, value)):
            check(spoilt)
        check(document)

    def test_spoilt_items_are_refused(self):
        item = self.item(self.flown)
        link_of = {link["rel"]: number for number, link in enumerate(item["links"])}
        for *steps, value in (("stac_version", None), ("stac_version", "1.1.0"), ("id", ""), ("bbox", None), ("bbox", item["bbox"][:3]),
                              ("bbox", 0, "7.1"), ("geometry", None), ("geometry", "type", "Square"), ("collection", None), ("assets", None),
                              ("geometry", "coordinates", 0, item["geometry"]["coordinates"][0][:3]), ("assets", "cog", "href", None),
                              ("assets", "cog", "roles", "data"), ("links", 0, "rel", None), ("links", 0, "href", "not an address"),
                              ("links", link_of["wmts"], "wmts:layer", None), ("links", link_of["wms"], "wms:layers", []),
                              ("properties", "datetime", None), ("properties", "datetime", "2024-06-01T10:00:00"),
                              ("properties", "datetime", "2024-06-31T10:00:00Z"), ("properties", "created", "2024-06-01T12:00:00+02:00"),
                              ("properties", "end_datetime", None), ("properties", "gsd", 0), ("properties", "proj:epsg", "EPSG:3857"),
                              ("properties", "proj:shape", [1.5, 2]), ("properties", "proj:other", 1),
                              ("stac_extensions", 1, "https://stac-extensions.github.io/unheard-of/v1.0.0/schema.json")):
            self.refused(item, self.schemas.check_entity, *steps, value=value)

    def test_spoilt_catalogues_collections_and_pages_are_refused(self):
        for path, *steps, value in (("/stac", "conformsTo", None), ("/stac", "description", ""), ("/stac", "links", 0, "method", "PUT"),
                                    ("/stac/conformance", "conformsTo", "all"), ("/stac/collections", "links", None),
                                    ("/stac/collections", "collections", 0, "extent", "temporal", None),
                                    ("/stac/collections/flights", "stac_version", None), ("/stac/collections/flights", "license", "all rights reserved"),
                                    ("/stac/collections/flights", "extent", "spatial", "bbox", 0, [1, 2, 3]),
                                    ("/stac/collections/flights", "extent", "temporal", "interval", 0, 0, "2024-06-01"),
                                    ("/stac/collections/flights/items", "numberReturned", -1),
                                    ("/stac/search", "type", "Features"), ("/stac/search", "features", 0, "stac_version", None),
                                    ("/stac/search", "links", 0, "href", "/stac")):
            document = self.server.json("GET", path)[1]
            self.refused(document, lambda spoilt, path=path: self.schemas.check_document(path, spoilt), *steps, value=value)
