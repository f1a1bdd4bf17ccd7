"""Packs the QGIS plugin into a zip for QGIS' "Install from ZIP": pack.py OUT.zip [--homepage URL] [--email ADDRESS]

The last two are what QGIS' own list of plugins wants to know; without them their lines are left out. The Python client is taken from its folder beside this one, so that there is one copy of it in the repository; the licence
is the repository's."""
import argparse
import pathlib
import re
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
PLUGIN = HERE / "skyquilt_qgis"
CLIENT = HERE.parent / "python" / "skyquilt"
ROOT = HERE.parents[2]
DATE = (2026, 1, 1, 0, 0, 0)  # the same sources make the same bytes


def metadata(text, **known):
    """The plugin's description with what is known; lines of what is not are left out."""
    for name, value in known.items():
        text = text.replace(f"@{name.upper()}@", value) if value else re.sub(rf"^.*@{name.upper()}@.*\n", "", text, flags=re.M)
    return text


def files(homepage=None, email=None):
    """Name in the zip: content."""
    version = re.search(r'^__version__ = "([^"]+)"', (CLIENT / "__init__.py").read_text(), re.M).group(1)
    found = {}
    for folder, below in ((PLUGIN, PLUGIN.name), (CLIENT, f"{PLUGIN.name}/skyquilt")):
        for path in sorted(folder.rglob("*")):
            if path.is_file() and path.suffix in (".py", ".txt", ".svg", ".png", ".typed"):
                found[f"{below}/{path.relative_to(folder).as_posix()}"] = path.read_bytes()
    about = f"{PLUGIN.name}/metadata.txt"
    found[about] = metadata(found[about].decode(), version=version, homepage=homepage, email=email).encode()
    found[f"{PLUGIN.name}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--homepage")
    parser.add_argument("--email")
    wanted = parser.parse_args()
    wanted.out.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(wanted.out, "w") as archive:
        for name, content in sorted(files(wanted.homepage, wanted.email).items()):
            archive.writestr(zipfile.ZipInfo(name, DATE), content, zipfile.ZIP_DEFLATED)
    print(wanted.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
