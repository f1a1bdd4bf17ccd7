// BandFacts: what one photo of a camera of several bands says of its band and of the capture it belongs to. A
// value; any thread.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "core/bands/radiometry.h"

namespace skyquilt::bands {

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
  bool is_look_too = false;        // the file's picture is one in colours, with the band's levels beside it
  bool is_panel = false;           // a picture of the calibration panel, not of the ground
  PanelTags panel;
  Radiometry radiometry;
};

}  // namespace skyquilt::bands
