// What a photo looks like as a whole, as one short vector, so that photos of the same place are found without
// comparing them: aggregated descriptors (VLAD: H. Jegou and others, CVPR 2010, with the normalisation of R.
// Arandjelovic and A. Zisserman, CVPR 2013) over a vocabulary learnt from the flight itself. Memory: 8 KB a
// photo. Pure; the same for any number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "core/alignment/scene/keypoints.h"

namespace skyquilt::alignment {

class Appearance {
 public:
  // Of each photo; null: it looks like nothing.
  static Appearance Learn(const std::vector<const PhotoFeatures*>& features, int threads);

  // The photos most like each one (by the cosine), the likest first; none of and for those that look like
  // nothing.
  std::vector<std::vector<int>> MostAlike(int most, int threads) const;

 private:
  std::vector<std::vector<std::int8_t>> vectors_;
  std::vector<double> lengths_;
};

}  // namespace skyquilt::alignment
