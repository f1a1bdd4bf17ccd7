// LightModel: what makes one and the same ground brighter or darker by where in a photo it lies (lens,
// sensor, the aircraft's own shade: fixed to the camera) and by the direction from which it is seen (the sun:
// fixed to the ground; surfaces look brighter with the sun behind the camera). Logarithms of stored (sRGB)
// values, smooth functions of few numbers for the whole flight. A value; any thread. Sources: radial
// vignetting of Goldman (2010) with low terms beside it; for the direction the even and odd powers that
// Walthall and others (1985) give reflectance over view and sun zenith, with the sun standing still during a
// flight, and one hot spot opposite the sun, round as in Maignan, Breon and Lacaze (2004), its profile as the
// photos have it (kSpotReaches).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>

#include "core/alignment/scene/aligned_flight.h"
#include "core/render/exposure/shade.h"

namespace skyquilt::render {

constexpr std::size_t kCameraTerms = 11;
constexpr std::size_t kSmoothDirectionTerms = 14;
constexpr std::size_t kDirectionTerms = kSmoothDirectionTerms + kSpotTerms;
using CameraTerms = std::array<double, kCameraTerms>;
using DirectionTerms = std::array<double, kDirectionTerms>;

// `place`: in the image, as Shade has it. r^2, r^4, r^6 and what is not round.
CameraTerms CameraBasis(const Eigen::Vector2d& place);

// A `look` is the horizontal offset of the ground from the camera (east, north) by its depth below; one
// beyond widest_look counts as one that far out.
struct Directions {
  std::optional<Eigen::Vector2d> hot_spot;  // where ground looks brightest: the sun stands behind the camera
  double widest_look = 0.0;

  DirectionTerms Basis(const Eigen::Vector2d& look) const;
  bool operator==(const Directions&) const = default;
};

struct LightModel {
  std::map<std::string, std::array<CameraTerms, 3>> cameras;  // by camera_key, then channel
  Directions directions;
  std::array<DirectionTerms, 3> of_directions{};  // by channel
  bool operator==(const LightModel&) const = default;
};

// Of a ray from the camera to the ground, in enu; one that does not point down is as flat as can be.
Eigen::Vector2d LookOf(const Eigen::Vector3d& ray_in_enu);

// What evens a photo, whose hot spot is `spot_share` of the flight's, by channel. An even one for a camera
// that the model does not know and light from everywhere.
Shade ShadeOf(const LightModel& light, const alignment::AlignedPhoto& photo,
              const std::array<double, 3>& spot_share);

}  // namespace skyquilt::render
