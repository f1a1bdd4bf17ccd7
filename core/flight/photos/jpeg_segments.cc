#include "core/flight/photos/jpeg_segments.h"

#include <algorithm>
#include <map>
#include <span>
#include <string_view>

#include "core/flight/bytes/log_bytes.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

constexpr int kMaxSegments = 4096;
constexpr std::uint64_t kMaxFillBytes = 1 << 16;  // of the whole file
constexpr std::size_t kMaxExtendedXmp = 1u << 20;
constexpr std::uint64_t kEndIsWithin = std::uint64_t{64}
                                       << 20;  // previews and films may stand behind the picture
constexpr std::string_view kExifHeader("Exif\0", 5);
constexpr std::string_view kFlirHeader("FLIR\0", 5);
constexpr std::size_t kFlirHeadBytes = 8;  // with the part's number and that of the last one
constexpr std::string_view kXmpHeader("http://ns.adobe.com/xap/1.0/\0", 29);
constexpr std::string_view kExtendedXmpHeader("http://ns.adobe.com/xmp/extension/\0", 35);

Error NoFrame(const char* detail) {
  return Because(ErrorCode::kCorrupt, RemarkCode::kJpegWithoutSize, detail);
}

// SOF0..SOF15 without DHT (C4), JPG (C8) and DAC (CC).
bool IsFrameMarker(int marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

// Parts of one extended packet: GUID (32 bytes), full length, offset, then the part.
class ExtendedXmp {
 public:
  void Add(const std::vector<std::uint8_t>& payload) {
    const std::size_t head = kExtendedXmpHeader.size();
    if (payload.size() < head + 40) return;
    const std::string guid(payload.begin() + head, payload.begin() + head + 32);
    const std::uint32_t length = BigEndian32(payload.data() + head + 32);
    const std::uint32_t offset = BigEndian32(payload.data() + head + 36);
    const std::size_t part = payload.size() - head - 40;
    if (length > kMaxExtendedXmp || offset > length || part > length - offset) return;
    if (packets_.size() >= 4 && !packets_.contains(guid)) return;
    std::string& packet = packets_[guid];
    // Grown by what truly came, so that a declared length alone takes no memory.
    if (packet.size() < offset + part) packet.resize(offset + part, ' ');
    std::copy(payload.begin() + head + 40, payload.end(), packet.begin() + offset);
  }
  void AppendTo(std::vector<std::string>& packets) && {
    for (auto& [guid, packet] : packets_) packets.push_back(std::move(packet));
  }

 private:
  std::map<std::string, std::string> packets_;
};

}  // namespace

Result<JpegSegments> ScanJpegSegments(ByteSource& source) {
  JpegSegments found;
  ExtendedXmp extended;
  std::uint64_t fill = 0;
  std::uint64_t offset = 2;  // after SOI, which the caller has seen
  for (int segment = 0; segment < kMaxSegments; ++segment) {
    std::uint8_t head[4];
    if (!source.Read(offset, std::span(head, 2))) break;
    // Stray bytes between segments, and padding.
    while (head[0] != 0xFF || head[1] == 0xFF) {
      if (++fill > kMaxFillBytes || !source.Read(++offset, std::span(head, 2))) return NoFrame("no marker");
    }
    const int marker = head[1];
    if (marker == 0xD9 || marker == 0xDA) break;  // end, or the first scan
    if (marker == 0x00 || marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8)) {
      offset += 2;
      continue;
    }
    if (!source.Read(offset, std::span(head, 4))) break;
    const std::size_t length = (std::size_t{head[2]} << 8) | head[3];
    if (length < 2) break;
    const std::uint64_t payload_offset = offset + 4;
    if (IsFrameMarker(marker) && found.width_px == 0) {
      std::uint8_t frame[6];
      if (length < 8 || !source.Read(payload_offset, frame)) break;
      found.height_px = (frame[1] << 8) | frame[2];
      found.width_px = (frame[3] << 8) | frame[4];
    } else if (marker == 0xE1) {
      std::vector<std::uint8_t> payload(length - 2);
      if (!source.Read(payload_offset, payload)) break;
      const std::string_view text = TextOf(payload);
      if (text.starts_with(kExifHeader) && payload.size() > 6) {
        if (found.exif.empty()) found.exif.assign(payload.begin() + 6, payload.end());
      } else if (text.starts_with(kXmpHeader)) {
        if (found.xmp.size() < 8) found.xmp.emplace_back(payload.begin() + kXmpHeader.size(), payload.end());
      } else if (text.starts_with(kExtendedXmpHeader)) {
        extended.Add(payload);
      } else if (text.starts_with(kFlirHeader) && payload.size() > kFlirHeadBytes) {
        found.flir.push_back({payload_offset + kFlirHeadBytes,
                              static_cast<std::uint32_t>(payload.size() - kFlirHeadBytes), payload[6],
                              payload[7]});
      }
    }
    offset = payload_offset + length - 2;
  }
  found.scan_offset = offset;
  if (found.width_px <= 0 || found.height_px <= 0) return NoFrame("no SOF segment with a size");
  std::move(extended).AppendTo(found.xmp);
  return found;
}

bool HasEndOfImage(ByteSource& source, std::uint64_t scan_offset) {
  constexpr std::uint64_t kBlock = 1 << 16;
  std::uint64_t end = source.size();
  if (end > kEndIsWithin) scan_offset = std::max(scan_offset, end - kEndIsWithin);
  while (end > scan_offset + 1) {
    const std::uint64_t begin = end - std::min(kBlock, end - scan_offset);
    const std::vector<std::uint8_t> block = source.ReadUpTo(begin, static_cast<std::size_t>(end - begin));
    for (std::size_t i = block.size(); i >= 2; --i) {
      if (block[i - 2] == 0xFF && block[i - 1] == 0xD9) return true;
    }
    if (begin == scan_offset) return false;
    end = begin + 1;  // a marker may lie across two blocks
  }
  return false;
}

}  // namespace skyquilt::flight
