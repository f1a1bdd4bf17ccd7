#include "core/simulate/world/surface_colors.h"

#include <algorithm>
#include <cmath>

#include "core/simulate/world/random.h"

namespace skyquilt::simulate {
namespace {

using Color = Eigen::Vector3f;

constexpr std::uint32_t kTreeSalt = 0x7f4a7c15u;
constexpr std::uint32_t kHueSalt = 0x1b873593u;
constexpr double kTreeCellM = 9.0;
constexpr double kRoadHalfM = 2.7;
constexpr double kTrackHalfM = 1.1;
constexpr double kStripHalfM = 0.8;
constexpr float kTwoPi = 6.2831853f;

Color Mix(const Color& a, const Color& b, float share_of_b) { return a + share_of_b * (b - a); }

// A smooth wave of this period across, faded to its mean below the footprint; 0..1.
float Stripes(double across_m, double period_m, float footprint_m) {
  const float weight = BandWeight(static_cast<float>(period_m), footprint_m);
  if (weight == 0.0f) return 0.5f;
  const double turns = across_m / period_m;
  const auto phase = static_cast<float>(turns - FloorToInt(turns));
  return 0.5f + 0.5f * weight * std::cos(kTwoPi * phase);
}

// Small things strewn about: tufts, stones, clods. One per cell, a soft disc; signed strength -1..1.
float Strewn(const GroundPoint& p, double cell_m, std::uint32_t salt) {
  const auto radius_m = static_cast<float>(0.3 * cell_m);
  const float weight = BandWeight(2.0f * radius_m, p.footprint_m);
  if (weight == 0.0f) return 0.0f;
  const double x = p.east / cell_m;
  const double y = p.north / cell_m;
  const std::int32_t floor_x = FloorToInt(x);
  const std::int32_t floor_y = FloorToInt(y);
  const std::uint32_t hash = HashCell(floor_x, floor_y, p.seed ^ salt);
  if ((hash & 3u) == 0u) return 0.0f;
  const float r = 0.12f + 0.18f * Uniform(hash, 0);
  const float dx = static_cast<float>(x - floor_x) - (0.3f + 0.4f * Uniform(hash, 1));
  const float dy = static_cast<float>(y - floor_y) - (0.3f + 0.4f * Uniform(hash, 2));
  const float inside = 1.0f - (dx * dx + dy * dy) / (r * r);
  if (inside <= 0.0f) return 0.0f;
  const float strength = 2.0f * Uniform(hash, 3) - 1.0f;
  return weight * strength * std::min(1.0f, 2.5f * inside);
}

// Texture shared by everything on the ground: noise of all octaves from 3 cm to 8 m, about +-1 in all.
// Fine octaves weigh `fine`, coarse ones `coarse`.
float GroundTexture(const GroundPoint& p, float fine, float coarse) {
  // Wavelengths and weights: nearly equal energy an octave, as natural ground has it.
  struct Octave {
    float wavelength_m, weight;
    bool is_fine;
  };
  static constexpr Octave kOctaves[] = {{0.03f, 0.42f, true}, {0.065f, 0.42f, true}, {0.14f, 0.42f, true},
                                        {0.31f, 0.40f, true}, {0.70f, 0.36f, false}, {1.7f, 0.34f, false},
                                        {4.1f, 0.30f, false}, {11.0f, 0.28f, false}};
  float sum = 0.0f;
  std::uint32_t octave = 0;
  for (const Octave& o : kOctaves) {
    sum += (o.is_fine ? fine : coarse) * o.weight *
           BandNoise(p.east, p.north, o.wavelength_m, octave, p.footprint_m, p.seed);
    ++octave;
  }
  return sum;
}

Color CropColor(const GroundPoint& p, const Parcel& parcel, TextureLevel texture) {
  const float turn = kTwoPi * 0.5f * Uniform(parcel.hash, 1);
  const double period_m = 0.55 + 0.6 * Uniform(parcel.hash, 2);
  const double across_m = parcel.u * std::cos(turn) + parcel.v * std::sin(turn);
  const float rows = SmoothStep(0.25f, 0.75f, Stripes(across_m, period_m, p.footprint_m));
  const Color soil(118.0f, 96.0f, 72.0f);
  const float ripeness = Uniform(parcel.hash, 3);
  const Color leaf = Mix(Color(62.0f, 104.0f, 44.0f), Color(168.0f, 158.0f, 84.0f), ripeness * ripeness);
  const bool is_poor = texture == TextureLevel::kRows;
  const float plants = GroundTexture(p, is_poor ? 0.35f : 1.0f, is_poor ? 0.15f : 0.8f);
  Color color = Mix(soil, leaf, std::clamp(rows + 0.35f * plants, 0.0f, 1.0f));
  color += Color(20.0f, 22.0f, 16.0f) * plants;
  if (!is_poor) color += Color(22.0f, 20.0f, 14.0f) * Strewn(p, 0.6, 0x31u);
  return color;
}

// How far within the outline of a pond a point lies, about; negative on land.
double MetresInPond(const GroundPoint& p, const Parcel& parcel) {
  const double du = (parcel.u - parcel.center_u) / (parcel.half_u * 0.72);
  const double dv = (parcel.v - parcel.center_v) / (parcel.half_v * 0.68);
  const double wobble = 0.12 * BandNoise(p.east, p.north, 18.0f, 2, p.footprint_m, p.seed ^ 0x77u);
  return (1.0 - std::sqrt(du * du + dv * dv) + wobble) * 0.7 * std::min(parcel.half_u, parcel.half_v);
}

Color PondColor(const GroundPoint& p, const Parcel& parcel) {
  const double inside = MetresInPond(p, parcel);
  const Color shore =
      Color(150.0f, 136.0f, 106.0f) + Color(26.0f, 24.0f, 20.0f) * GroundTexture(p, 1.0f, 0.8f);
  const Color grass = Color(92.0f, 118.0f, 62.0f) + Color(24.0f, 26.0f, 18.0f) * GroundTexture(p, 1.0f, 1.0f);
  const Color water = Color(48.0f, 74.0f, 82.0f) +
                      Color(3.0f, 4.0f, 4.0f) * BandNoise(p.east, p.north, 9.0f, 3, p.footprint_m, 5u);
  const Color land = Mix(grass, shore, Cover(inside + 1.5, 1.2f + p.footprint_m));
  return Mix(land, water, Cover(inside, 0.3f + p.footprint_m));
}

}  // namespace

bool IsWater(const GroundPoint& p, const Parcel& parcel) {
  return parcel.kind == ParcelKind::kPond && MetresInPond(p, parcel) > 0.0;
}

Color ParcelColor(const GroundPoint& p, const Parcel& parcel, TextureLevel texture) {
  Color color;
  switch (parcel.kind) {
    case ParcelKind::kCrop:
      color = CropColor(p, parcel, texture);
      break;
    case ParcelKind::kMeadow:
      color = Color(96.0f, 122.0f, 64.0f) + Color(30.0f, 34.0f, 22.0f) * GroundTexture(p, 1.0f, 1.0f) +
              Color(34.0f, 26.0f, 12.0f) * Strewn(p, 0.45, 0x51u) +
              Color(18.0f, 24.0f, 10.0f) * Strewn(p, 1.9, 0x52u);
      break;
    case ParcelKind::kPloughed: {
      const float furrow = Stripes(parcel.v, 0.38, p.footprint_m);
      color = Color(104.0f, 82.0f, 62.0f) + Color(30.0f, 26.0f, 22.0f) * GroundTexture(p, 1.1f, 0.9f) +
              Color(20.0f, 17.0f, 14.0f) * (furrow - 0.5f) +
              Color(30.0f, 27.0f, 24.0f) * Strewn(p, 0.35, 0x53u);
      break;
    }
    case ParcelKind::kSand:
      color = Color(202.0f, 186.0f, 152.0f) +
              Color(8.0f, 7.5f, 6.5f) * GroundTexture(p, 0.35f, 0.6f);  // poor on purpose: hard to match
      return color;
    case ParcelKind::kPond:
      color = PondColor(p, parcel);
      break;
    case ParcelKind::kFarmyard:
      color = Color(142.0f, 134.0f, 122.0f) + Color(30.0f, 29.0f, 28.0f) * GroundTexture(p, 1.0f, 0.8f) +
              Color(34.0f, 33.0f, 32.0f) * Strewn(p, 0.5, 0x54u) +
              Color(24.0f, 24.0f, 24.0f) * Strewn(p, 2.3, 0x55u);
      break;
  }
  const float hue = BandNoise(p.east, p.north, 6.5f, 5, p.footprint_m, p.seed ^ kHueSalt);
  return color + Color(6.0f, 2.0f, -5.0f) * hue;
}

Color WithBorders(const GroundPoint& p, const Parcel& parcel, const Color& color) {
  Color out = color;
  const float strip = Cover(kStripHalfM - parcel.to_row_border_m, p.footprint_m);
  if (strip > 0.0f) {
    const Color grass =
        Color(84.0f, 108.0f, 58.0f) + Color(32.0f, 34.0f, 24.0f) * GroundTexture(p, 1.0f, 0.8f);
    out = Mix(out, grass, strip);
  }
  const double half_m = parcel.column_border_is_road ? kRoadHalfM : kTrackHalfM;
  const float road = Cover(half_m - parcel.to_column_border_m, p.footprint_m);
  if (road == 0.0f) return out;
  if (!parcel.column_border_is_road) {
    const Color dirt = Color(164.0f, 146.0f, 116.0f) +
                       Color(26.0f, 24.0f, 22.0f) * GroundTexture(p, 1.0f, 0.8f) +
                       Color(24.0f, 24.0f, 24.0f) * Strewn(p, 0.4, 0x56u);
    return Mix(out, dirt, road);
  }
  Color asphalt = Color(98.0f, 98.0f, 102.0f) + Color(16.0f, 16.0f, 16.0f) * GroundTexture(p, 1.0f, 0.9f) +
                  Color(18.0f, 18.0f, 18.0f) * Strewn(p, 0.9, 0x57u);
  const Color paint(232.0f, 232.0f, 226.0f);
  const double along = parcel.v / 6.0;
  const double in_dash_m = 6.0 * (along - FloorToInt(along)) - 0.6;  // 3 m of paint every 6 m
  const float dash = Cover(std::min(in_dash_m, 3.0 - in_dash_m), p.footprint_m);
  asphalt = Mix(asphalt, paint, 0.92f * dash * Cover(0.07 - parcel.to_column_border_m, p.footprint_m));
  const double from_edge = std::abs(parcel.to_column_border_m - (kRoadHalfM - 0.25));
  asphalt = Mix(asphalt, paint, 0.85f * Cover(0.06 - from_edge, p.footprint_m));
  return Mix(out, asphalt, road);
}

Color WithTrees(const GroundPoint& p, const Parcel& parcel, const Color& color) {
  const double x = parcel.u / kTreeCellM;
  const double y = parcel.v / kTreeCellM;
  const std::int32_t floor_x = FloorToInt(x);
  const std::int32_t floor_y = FloorToInt(y);
  const std::uint32_t hash = HashCell(floor_x, floor_y, p.seed ^ kTreeSalt);
  if (Uniform(hash, 0) > 0.14f) return color;
  const double radius_m = 1.2 + 1.3 * Uniform(hash, 1);
  const double play_m = 0.5 * kTreeCellM - radius_m - 1.2;
  const double du = (x - floor_x - 0.5) * kTreeCellM - play_m * (2.0 * Uniform(hash, 2) - 1.0);
  const double dv = (y - floor_y - 0.5) * kTreeCellM - play_m * (2.0 * Uniform(hash, 3) - 1.0);
  const double ragged = 0.3 * BandNoise(p.east, p.north, 0.9f, 6, p.footprint_m, p.seed ^ kTreeSalt);
  const double shade_m = radius_m - std::hypot(du - 0.7, dv + 0.5);
  Color out = Mix(color, 0.55f * color, 0.9f * Cover(shade_m, 0.25f + p.footprint_m));
  const double from_center = std::hypot(du, dv);
  const float crown = Cover(radius_m + ragged - from_center, 0.08f + p.footprint_m);
  if (crown == 0.0f) return out;
  const float light = 1.0f - 0.35f * static_cast<float>(from_center / radius_m);
  const Color leaves =
      Color(64.0f, 98.0f, 46.0f) * light + Color(34.0f, 38.0f, 24.0f) * GroundTexture(p, 1.2f, 0.9f);
  return Mix(out, leaves, crown);
}

Color RoofColor(const GroundPoint& p, const Building& building) {
  const Eigen::Vector2d at = building.ToAxes({p.east, p.north});
  const float draw = Uniform(building.hash, 8);
  const Color base = draw < 0.4f   ? Color(150.0f, 74.0f, 56.0f)
                     : draw < 0.7f ? Color(112.0f, 114.0f, 120.0f)
                                   : Color(176.0f, 168.0f, 156.0f);
  const float tiles = Stripes(at.y(), 0.33, p.footprint_m) - 0.5f;
  Color color = base + Color(24.0f, 22.0f, 20.0f) * tiles +
                Color(22.0f, 20.0f, 20.0f) * GroundTexture(p, 1.0f, 0.8f) +
                Color(30.0f, 28.0f, 26.0f) * Strewn(p, 1.1, 0x58u);
  color *= 1.0f + 0.12f * (Cover(at.y(), 0.1f + p.footprint_m) - 0.5f);  // two sides of a ridge
  const double to_eave =
      std::min(building.half_size_m.x() - std::abs(at.x()), building.half_size_m.y() - std::abs(at.y()));
  return Mix(color, Color(70.0f, 66.0f, 64.0f), 0.8f * Cover(0.12 - to_eave, p.footprint_m));
}

Color WallColor(double along_m, double up_m, const Building& building, float footprint_m) {
  const Color base =
      Mix(Color(206.0f, 198.0f, 182.0f), Color(158.0f, 120.0f, 96.0f), Uniform(building.hash, 9));
  const float bricks = BandNoise(along_m, up_m, 0.25f, 1, footprint_m, building.hash);
  const double window = along_m / 2.2;
  const double in_window_m = std::abs(2.2 * (window - FloorToInt(window)) - 1.1);
  const float glass = Cover(0.45 - in_window_m, footprint_m) * Cover(0.6 - std::abs(up_m - 1.6), footprint_m);
  return Mix(0.8f * base + Color(14.0f, 13.0f, 12.0f) * bricks, Color(60.0f, 70.0f, 80.0f), glass);
}

namespace {

constexpr double kStoreyM = 2.8;
constexpr double kNoWindowsM = 50.0;  // up a wall: bricks alone
constexpr double kParapetM = 0.3;

// 1 on level ground.
float LightOn(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d to_sun(-0.45, -0.45, 0.77);
  return static_cast<float>(0.55 + 0.45 / to_sun.z() * std::max(0.0, normal.dot(to_sun)));
}

Eigen::Vector3d FromAxes(const Building& outline, double x, double y, double z) {
  const Eigen::Vector2d& axis = outline.axis_in_enu;
  return Eigen::Vector3d(x * axis.x() - y * axis.y(), x * axis.y() + y * axis.x(), z).normalized();
}

Eigen::Vector3f SideColor(const StandingObject& object, const Eigen::Vector2d& at, double up_m,
                          float footprint_m) {
  const Building& outline = object.outline;
  const bool is_long_side =
      outline.half_size_m.y() - std::abs(at.y()) < outline.half_size_m.x() - std::abs(at.x());
  const Eigen::Vector3d normal = is_long_side ? FromAxes(outline, 0.0, std::copysign(1.0, at.y()), 0.0)
                                              : FromAxes(outline, std::copysign(1.0, at.x()), 0.0, 0.0);
  const double along_m = is_long_side ? at.x() : at.y() + 50.0;
  const double in_storey_m =
      object.IsHouse() ? up_m - kStoreyM * std::floor(up_m / kStoreyM) : kNoWindowsM + up_m;
  return LightOn(normal) * WallColor(along_m, in_storey_m, outline, footprint_m);
}

Eigen::Vector3f GravelColor(const GroundPoint& point, const Building& outline, const Eigen::Vector2d& at) {
  Parcel yard;
  yard.kind = ParcelKind::kFarmyard;
  const Eigen::Vector3f gravel = 1.1f * ParcelColor(point, yard, TextureLevel::kRich);
  const double to_edge_m =
      std::min(outline.half_size_m.x() - std::abs(at.x()), outline.half_size_m.y() - std::abs(at.y()));
  const float parapet = 0.8f * Cover(kParapetM - to_edge_m, point.footprint_m);
  return gravel + parapet * (Eigen::Vector3f(214.0f, 210.0f, 202.0f) - gravel);
}

Eigen::Vector3f CrownColor(const StandingObject& tree, const Eigen::Vector3d& point, float footprint_m) {
  // The part that the point lies on.
  const Ellipsoid* part = nullptr;
  double least_off = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  for (const Ellipsoid& other : tree.crown) {
    const Eigen::Array3d half(other.half_width_m, other.half_width_m, other.half_height_m);
    const Eigen::Array3d from = (point - other.center_in_enu).array() / half;
    const double off = std::abs(from.matrix().norm() - 1.0);
    if (part != nullptr && off >= least_off) continue;
    part = &other;
    least_off = off;
    normal = (from / half).matrix().normalized();
  }
  // Noise of the plane, laid through the height aslant in two ways: one alone would be drawn out to streaks.
  const double up_m = point.z() - tree.ground_m;
  const GroundPoint leaf{point.x() + 0.6 * up_m, point.y() - 0.8 * up_m, footprint_m, tree.outline.hash};
  const GroundPoint twig{point.x() - 0.9 * up_m, point.y() - 0.4 * up_m, footprint_m, ~tree.outline.hash};
  const float texture = 0.7f * (GroundTexture(leaf, 1.2f, 0.9f) + GroundTexture(twig, 1.2f, 0.9f));
  const auto share_up = static_cast<float>(up_m / tree.outline.height_m);
  const float light = LightOn(normal) * (0.65f + 0.35f * std::clamp(share_up, 0.0f, 1.0f));
  if (part == &tree.crown.front())
    return light * Eigen::Vector3f(112.0f, 92.0f, 74.0f) + 14.0f * texture * Eigen::Vector3f::Ones();
  const float dry = Uniform(tree.outline.hash, 3);
  const Eigen::Vector3f green =
      Eigen::Vector3f(58.0f, 98.0f, 44.0f) + dry * Eigen::Vector3f(44.0f, 20.0f, 6.0f);
  return light * green + texture * Eigen::Vector3f(34.0f, 38.0f, 24.0f);
}

}  // namespace

Eigen::Vector3f ObjectColor(const StandingObject& object, const Eigen::Vector3d& point_in_enu, bool is_side,
                            float footprint_m) {
  const Eigen::Vector2d at = object.outline.ToAxes(point_in_enu.head<2>());
  const GroundPoint place{point_in_enu.x(), point_in_enu.y(), footprint_m, object.outline.hash};
  Eigen::Vector3f color;
  if (object.kind == ObjectKind::kTree) {
    color = CrownColor(object, point_in_enu, footprint_m);
  } else if (is_side) {
    color = SideColor(object, at, point_in_enu.z() - object.ground_m, footprint_m);
  } else if (object.kind == ObjectKind::kGabledHouse) {
    const double slope = std::copysign(object.fall_per_m, at.y());
    color = LightOn(FromAxes(object.outline, 0.0, slope, 1.0)) * RoofColor(place, object.outline);
  } else {
    color = GravelColor(place, object.outline, at);
  }
  return color.cwiseMax(0.0f).cwiseMin(255.0f);
}

}  // namespace skyquilt::simulate
