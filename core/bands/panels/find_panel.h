// FindPanel: a MicaSense calibration panel in a picture, by the code (QR) beside its grey square. The square
// stands one and a half sides of the code away from it, in one of four directions; the evenest is taken. A
// picture without a panel, or with one that is cut off or unsharp, has none. Pure; any thread; some 50 ms for
// a picture of 1 MP. Never fails.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "core/bands/panels/panel_code.h"
#include "core/image/decoded_image.h"

namespace skyquilt::bands {

// A four-sided area of a picture, its corners one after the other, in pixels.
using PanelArea = std::array<Eigen::Vector2d, 4>;

struct FoundPanel {
  PanelCode code;
  PanelArea area_px{};
};

std::optional<FoundPanel> FindPanel(const image::SampleImage& picture);

// The levels within an area: their median, how far the middle half spreads around it (a share of it), and the
// share of them that the sensor clipped. Nothing where the area does not lie within the picture or holds less
// than some 20 pixels.
struct AreaLevels {
  double median = 0.0;
  double spread = 0.0;
  double clipped_share = 0.0;
};
std::optional<AreaLevels> LevelsIn(const image::SampleImage& picture, const PanelArea& area_px);

// The same of values.
std::optional<double> MedianIn(const image::FloatImage& values, const PanelArea& area_px);

}  // namespace skyquilt::bands
