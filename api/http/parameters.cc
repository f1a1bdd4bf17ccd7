#include "api/http/parameters.h"

#include <fmt/format.h>

#include <cmath>

#include "storage/db/ids.h"

namespace skyquilt::api {

std::optional<double> ParseFiniteNumber(std::string_view text) {
  const std::optional<double> number = ParseNumber<double>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

std::vector<std::string_view> PartsOf(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::optional<std::vector<double>> FiniteNumbers(std::string_view text, std::size_t most) {
  std::vector<double> numbers;
  for (const std::string_view part : PartsOf(text, ',')) {
    const std::optional<double> number = ParseFiniteNumber(part);
    if (!number || numbers.size() == most) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

std::optional<std::string> Parameter(const Request& request, std::string_view name) {
  for (const auto& [known, value] : request.query) {
    if (EqualsIgnoringCase(known, name)) return value;
  }
  return std::nullopt;
}

Result<double> NumberParameter(const Request& request, const char* name) {
  if (const auto number = ParseFiniteNumber(request.Query(name).value_or(""))) return *number;
  return Error{ErrorCode::kInvalidArgument, fmt::format("The parameter \"{}\" must be a number.", name)};
}

Result<int> PageSizeOf(const Request& request, int usual, int most) {
  const auto text = request.Query("limit");
  if (!text) return usual;
  const std::optional<int> limit = ParseNumber<int>(*text);
  if (limit && *limit >= 1 && *limit <= most) return *limit;
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("The parameter \"limit\" must be a whole number from 1 to {}.", most)};
}

Result<std::optional<std::string>> ParseCursor(std::optional<std::string_view> text) {
  if (!text) return std::optional<std::string>();
  if (storage::IsId(*text)) return std::optional<std::string>(*text);
  return Error{ErrorCode::kInvalidArgument, "The parameter \"cursor\" is not one that a list gave."};
}

}  // namespace skyquilt::api
