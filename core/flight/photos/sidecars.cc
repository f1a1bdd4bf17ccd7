#include "core/flight/photos/sidecars.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/text/file_names.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/metadata/exif.h"
#include "core/flight/metadata/position_tags.h"
#include "core/flight/metadata/xmp.h"

namespace skyquilt::flight {
namespace {

// The folder the bytes are in and the name the user gave: wherever files are stored under others.
std::string PlaceOf(const std::string& name, const std::filesystem::path& path) {
  const std::string file = name.substr(name.find_last_of("/\\") + 1);
  return LowerCase((path.parent_path() / file).string());
}

std::optional<RecordedPosition> PositionIn(const std::filesystem::path& path, std::vector<Remark>& notes) {
  constexpr std::size_t kMaxSidecar = 1u << 20;  // as of an XMP packet in a photo
  const auto source = OpenFileBytes(path);
  if (!source || (*source)->size() > kMaxSidecar) return std::nullopt;
  const auto bytes = (*source)->ReadUpTo(0, kMaxSidecar);
  XmpTags xmp;
  if (!xmp.AddPacket(TextOf(bytes))) return std::nullopt;
  return PositionFromTags(ExifRecord{}, xmp, notes);
}

// What sidecars of this photo are called: "dji_0001.jpg.xmp", "dji_0001.xmp".
std::array<std::string, 2> PlacesBeside(const Photo& photo) {
  const std::string file = PlaceOf(photo.name, photo.path);
  return {file + ".xmp", file.substr(0, file.rfind('.')) + ".xmp"};
}

// Sidecars by their places. Those of no photo also without folders that were joined to their names, as to
// all files beside photos of doubled names ("100media_dji_0002.xmp"), where one alone is called so.
class SidecarsByPlace {
 public:
  SidecarsByPlace(const std::vector<InputFile>& sidecars, const std::vector<Photo>& photos) {
    std::set<std::string> beside_photos;
    for (const Photo& photo : photos) {
      for (std::string& place : PlacesBeside(photo)) beside_photos.insert(std::move(place));
    }
    for (std::size_t i = 0; i < sidecars.size(); ++i) {
      const std::string place = PlaceOf(sidecars[i].name, sidecars[i].path);
      at_.try_emplace(place, i);
      if (!beside_photos.contains(place)) AddWithoutFolders(place, i);
    }
  }

  std::optional<std::size_t> Find(const std::string& place) const {
    if (const auto found = at_.find(place); found != at_.end()) return found->second;
    const auto found = joined_.find(place);
    return found == joined_.end() ? std::nullopt : found->second;
  }

 private:
  void AddWithoutFolders(const std::string& place, std::size_t sidecar) {
    const std::size_t begin = place.find_last_of('/') + 1;
    std::string file = place.substr(begin);
    for (std::size_t folder = 0; folder < kMaxFoldersOfName; ++folder) {
      const std::size_t line = file.find('_');
      if (line == std::string::npos) return;
      file.erase(0, line + 1);
      const std::string_view stem = std::string_view(file).substr(0, file.find('.'));
      // "0002" is what is left of a name by chance.
      if (std::all_of(stem.begin(), stem.end(), IsDigit)) return;
      const auto [at, is_new] = joined_.try_emplace(place.substr(0, begin) + file, sidecar);
      if (!is_new) at->second.reset();
    }
  }

  std::map<std::string, std::size_t> at_;
  std::map<std::string, std::optional<std::size_t>> joined_;  // nothing where several are called so
};

}  // namespace

void TakePositionsFromSidecars(const std::vector<InputFile>& sidecars, std::vector<Photo>& photos,
                               std::vector<Remark>& warnings) {
  if (sidecars.empty()) return;
  const SidecarsByPlace by_place(sidecars, photos);
  std::vector<bool> is_used(sidecars.size(), false);
  for (Photo& photo : photos) {
    if (photo.position) continue;
    for (const std::string& place : PlacesBeside(photo)) {
      const auto found = by_place.Find(place);
      if (!found) continue;
      photo.position = PositionIn(sidecars[*found].path, photo.notes);
      if (!photo.position) continue;
      if (!photo.position->height_above_takeoff_m)
        photo.position->height_above_takeoff_m = photo.lone_height_above_takeoff_m;
      photo.lone_height_above_takeoff_m.reset();
      photo.notes.push_back(RemarkCode::kPositionFromSidecar);
      is_used[*found] = true;
      break;
    }
  }
  const auto unused = static_cast<std::size_t>(std::count(is_used.begin(), is_used.end(), false));
  if (unused == 0) return;
  const auto first = std::find(is_used.begin(), is_used.end(), false) - is_used.begin();
  warnings.push_back({RemarkCode::kSidecarsNotUsed,
                      {{"files", unused}, {"file", sidecars[static_cast<std::size_t>(first)].name}}});
}

}  // namespace skyquilt::flight
