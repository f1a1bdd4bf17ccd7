#include "api/http/parameters.h"

#include <fmt/format.h>

#include <cmath>

#include "storage/db/ids.h"

namespace skyquilt::api {

std::optional<double> ParseFiniteNumber(std::string_view text) {
  const std::optional<double> number = ParseNumber<double>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

std::optional<std::string> Parameter(const Request& request, std::string_view name) {
  for (const auto& [known, value] : request.query) {
    if (EqualsIgnoringCase(known, name)) return value;
  }
  return std::nullopt;
}

Result<double> NumberParameter(const Request& request, const char* name) {
  if (const auto number = ParseFiniteNumber(request.Query(name).value_or(""))) return *number;
  return Error{ErrorCode::kInvalidArgument, fmt::format("The parameter \"{}\" must be a number.", name), ""};
}

Result<int> PageSizeOf(const Request& request, int usual, int most) {
  const auto text = request.Query("limit");
  if (!text) return usual;
  const std::optional<int> limit = ParseNumber<int>(*text);
  if (limit && *limit >= 1 && *limit <= most) return *limit;
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("The parameter \"limit\" must be a whole number from 1 to {}.", most), ""};
}

Result<std::optional<std::string>> ParseCursor(std::optional<std::string_view> text) {
  if (!text) return std::optional<std::string>();
  if (storage::IsId(*text)) return std::optional<std::string>(*text);
  return Error{ErrorCode::kInvalidArgument, "The parameter \"cursor\" is not one that a list gave.", ""};
}

}  // namespace skyquilt::api
