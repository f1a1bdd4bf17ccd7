#include "api/nodeodm/node_options.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/json/job_options.h"
#include "api/json/json_text.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

// What a job option is called here, and how its value is written.
struct Offer {
  const char* name;
  const char* job_option;
  const char* type;
  const char* value;   // the default, always a text
  const char* domain;  // JSON
  const char* help;
};

constexpr std::array<Offer, 5> kOffers = {{
    {"orthophoto-resolution", "gsd_m", "float", "0", R"("float: 0 <= x <= 10000")",
     "Ground size of an orthophoto pixel in cm. 0 means as fine as the photos. Default: %(default)s"},
    {"rolling-shutter-readout", "readout_ms", "float", "0", R"("float: 0 <= x <= 500")",
     "Rolling shutter: milliseconds from reading a photo's first row to its last. 0 means as known of the camera. "
     "Default: %(default)s"},
    {"orthophoto-quality", "quality", "int", "85", R"("integer: 1 <= x <= 100")",
     "JPEG quality of the orthophoto's tiles. Default: %(default)s"},
    {"tile-format", "format", "enum", "auto", R"(["auto","webp"])",
     "Format of the map's tiles: JPEG with PNG at the fringe (auto), or WebP. One of: %(choices)s. Default: "
     "%(default)s"},
    {"align-method", "method", "enum", "auto", R"(["auto","imu","features","direct"])",
     "How photos are placed: by what suits (auto), by their recorded poses alone (imu), by matching "
     "features, or "
     "directly by brightness. One of: %(choices)s. Default: %(default)s"},
}};

const Offer* FindOffer(std::string_view name) {
  for (const Offer& offer : kOffers) {
    if (name == offer.name) return &offer;
  }
  return nullptr;
}

std::optional<double> NumberFrom(const Value& value) {
  if (value.is_number()) return value.get<double>();
  if (!value.is_string()) return std::nullopt;
  const auto& text = value.get_ref<const std::string&>();
  double number = 0.0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || parsed.ec != std::errc() || parsed.ptr != text.data() + text.size())
    return std::nullopt;
  return number;
}

// The value as the job's option has it; null keeps the default.
Result<Value> JobValue(const Offer& offer, const Value& value) {
  const std::string_view type = offer.type;
  if (type == "enum") return value;
  const std::optional<double> number = NumberFrom(value);
  if (!number) return Error{ErrorCode::kUnprocessable, "The value must be a number.", ""};
  if (std::string_view(offer.job_option) == "gsd_m") {
    return *number == 0.0 ? Value(nullptr) : Value(*number / 100.0);  // centimetres to metres
  }
  if (std::string_view(offer.job_option) == "readout_ms")
    return *number == 0.0 ? Value(nullptr) : Value(*number);
  const auto whole = static_cast<std::int64_t>(std::clamp(*number, -1e9, 1e9));
  if (static_cast<double>(whole) != *number)
    return Error{ErrorCode::kUnprocessable, "The value must be a whole number.", ""};
  return Value(whole);
}

std::string Shown(const Value& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

}  // namespace

std::string NodeOptionsJson() {
  Value list = Value::array();
  for (const Offer& offer : kOffers) {
    list.push_back({{"name", offer.name},
                    {"type", offer.type},
                    {"value", offer.value},
                    {"domain", Value::parse(offer.domain)},
                    {"help", offer.help}});
  }
  return list.dump();
}

Result<NodeChoice> ParseNodeOptions(std::string_view text) {
  if (text.empty()) return NodeChoice{"{}", "[]"};
  SKYQUILT_TRY(CheckJsonText(text));
  const Value list = Value::parse(text, nullptr, false);
  if (!list.is_array()) {
    return Error{ErrorCode::kInvalidArgument, "Invalid options: give a JSON list of {name, value}.", ""};
  }
  Value job_options = Value::object();
  Value shown = Value::array();
  Value errors = Value::array();
  for (const Value& item : list) {
    if (!item.is_object() || !item.contains("name") || !item["name"].is_string() || !item.contains("value")) {
      return Error{ErrorCode::kInvalidArgument, "Invalid options: every item needs a name and a value.", ""};
    }
    const Offer* offer = FindOffer(item["name"].get_ref<const std::string&>());
    if (offer == nullptr) continue;
    Result<Value> value = JobValue(*offer, item["value"]);
    // The job's own rules are the last word.
    if (value) {
      const Result<pipeline::MosaicOptions> checked = ParseJobOptions(
          Value{{offer->job_option, *value}}.dump(-1, ' ', false, Value::error_handler_t::replace));
      if (!checked) value = checked.error();
    }
    if (!value) {
      errors.push_back({{"name", offer->name}, {"error", value.error().message}});
      continue;
    }
    job_options[offer->job_option] = *value;
    shown.push_back({{"name", offer->name}, {"value", Shown(item["value"])}});
  }
  if (!errors.empty()) {
    return Error{ErrorCode::kUnprocessable, errors.dump(-1, ' ', false, Value::error_handler_t::replace), ""};
  }
  return NodeChoice{job_options.dump(), shown.dump(-1, ' ', false, Value::error_handler_t::replace)};
}

}  // namespace skyquilt::api
