// ScanJpegSegments: walks the marker segments of a JPEG up to its first scan and keeps what a header reader
// needs: the size, the EXIF block and the XMP packets. Never decodes pixels. Bounded: at most 4096 segments,
// 16 MiB of extended XMP. Any thread. Source: ITU-T T.81 annex B; Adobe XMP specification part 3,
// section 1.1.3.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/metadata/flir_record.h"

namespace skyquilt::flight {

struct JpegSegments {
  int width_px = 0;
  int height_px = 0;
  std::uint64_t scan_offset = 0;  // of the first scan (SOS) or of what stands in its place
  std::vector<std::uint8_t>
      exif;                      // the TIFF block of the EXIF segment, without its "Exif\0\0"; empty if none
  std::vector<std::string> xmp;  // packets in the order found; the joined extended packet last
  std::vector<FlirPart> flir;    // of a thermal camera's own record
};

// Errors: kCorrupt when there is no readable frame header.
Result<JpegSegments> ScanJpegSegments(ByteSource& source);

// Whether an end marker (EOI) follows the first scan. Coded pixels never contain one, so that without it the
// file was cut off; bytes behind it (previews, padding) do no harm. Reads backwards, quickly.
bool HasEndOfImage(ByteSource& source, std::uint64_t scan_offset);

}  // namespace skyquilt::flight
