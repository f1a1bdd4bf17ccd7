// ExposureModel: what makes photos of one flight agree in brightness and colour: a gain per photo and
// channel, and what lens and light do across each photo, in the stored (sRGB) values. A value; any thread.
#pragma once

#include <array>
#include <vector>

#include "core/render/exposure/light_model.h"
#include "core/render/exposure/shade.h"

namespace skyquilt::render {

// What is a photo's own in the light of the flight.
struct PhotoLight {
  std::array<double, 3> gain{1.0, 1.0, 1.0};
  std::array<double, 3> hot_spot{1.0, 1.0, 1.0};  // as a share of the flight's

  bool operator==(const PhotoLight&) const = default;
};

// A pixel of the photo is multiplied by gain and shade.
struct PhotoTone {
  std::array<double, 3> gain{1.0, 1.0, 1.0};
  Shade shade;
};

struct ExposureModel {
  LightModel light;
  std::vector<PhotoLight> photos;  // one per photo of the flight
  std::vector<PhotoTone> tones;    // the same, made by ToneOf

  // Of photos that are shown as they are.
  static ExposureModel Even(std::size_t photos) {
    return {{}, std::vector<PhotoLight>(photos), std::vector<PhotoTone>(photos)};
  }
};

inline PhotoTone ToneOf(const LightModel& light, const PhotoLight& own,
                        const alignment::AlignedPhoto& photo) {
  return {own.gain, ShadeOf(light, photo, own.hot_spot)};
}

}  // namespace skyquilt::render
