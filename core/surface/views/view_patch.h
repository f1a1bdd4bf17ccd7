// ViewPatch: what one photo shows of the cells of a tile, laid at a pile of heights over a surface (a plane
// sweep over that surface). Where the photo sees a place is computed exactly every 16 cells at three heights,
// lens and rolling shutter included; along a vertical line pixels are nearly linear in the inverse of the
// depth, so that a square in that follows them to hundredths of a pixel, and between the places all is
// bilinear. Within the pile a square in the height follows them (a line would
// put heights too low by a few tenths of a step). Frames enu, image (photo) and the pixels of a
// smaller picture of it. One thread at a time; the same bytes on any processor.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/surface/views/gray_photos.h"
#include "core/surface/views/surface_camera.h"

namespace skyquilt::surface {

// The cells of a tile with a margin of kCensusRadius around them, row by row from the south-west.
struct TileFrame {
  Eigen::Vector2d first_in_enu;  // centre of its first cell
  double cell_m = 1.0;
  int columns = 0, rows = 0;

  std::size_t Count() const { return static_cast<std::size_t>(columns) * rows; }
};

class ViewPatch {
 public:
  // low_m: by cell of the frame, z of the lowest height in enu; the highest is span_m above it and the
  // heights between are evenly spaced. False where the photo sees none of it. The pyramid has to outlive what
  // is sampled.
  bool Prepare(const SurfaceCamera& camera, const GrayPyramid& pyramid, const TileFrame& frame,
               const std::vector<float>& low_m, double span_m, int heights);
  // The gray of each cell of the frame at a height, bilinear.
  void Sample(int height, std::uint8_t* patch);
  // By cell inside the margin, as CensusShape numbers them: 255 where the photo does not see it at all
  // heights, and where a number stands for no cell.
  const std::vector<std::uint8_t>& Unseen() const { return unseen_; }

 private:
  // Fills unseen_; false where nothing is seen.
  bool MarkSeen();

  TileFrame frame_;
  int heights_ = 1;
  // By cell of the frame: the pixel at the lowest height, and with n steps up n * (step + n * bend) more.
  // Of one height there are no steps.
  std::vector<float> x_, y_, step_x_, step_y_, bend_x_, bend_y_;
  std::vector<float> high_;  // of a row at its highest
  std::vector<std::uint8_t> unseen_;
  const GrayPicture* picture_ = nullptr;
};

}  // namespace skyquilt::surface
