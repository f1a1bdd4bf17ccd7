#include "core/flight/aside/previews.h"

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "core/flight/aside/alike.h"
#include "core/flight/aside/picture_name.h"

namespace skyquilt::flight {
namespace {

// Of two or three equal names nothing follows: counters of cameras begin anew on every card.
constexpr std::size_t kFewestPreviews = 3;

// Nothing that a camera recorded: which photo it could be of its name alone tells.
bool HasNoRecords(const Photo& photo) {
  return !photo.origin.clock && photo.origin.makers_records == 0 && photo.make.empty() &&
         photo.model.empty() && !photo.position;
}

using ByStem = std::unordered_map<std::string, std::vector<std::size_t>>;

// Those of its name, also behind a folder's: names that lie in one folder after all have it in front
// ("small_DJI_0001.JPG").
const std::vector<std::size_t>* OfTheName(std::string_view stem, const ByStem& recorded) {
  constexpr int kMaxFolders = 4;
  for (int folder = 0; folder <= kMaxFolders; ++folder) {
    const auto found = recorded.find(std::string(stem));
    if (found != recorded.end()) return &found->second;
    const std::size_t line = stem.find('_');
    if (line == std::string_view::npos) break;
    stem.remove_prefix(line + 1);
  }
  return nullptr;
}

// The one given, or where the bytes are for files whose names are theirs alone.
std::string FolderOf(const Photo& photo) {
  const std::size_t end = photo.name.find_last_of("/\\");
  return end != std::string::npos ? photo.name.substr(0, end) : photo.path.parent_path().string();
}

}  // namespace

std::vector<std::optional<std::size_t>> FindPreviews(const std::vector<Photo>& photos) {
  std::vector<std::optional<std::size_t>> original_of(photos.size());
  std::map<std::string, std::vector<std::size_t>> bare;  // by folder
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (HasNoRecords(photos[i])) bare[FolderOf(photos[i])].push_back(i);
  }
  if (bare.empty()) return original_of;
  ByStem recorded;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!HasNoRecords(photos[i])) recorded[PictureNameOf(photos[i].name).stem].push_back(i);
  }
  for (const auto& [folder, pictures] : bare) {
    std::vector<std::pair<std::size_t, std::size_t>> found;
    for (const std::size_t i : pictures) {
      const auto* of_name = OfTheName(PictureNameOf(photos[i].name).stem, recorded);
      if (of_name == nullptr) continue;
      std::optional<std::size_t> best;
      for (std::size_t k = 0; k < std::min(of_name->size(), kMaxLookedAt); ++k) {
        const std::size_t other = (*of_name)[k];
        if (!IsReducedTo(photos[i], photos[other]) || AreOfTwoSensors(photos[i], photos[other])) continue;
        if (!best || PhotoPixels(photos[other]) > PhotoPixels(photos[*best])) best = other;
      }
      if (best) found.push_back({i, *best});
    }
    if (found.size() < kFewestPreviews || 2 * found.size() <= pictures.size()) continue;
    for (const auto& [i, original] : found) original_of[i] = original;
  }
  return original_of;
}

}  // namespace skyquilt::flight
