// Whether a photo is blurred: how much fine detail it shows where and in which direction (PictureDetail),
// told by another photo of the same ground, in the same direction over it: whatever lies there (crop rows, a
// road, water) shows as much in both, and only what one of the pictures lost is missing. Motion blurs one
// direction alone, so the one that lost most counts. Pure; any thread.
#pragma once

#include <cstdint>
#include <optional>

#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/view.h"

namespace skyquilt::alignment {

// `grey` without padding; finer than about a quarter of a megapixel, noise counts as detail.
PictureDetail MeasureDetail(int width_px, int height_px, const std::uint8_t* grey);

// Of a picture by itself, whatever it shows: fine over coarser detail where the picture has most, in the
// direction that has least. For photos of which nothing else is known.
double SharpnessByItself(const PictureDetail& detail);

// The share of the other photo's fine detail that `own` shows of the same ground: about 1 for two sharp
// photos. Nothing where they share too little, or look at it from distances too different to compare.
std::optional<double> SharpnessAgainst(const PictureDetail& own, const View& own_view,
                                       const PictureDetail& other, const View& other_view,
                                       const Relief& relief);

}  // namespace skyquilt::alignment
