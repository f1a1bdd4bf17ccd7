// ParseJson, JsonText: between JSON and its text, compiled once: the library's parser and serializer cost
// seconds in every object that calls them by themselves. A text that is no JSON gives a discarded value: ask
// `is_discarded()`, or what it should be (`is_object()`), before a look inside; at(), [], value() and get()
// of it throw an exception of the library's, but contains() is false, and a loop over it runs once. Bytes
// that are not UTF-8 are written as U+FFFD. Any thread.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace skyquilt {

nlohmann::json ParseJson(std::string_view text);
// Of a file; discarded too where it cannot be read.
nlohmann::json ParseJsonFile(const std::filesystem::path& path);
// Members in the order of the text.
nlohmann::ordered_json ParseOrderedJson(std::string_view text);

// The text that this member of `value` is; absent where it is none, or `value` no object.
std::optional<std::string> TextIn(const nlohmann::json& value, const char* name);

// `indent`: spaces a level; negative: one line.
std::string JsonText(const nlohmann::json& value, int indent = -1);
std::string JsonText(const nlohmann::ordered_json& value, int indent = -1);

}  // namespace skyquilt
