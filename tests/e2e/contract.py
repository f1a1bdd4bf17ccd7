"""The API's contract, api/openapi.json, held against what the server really answers."""
import gzip
import json
import pathlib
import re
import urllib.parse

import jsonschema

SPEC = json.loads(pathlib.Path(__file__, "../../../api/openapi.json").resolve().read_text())


def resolve(node):
    while isinstance(node, dict) and "$ref" in node:
        target = SPEC
        for step in node["$ref"].removeprefix("#/").split("/"):
            target = target[step.replace("~1", "/")]
        node = target
    return node


def pattern_of(template):
    """A template's parameters stand for a segment or a part of one; literal paths win."""
    parts = re.split(r"\{[^}]+\}", template)
    return re.compile("[^/]+".join(re.escape(part) for part in parts) + "$")


PATTERNS = sorted(((pattern_of(path), path) for path in SPEC["paths"]), key=lambda entry: entry[1].count("{"))


def template_of(path):
    return next((template for pattern, template in PATTERNS if pattern.match(path)), None)


def check(method, target, status, headers, body):
    """Raises AssertionError where an answer is not in the contract. HEAD and OPTIONS go as HTTP has them."""
    path = urllib.parse.urlsplit(target).path
    if headers.get("Content-Encoding") == "gzip":
        body = gzip.decompress(body)
    template = template_of(path)
    if method in ("HEAD", "OPTIONS") or status in (304, 416, 431, 408):
        return
    if template is None:
        is_page = headers.get("Content-Type", "").split(";")[0] in ("text/html", "text/css", "text/javascript", "image/svg+xml")
        assert status >= 400 or path == "/" or is_page, f"{method} {target} is not in the contract but answers {status}"
        return
    operation = SPEC["paths"][template].get(method.lower())
    if operation is None:
        assert status in (400, 401, 403, 404, 405, 501), f"{method} {template} is not in the contract but answers {status}"
        return
    responses = operation["responses"]
    described = responses.get(str(status)) or responses.get(f"{status // 100}XX") or responses.get("default")
    assert described, f"{method} {template} answers {status}, which its contract does not have: {body[:300]!r}"
    content = resolve(described).get("content")
    if not content:
        assert body == b"", f"{method} {template} {status} has a body where the contract has none: {body[:300]!r}"
        return
    kind = headers.get("Content-Type", "").split(";")[0].strip()
    media = next((content[key] for key in (kind, kind.split("/")[0] + "/*", "*/*") if key in content), None)
    assert media is not None, f"{method} {template} {status} answers {kind!r}; the contract has {list(content)}"
    if kind.endswith("json") and "schema" in media:
        validator = jsonschema.Draft202012Validator({**media["schema"], "components": SPEC["components"]})
        errors = [f"{error.json_path}: {error.message}" for error in validator.iter_errors(json.loads(body))]
        assert not errors, f"{method} {template} {status}: {errors[:5]}"
