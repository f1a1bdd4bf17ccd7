#include "core/poses/unplaced_words.h"

#include <fmt/core.h>

#include <algorithm>
#include <string_view>

namespace skyquilt::poses {
namespace {

constexpr std::string_view kBegin = "The map is whole but NOT GEOREFERENCED";
constexpr std::string_view kEnd = "to place it without aligning it again.";

}  // namespace

std::string NotGeoreferencedWords(double guessed_width_m) {
  return fmt::format(
      "{}: it lies at a local origin, its north is a guess and its scale is as if a photo showed {:.0f} m of ground. "
      "Add the flight log, surveyed points (gcp_list.txt) or positions (geo.txt), or give `skyquilt place` what "
      "is known {}",
      kBegin, guessed_width_m, kEnd);
}

std::string ReckonedFromNowhereWords() {
  return "No position anywhere: the map has the right scale and north, but its place on Earth is not known; "
         "it is drawn at 0 degrees north, 0 degrees east. Give --origin LAT,LON of the take-off to place it, "
         "also later with `skyquilt place`.";
}

void EraseUnplacedWords(std::vector<std::string>& warnings) {
  std::erase(warnings, ReckonedFromNowhereWords());
  for (std::string& warning : warnings) {
    const std::size_t begin = warning.find(kBegin);
    const std::size_t end = begin == std::string::npos ? begin : warning.find(kEnd, begin);
    if (end == std::string::npos) continue;
    warning.erase(begin, end + kEnd.size() - begin);
    while (warning.ends_with(' ')) warning.pop_back();
  }
  std::erase(warnings, std::string());
}

}  // namespace skyquilt::poses
