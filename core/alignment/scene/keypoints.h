// What a photo can be recognised by: keypoints and their descriptors, a thumbnail, and how much fine detail
// it shows where (told by core/alignment/features). Values; any thread.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace skyquilt::alignment {

inline constexpr int kDescriptorSize = 128;
using Descriptor = std::array<std::uint8_t, kDescriptorSize>;

// Frame `image` of the full-size photo.
struct Keypoint {
  float x_px = 0.0F;
  float y_px = 0.0F;
  float angle_rad = 0.0F;  // from the image's x axis towards its y axis (down)
  float scale_px = 0.0F;   // diameter of the described patch
};

// Grey, rows without padding; covers the whole photo.
struct Thumbnail {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> grey;
};

inline constexpr int kDetailCells = 10;  // a side of the grid over a photo

// Energy of second derivatives along (c, s), image right and down, a pixel:
// m0 c^4 + m1 c^3 s + m2 c^2 s^2 + m3 c s^3 + m4 s^4.
using DirectedEnergy = std::array<float, 5>;

struct DetailCell {
  DirectedEnergy fine{};
  DirectedEnergy coarse{};  // of the picture at a quarter of its size
  float brightness = 0.0F;  // mean grey level
};

// kDetailCells a row, from the top; empty: the picture is too small to tell.
using PictureDetail = std::vector<DetailCell>;

struct PhotoFeatures {
  // Any first n of these are spread over the photo and among the strongest of their place.
  std::vector<Keypoint> keypoints;
  std::vector<Descriptor> descriptors;
  Thumbnail thumbnail;
  double sigma_px = 1.0;  // how well a keypoint is located, in full-size pixels
  PictureDetail detail;
  std::string unreadable;  // why nothing is known of it; empty: it was read
  double decode_s = 0.0;   // wall seconds
  double detect_s = 0.0;
};

// One patch described in two directions or two sizes, which is no rival of itself.
inline bool AreOnePatch(const PhotoFeatures& features, int a, int b) {
  const Keypoint& x = features.keypoints[a];
  const Keypoint& y = features.keypoints[b];
  const float dx = x.x_px - y.x_px, dy = x.y_px - y.y_px, near = 0.5F * std::min(x.scale_px, y.scale_px);
  return dx * dx + dy * dy < near * near;
}

}  // namespace skyquilt::alignment
