#include "api/json/job_options.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "api/json/json_text.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/exports/custom/boundary.h"
#include "storage/uploads/photo_store.h"

namespace skyquilt::api {
namespace {

Error Refuse(std::string_view field, std::string_view rule) {
  return flight::Because(
      ErrorCode::kUnprocessable,
      {flight::RemarkCode::kFailOption, {{"option", std::string(field)}, {"rule_words", std::string(rule)}}});
}

using pipeline::JobOption;
using pipeline::JobOptionKind;

// The value as the table has it; nothing where it is of another type or out of range.
std::optional<double> NumberOf(const JobOption& option, const nlohmann::json& value) {
  switch (option.kind) {
    case JobOptionKind::kNumber:
    case JobOptionKind::kWhole: {
      const bool is_number =
          option.kind == JobOptionKind::kWhole ? value.is_number_integer() : value.is_number();
      if (!is_number || !option.Takes(value.get<double>())) return std::nullopt;
      return value.get<double>();
    }
    case JobOptionKind::kYesNo:
      if (!value.is_boolean()) return std::nullopt;
      return value.get<bool>() ? 1.0 : 0.0;
    case JobOptionKind::kChoice: {
      const auto found = std::find_if(option.choices.begin(), option.choices.end(),
                                      [&](const char* one) { return value == one; });
      if (found == option.choices.end()) return std::nullopt;
      return static_cast<double>(found - option.choices.begin());
    }
    case JobOptionKind::kOther:
      break;
  }
  return std::nullopt;
}

Result<void> SetPlain(const JobOption& option, const nlohmann::json& value,
                      pipeline::MosaicOptions* options) {
  if (option.may_be_open && value.is_null()) return {};
  const std::optional<double> number = NumberOf(option, value);
  if (!number) return Refuse(option.name, option.Rule());
  option.set(*number, options);
  return {};
}

Result<void> SetOrigin(const nlohmann::json& value, pipeline::MosaicOptions* options) {
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

Result<geo::LatLon> PlaceOf(const nlohmann::json& value) {
  constexpr const char* kRule = "has a place that is not [latitude, longitude] in degrees, up to 85 and 180";
  if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number())
    return Refuse("place", kRule);
  const geo::LatLon place{value[0].get<double>(), value[1].get<double>()};
  if (!(std::abs(place.lat_deg) <= 85.0 && std::abs(place.lon_deg) <= 180.0)) return Refuse("place", kRule);
  return place;
}

Result<void> SetPlace(const nlohmann::json& value, pipeline::MosaicOptions* options) {
  constexpr std::size_t kMaxPairs = 100;
  pipeline::PlaceRequest request;
  if (value == "control") {
    request.is_by_lists = true;
    options->placing = std::move(request);
    return {};
  }
  if (!value.is_array() || value.empty() || value.size() > kMaxPairs)
    return Refuse("place", "must be \"control\" or a list of 1 to 100 pairs of \"shown\" and \"is\"");
  for (const nlohmann::json& pair : value) {
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

Result<void> SetBoundary(const nlohmann::json& value, pipeline::MosaicOptions* options) {
  if (value.is_null()) return {};
  SKYQUILT_TRY_ASSIGN(options->boundary, storage::ParseBoundary(JsonText(value)));
  return {};
}

Result<void> SetLayers(const nlohmann::json& value, pipeline::MosaicOptions* options) {
  constexpr const char* kRule = "must be a list of \"photo\", \"error\" and \"height\", each at most once";
  if (!value.is_array()) return Refuse("layers", kRule);
  for (const nlohmann::json& name : value) {
    const auto layer = name.is_string() ? render::MapLayerNamed(name.get<std::string>()) : std::nullopt;
    if (!layer || std::count(options->layers.begin(), options->layers.end(), *layer) > 0)
      return Refuse("layers", kRule);
    options->layers.push_back(*layer);
  }
  return {};
}

Result<void> SetImport(const nlohmann::json& value, pipeline::MosaicOptions* options) {
  if (value.is_null()) return {};
  if (!value.is_string()) return Refuse("import_file", "must be the name of one of the flight's files");
  const auto name = value.get<std::string>();
  if (!storage::CheckFileName(name))
    return Refuse("import_file", "must be the name of one of the flight's files");
  options->import_file = name;
  return {};
}

// What else is said of a map that is not made but taken over would be said in vain.
Result<void> CheckImport(const nlohmann::json& given, const pipeline::MosaicOptions& options) {
  if (options.import_file.empty()) return {};
  for (const auto& [field, value] : given.items()) {
    if (field != "import_file" && field != "quality")
      return Refuse(field, "says how a map is made of photos; with \"import_file\" goes \"quality\" alone");
  }
  return {};
}

using OptionSetter = Result<void> (*)(const nlohmann::json&, pipeline::MosaicOptions*);
constexpr std::pair<std::string_view, OptionSetter> kOthers[] = {
    {"origin", SetOrigin}, {"boundary", SetBoundary},  {"place", SetPlace},
    {"layers", SetLayers}, {"import_file", SetImport},
};

std::string KnownOptions() {
  const std::span<const JobOption> table = pipeline::JobOptionTable();
  std::string known;
  for (const JobOption& option : table) {
    if (!known.empty()) known += &option == &table.back() ? " and " : ", ";
    known += option.name;
  }
  return known;
}

Result<void> SetOne(const std::string& field, const nlohmann::json& value, pipeline::MosaicOptions* options) {
  const JobOption* option = pipeline::FindJobOption(field);
  if (option && option->kind != JobOptionKind::kOther) return SetPlain(*option, value, options);
  for (const auto& [name, set] : kOthers) {
    if (field == name) return set(value, options);
  }
  return flight::Because(ErrorCode::kUnprocessable, {flight::RemarkCode::kFailOptionUnknown,
                                                     {{"option", field}, {"known_words", KnownOptions()}}});
}

}  // namespace

Result<pipeline::MosaicOptions> ParseJobOptions(std::string_view text) {
  SKYQUILT_TRY(CheckJsonText(text));
  const nlohmann::json parsed = ParseJson(text);
  if (parsed.is_discarded()) return Error{ErrorCode::kInvalidArgument, "The options are not JSON."};
  if (!parsed.is_object()) return Error{ErrorCode::kUnprocessable, "The options must be a JSON object."};
  pipeline::MosaicOptions options;
  for (const auto& [field, value] : parsed.items()) {
    SKYQUILT_TRY(SetOne(field, value, &options));
  }
  SKYQUILT_TRY(CheckImport(parsed, options));
  return options;
}

}  // namespace skyquilt::api
