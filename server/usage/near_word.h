// NearWord: which of the known words somebody meant who typed another: the one with the fewest letters
// changed, left out, added or swapped, if those are few for its length. Pure; any thread. Source: the
// restricted Damerau-Levenshtein distance.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skyquilt::server {

std::optional<std::string> NearWord(std::string_view typed, const std::vector<std::string>& known);

}  // namespace skyquilt::server
