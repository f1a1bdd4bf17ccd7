// How well seams hide, on simulated flights with truth: render_seams [photos [seeds [scene [folder]]]]. A row
// a scene and a way: the nearest photo everywhere against moved seams with evened light, which must keep
// within the bars, or the program fails. Into the folder goes a picture of each scene's most broken object.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/base/scoped_timer.h"
#include "core/geo/web_mercator.h"
#include "core/render/blocks/render_block.h"
#include "core/simulate/world/world_raster.h"
#include "tests/support/memory_sink.h"
#include "tests/support/simulated_map.h"

namespace {

using namespace skyquilt;

struct Picture {
  cv::Mat3f map, truth;  // red, green, blue
  cv::Mat1i owner;       // photo, or -1 where the map is not whole
};

// The finest zoom of the map beside the world; only tiles without any transparency.
std::vector<Picture> Compare(const test::SimulatedMap& map, const render::SeamMap& seams,
                             const test::MemorySink& tiles) {
  std::vector<Picture> pictures;
  for (const auto& [tile, stored] : tiles.tiles) {
    if (tile.z() != map.plan.base_zoom || stored.format != image::PictureFormat::kJpeg) continue;
    Picture picture;
    cv::Mat decoded = cv::imdecode(stored.bytes, cv::IMREAD_COLOR);
    cv::cvtColor(decoded, decoded, cv::COLOR_BGR2RGB);
    decoded.convertTo(picture.map, CV_32FC3);
    const auto truth = simulate::RenderWorld(map.truth.world, map.flight.frame,
                                             geo::RasterFrame::OfTile(tile, decoded.cols));
    cv::Mat(truth.height_px, truth.width_px, CV_8UC3, const_cast<std::uint8_t*>(truth.rgb.data()))
        .convertTo(picture.truth, CV_32FC3);
    picture.owner = cv::Mat1i(decoded.rows, decoded.cols);
    const Eigen::Vector2i corner = seams.grid.CellOfBlock(tile, 0);
    for (int y = 0; y < decoded.rows; ++y) {
      for (int x = 0; x < decoded.cols; ++x) {
        picture.owner(y, x) =
            seams.labels.At(corner.x() + x / seams.grid.cell_px, corner.y() + y / seams.grid.cell_px);
      }
    }
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

struct Light {
  double step_median = 0.0, step_p95 = 0.0, colour_error = 0.0;
};

Light MeasureLight(const std::vector<Picture>& pictures) {
  cv::Scalar map_sum, truth_sum;
  for (const Picture& picture : pictures)
    map_sum += cv::sum(picture.map), truth_sum += cv::sum(picture.truth);
  std::array<double, 3> gain{};
  for (int c = 0; c < 3; ++c) gain[static_cast<std::size_t>(c)] = truth_sum[c] / map_sum[c];
  std::vector<double> steps;
  double squares = 0.0;
  int squares_count = 0;
  constexpr int kNear = 6, kWide = 16, kLong = 16;
  for (const Picture& picture : pictures) {
    cv::Mat1f off(picture.map.rows, picture.map.cols);
    for (int y = 0; y < off.rows; ++y) {
      for (int x = 0; x < off.cols; ++x) {
        double sum = 0.0;
        for (int c = 0; c < 3; ++c)
          sum += picture.map(y, x)[c] * gain[static_cast<std::size_t>(c)] - picture.truth(y, x)[c];
        off(y, x) = static_cast<float>(sum / 3.0);
      }
    }
    for (int y = 0; y + 32 <= off.rows; y += 32) {
      for (int x = 0; x + 32 <= off.cols; x += 32) {
        const cv::Rect block(x, y, 32, 32);
        for (int c = 0; c < 3; ++c) {
          const double is = cv::mean(picture.map(block))[c] * gain[static_cast<std::size_t>(c)],
                       should = cv::mean(picture.truth(block))[c];
          squares += std::pow((is - should) / std::max(20.0, should), 2);
          ++squares_count;
        }
      }
    }
    const auto sample = [&](cv::Rect here, cv::Rect there) {
      const cv::Rect all(0, 0, off.cols, off.rows);
      if ((here & all) != here || (there & all) != there) return;
      // Corners where three photos meet are left out: whole patches of one photo only.
      double low = 0.0, high = 0.0, other_low = 0.0, other_high = 0.0;
      cv::minMaxLoc(picture.owner(here), &low, &high);
      cv::minMaxLoc(picture.owner(there), &other_low, &other_high);
      if (low != high || other_low != other_high || low < 0 || other_low < 0) return;
      steps.push_back(std::abs(cv::mean(off(here))[0] - cv::mean(off(there))[0]));
    };
    for (int y = 8; y + 8 < off.rows; y += kLong) {
      for (int x = 1; x < off.cols; ++x) {
        if (picture.owner(y, x) == picture.owner(y, x - 1)) continue;
        sample({x - kNear - kWide, y - kLong / 2, kWide, kLong}, {x + kNear, y - kLong / 2, kWide, kLong});
      }
    }
    for (int x = 8; x + 8 < off.cols; x += kLong) {
      for (int y = 1; y < off.rows; ++y) {
        if (picture.owner(y, x) == picture.owner(y - 1, x)) continue;
        sample({x - kLong / 2, y - kNear - kWide, kLong, kWide}, {x - kLong / 2, y + kNear, kLong, kWide});
      }
    }
  }
  return {Quantile(steps, 0.5), Quantile(steps, 0.95), std::sqrt(squares / std::max(1, squares_count))};
}

double GradientEnergy(const cv::Mat3b& rgb, const cv::Mat1b& where) {
  cv::Mat1b grey;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  double sum = 0.0;
  for (int y = 0; y + 1 < grey.rows; ++y) {
    for (int x = 0; x + 1 < grey.cols; ++x) {
      if (where(y, x) == 0 || where(y + 1, x) == 0 || where(y, x + 1) == 0) continue;
      sum += std::pow(grey(y, x + 1) - grey(y, x), 2) + std::pow(grey(y + 1, x) - grey(y, x), 2);
    }
  }
  return sum;
}

// Gradient energy of the map's blocks over that of the same ground from one photo alone: what blending costs.
double Sharpness(const test::SimulatedMap& map, const render::SeamMap& seams) {
  render::PhotoCache cache(*map.photos, std::int64_t{1} << 30);
  double map_energy = 0.0, alone_energy = 0.0;
  for (std::size_t b = 0; b < map.plan.blocks.size(); b += 3) {
    const render::RenderBlock& block = map.plan.blocks[b];
    const auto image =
        render::RenderBlockPixels({map.flight, map.ground, map.exposure, seams, map.plan, cache}, block);
    const int side = map.plan.BlockSizePx(), cell_px = seams.grid.cell_px;
    const Eigen::Vector2i corner = seams.grid.CellOfBlock(block.tile, map.plan.block_levels);
    const cv::Mat4b whole(side, side,
                          reinterpret_cast<cv::Vec4b*>(const_cast<std::uint8_t*>(image->rgba.data())));
    cv::Mat3b map_rgb;
    cv::cvtColor(whole, map_rgb, cv::COLOR_RGBA2RGB);
    for (const std::uint32_t photo : seams.PhotosIn(corner.x(), corner.y(), side / cell_px, side / cell_px)) {
      alignment::AlignedFlight one = map.flight;
      one.photos = {map.flight.photos[photo]};
      render::MosaicPlan plan = map.plan;
      plan.seen_in_merc = {map.plan.seen_in_merc[photo]};
      const render::ExposureModel exposure{
          map.exposure.light, {map.exposure.photos[photo]}, {map.exposure.tones[photo]}};
      const auto alone_seams =
          render::BuildSeamMap(one, map.ground, plan, exposure, {map.thumbnails[photo]}, {});
      render::PhotoCache own(*map.photos, std::int64_t{1} << 28);
      const auto alone =
          render::RenderBlockPixels({one, map.ground, exposure, alone_seams, plan, own}, {block.tile, {0}});
      const cv::Mat4b alone_rgba(side, side,
                                 reinterpret_cast<cv::Vec4b*>(const_cast<std::uint8_t*>(alone->rgba.data())));
      cv::Mat3b alone_rgb;
      cv::cvtColor(alone_rgba, alone_rgb, cv::COLOR_RGBA2RGB);
      cv::Mat1b where(side, side, static_cast<uchar>(0));
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
          where(y, x) = seams.labels.At(corner.x() + x / cell_px, corner.y() + y / cell_px) ==
                            static_cast<std::int32_t>(photo) &&
                        alone_rgba(y, x)[3] != 0;
        }
      }
      map_energy += GradientEnergy(map_rgb, where);
      alone_energy += GradientEnergy(alone_rgb, where);
    }
  }
  return map_energy / alone_energy;
}

// What the moved seams must reach: grey levels, shares.
constexpr double kMaxStepMedian = 1.0, kMaxStepP95 = 3.0, kMaxColourError = 0.03, kMinSharpness = 0.9,
                 kMaxBroken = 0.05;

// The map around a place, two hundred pixels a side.
void WritePicture(const test::SimulatedMap& map, const render::SeamMap& seams, const Eigen::Vector2d& in_enu,
                  const std::string& path) {
  constexpr int kSide = 200;
  const geo::Wgs84 wgs84 = map.flight.frame.Wgs84FromEnu({in_enu.x(), in_enu.y(), 0.0});
  const Eigen::Vector2d merc = geo::MercFromLatLon({wgs84.lat_deg, wgs84.lon_deg});
  const geo::TileId tile = geo::TileId::AtMerc(map.plan.base_zoom - map.plan.block_levels, merc);
  render::PhotoCache cache(*map.photos, std::int64_t{1} << 28);
  for (const render::RenderBlock& block : map.plan.blocks) {
    if (block.tile != tile) continue;
    const auto image =
        render::RenderBlockPixels({map.flight, map.ground, map.exposure, seams, map.plan, cache}, block);
    if (!image) return;
    const double pixel_m = geo::PixelSizeInMercM(map.plan.base_zoom, map.plan.tile_size_px);
    const auto corner = [&](double metres) {
      return std::clamp(static_cast<int>(metres / pixel_m) - kSide / 2, 0, image->width_px - kSide);
    };
    const geo::Bounds2 bounds = tile.BoundsInMerc();
    const cv::Mat4b whole(image->height_px, image->width_px,
                          reinterpret_cast<cv::Vec4b*>(const_cast<std::uint8_t*>(image->rgba.data())));
    cv::Mat bgr;
    cv::cvtColor(
        whole(cv::Rect(corner(merc.x() - bounds.min.x()), corner(bounds.max.y() - merc.y()), kSide, kSide)),
        bgr, cv::COLOR_RGBA2BGR);
    cv::imwrite(path, bgr);
    return;
  }
}

struct Scene {
  const char* name;
  bool has_boxes;
  int cars;
};

}  // namespace

int main(int argc, char** argv) {
  const int photos = argc > 1 ? std::atoi(argv[1]) : 20;
  const int seeds = argc > 2 ? std::atoi(argv[2]) : 2;
  const std::string only = argc > 3 ? argv[3] : "";
  const std::string folder = argc > 4 ? argv[4] : "";
  bool is_good = true;
  test::ObjectCount all_cars, all_roofs;
  const auto add = [](const test::ObjectCount& some, test::ObjectCount& all) {
    all.objects += some.objects, all.twice += some.twice, all.in_part += some.in_part;
  };
  fmt::print("{:<8} {:>4} {:<8} {:>8} {:>8} {:>9} {:>9} {:>14} {:>14} {:>8}\n", "scene", "seed", "seams",
             "step p50", "step p95", "colour %", "sharpness", "cars 2x/part", "roofs 2x/part", "label s");
  for (const Scene& scene : {Scene{"fields", false, 0}, Scene{"cars", false, 120}, Scene{"boxes", true, 0}}) {
    if (!only.empty() && only != scene.name) continue;
    for (int seed = 1; seed <= seeds; ++seed) {
      simulate::SimulateOptions options;
      options.seed = static_cast<std::uint32_t>(seed);
      options.world.seed = static_cast<std::uint32_t>(seed);
      options.world.has_boxes = scene.has_boxes;
      options.trajectory.photos = photos;
      const bool is_drawn = !scene.has_boxes && scene.cars == 0;
      // Where only the seams' places count, smaller photos of more ground.
      if (!is_drawn)
        options.intrinsics = camera::Intrinsics::Centered(800, 600, 600.0),
        options.trajectory.photos = 2 * photos;
      options.vignetting = 0.2;
      options.exposure_jitter = 0.08;
      const test::SimulatedMap map = test::MakeSimulatedMap(options, {}, scene.cars);
      for (const bool is_new : {false, true}) {
        double label_s = 0.0;
        render::SeamMap seams;
        {
          ScopedTimer timer(label_s);
          seams = map.Seams({is_new, is_new, 1});
        }
        const test::ObjectCount cars = test::CountCars(map, seams), roofs = test::CountRoofs(map, seams);
        Light light;
        double sharpness = 0.0;
        if (is_drawn) {
          test::MemorySink tiles;
          test::RenderMap(map, seams, 0, tiles);
          light = MeasureLight(Compare(map, seams, tiles));
          sharpness = Sharpness(map, seams);
        }
        fmt::print(
            "{:<8} {:>4} {:<8} {:>8.2f} {:>8.2f} {:>9.2f} {:>9.3f} {:>5}/{:<3} of{:>3} {:>5}/{:<3} of{:>3} "
            "{:>8.2f}\n",
            scene.name, seed, is_new ? "moved" : "nearest", light.step_median, light.step_p95,
            100.0 * light.colour_error, sharpness, cars.twice, cars.in_part, cars.objects, roofs.twice,
            roofs.in_part, scene.has_boxes ? roofs.objects : 0, label_s);
        std::fflush(stdout);
        if (!is_new) continue;
        if (is_drawn) {
          is_good &= light.step_median <= kMaxStepMedian && light.step_p95 <= kMaxStepP95 &&
                     light.colour_error <= kMaxColourError && sharpness >= kMinSharpness;
        }
        add(cars, all_cars);
        if (scene.has_boxes) add(roofs, all_roofs);
        const test::ObjectCount& objects = scene.has_boxes ? roofs : cars;
        if (!folder.empty() && objects.worst_share > 0.0) {
          WritePicture(map, seams, objects.worst_in_enu,
                       fmt::format("{}/{}_{}.png", folder, scene.name, seed));
        }
      }
    }
  }
  is_good &= all_cars.BrokenShare() <= kMaxBroken && all_roofs.BrokenShare() <= kMaxBroken;
  fmt::print("cars twice or in part {:.1f} %, roofs {:.1f} %: {}\n", 100.0 * all_cars.BrokenShare(),
             100.0 * all_roofs.BrokenShare(), is_good ? "within the bars" : "BEYOND THE BARS");
  return is_good ? 0 : 1;
}
