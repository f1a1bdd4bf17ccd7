// ReadImageHeader: which kind of picture the bytes are, its size, and its EXIF and XMP as found. JPEG, TIFF,
// PNG. Bounded, never decodes pixels. Any thread. Sources: ITU-T T.81, TIFF 6.0, PNG 3rd edition.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/metadata/exif_table.h"
#include "core/flight/metadata/flir_record.h"
#include "core/flight/metadata/xmp.h"
#include "core/flight/photo.h"

namespace skyquilt::flight {

struct ImageHeader {
  int width_px = 0;
  int height_px = 0;
  ExifTable exif;
  SampleKind sample_kind = SampleKind::kBytes;
  std::vector<std::string> xmp_packets;
  std::vector<FlirPart> flir;  // of a JPEG with a thermal camera's levels in it
};

// The XMP of a header, or of wherever else in the source it stands; what is damaged is said in `notes`.
XmpTags ReadXmp(const ImageHeader& header, ByteSource& source, std::vector<Remark>& notes);

// Errors: kUnsupportedFormat (says what it is, where known), kCorrupt, kTooLarge.
Result<ImageHeader> ReadImageHeader(ByteSource& source);

}  // namespace skyquilt::flight
