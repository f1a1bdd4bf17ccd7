#include "core/base/text/json_io.h"

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

namespace skyquilt {
namespace {

template <typename Json>
Json Parse(std::string_view text) {
  return Json::parse(text.data(), text.data() + text.size(), nullptr, /*allow_exceptions=*/false);
}

template <typename Json>
std::string Dump(const Json& value, int indent) {
  return value.dump(indent, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace);
}

}  // namespace

nlohmann::json ParseJson(std::string_view text) { return Parse<nlohmann::json>(text); }

nlohmann::json ParseJsonFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return ParseJson(std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()));
}

nlohmann::ordered_json ParseOrderedJson(std::string_view text) { return Parse<nlohmann::ordered_json>(text); }

std::optional<std::string> TextIn(const nlohmann::json& value, const char* name) {
  const auto found = value.find(name);
  if (found == value.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

std::string JsonText(const nlohmann::json& value, int indent) { return Dump(value, indent); }
std::string JsonText(const nlohmann::ordered_json& value, int indent) { return Dump(value, indent); }

}  // namespace skyquilt
