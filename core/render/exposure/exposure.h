// ExposureModel: what makes photos of one flight agree in brightness and colour: a gain per photo and channel
// and one even radial vignetting curve per camera, in the stored (sRGB) values. A value; any thread.
#pragma once

#include <array>
#include <vector>

namespace skyquilt::render {

// A pixel at relative radius r (1 at the image corner) is divided by 1 + a[0] r^2 + a[1] r^4 + a[2] r^6.
struct Vignetting {
  std::array<double, 3> a{};
  double Falloff(double radius_squared) const {
    return 1.0 + radius_squared * (a[0] + radius_squared * (a[1] + radius_squared * a[2]));
  }
};

struct PhotoTone {
  std::array<double, 3> gain{1.0, 1.0, 1.0};
  Vignetting vignetting;
};

struct ExposureModel {
  std::vector<PhotoTone> photos;  // one per photo of the flight
};

}  // namespace skyquilt::render
