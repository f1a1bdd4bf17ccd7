"""Writes skyquilt/contract from the server's contract, api/openapi.json: a type for every document and a method for every
operation. `generate.py` writes, `generate.py --check` says (exit code 1) whether what lies there is what would be written.

Left to others: protocols that have clients of their own (tags node and standards) and tus (tag uploads), which
skyquilt/sending.py speaks. Of operations that take several kinds of body the JSON one is offered.

Types are TypedDicts: what the server said, to the letter, also where a later server says more. Python 3.9 reads them,
which is what QGIS 3.22 brings."""
import argparse
import json
import keyword
import pathlib
import re
import sys
import textwrap

HERE = pathlib.Path(__file__).resolve().parent
CONTRACT = HERE.parents[1] / "openapi.json"
TARGET = HERE / "skyquilt" / "contract"
LEFT_TO_OTHERS = {"node", "standards", "uploads"}
LEFT_OUT_TYPES = re.compile(r"Node|Ogc|Stac|StatusInfo|ResumableUpload")  # of the same
PLAIN = {"string": "str", "integer": "int", "number": "float", "boolean": "bool", "null": "None"}
HEAD = '"""{}\n\nWritten by generate.py from api/openapi.json; changes belong there."""\n'
ANSWERS_TO_FORMS = {("createFlight", "202")}  # methods send JSON, so that these never come
MAX_LINES = 430  # of a file of types
VERBS = ("get", "post", "put", "patch", "delete")


def camel(text):
    return "".join(part[:1].upper() + part[1:] for part in re.split(r"[^0-9A-Za-z]+", text))


def snake(text):
    return re.sub(r"[^0-9a-z]+", "_", re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", text).lower()).strip("_")


def parameter_name(text):
    name = snake(text)
    return name + "_" if keyword.iskeyword(name) else name


def docstring(text, indent):
    """The text as a docstring, wrapped."""
    text = " ".join(text.split()).replace("\\", "\\\\").replace('"""', "'''")
    text = text + ("" if text.endswith((".", "?", "!")) else ".")
    lines = textwrap.wrap(text + ('"' if text.endswith('"') else ""), 116 - len(indent), break_on_hyphens=False)
    return "\n".join([indent + '"""' + lines[0], *(indent + line for line in lines[1:])]) + '"""\n'


def comment(text, indent):
    return "".join(f"{indent}# {line}\n" for line in textwrap.wrap(" ".join(text.split()), 116 - len(indent), break_on_hyphens=False))


class Models:
    """The types of documents, in the order in which they can be read."""

    def __init__(self, schemas):
        self.schemas, self.written, self.text = schemas, set(), []

    def type_of(self, schema, name, quoted=False):
        """How a schema is said in Python; objects become types called `name`."""
        if "$ref" in schema:
            target = schema["$ref"].rsplit("/", 1)[1]
            self.write(target, self.schemas[target])
            return target
        if "enum" in schema or "const" in schema:
            values = schema.get("enum", [schema.get("const")])
            return f"Literal[{', '.join(repr(value) for value in values)}]"
        for key in ("oneOf", "anyOf"):
            if key in schema:
                return self.union([self.type_of(one, f"{name}{number or ''}") for number, one in enumerate(schema[key])])
        kinds = schema.get("type", [])
        kinds = [kinds] if isinstance(kinds, str) else kinds
        return self.union([self.of_kind(kind, schema, name) for kind in kinds] or ["Any"])

    @staticmethod
    def union(types):
        flat = [one for kind in types for one in (kind[6:-1].split(", ") if kind.startswith("Union[") else [kind])]
        types = list(dict.fromkeys(flat))
        if len(types) == 1:
            return types[0]
        if "None" in types:
            return f"Optional[{Models.union([one for one in types if one != 'None'])}]"
        return f"Union[{', '.join(types)}]"

    def of_kind(self, kind, schema, name):
        if kind == "array":
            return f"List[{self.type_of(schema.get('items', {}), name + 'Item')}]"
        if kind != "object":
            return PLAIN[kind]
        if schema.get("properties") or schema.get("required"):
            self.write(name, schema)
            return name
        inner = schema.get("additionalProperties")
        return f"Dict[str, {self.type_of(inner, name + 'Value') if isinstance(inner, dict) else 'Any'}]"

    def write(self, name, schema):
        if name in self.written:
            return
        self.written.add(name)
        properties, required = schema.get("properties", {}), schema.get("required", [])
        fields = [(key, properties.get(key, {})) for key in dict.fromkeys([*properties, *required])]
        types = {key: self.type_of(value, name + camel(key)) for key, value in fields}
        if any(keyword.iskeyword(key) or not key.isidentifier() for key in types):
            inner = ", ".join(f'"{key}": {kind}' for key, kind in types.items())
            self.text.append(f'{name} = TypedDict("{name}", {{{inner}}})\n')
            return
        for_sure = [one for one in fields if one[0] in required]
        perhaps = [one for one in fields if one[0] not in required]
        about = schema.get("description", "")
        if for_sure and perhaps:
            self.write_class(f"{name}ForSure", "TypedDict", f"What {name} always has", for_sure, types)
            self.write_class(name, f"{name}ForSure, total=False", about, perhaps, types)
        else:
            self.write_class(name, "TypedDict" if for_sure else "TypedDict, total=False", about, for_sure or perhaps, types)

    def write_class(self, name, base, about, fields, types):
        text = f"class {name}({base}):\n" + (docstring(about, "    ") if about else "")
        for key, schema in fields:
            text += comment(schema.get("description", ""), "    ") + f"    {key}: {types[key]}\n"
        self.text.append(text)

    def sources(self):
        """Name of a file: its text. Later documents are made of earlier ones, so that a file takes all of those before it;
        models.py is the last and has every type."""
        parts = [[]]
        for text in self.text:
            if sum(one.count("\n") + 2 for one in parts[-1]) + text.count("\n") > MAX_LINES:
                parts.append([])
            parts[-1].append(text)
        names = [f"documents_{number}" for number in range(1, len(parts))] + ["models"]
        head = HEAD.format("The documents that the server takes and answers.")
        files = {}
        for number, (name, part) in enumerate(zip(names, parts)):
            body = "\n\n".join(part)
            used = [one for one in ("Any", "Dict", "List", "Literal", "Optional", "TypedDict", "Union") if re.search(rf"\b{one}\b", body)]
            earlier = "".join(f"from .{one} import *  # noqa: F401,F403\n" for one in names[:number])
            files[f"{name}.py"] = head + f"from typing import {', '.join(used)}\n" + (f"\n{earlier}" if earlier else "") + "\n\n" + body
        return files


class Operation:
    """One operation of the contract as a method."""

    def __init__(self, verb, path, shared, operation, models):
        self.verb, self.path, self.operation, self.models = verb, path, operation, models
        self.name = snake(operation["operationId"])
        merged = {(one["in"], one["name"]): one for one in [*shared, *operation.get("parameters", [])]}
        self.parameters = sorted(merged.values(), key=lambda one: (one["in"] != "path", not one.get("required", False)))
        self.body = operation.get("requestBody", {}).get("content", {})

    def can_be_written(self):
        return not self.body or "application/json" in self.body or "application/octet-stream" in self.body

    def answer(self):
        """(kind of answer, its type): json, stream, or none."""
        kinds, types = set(), []
        for status, response in sorted(self.operation["responses"].items()):
            if (self.operation["operationId"], status) in ANSWERS_TO_FORMS:
                continue
            for media, content in response.get("content", {}).items() if status[0] == "2" else ():
                kinds.add("json" if media.endswith("json") and status != "206" else "" if status == "206" else "stream")
                if media.endswith("json") and status != "206":
                    own = camel(self.operation["operationId"]) + ("Answer" if not types else f"Answer{status}")
                    types.append(self.models.type_of(content.get("schema", {}), own))
        kinds.discard("")
        if "stream" in kinds:
            return "stream", "Answer"
        if "json" in kinds:
            kind = Models.union(types)
            return "json", kind
        return "none", "None"

    def body_argument(self):
        """(argument, keyword in the call) of the body."""
        if "application/json" in self.body:
            kind = self.models.type_of(self.body["application/json"].get("schema", {}), camel(self.operation["operationId"]) + "Body")
            return (f"body: {self.qualified(kind)}", "json_body=body")
        if self.body:
            return ("body: Body", "body=body")
        return None

    def qualified(self, kind):
        return re.sub(r"\b([A-Z]\w+)\b", lambda found: f"models.{found[1]}" if found[1] in self.models.written else found[1], kind)

    def source(self):
        kind, answer = self.answer()
        arguments, call = ["self"], [f'"{self.verb.upper()}"', f'"{self.path}"']
        by_place = {"path": [], "query": [], "header": []}
        optional = []
        for one in self.parameters:
            name = parameter_name(one["name"])
            by_place[one["in"]].append(f'"{one["name"]}": {name}')
            typed = self.models.type_of(one.get("schema", {}), camel(name))
            typed = "str" if one["in"] == "path" and typed == "str" else typed
            if one["in"] == "path" or one.get("required"):
                arguments.append(f"{name}: {typed}")
            else:
                typed = typed if typed.startswith("Optional") else f"Optional[{typed}]"
                optional.append(f"{name}: {typed} = None")
        if self.body_argument():
            argument, said = self.body_argument()
            arguments.append(argument)
            call.append(said)
        if kind == "stream":
            optional.append("headers: Optional[Mapping[str, str]] = None")
        for place, said in (("path", "path"), ("query", "query"), ("header", "headers")):
            if by_place[place]:
                call.append(f"{said}={{{', '.join(by_place[place])}}}")
        if kind == "stream":
            call = [one for one in call if not one.startswith("headers=")]
            own = ", ".join(by_place["header"])
            call.append(f"headers={{{own}, **(headers or {{}})}}" if own else "headers=headers")
        arguments += (["*"] if optional else []) + optional
        about = self.operation.get("summary", self.name)
        about += ("" if about.endswith(".") else ".") + " " + self.operation.get("description", "")
        sent = "self._stream(" if kind == "stream" else "self._send("
        start, end = {"none": (sent, ")"), "stream": (f"return {sent}", ")"),
                      "json": (f"return cast({json.dumps(self.qualified(answer))}, {sent}", "))")}[kind]
        return (wrapped(f"    def {self.name}(", arguments, f") -> {self.qualified(answer)}:") + docstring(about, "        ") +
                wrapped(f"        {start}", call, end))


def wrapped(start, arguments, end):
    """A line of code with as many arguments in a line as fit."""
    lines = [start]
    for number, argument in enumerate(arguments):
        is_last = number == len(arguments) - 1
        said = argument + (end if is_last else ",")
        if len(lines[-1]) + len(said) + 1 > 120 and number > 0:
            lines.append(" " * len(start) if len(start) < 60 else " " * (len(start) - len(start.lstrip()) + 8))
            lines[-1] += said
        else:
            lines[-1] += said if number == 0 else " " + said
    return "\n".join(lines) + "\n"


def sources():
    """Name of a file: its text."""
    contract = json.loads(CONTRACT.read_text())
    models = Models(contract["components"]["schemas"])
    for name, schema in models.schemas.items():
        if not LEFT_OUT_TYPES.match(name):
            models.write(name, schema)
    rooms = {}
    for path, item in contract["paths"].items():
        for verb in VERBS:
            operation = item.get(verb)
            if operation is None or set(operation["tags"]) & LEFT_TO_OTHERS:
                continue
            made = Operation(verb, path, item.get("parameters", []), operation, models)
            if made.can_be_written():
                rooms.setdefault(operation["tags"][0], []).append(made)
    about = {tag["name"]: tag["description"] for tag in contract["tags"]}
    files = {}
    for room, operations in sorted(rooms.items()):
        methods = "\n".join(one.source() for one in sorted(operations, key=lambda one: one.name))
        used = [name for name in ("Any", "Dict", "List", "Literal", "Mapping", "Optional", "Union", "cast") if re.search(rf"\b{name}\b", methods)]
        ours = [name for name in ("Answer", "Body") if re.search(rf"(?<![\w.]){name}\b", methods)]
        imports = [f"from typing import {', '.join(used)}"] if used else []
        imports += [""] + (["from skyquilt.contract import models"] if "models." in methods else [])
        imports += [f"from skyquilt.transport import {', '.join(['Calls', *sorted(ours)])}"]
        imports = [line.replace("from skyquilt.contract import models", "from . import models")
                   .replace("from skyquilt.", "from ..") for line in imports]
        files[f"{room}.py"] = (HEAD.format(about[room] + ".") + "\n".join(imports).lstrip("\n") +
                               f"\n\n\nclass {camel(room)}(Calls):\n" + docstring(about[room], "    ") + "\n" + methods)
    files.update(models.sources())
    rooms = sorted(rooms)
    files["__init__.py"] = (HEAD.format("Every operation of the server's contract.") +
                            "\n".join(f"from .{room} import {camel(room)}" for room in rooms) +
                            f"\n\n\nclass Operations({', '.join(camel(room) for room in rooms)}):\n" +
                            docstring("All operations; `skyquilt.Client.api` is one", "    "))
    return files


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing, say what differs")
    is_check = parser.parse_args().check
    wanted = sources()
    there = {path.name: path.read_text() for path in TARGET.glob("*.py")}
    if not is_check:
        TARGET.mkdir(exist_ok=True)
        for name in there.keys() - wanted.keys():
            (TARGET / name).unlink()
        for name, text in wanted.items():
            (TARGET / name).write_text(text)
        return 0
    differ = sorted(name for name in there.keys() | wanted.keys() if there.get(name) != wanted.get(name))
    for name in differ:
        print(f"api/clients/python/skyquilt/contract/{name} is not what api/openapi.json says; run api/clients/python/generate.py")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
