// Parameters of a request's query as values, for all who read them alike. Pure. Errors: kInvalidArgument; the
// message names the parameter.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/http/http_message.h"
#include "core/base/result.h"
#include "core/base/text/plain_text.h"

namespace skyquilt::api {

// ParseNumber (core/base/text/plain_text.h), but for infinities and what is not a number.
std::optional<double> ParseFiniteNumber(std::string_view text);

// One more than there are separators.
std::vector<std::string_view> PartsOf(std::string_view text, char separator);
// With commas between them. Absent: one of them is none, or there are more than `most`.
std::optional<std::vector<double>> FiniteNumbers(std::string_view text, std::size_t most);

// A parameter by its name in whatever case, as OWS and ArcGIS have them.
std::optional<std::string> Parameter(const Request& request, std::string_view name);
// A parameter that must be there and a number.
Result<double> NumberParameter(const Request& request, const char* name);
// How many a page of a list is to have: "limit", from 1 to `most`.
Result<int> PageSizeOf(const Request& request, int usual, int most);
// Where a list goes on: the id that its page before named, or nothing.
Result<std::optional<std::string>> ParseCursor(std::optional<std::string_view> text);

}  // namespace skyquilt::api
