// PictureDetail: how much fine detail a picture shows where, and in which direction: what tells a blurred
// photo (core/alignment/features/sharpness.h). Pure; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/alignment/scene/keypoints.h"

namespace skyquilt::alignment {

inline constexpr double kMinDetail = 0.1;  // grey levels squared: of a picture without anything to see

double EnergyAlong(const DirectedEnergy& energy, double c, double s);

// `grey` without padding; finer than about a quarter of a megapixel, noise counts as detail.
PictureDetail MeasureDetail(int width_px, int height_px, const std::uint8_t* grey);

// Of a picture by itself, whatever it shows: fine over coarser detail where the picture has most, in the
// direction that has least. For photos of which nothing else is known.
double SharpnessByItself(const PictureDetail& detail);

}  // namespace skyquilt::alignment
