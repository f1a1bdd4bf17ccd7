#include "server/watch/group_photos.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <tuple>
#include <utility>

namespace skyquilt::server {
namespace {

// JEITA CP-3461 (DCF), 3.2.2: three digits and five letters of the maker's.
constexpr std::size_t kDcfDigits = 3, kDcfLetters = 5;

bool IsDcfName(const std::string& name) {
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  const auto is_word = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  return name.size() == kDcfDigits + kDcfLetters && std::all_of(name.begin(), name.begin() + 3, is_digit) &&
         std::all_of(name.begin() + 3, name.end(), is_word);
}

struct TimedPhoto {
  std::size_t index = 0;
  std::optional<flight::UtcTime> time;
};

// In order of their paths: who has no time takes it from the one before, the first from those after it.
void FillTimes(std::vector<TimedPhoto>& photos) {
  std::optional<flight::UtcTime> known;
  for (TimedPhoto& photo : photos) {
    if (photo.time) known = photo.time;
    photo.time = known;
  }
  known.reset();
  for (auto photo = photos.rbegin(); photo != photos.rend(); ++photo) {
    if (photo->time) known = photo->time;
    photo->time = known;
  }
}

}  // namespace

std::filesystem::path RollOf(const std::filesystem::path& photo) {
  std::filesystem::path folder = photo.parent_path();
  std::string name = folder.filename().string();
  if (!IsDcfName(name)) return folder;
  std::fill_n(name.begin(), kDcfDigits, '*');
  return folder.parent_path() / name;
}

bool SaysNothing(const std::filesystem::path& folder) {
  const std::string name = folder.filename().string();
  return IsDcfName(name) || name == "DCIM" || name == "images" || name == "photos" || name.empty();
}

std::vector<std::vector<std::size_t>> GroupPhotos(const std::vector<CardPhoto>& photos,
                                                  std::chrono::seconds gap) {
  std::map<std::pair<std::filesystem::path, std::string>, std::vector<TimedPhoto>> rolls;
  std::vector<std::size_t> by_path(photos.size());
  for (std::size_t i = 0; i < photos.size(); ++i) by_path[i] = i;
  std::sort(by_path.begin(), by_path.end(),
            [&](std::size_t a, std::size_t b) { return photos[a].path < photos[b].path; });
  for (const std::size_t i : by_path)
    rolls[{RollOf(photos[i].path), photos[i].camera}].push_back({i, photos[i].taken_at});
  std::vector<std::vector<std::size_t>> flights;
  for (auto& [roll, taken] : rolls) {
    FillTimes(taken);
    std::stable_sort(taken.begin(), taken.end(),
                     [](const TimedPhoto& a, const TimedPhoto& b) { return a.time < b.time; });
    for (std::size_t k = 0; k < taken.size(); ++k) {
      const bool is_new = k == 0 || (taken[k].time && *taken[k].time - *taken[k - 1].time > gap);
      if (is_new) flights.emplace_back();
      flights.back().push_back(taken[k].index);
    }
  }
  return flights;
}

}  // namespace skyquilt::server
