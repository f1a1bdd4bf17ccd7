#include "core/flight/photos/image_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <utility>

#include "core/base/try.h"
#include "core/flight/aside/aside.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/photos/jpeg_segments.h"
#include "core/flight/photos/png_profile.h"
#include "core/flight/photos/read_photo.h"
#include "core/flight/photos/sample_format.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

constexpr std::uint16_t kXmpTag = 0x02BC;

Error Unsupported(Remark why) { return Because(ErrorCode::kUnsupportedFormat, std::move(why)); }

Error DamagedBy(RemarkCode why, std::string detail = "") {
  return Because(ErrorCode::kCorrupt, why, std::move(detail));
}

bool Has(const std::vector<std::uint8_t>& bytes, std::size_t at, std::string_view text) {
  return bytes.size() >= at + text.size() && std::memcmp(bytes.data() + at, text.data(), text.size()) == 0;
}

// What is packed, by its first bytes; a tar by those of its first header.
struct ArchiveMark {
  std::size_t at;
  std::string_view bytes;
  const char* kind;
};
constexpr std::array<ArchiveMark, 8> kArchiveMarks = {{{0, "PK\x03\x04", "ZIP"},
                                                       {0, "7z\xBC\xAF\x27\x1C", "7-Zip"},
                                                       {0, "Rar!\x1A\x07", "RAR"},
                                                       {0, "\xFD\x37zXZ", "xz"},
                                                       {0, "\x28\xB5\x2F\xFD", "Zstandard"},
                                                       {0, "\x1F\x8B", "gzip"},
                                                       {0, "BZh", "bzip2"},
                                                       {257, "ustar", "tar"}}};

Error NotAPhoto(const std::vector<std::uint8_t>& start) {
  const BoxedPicture boxed = BoxedPictureOf(TextOf(start));
  if (boxed == BoxedPicture::kHeic) return Unsupported(RemarkCode::kHeicPicture);
  if (boxed == BoxedPicture::kAvif) return Unsupported(RemarkCode::kAvifPicture);
  if (Has(start, 4, "ftyp")) return Unsupported(RemarkCode::kIsVideo);
  if (Has(start, 0, "RIFF") && Has(start, 8, "WEBP")) {
    return Unsupported(RemarkCode::kWebpPicture);
  }
  for (const ArchiveMark& mark : kArchiveMarks)
    if (Has(start, mark.at, mark.bytes)) return Unsupported({RemarkCode::kIsArchive, {{"kind", mark.kind}}});
  if (LooksLikeText(TextOf(start))) return Unsupported(RemarkCode::kIsText);
  return Unsupported(RemarkCode::kIsNoPicture);
}

void CollectXmp(ImageHeader& header) {
  for (const ExifIfd ifd : {ExifIfd::kImage, ExifIfd::kExif}) {
    if (const ExifValue* value = header.exif.Find(ifd, kXmpTag)) {
      header.xmp_packets.emplace_back(value->bytes.begin(), value->bytes.end());
    }
  }
}

Result<ImageHeader> ReadJpeg(ByteSource& source) {
  SKYQUILT_TRY_ASSIGN(auto segments, ScanJpegSegments(source));
  if (!HasEndOfImage(source, segments.scan_offset)) {
    return DamagedBy(RemarkCode::kJpegCutOff, "no EOI");
  }
  ImageHeader header;
  header.width_px = segments.width_px;
  header.height_px = segments.height_px;
  header.exif = ReadExifSegment(segments.exif);
  header.xmp_packets = std::move(segments.xmp);
  header.flir = std::move(segments.flir);
  CollectXmp(header);
  return header;
}

// Whether all strips (or tiles) lie within the file. Only what is listed is judged.
bool HoldsItsPixels(const ExifTable& table, std::uint64_t file_size) {
  constexpr std::pair<std::uint16_t, std::uint16_t> kOffsetsAndCounts[] = {{0x0111, 0x0117},
                                                                           {0x0144, 0x0145}};
  for (const auto& [offsets_tag, counts_tag] : kOffsetsAndCounts) {
    const ExifValue* offsets = table.Find(ExifIfd::kImage, offsets_tag);
    const ExifValue* counts = table.Find(ExifIfd::kImage, counts_tag);
    if (offsets == nullptr || counts == nullptr) continue;
    for (std::size_t i = 0; i < std::min(offsets->count, counts->count); ++i) {
      const double end = offsets->Number(i).value_or(0.0) + counts->Number(i).value_or(0.0);
      if (end > static_cast<double>(file_size)) return false;
    }
  }
  return true;
}

Result<ImageHeader> ReadTiff(ByteSource& source) {
  constexpr std::uint16_t kWidth = 0x0100, kHeight = 0x0101;
  SKYQUILT_TRY_ASSIGN(auto table, ReadTiffTags(source));
  if (auto raw = WhyRaw(table, source)) return *std::move(raw);
  if (auto map = WhyMap(table)) return *std::move(map);
  const auto width = table.Number(ExifIfd::kImage, kWidth);
  const auto height = table.Number(ExifIfd::kImage, kHeight);
  if (!width || !height || *width < 1.0 || *height < 1.0) {
    return DamagedBy(RemarkCode::kTiffWithoutSize);
  }
  if (!HoldsItsPixels(table, source.size())) {
    return DamagedBy(RemarkCode::kTiffCutOff);
  }
  SKYQUILT_TRY_ASSIGN(const SampleFormat format, SampleFormatOfTiff(table));
  ImageHeader header;
  header.sample_kind = format.kind;
  header.width_px = static_cast<int>(std::min(*width, 1e9));
  header.height_px = static_cast<int>(std::min(*height, 1e9));
  header.exif = std::move(table);
  CollectXmp(header);
  return header;
}

Result<ImageHeader> ReadPng(ByteSource& source) {
  constexpr int kMaxChunks = 100000;
  constexpr std::uint32_t kMaxExif = 1u << 16, kMaxTextChunk = 1u << 20;
  constexpr std::size_t kMaxPackets = 4;
  ImageHeader header;
  std::uint64_t offset = 8;
  constexpr std::size_t kEnoughForSamples = 26;
  header.sample_kind = SampleKindOfPng(source.ReadUpTo(0, kEnoughForSamples));
  bool has_end = false, has_exif = false;
  std::size_t profiles = 0;
  for (int chunk = 0; chunk < kMaxChunks && !has_end; ++chunk) {
    std::uint8_t head[8];
    if (!source.Read(offset, head)) break;
    const std::uint32_t length = BigEndian32(head);
    const std::string_view type = TextOf({head + 4, 4});
    const std::uint64_t body = offset + 8;
    if (type == "IHDR" && length >= 8) {
      std::uint8_t size[8];
      if (!source.Read(body, size)) break;
      header.width_px = static_cast<int>(std::min<std::uint32_t>(BigEndian32(size), 1000000000));
      header.height_px = static_cast<int>(std::min<std::uint32_t>(BigEndian32(size + 4), 1000000000));
    } else if (type == "eXIf" && length <= kMaxExif && !has_exif) {
      has_exif = true;
      header.exif = ReadExifSegment(source.ReadUpTo(body, length));
    } else if ((type == "zTXt" || type == "tEXt") && length <= kMaxTextChunk) {
      if (profiles < kMaxPackets && IsPngProfile(source.ReadUpTo(body, kPngProfileKeyBytes))) {
        ++profiles;
        const PngProfile profile = ReadPngProfile(source.ReadUpTo(body, length), type == "zTXt");
        if (!profile.exif.empty() && !has_exif) {
          has_exif = true;
          header.exif = ReadExifSegment(profile.exif);
        }
        if (!profile.xmp.empty() && header.xmp_packets.size() < kMaxPackets)
          header.xmp_packets.push_back(profile.xmp);
      }
    } else if (type == "iTXt" && length <= kMaxTextChunk) {
      constexpr std::string_view kKey("XML:com.adobe.xmp\0\0\0\0\0", 22);  // uncompressed, no language
      if (header.xmp_packets.size() >= kMaxPackets || !Has(source.ReadUpTo(body, kKey.size()), 0, kKey)) {
        offset = body + length + 4;
        continue;
      }
      const auto text = source.ReadUpTo(body, length);
      if (text.size() > kKey.size()) header.xmp_packets.emplace_back(text.begin() + kKey.size(), text.end());
    }
    has_end = type == "IEND";
    offset = body + length + 4;
  }
  if (header.width_px < 1 || header.height_px < 1 || !has_end) {
    return DamagedBy(RemarkCode::kPngDamaged);
  }
  CollectXmp(header);
  return header;
}

Result<ImageHeader> ReadByKind(ByteSource& source) {
  if (source.size() == 0) {
    return DamagedBy(RemarkCode::kPhotoEmpty);
  }
  const std::vector<std::uint8_t> start = source.ReadUpTo(0, 512);
  if (start.empty()) return Because(ErrorCode::kIo, RemarkCode::kPhotoUnread);
  if (Has(start, 0, "\xFF\xD8\xFF")) return ReadJpeg(source);
  if (const auto raw = RawFormatOf(start); !raw.empty()) return AsideError(Aside::kRawPicture, raw);
  if (IsTiff(start)) return ReadTiff(source);
  if (Has(start, 0, "\x89PNG\r\n\x1A\n")) return ReadPng(source);
  return NotAPhoto(start);
}

}  // namespace

Result<ImageHeader> ReadImageHeader(ByteSource& source) {
  auto header = ReadByKind(source);
  if (!header) return header;
  const double pixels = static_cast<double>(header->width_px) * header->height_px;
  if (std::max(header->width_px, header->height_px) > kMaxPhotoSidePx || pixels > kMaxPhotoPixels) {
    return Because(ErrorCode::kTooLarge, {RemarkCode::kPictureTooLarge,
                                          {{"width_px", header->width_px},
                                           {"height_px", header->height_px},
                                           {"most_side_px", kMaxPhotoSidePx},
                                           {"most_million_px", kMaxPhotoPixels / 1e6}}});
  }
  constexpr int kSmallestSide = 16;
  if (std::min(header->width_px, header->height_px) < kSmallestSide) {
    return Because(
        ErrorCode::kUnsupportedFormat,
        {RemarkCode::kPictureTooSmall, {{"width_px", header->width_px}, {"height_px", header->height_px}}});
  }
  return header;
}

XmpTags ReadXmp(const ImageHeader& header, ByteSource& source, std::vector<Remark>& notes) {
  XmpTags xmp;
  bool is_broken = false;
  for (const std::string& packet : header.xmp_packets) is_broken |= !xmp.AddPacket(packet);
  if (xmp.empty()) {
    const std::string packet = ScanForXmpPacket(source);
    if (!packet.empty()) is_broken |= !xmp.AddPacket(packet);
  }
  if (is_broken && xmp.empty()) notes.push_back(RemarkCode::kXmpDamaged);
  return xmp;
}

}  // namespace skyquilt::flight
