// ReadBandFacts: the band of one photo from the TIFF and XMP tags of Parrot Sequoia, MicaSense RedEdge and
// Altum, DJI P4 Multispectral and Mavic 3 Multispectral, of any TIFF that names its band (Camera:BandName),
// and of the radiometric JPEGs of FLIR's cameras. Reads headers alone. Bytes may be hostile: bounded as
// ReadPhotoFrom is. Any thread.
#pragma once

#include "core/bands/band_facts.h"
#include "core/base/result.h"
#include "core/flight/bytes/byte_source.h"

namespace skyquilt::bands {

// Errors: kUnsupportedFormat (also where no band is named), kCorrupt, kTooLarge.
Result<BandFacts> ReadBandFacts(flight::ByteSource& source);

}  // namespace skyquilt::bands
