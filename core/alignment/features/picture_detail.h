// PictureDetail: how much fine detail a picture shows where, and in which direction: what tells a blurred
// photo (core/alignment/features/sharpness.h). Pure; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace skyquilt::alignment {

inline constexpr int kDetailCells = 10;    // a side of the grid over a photo
inline constexpr double kMinDetail = 0.1;  // grey levels squared: of a picture without anything to see

// Energy of second derivatives along (c, s), image right and down, a pixel:
// m0 c^4 + m1 c^3 s + m2 c^2 s^2 + m3 c s^3 + m4 s^4.
using DirectedEnergy = std::array<float, 5>;
double EnergyAlong(const DirectedEnergy& energy, double c, double s);

struct DetailCell {
  DirectedEnergy fine{};
  DirectedEnergy coarse{};  // of the picture at a quarter of its size
  float brightness = 0.0F;  // mean grey level
};

// kDetailCells a row, from the top; empty: the picture is too small to tell.
struct PictureDetail {
  std::vector<DetailCell> cells;
};

// `grey` without padding; finer than about a quarter of a megapixel, noise counts as detail.
PictureDetail MeasureDetail(int width_px, int height_px, const std::uint8_t* grey);

// Of a picture by itself, whatever it shows: fine over coarser detail where the picture has most, in the
// direction that has least. For photos of which nothing else is known.
double SharpnessByItself(const PictureDetail& detail);

}  // namespace skyquilt::alignment
