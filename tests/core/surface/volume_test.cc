// Volumes above and below a base, against boxes and slopes that are known.
#include "core/surface/terrain/volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace skyquilt::surface {
namespace {

constexpr int kFieldSide = 60;
constexpr double kFieldCellM = 0.5;

// A square of heights, all of it within but for a rim of five cells, whose outline is the edge.
struct Field {
  std::vector<float> heights_m;
  std::vector<std::uint8_t> is_measured, is_inside;
  std::vector<EdgeHeight> edge;

  explicit Field(const std::function<double(double, double)>& height_at) {
    for (int row = 0; row < kFieldSide; ++row) {
      for (int column = 0; column < kFieldSide; ++column) {
        heights_m.push_back(static_cast<float>(height_at(column + 0.5, row + 0.5)));
        is_measured.push_back(1);
        is_inside.push_back(column >= 5 && column < 55 && row >= 5 && row < 55 ? 1 : 0);
      }
    }
    for (int i = 0; i < 50; ++i) {
      for (const Eigen::Vector2d& place : {Eigen::Vector2d(5 + i, 5), Eigen::Vector2d(55, 5 + i),
                                           Eigen::Vector2d(55 - i, 55), Eigen::Vector2d(5, 55 - i)})
        edge.push_back({place, height_at(place.x(), place.y())});
    }
  }
  std::optional<AreaVolume> Over(VolumeBase base, double given_m = 0.0) const {
    return VolumeOver({kFieldSide, kFieldSide, kFieldCellM, heights_m, is_measured, is_inside}, edge, base,
                      given_m);
  }
};

bool IsInBox(double x, double y) { return x > 20 && x < 40 && y > 20 && y < 40; }

TEST(VolumeTest, OfABoxOnASlopeIsThatOfTheBox) {
  const Field field(
      [](double x, double y) { return 100.0 + 0.02 * x - 0.01 * y + (IsInBox(x, y) ? 3.0 : 0.0); });
  const AreaVolume volume = *field.Over(VolumeBase::kPlane);
  EXPECT_NEAR(volume.cut_m3, 10.0 * 10.0 * 3.0, 0.01);
  EXPECT_NEAR(volume.fill_m3, 0.0, 0.01);
  EXPECT_NEAR(volume.area_m2, 25.0 * 25.0, 1e-9);
  EXPECT_NEAR(volume.base_m, 100.0 + 0.02 * 30 - 0.01 * 30, 1e-6);
  EXPECT_EQ(volume.measured_share, 1.0);
  // Its walls may stand half a cell further out or in: 40 m of them, 3 m high.
  EXPECT_NEAR(*volume.net_sigma_m3, 0.25 * 40.0 * 3.0, 8.0);
}

TEST(VolumeTest, AboveTheLowestOfTheEdgeAndAGivenHeight) {
  const Field field([](double x, double y) { return IsInBox(x, y) ? 98.0 : 100.0 + 0.1 * (x - 5.0); });
  const AreaVolume lowest = *field.Over(VolumeBase::kLowest);
  EXPECT_NEAR(lowest.base_m, 100.0, 1e-6);
  EXPECT_NEAR(lowest.fill_m3, 10.0 * 10.0 * 2.0, 0.01);
  EXPECT_GT(lowest.cut_m3, 1000.0);
  const AreaVolume given = *field.Over(VolumeBase::kGiven, 98.0);
  EXPECT_NEAR(given.fill_m3, 0.0, 1e-6);
  EXPECT_NEAR(given.lowest_m, 98.0, 1e-6);
  EXPECT_TRUE(lowest.net_sigma_m3);
  EXPECT_FALSE(given.net_sigma_m3) << "the height may count from another zero than the map's";
}

TEST(VolumeTest, WhatIsUnknownIsNotCountedAndWhatIsFilledIsDoubted) {
  Field field([](double x, double y) { return IsInBox(x, y) ? 102.0 : 100.0; });
  const AreaVolume whole = *field.Over(VolumeBase::kPlane);
  Field a_little = field;
  for (std::size_t i = 0; i < field.heights_m.size(); ++i) {
    const double x = static_cast<double>(i % kFieldSide) + 0.5;
    if (x > 30) field.is_measured[i] = 0;
    if (x > 48) a_little.is_measured[i] = 0;
    if (x < 10) field.heights_m[i] = std::numeric_limits<float>::quiet_NaN();
  }
  const AreaVolume part = *field.Over(VolumeBase::kPlane);
  EXPECT_NEAR(part.area_m2, whole.area_m2 * 45.0 / 50.0, 1e-6);
  EXPECT_NEAR(part.measured_share, 20.0 / 45.0, 0.023);
  EXPECT_NEAR(part.cut_m3, whole.cut_m3, 0.01);
  EXPECT_GT(*a_little.Over(VolumeBase::kPlane)->net_sigma_m3, 1.001 * *whole.net_sigma_m3);
  EXPECT_FALSE(part.net_sigma_m3) << "less than half of it was measured";
}

TEST(VolumeTest, ARoughEdgeMakesTheBaseUnsure) {
  const auto rough = [](double x, double y) { return 100.0 + 0.3 * std::sin(1.7 * x) * std::cos(2.3 * y); };
  const Field even([](double, double) { return 100.0; }), uneven(rough);
  EXPECT_LT(even.Over(VolumeBase::kLowest)->net_sigma_m3.value(), 1e-6);
  EXPECT_GT(uneven.Over(VolumeBase::kLowest)->net_sigma_m3.value(), 10.0);
}

TEST(VolumeTest, SinceAnEarlierFlightIsWhatWasBroughtAndTaken) {
  const Field before([](double x, double) { return 50.0 + 0.1 * x; });
  const Field after(
      [](double x, double y) { return 50.0 + 0.1 * x + (IsInBox(x, y) ? (x < 30 ? 2.0 : -1.0) : 0.0); });
  const AreaHeights now{kFieldSide,      kFieldSide,        kFieldCellM,
                        after.heights_m, after.is_measured, after.is_inside};
  const AreaVolume volume = *VolumeSince(now, {before.heights_m, before.is_measured, 0.02});
  EXPECT_NEAR(volume.cut_m3, 5.0 * 10.0 * 2.0, 0.01);
  EXPECT_NEAR(volume.fill_m3, 5.0 * 10.0 * 1.0, 0.01);
  EXPECT_NEAR(volume.area_m2, 25.0 * 25.0, 1e-9);
  // The flights' level against each other is a part of it.
  EXPECT_GT(*volume.net_sigma_m3, 0.02 * volume.area_m2);
  EXPECT_FALSE(VolumeSince(now, {before.heights_m, before.is_measured, std::nullopt})->net_sigma_m3);
  std::vector<std::uint8_t> few(before.is_measured.size(), 0);
  EXPECT_EQ(VolumeSince(now, {before.heights_m, few, 0.02})->measured_share, 0.0);
  const std::vector<float> unknown(before.heights_m.size(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(VolumeSince(now, {unknown, before.is_measured, 0.02}));
}

TEST(VolumeTest, StepsOfAnEarlierFlightStandAsideByItsOwnCells) {
  const Field field([](double x, double y) { return IsInBox(x, y) ? 53.0 : 50.0; });
  const AreaHeights now{kFieldSide,      kFieldSide,        kFieldCellM,
                        field.heights_m, field.is_measured, field.is_inside};
  const auto sigma_m3 = [&](double own_cell_m) {
    return *VolumeSince(now, {field.heights_m, field.is_measured, 0.0, own_cell_m})->net_sigma_m3;
  };
  // Of each the walls are the same: hypot(1, 1) of them, and hypot(1, 4) by cells four times as large.
  EXPECT_NEAR(sigma_m3(4.0 * kFieldCellM), std::sqrt(17.0 / 2.0) * sigma_m3(kFieldCellM), 1e-6);
  EXPECT_EQ(sigma_m3(0.5 * kFieldCellM), sigma_m3(kFieldCellM));
}

TEST(VolumeTest, WithoutHeightsThereIsNone) {
  Field field([](double, double) { return std::numeric_limits<double>::quiet_NaN(); });
  EXPECT_FALSE(field.Over(VolumeBase::kGiven, 1.0));
  field.edge.clear();
  EXPECT_FALSE(field.Over(VolumeBase::kPlane));
  // An edge along one line, as of a polygon that reaches in from beside the map.
  Field line([](double x, double) { return 100.0 + x; });
  line.edge.resize(1);
  EXPECT_TRUE(std::isfinite(line.Over(VolumeBase::kPlane)->net_sigma_m3.value()));
}

}  // namespace
}  // namespace skyquilt::surface
