// The EXIF segment of a JPEG, read as the small TIFF file that it is, and libexif's names of tags. libexif's
// own reader is not used on what others made: it copies the values of each entry, however many entries share
// them, which makes gigabytes of 64 KiB, and looks into the notes of every maker.
#include <fmt/format.h>
#include <libexif/exif-tag.h>

#include "core/flight/metadata/exif_table.h"

namespace skyquilt::flight {

ExifTable ReadExifSegment(std::span<const std::uint8_t> tiff_block) {
  constexpr std::size_t kMaxSegment = 1 << 16;
  if (tiff_block.size() < 8 || tiff_block.size() > kMaxSegment) return {};
  MemoryBytes source(tiff_block);
  Result<ExifTable> table = ReadTiffTags(source);
  return table ? *std::move(table) : ExifTable();
}

std::string ExifTagName(ExifIfd ifd, std::uint16_t tag) {
  const ::ExifIfd directory =
      ifd == ExifIfd::kGps ? EXIF_IFD_GPS : (ifd == ExifIfd::kExif ? EXIF_IFD_EXIF : EXIF_IFD_0);
  const char* name = exif_tag_get_name_in_ifd(static_cast<ExifTag>(tag), directory);
  return name ? std::string(name) : fmt::format("0x{:04X}", tag);
}

}  // namespace skyquilt::flight
