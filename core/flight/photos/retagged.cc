#include "core/flight/photos/retagged.h"

#include <xxhash.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "core/flight/aside/aside.h"
#include "core/flight/aside/picture_name.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/photos/jpeg_segments.h"

namespace skyquilt::flight {
namespace {

struct Named {
  std::string counter;             // "0001_w": the last number of the name, and what follows
  bool is_named_for_tags = false;  // "DJI_0001_geotag.JPG"
};

Named NamedAs(const std::string& name) {
  constexpr std::string_view kDigits = "0123456789";
  const std::string stem = PictureNameOf(name).stem;
  const auto without = WithoutTagMark(stem);
  const std::string_view plain = without ? *without : std::string_view(stem);
  const std::size_t end = plain.find_last_of(kDigits);
  const std::size_t before =
      end == std::string_view::npos ? std::string_view::npos : plain.find_last_not_of(kDigits, end);
  return {std::string(before == std::string_view::npos ? plain : plain.substr(before + 1)),
          without.has_value()};
}

// Of what a JPEG holds behind its tags; nothing for other files.
std::optional<std::uint64_t> HashOfPicture(const Photo& photo) {
  constexpr std::size_t kStart = 1 << 16;
  if (photo.path.empty()) return std::nullopt;
  const auto source = OpenFileBytes(photo.path);
  if (!source) return std::nullopt;
  const auto segments = ScanJpegSegments(**source);
  if (!segments) return std::nullopt;
  const auto start = (*source)->ReadUpTo(segments->scan_offset, kStart);
  if (start.empty()) return std::nullopt;
  return XXH3_64bits(start.data(), start.size());
}

}  // namespace

void LeaveOutRetagged(std::vector<Photo>& photos, std::vector<LeftOutPhoto>& left_out) {
  using Records = std::tuple<std::string, std::string, std::string, int, int, UtcTime>;
  std::map<Records, std::vector<std::size_t>> alike;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const Photo& photo = photos[i];
    // What exiftool kept of a file is told by its name.
    if (!photo.origin.clock || PictureNameOf(photo.name).is_before_a_change) continue;
    alike[{NamedAs(photo.name).counter, photo.make, photo.model, photo.intrinsics.width_px,
           photo.intrinsics.height_px, *photo.origin.clock}]
        .push_back(i);
  }
  std::map<std::pair<std::size_t, std::uint64_t>, std::vector<std::size_t>> pictures;  // by the first alike
  for (const auto& [records, files] : alike) {
    if (files.size() < 2) continue;
    for (const std::size_t i : files) {
      if (const auto hash = HashOfPicture(photos[i])) pictures[{files.front(), *hash}].push_back(i);
    }
  }
  // The smaller the better; of equals the one named for its new tags, then the first given.
  const auto rank = [&](std::size_t i) {
    const Photo& photo = photos[i];
    const double sigma_m =
        photo.position ? SigmaOfRecordM(*photo.position) : std::numeric_limits<double>::infinity();
    return std::tuple(sigma_m, photo.origin.is_edited, -photo.origin.makers_records,
                      !NamedAs(photo.name).is_named_for_tags, i);
  };
  std::vector<bool> is_out(photos.size(), false);
  for (const auto& [picture, files] : pictures) {
    const std::size_t best = *std::ranges::min_element(files, {}, rank);
    for (const std::size_t i : files) {
      if (i == best) continue;
      is_out[i] = true;
      left_out.push_back(LeftAside(photos[i].name, Aside::kOtherTags, photos[best].name));
    }
  }
  std::size_t k = 0;
  std::erase_if(photos, [&](const Photo&) { return is_out[k++]; });
}

}  // namespace skyquilt::flight
