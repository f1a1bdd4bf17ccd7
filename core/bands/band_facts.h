// BandFacts: what one photo of a camera of several bands says of its band and of the capture it belongs to,
// from the TIFF and XMP tags of Parrot Sequoia, MicaSense RedEdge and Altum, DJI P4 Multispectral and Mavic 3
// Multispectral, Sentera 6X, of any TIFF that names its band (Camera:BandName), and of the radiometric JPEGs
// of FLIR's cameras. Bytes may be hostile: bounded as ReadPhotoFrom is. Any thread.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "core/bands/radiometry.h"
#include "core/base/result.h"
#include "core/flight/bytes/byte_source.h"

namespace skyquilt::bands {

inline constexpr const char* kThermalBand = "lwir";

// A band's name as makers write it, brought to one spelling: blue, green, red, rededge, nir, panchro, lwir;
// any other in lower case, letters and digits alone. Empty for a name without those.
std::string BandNameOf(std::string_view written);

// Lower is better to align by: bands in which soil, plants and roofs differ most, and lenses are sharp.
int AlignRank(std::string_view band_name);

// What a camera that found a calibration panel in its picture wrote down of it (MicaSense).
struct PanelTags {
  std::optional<std::array<double, 8>> area_px;  // x, y of four corners
  std::optional<double> reflectance;
  std::string serial;
};

struct BandFacts {
  std::string name;  // as BandNameOf has it
  std::optional<double> wavelength_nm;
  std::optional<double> width_nm;  // full width at half maximum
  std::string capture_id;          // all bands of one capture share it; empty where none is written
  std::string rig;                 // what the maker calls the cameras together; empty where it does not
  bool is_look_too = false;        // the file's picture is one in colours, with the band's levels beside it
  bool is_panel = false;           // a picture of the calibration panel, not of the ground
  PanelTags panel;
  Radiometry radiometry;
};

// Reads headers alone. Errors: kUnsupportedFormat (also where no band is named), kCorrupt, kTooLarge.
Result<BandFacts> ReadBandFacts(flight::ByteSource& source);

}  // namespace skyquilt::bands
