// Tags of flights: a bounded list of short words by which a user finds flights again. A tag is 1 to 40
// characters (at most 120 bytes) of valid UTF-8 without commas, control characters and spaces at its ends; a
// flight has at most 20, none twice, in the order of their bytes. Upper and lower case differ. Pure.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::storage {

inline constexpr std::size_t kMaxTags = 20;
inline constexpr std::size_t kMaxTagCharacters = 40;
inline constexpr std::size_t kMaxTagBytes = 120;

// In order, each once. Errors: kUnprocessable (one of them is no tag, or they are too many), in words for
// whoever gave them.
Result<std::vector<std::string>> CheckedTags(std::vector<std::string> tags);

// As the catalogue keeps them: "\nmaize\nnorth\n"; "" for none.
std::string TagsText(const std::vector<std::string>& tags);
std::vector<std::string> TagsFrom(std::string_view text);

}  // namespace skyquilt::storage
