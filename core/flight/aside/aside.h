// Aside: why a picture that could be read takes no part in a map, and the words for it; and those that are
// told by content, whatever their names: raw pictures and panoramas. Any thread. Sources: TIFF 6.0 and
// TIFF/EP (ISO 12234-2); Adobe DNG 1.7, ExifTool's table of compressions; Google, Photo Sphere XMP metadata.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/flight/metadata/exif_table.h"
#include "core/flight/metadata/xmp.h"
#include "core/flight/photo.h"

namespace skyquilt::flight {

enum class Aside {
  kSameBytes = 1,       // `of`: the file that has them too
  kPanorama = 2,        // `of`: what shows it
  kRawPicture = 3,      // `of`: its format
  kThumbnailFirst = 4,  // a TIFF that begins with a thumbnail
  kCopy = 5,            // `of`: the original
  kOlderMetadata = 6,   // the file from before its tags were changed; `of`: the one with the new tags
  kOtherCamera = 7,     // `of`: its camera, `instead`: the map's
  kThermal = 8,         // beside visible pictures; `of` and `instead` as above
  kVisible = 9,         // beside more thermal pictures; the same
  kOtherTags = 10,      // `of`: the file of the same picture whose tags are used
  kMap = 11,            // a GeoTIFF that no camera wrote
};

// The reason as an error of reading it, and as an entry of a flight's list.
Error AsideError(Aside why, std::string_view of, std::string_view instead = "");
LeftOutPhoto LeftAside(const std::string& name, Aside why, std::string_view of,
                       std::string_view instead = "");

// Of a copy of a picture that is used, one that another camera took beside those used, or what shows no
// ground of its own: no gap in the map comes of it.
bool LeavesNoGap(const LeftOutPhoto& photo);

// "DJI M3T, wide, 4000 x 3000 px"
std::string CameraInWords(const Photo& photo, Lens lens);

// What is left out, a line a photo; of more than three with one reason the first is named, and how many more.
// At most 20, then how many pictures remain.
std::vector<std::string> LeftOutInLines(const std::vector<LeftOutPhoto>& left_out);
// The same as one remark: three of them, and how many more.
Remark FirstLeftOut(const std::vector<LeftOutPhoto>& left_out);

// The format of a raw picture whose file begins so (16 bytes are enough): "RAF", "CR3"; empty for all else.
std::string_view RawFormatOf(std::span<const std::uint8_t> head);

// Which picture of the containers of films (ISO/IEC 14496-12, 23008-12) begins so, by the brands of its first
// box, as many as `head` has; sequences of pictures count as such.
enum class BoxedPicture { kNone, kHeic, kAvif };
BoxedPicture BoxedPictureOf(std::string_view head);

// Why a TIFF, of which `first` are the tags, holds no picture as others hold it; nothing for a photo. Looks
// at 16 directories, and only of a TIFF whose first is a thumbnail or has others below it.
std::optional<Error> WhyRaw(const ExifTable& first, ByteSource& source);

// Why a TIFF of these tags is a map, of this program or of others, and no photo.
std::optional<Error> WhyMap(const ExifTable& tags);

std::optional<Error> WhyPanorama(int width_px, int height_px, const XmpTags& xmp);

}  // namespace skyquilt::flight
