// A map whose every pixel says where it lies: waves of red along x and of green along y of Web Mercator, in
// tiles of two zooms around a place; and, by Krueger's series and nothing of what is tested, where a place of
// UTM lies. Waves are 40 pixels of the finest zoom long: a tenth of a pixel makes a difference of 1.6 levels.
#pragma once

#include <cmath>
#include <cstdlib>
#include <functional>

#include "api/tiles/recode_tile.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {

class TexturedMap {
 public:
  static constexpr int kZoom = 18, kTiles = 4;  // a square of so many tiles at the finest zoom

  TexturedMap(SampleService& sample, const geo::LatLon& near, int side_px = 256) {
    const geo::TileId middle = geo::TileId::AtMerc(kZoom, geo::MercFromLatLon(near));
    const std::uint32_t column = middle.x() / kTiles * kTiles, row = middle.y() / kTiles * kTiles;
    wave_m_ = 40 * geo::PixelSizeInMercM(kZoom, side_px);
    bounds_.Include(geo::TileId::Make(kZoom, column, row)->BoundsInMerc());
    bounds_.Include(geo::TileId::Make(kZoom, column + kTiles - 1, row + kTiles - 1)->BoundsInMerc());
    std::vector<storage::SmallTile> tiles;
    for (const int zoom : {kZoom - 1, kZoom}) {
      const std::uint32_t shrunk = zoom == kZoom ? 1 : 2;
      for (std::uint32_t y = row / shrunk; y < (row + kTiles) / shrunk; ++y) {
        for (std::uint32_t x = column / shrunk; x < (column + kTiles) / shrunk; ++x) {
          const geo::TileId tile = *geo::TileId::Make(zoom, x, y);
          tiles.push_back(
              {zoom, static_cast<int>(x), static_cast<int>(tile.TmsRow()), Painted(tile, side_px)});
        }
      }
    }
    flight_ = sample.NewFlight();
    revision_ = sample.PublishAt(geo::LatLonBoundsFromMerc(bounds_), flight_, tiles, side_px);
  }

  const std::string& flight() const { return flight_; }
  std::int64_t revision() const { return revision_; }
  const geo::Bounds2& bounds_in_merc() const { return bounds_; }
  geo::LatLonBounds bounds() const { return geo::LatLonBoundsFromMerc(bounds_); }

  double Red(const Eigen::Vector2d& merc) const { return Wave(merc.x() - bounds_.min.x()); }
  double Green(const Eigen::Vector2d& merc) const { return Wave(bounds_.max.y() - merc.y()); }

  // Holds each pixel of a picture against where it lies and answers how many showed the map.
  int Compare(const image::RgbaImage& picture, const std::function<geo::LatLon(double x, double y)>& position,
              double most_off = 1.5) const {
    int shown = 0, wrong = 0;
    for (int y = 0; y < picture.height_px; ++y) {
      for (int x = 0; x < picture.width_px; ++x) {
        const Eigen::Vector2d merc = geo::MercFromLatLon(position(x + 0.5, y + 0.5));
        const std::uint8_t* const pixel = picture.Pixel(x, y);
        const double inside = std::min((merc - bounds_.min).minCoeff(), (bounds_.max - merc).minCoeff());
        // Half a pixel at the edge is between what is known and what is not.
        if (std::abs(inside) < wave_m_ / 20) continue;
        if (inside < 0.0) {
          wrong += pixel[3] != 0;
          continue;
        }
        ++shown;
        wrong += pixel[3] != 255 || std::abs(pixel[0] - Red(merc)) > most_off ||
                 std::abs(pixel[1] - Green(merc)) > most_off;
      }
    }
    EXPECT_EQ(wrong, 0) << "of " << shown;
    return shown;
  }

 private:
  double Wave(double along_m) const { return 127.0 + 100.0 * std::sin(2.0 * geo::kPi * along_m / wave_m_); }

  std::string Painted(const geo::TileId& tile, int side_px) const {
    const geo::Bounds2 here = tile.BoundsInMerc();
    const double pixel_m = here.Width() / side_px;
    image::RgbaImage picture = image::RgbaImage::Transparent(side_px, side_px);
    for (int y = 0; y < side_px; ++y) {
      for (int x = 0; x < side_px; ++x) {
        const Eigen::Vector2d merc(here.min.x() + (x + 0.5) * pixel_m, here.max.y() - (y + 0.5) * pixel_m);
        std::uint8_t* const pixel = picture.Pixel(x, y);
        pixel[0] = static_cast<std::uint8_t>(std::lround(Red(merc)));
        pixel[1] = static_cast<std::uint8_t>(std::lround(Green(merc)));
        pixel[2] = 60;
        pixel[3] = 255;
      }
    }
    return EncodeTile(std::move(picture), image::PictureFormat::kPng);
  }

  std::string flight_;
  std::int64_t revision_ = 0;
  double wave_m_ = 1.0;
  geo::Bounds2 bounds_;
};

// Karney 2011, equations 9 to 11 and 35, to the third order: within a tenth of a millimetre in a zone. North
// of the equator and south of it, with northings below zero there.
inline geo::LatLon LatLonOfUtm(int zone, double east_m, double north_m) {
  constexpr double n = geo::kWgs84Flattening / (2.0 - geo::kWgs84Flattening);
  constexpr double radius = geo::kWgs84SemiMajorM / (1.0 + n) * (1.0 + n * n / 4.0 + n * n * n * n / 64.0);
  const double beta[] = {n / 2 - 2 * n * n / 3 + 37 * n * n * n / 96, n * n / 48 + n * n * n / 15,
                         17 * n * n * n / 480};
  const double delta[] = {2 * n - 2 * n * n / 3 - 2 * n * n * n, 7 * n * n / 3 - 8 * n * n * n / 5,
                          56 * n * n * n / 15};
  const double xi = north_m / (0.9996 * radius), eta = (east_m - 500000.0) / (0.9996 * radius);
  double xi_of_sphere = xi, eta_of_sphere = eta;
  for (int j = 1; j <= 3; ++j) {
    xi_of_sphere -= beta[j - 1] * std::sin(2 * j * xi) * std::cosh(2 * j * eta);
    eta_of_sphere -= beta[j - 1] * std::cos(2 * j * xi) * std::sinh(2 * j * eta);
  }
  const double chi = std::asin(std::sin(xi_of_sphere) / std::cosh(eta_of_sphere));
  double lat = chi;
  for (int j = 1; j <= 3; ++j) lat += delta[j - 1] * std::sin(2 * j * chi);
  const double lon = std::atan2(std::sinh(eta_of_sphere), std::cos(xi_of_sphere));
  return {.lat_deg = geo::RadToDeg(lat), .lon_deg = geo::RadToDeg(lon) + zone * 6.0 - 183.0};
}

}  // namespace skyquilt::api
