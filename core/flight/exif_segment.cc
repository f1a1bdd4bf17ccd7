// The EXIF segment of a JPEG through libexif, and libexif's names of tags.
#include <fmt/format.h>
#include <libexif/exif-data.h>
#include <libexif/exif-tag.h>

#include <algorithm>
#include <memory>
#include <new>

#include "core/flight/exif_table.h"

namespace skyquilt::flight {
namespace {

struct ExifDataDeleter {
  void operator()(ExifData* data) const { exif_data_unref(data); }
};

void CopyDirectory(ExifData& data, ExifIfd ifd, ExifContent* content, ExifTable& table) {
  if (content == nullptr) return;
  const bool is_big_endian = exif_data_get_byte_order(&data) == EXIF_BYTE_ORDER_MOTOROLA;
  for (unsigned i = 0; i < content->count; ++i) {
    const ExifEntry* entry = content->entries[i];
    if (entry == nullptr || entry->data == nullptr) continue;
    const auto tag = static_cast<std::uint16_t>(entry->tag);
    if (table.Find(ifd, tag) != nullptr) continue;  // the first of a doubled tag counts
    ExifValue value;
    value.type = static_cast<std::uint16_t>(entry->format);
    value.is_big_endian = is_big_endian;
    value.count = static_cast<std::uint32_t>(std::min<unsigned long>(entry->components, entry->size));
    value.bytes.assign(entry->data, entry->data + entry->size);
    table.Set(ifd, tag, std::move(value));
  }
}

}  // namespace

ExifTable ReadExifSegment(std::span<const std::uint8_t> tiff_block) {
  constexpr std::size_t kMaxSegment = 1 << 16;
  ExifTable table;
  if (tiff_block.size() < 8 || tiff_block.size() > kMaxSegment) return table;
  std::vector<std::uint8_t> segment{'E', 'x', 'i', 'f', 0, 0};
  segment.insert(segment.end(), tiff_block.begin(), tiff_block.end());
  const std::unique_ptr<ExifData, ExifDataDeleter> exif(exif_data_new());
  if (!exif) throw std::bad_alloc();
  // What the file says, as it says it: nothing added, nothing dropped, nothing "fixed".
  exif_data_unset_option(exif.get(), EXIF_DATA_OPTION_IGNORE_UNKNOWN_TAGS);
  exif_data_unset_option(exif.get(), EXIF_DATA_OPTION_FOLLOW_SPECIFICATION);
  exif_data_load_data(exif.get(), segment.data(), static_cast<unsigned>(segment.size()));
  CopyDirectory(*exif, ExifIfd::kImage, exif->ifd[EXIF_IFD_0], table);
  CopyDirectory(*exif, ExifIfd::kExif, exif->ifd[EXIF_IFD_EXIF], table);
  CopyDirectory(*exif, ExifIfd::kGps, exif->ifd[EXIF_IFD_GPS], table);
  return table;
}

std::string ExifTagName(ExifIfd ifd, std::uint16_t tag) {
  const ::ExifIfd directory =
      ifd == ExifIfd::kGps ? EXIF_IFD_GPS : (ifd == ExifIfd::kExif ? EXIF_IFD_EXIF : EXIF_IFD_0);
  const char* name = exif_tag_get_name_in_ifd(static_cast<ExifTag>(tag), directory);
  return name ? std::string(name) : fmt::format("0x{:04X}", tag);
}

}  // namespace skyquilt::flight
