// ExposureModel: what makes photos of one flight agree in brightness and colour: a gain per photo and
// channel, and what lens and light do across each photo (LightModel; as a Shade where pixels are multiplied),
// in the stored (sRGB) values. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/camera/intrinsics.h"

namespace skyquilt::render {

constexpr int kShadeDegree = 6;
constexpr std::size_t kShadeTerms = (kShadeDegree + 1) * (kShadeDegree + 2) / 2;

// 1, x, y, x^2, xy, y^2, ...
std::array<double, kShadeTerms> ShadePowers(double x, double y);

// A hot spot is a sum of round hills, so that it may be as sharp and as wide as the overlaps show. How far
// each reaches from the middle, as a tangent of direction; the widest first.
inline constexpr std::array kSpotReaches{0.32, 0.16, 0.08};
inline constexpr std::size_t kSpotTerms = kSpotReaches.size();

// 1 in the middle, 0 with level slope at `reach` and beyond.
template <typename T>
T SpotHill(T distance_squared, T reach) {
  const T left = std::max(T(0), T(1) - distance_squared / (reach * reach));
  return left * left;
}

// What a photo's pixels are multiplied with, by where they lie in it: for each channel a polynomial in the
// place, and a hot spot where the sun stood behind the camera. Places are (x, y) from the middle of the lens,
// 1 at the distance of half the image's diagonal.
struct Shade {
  // By channel: what is added to 1; by term of ShadePowers.
  std::array<std::array<float, kShadeTerms>, 3> terms{};
  std::array<float, 2> spot_place{};
  std::array<float, 4> look_by_place{};  // row by row: how the direction changes with the place, at the spot
  std::array<std::array<float, kSpotTerms>, 3> spot_log_gains{};  // by channel; of each hill's middle

  bool IsEven() const;  // 1 everywhere
  bool HasSpot() const;
  std::array<double, 3> At(double x, double y) const;
};

// A shade at the nodes of a grid, for whoever asks at many places.
class ShadeGrid {
 public:
  ShadeGrid(const Shade& shade, const camera::Intrinsics& lens);

  // At a pixel; beyond the image as at its edge. Bilinear: within 0.3 % of the polynomial.
  std::array<float, 3> At(float x_px, float y_px) const;

 private:
  static constexpr int kColumns = 25, kRows = 19;

  float columns_per_px_, rows_per_px_;
  float spot_x_px_, spot_y_px_;
  std::array<float, 4> look_by_px_{};
  std::array<std::array<float, kSpotTerms>, 3> spot_log_gains_;
  bool has_spot_;
  std::vector<std::array<float, 3>> nodes_;  // row by row; empty where the shade is even
};

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

// What makes one and the same ground brighter or darker by where in a photo it lies (lens, sensor, the
// aircraft's own shade: fixed to the camera) and by the direction from which it is seen (the sun: fixed to
// the ground; surfaces look brighter with the sun behind the camera). Logarithms of stored (sRGB) values,
// smooth functions of few numbers for the whole flight. Sources: radial vignetting of Goldman (2010) with low
// terms beside it; for the direction the even and odd powers that Walthall and others (1985) give reflectance
// over view and sun zenith, with the sun standing still during a flight, and one hot spot opposite the sun,
// round as in Maignan, Breon and Lacaze (2004), its profile as the photos have it (kSpotReaches).
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
