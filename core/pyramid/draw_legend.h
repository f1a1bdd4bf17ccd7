// DrawLegend: a bar of colours with a title over it and values below it, as a picture. On a card of its own,
// white within a grey line, so that it is read on light and on dark. Characters that are not ASCII are drawn
// as question marks; a title that is too long ends in dots. Pure; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/image/rgba_image.h"

namespace skyquilt::pyramid {

struct Legend {
  std::string title;
  std::vector<std::array<std::uint8_t, 3>> colours;  // from the left, evenly; at least one
  std::vector<std::string> marks;                    // below, evenly, the first at the left end
};

// Opaque. Preconditions: sides that leave room for the bar (80 x 56 at least), a colour.
image::RgbaImage DrawLegend(const Legend& legend, int width_px, int height_px);

}  // namespace skyquilt::pyramid
