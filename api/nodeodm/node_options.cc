#include "api/nodeodm/node_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/json/job_options.h"
#include "api/json/json_text.h"
#include "api/nodeodm/node_option_list.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

constexpr double kFinestGsdM = 0.001;  // that a job takes
constexpr std::size_t kMaxUnknown = 50;

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

Error MustBe(const char* what) {
  return {ErrorCode::kUnprocessable, fmt::format("The value must be {}.", what), ""};
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

std::string NodeOptionsJson() {
  Value list = Value::array();
  for (const NodeOption& option : NodeOptionList()) {
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
    return Error{ErrorCode::kInvalidArgument, "Invalid options: give a JSON list of {name, value}.", ""};
  }
  Value job_options = Value::object();
  Value shown = Value::array();
  Value errors = Value::array();
  for (const Value& item : list) {
    if (!item.is_object() || !item.contains("name") || !item["name"].is_string() || !item.contains("value")) {
      return Error{ErrorCode::kInvalidArgument, "Invalid options: every item needs a name and a value.", ""};
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
    return Error{ErrorCode::kUnprocessable, JsonText(errors), ""};
  }
  choice.job_options = JsonText(job_options);
  choice.shown = JsonText(shown);
  return choice;
}

}  // namespace skyquilt::api
