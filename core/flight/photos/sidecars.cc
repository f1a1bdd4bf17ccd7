#include "core/flight/photos/sidecars.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

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

}  // namespace

void TakePositionsFromSidecars(const std::vector<InputFile>& sidecars, std::vector<Photo>& photos,
                               std::vector<Remark>& warnings) {
  if (sidecars.empty()) return;
  std::map<std::string, std::size_t> at_place;
  for (std::size_t i = 0; i < sidecars.size(); ++i)
    at_place.try_emplace(PlaceOf(sidecars[i].name, sidecars[i].path), i);
  std::vector<bool> is_used(sidecars.size(), false);
  for (Photo& photo : photos) {
    if (photo.position) continue;
    for (const std::string& place : PlacesBeside(photo)) {
      const auto found = at_place.find(place);
      if (found == at_place.end()) continue;
      photo.position = PositionIn(sidecars[found->second].path, photo.notes);
      if (!photo.position) continue;
      if (!photo.position->height_above_takeoff_m)
        photo.position->height_above_takeoff_m = photo.lone_height_above_takeoff_m;
      photo.lone_height_above_takeoff_m.reset();
      photo.notes.push_back(RemarkCode::kPositionFromSidecar);
      is_used[found->second] = true;
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
