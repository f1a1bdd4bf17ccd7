"""Fails on any #include that points upwards: server -> api -> storage -> core's values and ports; inside core only
downwards. The heavy libraries stay in the folders that own them."""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
CORE_ORDER = ["base", "image", "geo", "camera", "flight", "bands", "poses", "alignment", "ground", "surface", "render", "pyramid", "pipeline"]
# pyramid is a leaf below render: tiles know nothing of photos.
MAY_USE = {name: set(CORE_ORDER[: i + 1]) for i, name in enumerate(CORE_ORDER)}
MAY_USE["render"] |= {"pyramid"}
# Arithmetic over bands knows of nothing but numbers.
MAY_USE["indices"] = {"base", "indices"}
MAY_USE["pyramid"] = {"base", "image", "geo", "pyramid"}
MAY_USE["video"] = {"base", "image", "geo", "camera", "flight", "video"}
MAY_USE["simulate"] = {"base", "image", "geo", "camera", "flight", "poses", "simulate"}
# What storage and api may know of the core: values and ports, never a stage's algorithm.
CORE_VALUES = {
    "core/base/", "core/indices/", "core/geo/", "core/bands/band_sink.h", "core/surface/dense_surface.h", "core/surface/ground_below.h", "core/surface/terrain/height_shift.h", "core/surface/terrain/volume.h", "core/camera/intrinsics.h", "core/flight/photo.h", "core/flight/flight.h",
    "core/flight/read_flight.h", "core/flight/bytes/input_file.h", "core/flight/remarks/", "core/image/", "core/flight/photos/photo_source.h", "core/pyramid/tile_sink.h", "core/pyramid/draw_legend.h", "core/pyramid/map_memory.h", "core/pipeline/mosaic_options.h",
    "core/pipeline/report/map_quality.h", "core/pipeline/report/mosaic_report.h", "core/pipeline/report/locate.h", "core/pipeline/report/ground_profile.h", "core/alignment/scene/aligned_flight.h", "core/render/map_layer.h",
}
LIBRARIES = {
    r"boost/": {"server"},
    r"curl/": {"server/webhooks", "server/client", "storage/blobs"},
    r"sqlite3\.h": {"storage"},
    r"(libpq-fe|libpq/|postgres_ext)": {"storage/db/postgres"},
    r"(gdal|cpl_|ogr)": {"storage"},
    r"opencv2/": {"core/alignment", "core/surface", "core/render", "core/pyramid", "core/simulate", "core/video", "core/flight/photos/photo_decoder.cc"},
    r"lib(av|sws)": {"core/video"},
    r"ceres/": {"core/poses", "core/alignment"},
}
HEAVY_IN_HEADERS = re.compile(r"^(boost/|curl/|opencv2/|ceres/|nlohmann/(?!json_fwd)|CLI/|gdal|sqlite3\.h|libpq)")
# Coroutines, by the two files of a connection; what the three sources that transfer by libcurl share.
HEAVY_HEADERS_ALLOWED = {"server/http/connection.h", "storage/blobs/curl_transfer.h"}
FOLDERS = ("core", "storage", "api", "server")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)


def core_part(path):
    return path.split("/")[1]


def allowed(source, target):
    """Why `source` may not include the project header `target`; None if it may."""
    top_source, top_target = source.split("/")[0], target.split("/")[0]
    if top_source == "core":
        if top_target != "core":
            return "core knows nothing above itself"
        if core_part(target) not in MAY_USE[core_part(source)]:
            return f"core/{core_part(source)} may not know core/{core_part(target)}"
        return None
    if top_source in ("storage", "api"):
        if top_target == "core" and not any(target.startswith(value) for value in CORE_VALUES):
            return f"{top_source} sees only the core's values and ports"
        if top_target == "server" or (top_source == "storage" and top_target == "api"):
            return f"{top_source} is below {top_target}"
        return None
    return None


# The library's parser and serializer, compiled anew wherever they are called: seconds in every object. The last three bound
# what they take while it is parsed.
JSON_DOORS = {"core/base/text/json_io.cc", "storage/exports/custom/boundary.cc", "storage/rasters/geojson_shape.cc",
              "server/imports/told_quality.cc"}
JSON_TEXT = re.compile(r"\.dump\(|(?:[jJ]son|Value|Document|Report|Input)::(?:parse|accept)\(")


def main():
    problems = []
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix not in (".h", ".cc"):
                continue
            source = path.relative_to(ROOT).as_posix()
            if source not in JSON_DOORS and JSON_TEXT.search(path.read_text()):
                problems.append(f"{source}: JSON and text become each other by ParseJson and JsonText (core/base/text/json_io.h)")
            for kind, target in INCLUDE.findall(path.read_text()):
                if kind == '"':
                    if target.split("/")[0] in FOLDERS and not (ROOT / target).exists():
                        problems.append(f"{source}: includes {target}, which is not there")
                        continue
                    reason = allowed(source, target)
                    if reason:
                        problems.append(f"{source}: includes {target}: {reason}")
                    continue
                if path.suffix == ".h" and HEAVY_IN_HEADERS.match(target) and source not in HEAVY_HEADERS_ALLOWED:
                    problems.append(f"{source}: the heavy header <{target}> belongs in a .cc file")
                for pattern, owners in LIBRARIES.items():
                    if re.match(pattern, target) and not any(source.startswith(owner) for owner in owners):
                        problems.append(f"{source}: <{target}> belongs to {', '.join(sorted(owners))}")
    print("\n".join(problems) or "every include points the right way")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
