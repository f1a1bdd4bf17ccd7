#include "api/stac/stac_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "api/http/parameters.h"
#include "api/json/json_codec.h"
#include "api/json/json_text.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "storage/db/ids.h"

namespace skyquilt::api {
namespace {

using SearchJson = nlohmann::json;

constexpr int kMaxFound = 200;
constexpr std::size_t kMaxNames = 1000;

Error BadParameter(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

Result<std::optional<std::vector<std::string>>> NamesOf(const SearchJson& body, const char* name) {
  std::optional<std::vector<std::string>> names;
  const auto found = body.find(name);
  if (found == body.end() || found->is_null()) return names;
  names.emplace();
  const Error bad = BadParameter(fmt::format("\"{}\" must be a list of at most {} names.", name, kMaxNames));
  if (!found->is_array() || found->size() > kMaxNames) return bad;
  for (const SearchJson& one : *found) {
    if (!one.is_string()) return bad;
    names->push_back(one.get<std::string>());
  }
  return names;
}

// What is passed over would find everything.
Result<void> CheckKnown(const std::function<bool(const char*)>& is_given) {
  for (const char* unknown : {"query", "filter"}) {
    if (is_given(unknown)) {
      return BadParameter(fmt::format(
          "This server does not search by \"{}\"; it does by bbox, intersects, datetime, ids and collections.",
          unknown));
    }
  }
  return {};
}

Result<void> SetCursor(StacSearch& search, std::string_view text) {
  if (!storage::IsId(text)) return BadParameter("\"cursor\" is not one that a page gave.");
  search.cursor = std::string(text);
  return {};
}

Result<StacSearch> Checked(StacSearch search) {
  if (search.bbox && search.intersects) return BadParameter("Give \"bbox\" or \"intersects\", not both.");
  return search;
}

}  // namespace

Result<StacSearch> ParseStacQuery(const Request& request) {
  SKYQUILT_TRY(CheckKnown([&](const char* name) { return request.Query(name).has_value(); }));
  StacSearch search;
  SKYQUILT_TRY_ASSIGN(search.limit, ParseLimit(request.Query("limit").value_or(""), search.limit, kMaxFound));
  if (const auto cursor = request.Query("cursor")) SKYQUILT_TRY(SetCursor(search, *cursor));
  if (const auto bbox = request.Query("bbox")) {
    SKYQUILT_TRY_ASSIGN(search.bbox, ParseBbox(*bbox));
  }
  if (const auto shape = request.Query("intersects")) {
    SKYQUILT_TRY(CheckJsonText(*shape));
    SKYQUILT_TRY_ASSIGN(auto parsed, storage::GeoJsonShape::Parse(*shape));
    search.intersects = std::move(parsed);
  }
  if (const auto datetime = request.Query("datetime")) {
    SKYQUILT_TRY_ASSIGN(search.datetime, ParseTimeSpan(*datetime));
  }
  const auto names = [&](const char* name) -> Result<std::optional<std::vector<std::string>>> {
    const auto text = request.Query(name);
    if (!text) return std::optional<std::vector<std::string>>();
    const std::vector<std::string_view> parts = PartsOf(*text, ',');
    if (parts.size() > kMaxNames) return BadParameter(fmt::format("\"{}\" has too many names.", name));
    return std::optional(std::vector<std::string>(parts.begin(), parts.end()));
  };
  SKYQUILT_TRY_ASSIGN(search.ids, names("ids"));
  SKYQUILT_TRY_ASSIGN(search.collections, names("collections"));
  return Checked(std::move(search));
}

Result<StacSearch> ParseStacBody(const std::string& body) {
  SKYQUILT_TRY(CheckJsonText(body));
  const SearchJson json = ParseJson(body);
  if (!json.is_object()) return BadParameter("The body must be a JSON object.");
  SKYQUILT_TRY(CheckKnown([&](const char* name) { return json.contains(name); }));
  const auto given = [&](const char* name) { return json.contains(name) && !json[name].is_null(); };
  StacSearch search;
  if (given("limit")) {
    if (!json["limit"].is_number_integer()) return BadParameter("\"limit\" must be a whole number.");
    SKYQUILT_TRY_ASSIGN(search.limit, ParseLimit(JsonText(json["limit"]), search.limit, kMaxFound));
  }
  if (given("cursor")) {
    if (!json["cursor"].is_string()) return BadParameter("\"cursor\" is not one that a page gave.");
    SKYQUILT_TRY(SetCursor(search, json["cursor"].get<std::string>()));
  }
  if (given("bbox")) {
    std::vector<double> numbers;
    if (json["bbox"].is_array() && json["bbox"].size() <= 6) {
      for (const SearchJson& number : json["bbox"])
        numbers.push_back(number.is_number() ? number.get<double>() : std::nan(""));
    }
    SKYQUILT_TRY_ASSIGN(search.bbox, BboxOf(numbers));
  }
  if (given("intersects")) {
    SKYQUILT_TRY_ASSIGN(auto parsed, storage::GeoJsonShape::Parse(JsonText(json["intersects"])));
    search.intersects = std::move(parsed);
  }
  if (given("datetime")) {
    if (!json["datetime"].is_string()) return BadParameter("\"datetime\" must be a text.");
    SKYQUILT_TRY_ASSIGN(search.datetime, ParseTimeSpan(json["datetime"].get<std::string>()));
  }
  SKYQUILT_TRY_ASSIGN(search.ids, NamesOf(json, "ids"));
  SKYQUILT_TRY_ASSIGN(search.collections, NamesOf(json, "collections"));
  return Checked(std::move(search));
}

std::optional<StacTimes> CaptureTimesOf(const storage::Revision& revision) {
  const double lon_deg = revision.bounds.Middle().lon_deg;
  const auto first = UtcOfCapture(revision.first_capture, lon_deg);
  const auto last = UtcOfCapture(revision.last_capture, lon_deg);
  if (!first || !last) return std::nullopt;
  return StacTimes{*first, *last};
}

bool StacSearch::Finds(const storage::ShownFlight& map) const {
  const auto has = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  if (collections && !has(*collections, kStacCollection)) return false;
  const std::string id = fmt::format("{}-r{}", map.flight_id, map.revision.revision);
  if (ids && !has(*ids, id) && !has(*ids, map.flight_id)) return false;
  if (!LiesSomewhere(map.revision.bounds)) return false;
  if (bbox && !BoxesMeet(*bbox, map.revision.bounds)) return false;
  if (datetime) {
    const std::string made = FormatTime(map.revision.created);
    const StacTimes times = CaptureTimesOf(map.revision).value_or(StacTimes{made, made});
    const auto first = InstantOf(times.first), last = InstantOf(times.last);
    if (!first || !last) return false;
    if (datetime->from && *last < *datetime->from) return false;
    if (datetime->to && *first > *datetime->to) return false;
  }
  return !intersects || intersects->Meets(map.revision.bounds);
}

}  // namespace skyquilt::api
