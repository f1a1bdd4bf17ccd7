// The cameras of the bands of a flight: where each band's picture of each capture was taken and through which
// lens. Value of RegisterBands, input of RenderBands. Any thread.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/bands/captures.h"
#include "core/flight/remarks/remark.h"
#include "core/render/bands/pixel_field.h"

namespace skyquilt::render {

struct BandCamera {
  alignment::AlignedPhoto photo;  // as placed; its recorded photo is the band's own
  PixelField field;               // what its lens does besides
  bands::Radiometry radiometry;
};

// One capture; cameras by band, nothing where the capture lacks one or its picture is damaged.
struct BandedCapture {
  std::vector<std::optional<BandCamera>> cameras;
};

// How well a band lies on the reference band, over all captures.
struct BandRegistration {
  int pictures = 0;          // that have values
  int measured = 0;          // of those, registered by what they show
  int patches = 0;           // where both show the same, of all that were looked at
  double residual_px = 0.0;  // root of the mean square of what is left, pixels of the band
};

struct BandCameras {
  std::vector<BandedCapture> captures;          // by photo of the references' flight
  std::vector<BandRegistration> registrations;  // by band
  std::vector<flight::Remark> warnings;
};

}  // namespace skyquilt::render
