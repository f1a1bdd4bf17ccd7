#include "core/pipeline/memory_budget.h"

#include <gtest/gtest.h>

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/image/picture_codec.h"
#include "core/render/seams/seam_grid.h"
#include "tests/support/value_of.h"

namespace skyquilt::pipeline {
namespace {

constexpr std::int64_t kGib = std::int64_t{1} << 30;

// Photos straight down along a line.
alignment::AlignedFlight FlightAt(const std::vector<double>& heights_m) {
  alignment::AlignedFlight flight;
  flight.frame = geo::LocalFrame({46.8, 7.1, 500.0});
  for (const double height_m : heights_m) {
    alignment::AlignedPhoto photo;
    photo.photo.name = "P" + std::to_string(flight.photos.size());
    photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
        Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0),
        {10.0 * static_cast<double>(flight.photos.size()), 0.0, height_m});
    photo.height_above_ground_m = height_m;
    flight.photos.push_back(photo);
  }
  return flight;
}

TEST(MemoryBudget, WhatIsDividedIsNoMoreThanThereIs) {
  for (const double height_m : {0.01, 0.5, 2.0, 10.0, 50.0, 1000.0}) {
    for (const std::int64_t memory : {kGib / 4, kGib, 8 * kGib}) {
      MosaicOptions options;
      options.max_memory_bytes = memory;
      options.threads = 8;
      const auto flight = FlightAt({height_m, height_m, height_m});
      const auto plan =
          test::ValueOf(render::PlanMosaic(flight, ground::GroundSurface::Plane(0.0), PlanWithin(options)));
      const RenderBudget budget = BudgetFor(options, plan);
      EXPECT_GE(budget.threads, 1);
      EXPECT_GT(budget.cache_bytes, 0);
      EXPECT_LE(budget.threads * render::BlockBytes(plan.BlockSizePx()) + budget.cache_bytes, memory)
          << height_m << " m, " << plan.tile_size_px << " px";
      const render::SeamGrid grid = render::MakeSeamGrid(plan, 4000.0, 0.68);
      double cells = 0.0;
      for (const geo::Bounds2& seen : plan.seen_in_merc)
        cells += seen.Width() * seen.Height() / (grid.CellInMercM() * grid.CellInMercM());
      EXPECT_LE(cells * static_cast<double>(render::kSeamCellBytes), static_cast<double>(memory));
    }
  }
}

// Heights a finger above the ground asked for tiles of 32,768 pixels.
TEST(MemoryBudget, TilesDoNotGrowBeyondItNorBeyondWhatIsDecoded) {
  const auto flight = FlightAt({0.001, 0.001, 0.002});
  for (const std::int64_t memory : {kGib / 2, kGib, 4 * kGib, 64 * kGib}) {
    MosaicOptions options;
    options.max_memory_bytes = memory;
    const auto plan =
        test::ValueOf(render::PlanMosaic(flight, ground::GroundSurface::Plane(0.0), PlanWithin(options)));
    EXPECT_EQ(plan.tile_size_px, memory < kGib ? image::kMaxPictureSidePx / 2 : image::kMaxPictureSidePx);
  }
}

TEST(PlanMosaic, RefusesPixelsFarFinerThanThePhotos) {
  const auto flight = FlightAt({60.0, 60.0});  // 2 cm
  const auto ground = ground::GroundSurface::Plane(0.0);
  EXPECT_NE(test::ErrorOf(render::PlanMosaic(flight, ground, {.gsd_m = 0.001})).message.find("--gsd"),
            std::string::npos);
  EXPECT_TRUE(render::PlanMosaic(flight, ground, {.gsd_m = 0.005}).ok());
}

TEST(PlanMosaic, IsAsFineAsTheLargePicturesAmongAsManySmallOnes) {
  const auto ground = ground::GroundSurface::Plane(0.0);
  auto flight = FlightAt({60.0, 60.0, 60.0, 60.0, 60.0, 60.0});  // 2 cm
  for (std::size_t i = 0; i < 3; ++i)
    flight.photos[i].intrinsics = camera::Intrinsics::Centered(1000, 750, 750.0);  // of the same view, 8 cm
  EXPECT_NEAR(render::PlanMosaic(flight, ground, {})->gsd_m, 0.02, 1e-9);
  // Of one size the middle picture decides, of two middles the upper.
  EXPECT_NEAR(render::PlanMosaic(FlightAt({60.0, 90.0, 30.0}), ground, {})->gsd_m, 0.02, 1e-9);
  EXPECT_NEAR(render::PlanMosaic(FlightAt({60.0, 90.0, 30.0, 120.0}), ground, {})->gsd_m, 0.03, 1e-9);
}

TEST(PlanMosaic, IsNotFinerThanThePhotosWhereThatIsAskedFor) {
  const auto flight = FlightAt({60.0, 60.0});  // 2 cm
  const auto ground = ground::GroundSurface::Plane(0.0);
  MosaicOptions options;
  const auto own = test::ValueOf(render::PlanMosaic(flight, ground, PlanWithin(options)));
  options.not_finer_than_photos = true;
  for (const double gsd_m : {0.001, 0.005, 0.2}) {
    options.gsd_m = gsd_m;
    const auto plan = test::ValueOf(render::PlanMosaic(flight, ground, PlanWithin(options)));
    EXPECT_EQ(plan.base_zoom<own.base_zoom, gsd_m> 0.1) << gsd_m;
    EXPECT_LE(plan.base_zoom, own.base_zoom) << gsd_m;
    EXPECT_DOUBLE_EQ(options.OutputGsdM(0.02), std::max(gsd_m, 0.02));
  }
}

}  // namespace
}  // namespace skyquilt::pipeline
