#include "api/nodeodm/node_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/http/parameters.h"
#include "api/json/job_options.h"
#include "api/json/json_text.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

// Why several options do nothing.
constexpr const char* kNoModel = "No effect: no 3D model or point cloud is made here.";
constexpr const char* kNoCloud = "No effect: no point cloud is made here.";
constexpr const char* kNoMesh = "No effect: no mesh is made here.";
constexpr const char* kNoDem = "No effect: cells have two of the map's pixels, and gaps are always filled.";
constexpr const char* kNoGround = "No effect: what is ground is told by rules of its own here.";
constexpr const char* kChosenHere = "No effect: chosen here by what the photos need.";
constexpr const char* kNeverSplit =
    "No effect: a flight is always mapped as a whole here, within the memory it is given.";
constexpr const char* kEndsWithPhotos = "No effect: the map always ends where the photos do.";
constexpr const char* kLensIsFound = "No effect: the lens is found from the photos.";
constexpr const char* kQualities = R"(["ultra","high","medium","low","lowest"])";
constexpr const char* kStages =
    R"(["dataset","split","merge","opensfm","openmvs","odm_filterpoints","odm_meshing","mvs_texturing","odm_georeferencing","odm_dem","odm_orthophoto","odm_report","odm_postprocess"])";

constexpr NodeOption kNodeOptions[] = {
    {"orthophoto-resolution", "float", "0", "float: 0 <= x <= 10000",
     "Ground size of an orthophoto pixel in cm, never finer than the photos. 0 means as fine as the photos. Default: %(default)s",
     NodeOptionEffect::kJob, "gsd_m"},
    {"rolling-shutter-readout", "float", "0", "float: 0 <= x <= 500",
     "Rolling shutter: milliseconds from reading a photo's first row to its last. 0 means as known of the camera. Default: %(default)s",
     NodeOptionEffect::kJob, "readout_ms"},
    {"orthophoto-quality", "int", "85", "integer: 1 <= x <= 100",
     "JPEG quality of the orthophoto's tiles. Default: %(default)s", NodeOptionEffect::kJob, "quality"},
    {"tile-format", "enum", "auto", R"(["auto","jpeg-png","webp"])",
     "Format of the map's tiles: JPEG with WebP at the fringe (auto), with PNG there (jpeg-png), or WebP throughout. One of: %(choices)s. Default: %(default)s",
     NodeOptionEffect::kJob, "format"},
    {"align-method", "enum", "auto", R"(["auto","images","imu"])",
     "How photos are placed: by what suits (auto), by what they show alone (images), or by their recorded poses alone (imu). One of: %(choices)s. Default: %(default)s",
     NodeOptionEffect::kJob, "method"},
    {"surface", "enum", "smooth", R"(["smooth","dense","auto"])",
     "What photos are projected to: the ground alone (smooth), on which houses and trees lean, or heights of every two pixels (dense), so that they stand upright, which takes several times as long, or this where they lean much (auto). One of: %(choices)s. Default: %(default)s",
     NodeOptionEffect::kJob, "surface"},
    {"archive-tiles", "enum", kUsualArchiveTiles, R"(["mbtiles","pmtiles","both","none"])",
     "In which file all.zip holds the map's tiles beside the GeoTIFF, which has them too. One of: %(choices)s. Default: %(default)s",
     NodeOptionEffect::kArchive},
    // Of OpenDroneMap, in the order of the alphabet.
    {"3d-tiles", "bool", "false", "", kNoModel},
    {"align", "string", "", "path", "No effect: give surveyed points in gcp_list.txt instead."},
    {"auto-boundary", "bool", "false", "", kEndsWithPhotos},
    {"auto-boundary-distance", "float", "0", "positive float", kEndsWithPhotos},
    {"bg-removal", "bool", "false", "", "No effect: photos are used whole."},
    {"boundary", "string", "", "json",
     "GeoJSON polygon that the orthophoto is cut to. Photos are placed as without. Default: %(default)s",
     NodeOptionEffect::kJob, "boundary"},
    {"build-overviews", "bool", "false", "", "No effect: the orthophoto always has overviews."},
    {"camera-lens", "enum", "auto",
     R"(["auto","perspective","brown","fisheye","fisheye_opencv","spherical","equirectangular","dual"])",
     kLensIsFound},
    {"cameras", "string", "", "json", kLensIsFound},
    {"cog", "bool", "false", "", "No effect: the orthophoto is always a cloud-optimised GeoTIFF."},
    {"crop", "float", "3", "positive float", kEndsWithPhotos},
    {"dem-decimation", "int", "1", "positive integer", kNoDem},
    {"dem-euclidean-map", "bool", "false", "", kNoDem},
    {"dem-gapfill-steps", "int", "3", "positive integer", kNoDem},
    {"dem-resolution", "float", "5", "float", kNoDem},
    {"depthmap-resolution", "float", "640", "positive float", kNoCloud},
    {"dsm", "bool", "false", "",
     "Heights of ground, roofs and trees as the photos show them (odm_dem/dsm.tif), in cells of two of the map's pixels. Default: %(default)s",
     NodeOptionEffect::kJob, "heights"},
    {"dtm", "bool", "false", "",
     "Those, and the ground below houses and trees (odm_dem/dtm.tif) with its contours. Default: %(default)s",
     NodeOptionEffect::kJob, "heights"},
    {"end-with", "enum", "odm_postprocess", kStages, "No effect: a task always ends with the map."},
    {"fast-orthophoto", "bool", "false", "",
     "No effect: the orthophoto is always made without a 3D model here."},
    {"feature-quality", "enum", "high", kQualities, kChosenHere},
    {"feature-type", "enum", "dspsift", R"(["akaze","dspsift","hahog","orb","sift"])", kChosenHere},
    {"force-gps", "bool", "false", "",
     "No effect: recorded positions are weighed by how well they agree with the photos, beside surveyed points too."},
    {"gltf", "bool", "false", "", kNoModel},
    {"gps-accuracy", "float", "3", "positive float",
     "No effect: how far positions are off is read from the photos or found from them."},
    {"gps-z-offset", "float", "0", "float",
     "No effect: heights count as surveyed points do, else as the photos record them."},
    {"ignore-gsd", "bool", "false", "", "No effect: the map is never finer than the photos."},
    {"matcher-neighbors", "int", "0", "positive integer", kChosenHere},
    {"matcher-order", "int", "0", "positive integer", kChosenHere},
    {"matcher-type", "enum", "flann", R"(["bow","bruteforce","flann"])", kChosenHere},
    {"max-concurrency", "int", "4", "positive integer",
     "No effect: a task uses the processor cores that are free."},
    {"merge", "enum", "all", R"(["all","pointcloud","orthophoto","dem"])", kNeverSplit},
    {"mesh-octree-depth", "int", "11", "integer: 1 <= x <= 14", kNoMesh},
    {"mesh-size", "int", "200000", "positive integer", kNoMesh},
    {"min-num-features", "int", "10000", "integer", kChosenHere},
    {"no-gpu", "bool", "false", "", "No effect: no GPU is used."},
    {"optimize-disk-space", "bool", "false", "",
     "No effect: what a task needs only meanwhile is always removed at its end."},
    {"orthophoto-compression", "enum", "DEFLATE", R"(["JPEG","LZW","PACKBITS","DEFLATE","LZMA","NONE"])",
     "No effect: the orthophoto's tiles are always JPEG or WebP (see tile-format)."},
    {"orthophoto-cutline", "bool", "false", "",
     "No effect: seams follow what the photos show; no cutline is written."},
    {"orthophoto-kmz", "bool", "false", "", "No effect: all.zip has none."},
    {"orthophoto-no-tiled", "bool", "false", "", "No effect: the orthophoto is always tiled."},
    {"orthophoto-png", "bool", "false", "",
     "No effect: all.zip has none; the flight's page gives pictures of the map."},
    {"pc-classify", "bool", "false", "", kNoCloud},
    {"pc-copc", "bool", "false", "", kNoCloud},
    {"pc-csv", "bool", "false", "", kNoCloud},
    {"pc-ept", "bool", "false", "", kNoCloud},
    {"pc-filter", "float", "5", "positive float", kNoCloud},
    {"pc-geometric", "bool", "false", "", kNoCloud},
    {"pc-las", "bool", "false", "", kNoCloud},
    {"pc-quality", "enum", "medium", kQualities, kNoCloud},
    {"pc-rectify", "bool", "false", "", kNoCloud},
    {"pc-sample", "float", "0", "positive float", kNoCloud},
    {"pc-skip-geometric", "bool", "false", "", kNoCloud},
    {"primary-band", "string", "auto", "string",
     "No effect: the map is drawn from the photos in colour, or from one band."},
    {"radiometric-calibration", "enum", "none", R"(["none","camera","camera+sun"])",
     "No effect: colours are evened out by what overlapping photos show, bands calibrated by what is recorded."},
    {"rerun-from", "enum", "", kStages, "No effect: a restarted task uses again by itself what still holds."},
    {"resize-to", "int", "-1", "integer", "No effect: photos are used at their full size."},
    {"rolling-shutter", "bool", "false", "",
     "No effect: corrected wherever the camera's readout time is known (see rolling-shutter-readout)."},
    {"sfm-algorithm", "enum", "incremental", R"(["incremental","triangulation","planar"])",
     "No effect: see align-method."},
    {"sfm-no-partial", "bool", "false", "",
     "No effect: photos that do not join the others are placed by their records, and the report says so."},
    {"skip-3dmodel", "bool", "false", "", "No effect: no 3D model is made here anyway."},
    {"skip-band-alignment", "bool", "false", "", "No effect: bands are always laid on each other."},
    {"skip-orthophoto", "bool", "false", "", "No effect: the orthophoto is what this node makes."},
    {"skip-report", "bool", "false", "", "No effect: the report is always written."},
    {"sky-removal", "bool", "false", "", "No effect: what lies towards the horizon is never drawn."},
    {"sm-cluster", "string", "", "string", kNeverSplit},
    {"sm-no-align", "bool", "false", "", kNeverSplit},
    {"smrf-scalar", "float", "1.25", "positive float", kNoGround},
    {"smrf-slope", "float", "0.15", "positive float", kNoGround},
    {"smrf-threshold", "float", "0.5", "positive float", kNoGround},
    {"smrf-window", "float", "18.0", "positive float", kNoGround},
    {"split", "int", "999999", "positive integer", kNeverSplit},
    {"split-image-groups", "string", "", "path", kNeverSplit},
    {"split-overlap", "int", "150", "positive integer", kNeverSplit},
    {"texturing-keep-unseen-faces", "bool", "false", "", kNoMesh},
    {"texturing-single-material", "bool", "false", "", kNoMesh},
    {"texturing-skip-global-seam-leveling", "bool", "false", "", kNoMesh},
    {"texturing-skip-local-seam-leveling", "bool", "false", "", kNoMesh},
    {"tiles", "bool", "false", "", "No effect: see archive-tiles."},
    {"time", "bool", "false", "", "No effect: how long each stage took is always in the report."},
    {"use-3dmesh", "bool", "false", "", kNoMesh},
    {"use-exif", "bool", "false", "",
     "No effect: surveyed points, where there are any, place the map together with the photos' positions."},
    {"use-fixed-camera-params", "bool", "false", "", kChosenHere},
    {"use-hybrid-bundle-adjustment", "bool", "false", "", kChosenHere},
    {"verbose", "bool", "false", "", "No effect: the output has every stage anyway."},
    {"video-limit", "int", "500", "positive integer",
     "No effect: of a film as many frames are used as the map needs."},
    {"video-resolution", "int", "4000", "positive integer", "No effect: films are used at their full size."},
};

// Null for a name that is not in the list.
const NodeOption* FindNodeOption(std::string_view name) {
  for (const NodeOption& option : kNodeOptions) {
    if (name == option.name) return &option;
  }
  return nullptr;
}

using Value = nlohmann::ordered_json;

constexpr double kFinestGsdM = 0.001;  // that a job takes
constexpr std::size_t kMaxUnknown = 50;

std::optional<double> NumberFrom(const Value& value) {
  if (value.is_number()) return value.get<double>();
  if (!value.is_string()) return std::nullopt;
  return ParseNumber<double>(value.get_ref<const std::string&>());
}

Error MustBe(const char* what) {
  return {ErrorCode::kUnprocessable, fmt::format("The value must be {}.", what)};
}

// The value in its option's own type: clients send texts for numbers and truths as well.
Result<Value> TypedValue(const NodeOption& option, const Value& value) {
  const std::string_view type = option.type;
  if (type == "bool") {
    if (value == "true" || value == true) return Value(true);
    if (value == "false" || value == false) return Value(false);
    return MustBe("true or false");
  }
  if (type == "string" || type == "enum") {
    const bool is_json = std::string_view(option.domain) == "json" && value.is_object();
    if ((value.is_object() && !is_json) || value.is_array()) return MustBe("a text");
    return Value(value.is_string() ? value.get<std::string>() : JsonText(value));
  }
  const std::optional<double> number = NumberFrom(value);
  if (!number || !std::isfinite(*number)) return MustBe("a number");
  constexpr double kMaxWhole = 1e15;
  const bool is_whole = std::abs(*number) < kMaxWhole && *number == std::floor(*number);
  if (is_whole) return Value(static_cast<std::int64_t>(*number));
  if (type == "int") return MustBe("a whole number");
  return Value(*number);
}

bool IsOffered(const NodeOption& option, const Value& value) {
  const Value offered = ParseOrderedJson(option.domain);
  return std::find(offered.begin(), offered.end(), value) != offered.end();
}

// What a job is told of a typed value. The job's own rules are the last word.
Result<Value> JobOptionsOf(const NodeOption& option, const Value& value) {
  const std::string_view name = option.job_option;
  Value chosen = {{name, value}};
  if (name == "gsd_m") {
    const auto centimetres = value.get<double>();
    if (centimetres < 0.0) return MustBe("between 0 and 10000 cm");
    if (centimetres == 0.0) return Value(Value::object());
    chosen = {{"gsd_m", std::max(centimetres / 100.0, kFinestGsdM)},
              {"any_gsd", true},
              {"not_finer_than_photos", true}};  // in centimetres
  }
  if (name == "boundary") {
    if (value == "") return Value(Value::object());
    const Value area = ParseOrderedJson(value.get<std::string>());
    if (!area.is_object()) return MustBe("a GeoJSON polygon");
    chosen = {{"boundary", area}};
  }
  if (name == "heights") {
    if (value != true) return Value(Value::object());
    chosen = {{"heights", option.name}};
  }
  if (name == "readout_ms" && value == 0) return Value(Value::object());
  SKYQUILT_TRY(ParseJobOptions(JsonText(chosen)));
  return chosen;
}

}  // namespace

std::span<const NodeOption> NodeOptionList() { return kNodeOptions; }

std::string NodeOptionsJson() {
  Value list = Value::array();
  for (const NodeOption& option : kNodeOptions) {
    const bool is_choice = std::string_view(option.type) == "enum";
    list.push_back({{"name", option.name},
                    {"type", option.type},
                    {"value", option.value},
                    {"domain", is_choice ? ParseOrderedJson(option.domain) : Value(option.domain)},
                    {"help", option.help}});
  }
  return JsonText(list);
}

Result<NodeChoice> ParseNodeOptions(std::string_view text) {
  NodeChoice choice;
  if (text.empty()) return choice;
  SKYQUILT_TRY(CheckJsonText(text));
  const Value list = ParseOrderedJson(text);
  if (!list.is_array()) {
    return Error{ErrorCode::kInvalidArgument, "Invalid options: give a JSON list of {name, value}."};
  }
  Value job_options = Value::object();
  Value shown = Value::array();
  Value errors = Value::array();
  for (const Value& item : list) {
    if (!item.is_object() || !item.contains("name") || !item["name"].is_string() || !item.contains("value")) {
      return Error{ErrorCode::kInvalidArgument, "Invalid options: every item needs a name and a value."};
    }
    const auto& name = item["name"].get_ref<const std::string&>();
    const NodeOption* option = FindNodeOption(name);
    if (option == nullptr) {
      if (choice.unknown.size() < kMaxUnknown) choice.unknown.push_back(name);
      continue;
    }
    const Result<Value> value = TypedValue(*option, item["value"]);
    Result<Value> chosen = value;
    if (value && option->effect == NodeOptionEffect::kArchive && !IsOffered(*option, *value))
      chosen = MustBe(fmt::format("one of {}", option->domain).c_str());
    if (value && option->effect == NodeOptionEffect::kJob) chosen = JobOptionsOf(*option, *value);
    if (!chosen) {
      errors.push_back({{"name", name}, {"error", chosen.error().message}});
      continue;
    }
    // The ground comes with the surface, whichever is named last.
    const bool has_ground = job_options.value("heights", "") == "dtm";
    if (option->effect == NodeOptionEffect::kJob) job_options.update(*chosen);
    if (has_ground) job_options["heights"] = "dtm";
    shown.push_back({{"name", name}, {"value", *value}});
  }
  if (!errors.empty()) {
    return Error{ErrorCode::kUnprocessable, JsonText(errors)};
  }
  choice.job_options = JsonText(job_options);
  choice.shown = JsonText(shown);
  return choice;
}

}  // namespace skyquilt::api
