#include "api/json/job_options.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/json/json_text.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/exports/custom/boundary.h"
#include "storage/uploads/photo_store.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

Error Refuse(std::string_view field, std::string_view rule) {
  return flight::Because(
      ErrorCode::kUnprocessable,
      {flight::RemarkCode::kFailOption, {{"option", std::string(field)}, {"rule_words", std::string(rule)}}});
}

Result<void> SetGsd(const json& value, pipeline::MosaicOptions* options) {
  if (value.is_null()) return {};
  if (!value.is_number()) return Refuse("gsd_m", "must be a number of metres");
  const auto gsd_m = value.get<double>();
  if (!(gsd_m >= 0.001 && gsd_m <= 100.0)) return Refuse("gsd_m", "must lie between 0.001 and 100 metres");
  options->gsd_m = gsd_m;
  return {};
}

Result<void> SetAnyGsd(const json& value, pipeline::MosaicOptions* options) {
  if (!value.is_boolean()) return Refuse("any_gsd", "must be true or false");
  options->any_gsd = value.get<bool>();
  return {};
}

Result<void> SetNotFiner(const json& value, pipeline::MosaicOptions* options) {
  if (!value.is_boolean()) return Refuse("not_finer_than_photos", "must be true or false");
  options->not_finer_than_photos = value.get<bool>();
  return {};
}

Result<void> SetReadout(const json& value, pipeline::MosaicOptions* options) {
  if (value.is_null()) return {};
  if (!value.is_number()) return Refuse("readout_ms", "must be a number of milliseconds");
  const auto readout_ms = value.get<double>();
  if (!(readout_ms >= 0.0 && readout_ms <= 500.0))
    return Refuse("readout_ms", "must lie between 0 and 500 milliseconds");
  options->readout_s = 1e-3 * readout_ms;
  return {};
}

Result<void> SetMaxLook(const json& value, pipeline::MosaicOptions* options) {
  if (!value.is_number()) return Refuse("max_look_deg", "must be a number of degrees");
  const auto max_look_deg = value.get<double>();
  if (!(max_look_deg >= 10.0 && max_look_deg <= 75.0))
    return Refuse("max_look_deg", "must lie between 10 and 75 degrees off the vertical");
  options->max_look_deg = max_look_deg;
  return {};
}

Result<void> SetFormat(const json& value, pipeline::MosaicOptions* options) {
  for (const auto& [name, encoding] : pipeline::kTileFormats) {
    if (value == name) {
      options->encoding = encoding;
      return {};
    }
  }
  return Refuse("format", "must be \"auto\", \"jpeg-png\" or \"webp\"");
}

Result<void> SetQuality(const json& value, pipeline::MosaicOptions* options) {
  if (!value.is_number_integer()) return Refuse("quality", "must be a whole number");
  const auto quality = value.get<std::int64_t>();
  if (quality < 1 || quality > 100) return Refuse("quality", "must lie between 1 and 100");
  options->jpeg_quality = static_cast<int>(quality);
  return {};
}

Result<void> SetMethod(const json& value, pipeline::MosaicOptions* options) {
  for (const auto& [name, method] : pipeline::kAlignMethods) {
    if (value == name) {
      options->method = method;
      return {};
    }
  }
  return Refuse("method", "must be \"auto\", \"images\", \"imu\", \"features\" or \"direct\"");
}

Result<void> SetSurface(const json& value, pipeline::MosaicOptions* options) {
  for (const auto& [name, ground] : pipeline::kMapGrounds) {
    if (value == name) {
      options->surface = ground;
      return {};
    }
  }
  return Refuse("surface", "must be \"smooth\", \"dense\" or \"auto\"");
}

Result<void> SetHeights(const json& value, pipeline::MosaicOptions* options) {
  for (const auto& [name, heights] : pipeline::kMapHeights) {
    if (value == name) {
      options->heights = heights;
      return {};
    }
  }
  return Refuse("heights", "must be \"none\", \"dsm\" or \"dtm\"");
}

Result<void> SetOrigin(const json& value, pipeline::MosaicOptions* options) {
  if (value.is_null()) return {};
  if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number()) {
    return Refuse("origin", "must be [latitude, longitude] in degrees");
  }
  const geo::LatLon origin{value[0].get<double>(), value[1].get<double>()};
  if (!(std::abs(origin.lat_deg) <= 85.0 && std::abs(origin.lon_deg) <= 180.0)) {
    return Refuse("origin", "must be a latitude up to 85 and a longitude up to 180 degrees");
  }
  options->origin = origin;
  return {};
}

Result<geo::LatLon> PlaceOf(const json& value) {
  constexpr const char* kRule = "has a place that is not [latitude, longitude] in degrees, up to 85 and 180";
  if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number())
    return Refuse("place", kRule);
  const geo::LatLon place{value[0].get<double>(), value[1].get<double>()};
  if (!(std::abs(place.lat_deg) <= 85.0 && std::abs(place.lon_deg) <= 180.0)) return Refuse("place", kRule);
  return place;
}

Result<void> SetPlace(const json& value, pipeline::MosaicOptions* options) {
  constexpr std::size_t kMaxPairs = 100;
  pipeline::PlaceRequest request;
  if (value == "control") {
    request.is_by_lists = true;
    options->placing = std::move(request);
    return {};
  }
  if (!value.is_array() || value.empty() || value.size() > kMaxPairs)
    return Refuse("place", "must be \"control\" or a list of 1 to 100 pairs of \"shown\" and \"is\"");
  for (const json& pair : value) {
    if (!pair.is_object() || pair.size() != 2 || !pair.contains("shown") || !pair.contains("is"))
      return Refuse(
          "place",
          "must be a list of pairs of \"shown\", where the map shows a thing, and \"is\", where it is");
    SKYQUILT_TRY_ASSIGN(const geo::LatLon shown, PlaceOf(pair["shown"]));
    SKYQUILT_TRY_ASSIGN(const geo::LatLon is, PlaceOf(pair["is"]));
    request.pairs.push_back({shown, is});
  }
  options->placing = std::move(request);
  return {};
}

Result<void> SetBoundary(const json& value, pipeline::MosaicOptions* options) {
  if (value.is_null()) return {};
  SKYQUILT_TRY_ASSIGN(options->boundary, storage::ParseBoundary(value.dump()));
  return {};
}

Result<void> SetTakeoffHeight(const json& value, pipeline::MosaicOptions* options) {
  if (value.is_null()) return {};
  if (!value.is_number()) return Refuse("takeoff_height_m", "must be a number of metres");
  const auto height_m = value.get<double>();
  if (!(height_m >= -500.0 && height_m <= 9000.0))
    return Refuse("takeoff_height_m", "must lie between -500 and 9000 metres above sea level");
  options->takeoff_height_amsl_m = height_m;
  return {};
}

Result<void> SetLandedAtStart(const json& value, pipeline::MosaicOptions* options) {
  if (!value.is_boolean()) return Refuse("landed_at_start", "must be true or false");
  options->landed_at_start = value.get<bool>();
  return {};
}

Result<void> SetLayers(const json& value, pipeline::MosaicOptions* options) {
  constexpr const char* kRule = "must be a list of \"photo\", \"error\" and \"height\", each at most once";
  if (!value.is_array()) return Refuse("layers", kRule);
  for (const json& name : value) {
    const auto layer = name.is_string() ? render::MapLayerNamed(name.get<std::string>()) : std::nullopt;
    if (!layer || std::count(options->layers.begin(), options->layers.end(), *layer) > 0)
      return Refuse("layers", kRule);
    options->layers.push_back(*layer);
  }
  return {};
}

Result<void> SetImport(const json& value, pipeline::MosaicOptions* options) {
  if (value.is_null()) return {};
  if (!value.is_string()) return Refuse("import_file", "must be the name of one of the flight's files");
  const auto name = value.get<std::string>();
  if (!storage::CheckFileName(name))
    return Refuse("import_file", "must be the name of one of the flight's files");
  options->import_file = name;
  return {};
}

// What else is said of a map that is not made but taken over would be said in vain.
Result<void> CheckImport(const json& given, const pipeline::MosaicOptions& options) {
  if (options.import_file.empty()) return {};
  for (const auto& [field, value] : given.items()) {
    if (field != "import_file" && field != "quality")
      return Refuse(field, "says how a map is made of photos; with \"import_file\" goes \"quality\" alone");
  }
  return {};
}

}  // namespace

Result<pipeline::MosaicOptions> ParseJobOptions(std::string_view text) {
  SKYQUILT_TRY(CheckJsonText(text));
  const json parsed = json::parse(text, nullptr, false);
  if (parsed.is_discarded()) return Error{ErrorCode::kInvalidArgument, "The options are not JSON.", ""};
  if (!parsed.is_object()) return Error{ErrorCode::kUnprocessable, "The options must be a JSON object.", ""};
  pipeline::MosaicOptions options;
  for (const auto& [field, value] : parsed.items()) {
    Result<void> set;
    if (field == "gsd_m") {
      set = SetGsd(value, &options);
    } else if (field == "any_gsd") {
      set = SetAnyGsd(value, &options);
    } else if (field == "not_finer_than_photos") {
      set = SetNotFiner(value, &options);
    } else if (field == "max_look_deg") {
      set = SetMaxLook(value, &options);
    } else if (field == "readout_ms") {
      set = SetReadout(value, &options);
    } else if (field == "format") {
      set = SetFormat(value, &options);
    } else if (field == "quality") {
      set = SetQuality(value, &options);
    } else if (field == "method") {
      set = SetMethod(value, &options);
    } else if (field == "surface") {
      set = SetSurface(value, &options);
    } else if (field == "heights") {
      set = SetHeights(value, &options);
    } else if (field == "origin") {
      set = SetOrigin(value, &options);
    } else if (field == "boundary") {
      set = SetBoundary(value, &options);
    } else if (field == "takeoff_height_m") {
      set = SetTakeoffHeight(value, &options);
    } else if (field == "landed_at_start") {
      set = SetLandedAtStart(value, &options);
    } else if (field == "place") {
      set = SetPlace(value, &options);
    } else if (field == "layers") {
      set = SetLayers(value, &options);
    } else if (field == "import_file") {
      set = SetImport(value, &options);
    } else {
      set = flight::Because(
          ErrorCode::kUnprocessable,
          {flight::RemarkCode::kFailOptionUnknown,
           {{"option", field},
            {"known_words",
             "gsd_m, any_gsd, not_finer_than_photos, max_look_deg, readout_ms, format, quality, method, surface, heights, origin, "
             "boundary, takeoff_height_m, landed_at_start, place, layers and import_file"}}});
    }
    if (!set) return set.error();
  }
  SKYQUILT_TRY(CheckImport(parsed, options));
  return options;
}

}  // namespace skyquilt::api
