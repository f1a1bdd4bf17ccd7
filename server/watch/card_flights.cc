#include "server/watch/card_flights.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
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

// In order of their paths: who has no time takes it from the one before, the first from those after it.
void FillTimes(const std::vector<std::size_t>& roll, std::vector<CardPhoto>& photos) {
  std::optional<flight::UtcTime> known;
  const auto fill = [&](std::size_t i) {
    if (photos[i].taken_at) known = photos[i].taken_at;
    photos[i].taken_at = known;
  };
  std::for_each(roll.begin(), roll.end(), fill);
  known.reset();
  std::for_each(roll.rbegin(), roll.rend(), fill);
}

namespace fs = std::filesystem;
using Files = std::map<fs::path, CardFile>;

// How many times longer a photo without its end is waited for.
constexpr int kPatienceForCut = 3;

std::string NameOfCardFlight(const CardFiles& card, const fs::path& first_photo) {
  const CardFile& file = card.files().at(first_photo);
  const auto is_root = [&](const fs::path& folder) {
    return std::find(card.roots().begin(), card.roots().end(), folder) != card.roots().end();
  };
  fs::path folder = first_photo.parent_path();
  while (!is_root(folder) && folder.has_relative_path() && SaysNothing(folder)) folder = folder.parent_path();
  std::string name = is_root(folder) || SaysNothing(folder) ? file.model : folder.filename().string();
  if (name.empty()) name = "Flight";
  if (!file.taken_at) return name;
  const auto local = std::chrono::floor<std::chrono::seconds>(*file.taken_at) + file.clock_minus_utc;
  return fmt::format("{}, {:%Y-%m-%d %H:%M}", name, fmt::gmtime(std::chrono::system_clock::to_time_t(local)));
}

// Rolls in which a file is still to come to its end.
std::set<fs::path> RollsAtWork(const Files& files, const FlightRules& rules,
                               CardFile::Clock::time_point now) {
  std::set<fs::path> rolls;
  for (const auto& [path, file] : files) {
    const bool may_end =
        file.kind == CardKind::kCut && now - file.changed_at < kPatienceForCut * rules.settle;
    if (may_end || file.kind == CardKind::kUnread) rolls.insert(RollOf(path));
  }
  return rolls;
}

// By when they were written, what lies beside the photos of several flights goes to the nearest.
std::size_t NearestOf(const std::vector<CardFlight>& flights, const std::vector<std::size_t>& candidates,
                      const Files& files, const CardFile& beside) {
  std::size_t nearest = candidates.front();
  auto least = fs::file_time_type::duration::max();
  for (const std::size_t candidate : candidates) {
    auto first = fs::file_time_type::max(), last = fs::file_time_type::min();
    for (const fs::path& photo : flights[candidate].photos) {
      first = std::min(first, files.at(photo).written_at);
      last = std::max(last, files.at(photo).written_at);
    }
    const auto away = beside.written_at < first  ? first - beside.written_at
                      : beside.written_at > last ? beside.written_at - last
                                                 : fs::file_time_type::duration::zero();
    if (away >= least) continue;
    least = away;
    nearest = candidate;
  }
  return nearest;
}

void AddBeside(const Files& files, std::vector<CardFlight>& flights) {
  std::map<fs::path, std::vector<std::size_t>> flights_in;
  for (std::size_t i = 0; i < flights.size(); ++i) {
    std::set<fs::path> folders;
    for (const fs::path& photo : flights[i].photos) folders.insert(photo.parent_path());
    for (const fs::path& folder : folders) flights_in[folder].push_back(i);
  }
  for (const auto& [path, file] : files) {
    if (file.kind != CardKind::kBeside) continue;
    const auto candidates = flights_in.find(path.parent_path());
    if (candidates == flights_in.end()) continue;
    flights[NearestOf(flights, candidates->second, files, file)].beside.push_back(path);
  }
}

void Settle(const Files& files, const std::set<fs::path>& at_work, const FlightRules& rules,
            CardFile::Clock::time_point now, CardFlight& flight) {
  Hasher hasher;
  flight.is_settled = true;
  const auto look_at = [&](const fs::path& path) {
    const CardFile& file = files.at(path);
    flight.bytes += file.bytes;
    flight.is_settled &= now - file.changed_at >= rules.settle;
    hasher.Add(path.string())
        .Add(file.bytes)
        .Add(static_cast<std::int64_t>(file.written_at.time_since_epoch().count()));
  };
  std::for_each(flight.photos.begin(), flight.photos.end(), look_at);
  std::for_each(flight.beside.begin(), flight.beside.end(), look_at);
  std::set<fs::path> rolls;
  for (const fs::path& photo : flight.photos) rolls.insert(RollOf(photo));
  for (const fs::path& roll : rolls) flight.is_settled &= !at_work.contains(roll);
  const Digest digest = hasher.Finish();
  flight.signature.assign(digest.begin(), digest.end());
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

std::vector<std::vector<std::size_t>> GroupPhotos(std::vector<CardPhoto> photos, std::chrono::seconds gap) {
  std::map<std::pair<std::filesystem::path, std::string>, std::vector<std::size_t>> rolls;
  std::vector<std::size_t> by_path(photos.size());
  for (std::size_t i = 0; i < photos.size(); ++i) by_path[i] = i;
  std::sort(by_path.begin(), by_path.end(),
            [&](std::size_t a, std::size_t b) { return photos[a].path < photos[b].path; });
  for (const std::size_t i : by_path) rolls[{RollOf(photos[i].path), photos[i].camera}].push_back(i);
  std::vector<std::vector<std::size_t>> flights;
  for (auto& [roll, taken] : rolls) {
    FillTimes(taken, photos);
    std::stable_sort(taken.begin(), taken.end(),
                     [&](std::size_t a, std::size_t b) { return photos[a].taken_at < photos[b].taken_at; });
    for (std::size_t k = 0; k < taken.size(); ++k) {
      const auto& time = photos[taken[k]].taken_at;
      const bool is_new = k == 0 || (time && *time - *photos[taken[k - 1]].taken_at > gap);
      if (is_new) flights.emplace_back();
      flights.back().push_back(taken[k]);
    }
  }
  return flights;
}

std::vector<CardFlight> FlightsOf(const CardFiles& card, const FlightRules& rules,
                                  CardFile::Clock::time_point now) {
  const Files& files = card.files();
  std::vector<CardPhoto> photos;
  std::map<fs::path, std::size_t> cut_in;
  for (const auto& [path, file] : files) {
    if (file.kind == CardKind::kPhoto) photos.push_back({path, file.camera, file.taken_at});
    if (file.kind == CardKind::kCut) ++cut_in[RollOf(path)];
  }
  const std::set<fs::path> at_work = RollsAtWork(files, rules, now);
  std::vector<CardFlight> flights;
  for (const std::vector<std::size_t>& group : GroupPhotos(photos, rules.gap)) {
    if (group.size() < rules.min_photos) continue;
    CardFlight& flight = flights.emplace_back();
    for (const std::size_t index : group) flight.photos.push_back(photos[index].path);
    flight.name = NameOfCardFlight(card, flight.photos.front());
    flight.cut_photos = cut_in[RollOf(flight.photos.front())];
  }
  AddBeside(files, flights);
  for (CardFlight& flight : flights) Settle(files, at_work, rules, now, flight);
  return flights;
}

}  // namespace skyquilt::server
