#include "server/usage/near_word.h"

#include <algorithm>

namespace skyquilt::server {
namespace {

constexpr std::size_t kLongestWord = 64;  // of what is compared: an argument may have any length

std::size_t Distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> of(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) of[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) of[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      of[i][j] =
          std::min({of[i - 1][j] + 1, of[i][j - 1] + 1, of[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        of[i][j] = std::min(of[i][j], of[i - 2][j - 2] + 1);
    }
  }
  return of[a.size()][b.size()];
}

}  // namespace

std::optional<std::string> NearWord(std::string_view typed, const std::vector<std::string>& known) {
  if (typed.empty() || typed.size() > kLongestWord) return std::nullopt;
  std::optional<std::string> nearest;
  std::size_t least = 0;
  for (const std::string& word : known) {
    const bool is_begun = (typed.size() > 2 && word.starts_with(typed)) ||  // cut short, or more than that
                          (word.size() > 2 && typed.starts_with(word));
    const std::size_t distance = is_begun ? 1 : Distance(typed, word);
    if (nearest && distance >= least) continue;
    nearest = word;
    least = distance;
  }
  if (!nearest || least > std::max<std::size_t>(1, nearest->size() / 3)) return std::nullopt;
  return nearest;
}

}  // namespace skyquilt::server
