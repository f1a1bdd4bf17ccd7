// MeasureBand: where patches of the reference band's picture are found in another band's picture of the same
// capture. Bands differ in brightness, even in its sign, but not in where edges are: patches of gradient
// magnitude are correlated. Pure; any thread. Source: normalised cross-correlation (Lewis 1995) of gradients,
// peak by parabolas.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/image/decoded_image.h"
#include "core/render/bands/band_cameras.h"

namespace skyquilt::render {

// The edges of a picture at some of 1/1, 1/2 and 1/4 of its size. Sixteen bytes a pixel while it is made, six
// later. `from`, `to`: the smallest and the largest denominator.
class BandEdges {
 public:
  BandEdges(const image::SampleImage& picture, int from, int to);
  ~BandEdges();
  BandEdges(BandEdges&&) noexcept;

  struct Levels;
  const Levels& levels() const { return *levels_; }

 private:
  std::unique_ptr<Levels> levels_;
};

// A point on the ground, as the reference saw it, and where the other band shows it.
struct BandSighting {
  Eigen::Vector3d in_reference_cam = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel_in_band = Eigen::Vector2d::Zero();
};

struct BandMeasurement {
  std::vector<BandSighting> sightings;
  int looked_at = 0;
};

struct PatchSearch {
  int denominator;  // 1, 2 or 4: at that part of the pictures' size
  int reach_px;     // so far around the expected place, pixels of that size
  double patches;   // about so many all over the picture
};

// `band`, `field`: how its camera is believed to stand, and through what it looks.
BandMeasurement MeasureBand(const alignment::AlignedPhoto& reference, const BandEdges& reference_edges,
                            const alignment::AlignedPhoto& band, const PixelField& field,
                            const BandEdges& band_edges, const ground::GroundSurface& ground,
                            const PatchSearch& search);

}  // namespace skyquilt::render
