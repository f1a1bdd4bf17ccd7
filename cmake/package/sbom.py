"""Writes what the program is made of as a CycloneDX 1.5 document: the Debian packages of the libraries that are loaded
with it or by it, directly or by each other, those whose headers are compiled into it, and the npm packages of the page.

Reads ELF files by readelf and asks dpkg whose they are, so that programs of another architecture can be listed too where
their libraries are installed (multiarch). A library without a package is listed by its name and file alone."""
import argparse
import base64
import datetime
import json
import os
import pathlib
import re
import subprocess
import sys
import time
import urllib.parse
import uuid

# Whose code is in the program itself; ARCHITECTURE.md has them with the others.
HEADERS = ("libboost-dev", "libcli11-dev", "libeigen3-dev", "nlohmann-json3-dev")
TRIPLETS = {"Advanced Micro Devices X86-64": "x86_64-linux-gnu", "AArch64": "aarch64-linux-gnu"}


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True, env={**os.environ, "LC_ALL": "C"}).stdout


class Libraries:
    """Which shared libraries a program loads, and by which others."""

    def __init__(self, program):
        machine = re.search(r"Machine:\s+(.*)", run("readelf", "-h", program))[1]
        triplet = TRIPLETS.get(machine)
        if triplet is None:
            sys.exit(f"sbom.py knows no libraries for {machine}: add its triplet to TRIPLETS.")
        self.folders = [pathlib.Path(root, triplet) for root in ("/lib", "/usr/lib")] + [pathlib.Path("/lib"), pathlib.Path("/lib64")]
        self.found, self.missing = {}, set()
        self.needs = {program: self.follow(program)}

    def follow(self, path):
        said = run("readelf", "-W", "-d", path)
        own = [pathlib.Path(folder.replace("$ORIGIN", str(pathlib.Path(path).parent)))
               for line in re.findall(r"\((?:RPATH|RUNPATH)\).*\[(.*)\]", said) for folder in line.split(":") if folder]
        needed = []
        # Loaded when they are first needed: the note of systemd's "ELF dlopen metadata".
        late = re.findall(r'"soname":\["([^"]+)"\]', run("readelf", "-W", "-p", ".note.dlopen", path))
        for name in re.findall(r"\(NEEDED\).*\[(.*)\]", said) + sorted(set(late)):
            place = next((folder / name for folder in own + self.folders if (folder / name).exists()), None)
            if place is None:
                self.missing.add(name)
                continue
            real = os.path.realpath(place)
            needed.append(real)
            if real not in self.found:
                self.found[real] = None
                self.found[real] = self.follow(real)
        return needed


def owners(paths):
    """path: package (name:architecture) as dpkg knows it, with or without /usr before /lib."""
    names = {name: path for path in paths for name in (path.removeprefix("/usr"), path)}
    said = subprocess.run(["dpkg-query", "-S", *names], capture_output=True, text=True).stdout
    known = {}
    for line in said.splitlines():
        packages, _, name = line.rpartition(": ")
        if name in names and not packages.startswith("diversion "):
            known[names[name]] = packages.split(", ")[0]
    return known


def debian_components(packages):
    """package: its component, for names with or without their architecture; dpkg reads its database once for all."""
    said = run("dpkg-query", "-W", "-f", "${Package}\t${binary:Package}\t${Version}\t${Architecture}\t${Homepage}\n", *packages)
    known = {}
    for line in said.splitlines():
        name, full_name, version, architecture, homepage = line.split("\t")
        purl = f"pkg:deb/debian/{name}@{urllib.parse.quote(version, safe='')}?arch={architecture}"
        component = {"type": "library", "bom-ref": purl, "name": name, "version": version, "purl": purl}
        if homepage:
            component["externalReferences"] = [{"type": "website", "url": homepage}]
        known.update({name: component, full_name: component, f"{name}:{architecture}": component})
    return {package: known[package] for package in packages}


def npm_components(lock):
    for place, package in sorted(json.loads(pathlib.Path(lock).read_text())["packages"].items()):
        if not place or package.get("dev"):
            continue
        name = place.rsplit("node_modules/", 1)[1]
        purl = f"pkg:npm/{urllib.parse.quote(name, safe='/')}@{package['version']}"
        component = {"type": "library", "bom-ref": purl, "name": name, "version": package["version"], "purl": purl}
        license_said = package.get("license")
        if license_said:
            is_expression = " " in license_said
            component["licenses"] = [{"expression": license_said} if is_expression else {"license": {"id": license_said}}]
        kind, _, digest = package.get("integrity", "").partition("-")
        if kind == "sha512":
            component["hashes"] = [{"alg": "SHA-512", "content": base64.b64decode(digest).hex()}]
        yield component


def document(given):
    libraries = Libraries(given.program)
    packages = owners(libraries.found)
    of_debian = debian_components(sorted({*packages.values(), *HEADERS}))
    reference = {path: of_debian[package]["bom-ref"] for path, package in packages.items()}
    components = {component["bom-ref"]: component for component in of_debian.values()}
    for path in set(libraries.found) - set(packages):
        reference[path] = f"file:{path}"
        components[reference[path]] = {"type": "library", "bom-ref": reference[path], "name": pathlib.Path(path).name}
    for name in libraries.missing:
        print(f"sbom.py: {name} was not found on this machine", file=sys.stderr)
        components[f"file:{name}"] = {"type": "library", "bom-ref": f"file:{name}", "name": name}
    program = {"type": "application", "bom-ref": f"skyquilt@{given.version}", "name": "skyquilt", "version": given.version,
               "licenses": [{"license": {"id": "Apache-2.0"}}]}
    depends = {program["bom-ref"]: {reference[path] for path in libraries.needs[given.program]}}
    for path, needed in libraries.found.items():
        depends.setdefault(reference[path], set()).update(reference[other] for other in needed)
    for component in [*(of_debian[package] for package in HEADERS), *npm_components(given.lock)]:
        components[component["bom-ref"]] = component
        depends[program["bom-ref"]].add(component["bom-ref"])
    seconds = int(os.environ.get("SOURCE_DATE_EPOCH", time.time()))
    when = datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    told = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
            "metadata": {"timestamp": when, "component": program},
            "components": [components[key] for key in sorted(components)],
            "dependencies": [{"ref": key, "dependsOn": sorted(depends[key] - {key})} for key in sorted(depends)]}
    told["serialNumber"] = "urn:uuid:" + str(uuid.uuid5(uuid.NAMESPACE_URL, json.dumps(told, sort_keys=True)))
    return told


arguments = argparse.ArgumentParser()
for option in ("program", "version", "lock", "out"):
    arguments.add_argument(f"--{option}", required=True)
parsed = arguments.parse_args()
out = pathlib.Path(parsed.out)
out.parent.mkdir(parents=True, exist_ok=True)
out.write_text(json.dumps(document(parsed), indent=1) + "\n")
