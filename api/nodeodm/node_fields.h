// What clients of the NodeODM-compatible node send as a form in one way or the other: multipart, urlencoded
// or JSON. Pure.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace skyquilt::api {

// Texts by name. What JSON has as a list, an object, a number or a truth is its JSON text.
using NodeFields = std::map<std::string, std::string, std::less<>>;

// Of a field that comes twice, the first counts; files are passed over. An empty body has no fields. Errors:
// kInvalidArgument, kTooLarge.
Result<NodeFields> ParseNodeFields(std::string_view content_type, const std::string& body);

// The field's text, empty if there is none.
std::string NodeField(const NodeFields& fields, std::string_view name);

}  // namespace skyquilt::api
