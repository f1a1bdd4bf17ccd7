// PictureSheet: pictures side by side with a caption over each, on white, as one picture. For people; the
// captions are ASCII. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/image/rgba_image.h"

namespace skyquilt::pyramid {

struct SheetPicture {
  std::string caption;
  image::RgbaImage image;
};

// Row by row, `columns` a row; every cell is as large as the largest picture.
image::RgbaImage PictureSheet(const std::vector<SheetPicture>& pictures, int columns);

}  // namespace skyquilt::pyramid
