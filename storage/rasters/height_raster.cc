#include "storage/rasters/height_raster.h"

#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/try.h"
#include "core/geo/geodesic.h"
#include "core/geo/web_mercator.h"
#include "storage/rasters/gdal_steps.h"
#include "storage/rasters/places_in_zone.h"

namespace skyquilt::storage {
namespace {

constexpr float kNoHeight = std::numeric_limits<float>::quiet_NaN();
constexpr int kSketchSide = 64;
std::size_t CellCount(int columns, int rows) {
  return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
}

// Of one level of detail; columns and rows as of `band`.
struct HeightWindow {
  int left = 0, top = 0, columns = 0, rows = 0;
};

bool ReadWindow(GDALRasterBand& band, const HeightWindow& window, int to_columns, int to_rows, void* to,
                GDALDataType type, GDALRIOResampleAlg how) {
  GDALRasterIOExtraArg extra;
  INIT_RASTERIO_EXTRA_ARG(extra);
  extra.eResampleAlg = how;
  return band.RasterIO(GF_Read, window.left, window.top, window.columns, window.rows, to, to_columns, to_rows,
                       type, 0, 0, &extra) == CE_None;
}

// The cells around places that lie between `low` and `high`; none where they lie beside the band.
std::optional<HeightWindow> WindowAround(GDALRasterBand& band, const Eigen::Vector2d& low,
                                         const Eigen::Vector2d& high) {
  const auto within = [](double place, int count) {
    return static_cast<int>(std::clamp(place, 0.0, static_cast<double>(count)));
  };
  HeightWindow window;
  window.left = within(std::floor(low.x() - 0.5), band.GetXSize());
  window.top = within(std::floor(low.y() - 0.5), band.GetYSize());
  window.columns = within(std::floor(high.x() - 0.5) + 2.0, band.GetXSize()) - window.left;
  window.rows = within(std::floor(high.y() - 0.5) + 2.0, band.GetYSize()) - window.top;
  return window.columns > 0 && window.rows > 0 ? std::optional(window) : std::nullopt;
}

// `place` counted in cells, the middle of the first at 0.5; NaN beside them or where the nearest has none.
float Between(const std::vector<float>& heights_m, const HeightWindow& window, const Eigen::Vector2d& place) {
  const double x = place.x() - 0.5 - window.left, y = place.y() - 0.5 - window.top;
  if (!(x > -0.5 && y > -0.5 && x < window.columns - 0.5 && y < window.rows - 0.5)) return kNoHeight;
  const auto at = [&](double column, double row) {
    const int c = std::clamp(static_cast<int>(column), 0, window.columns - 1);
    const int r = std::clamp(static_cast<int>(row), 0, window.rows - 1);
    return heights_m[CellCount(window.columns, r) + static_cast<std::size_t>(c)];
  };
  if (!std::isfinite(at(std::round(x), std::round(y)))) return kNoHeight;
  const double left = std::floor(x), top = std::floor(y);
  double sum = 0.0, weights = 0.0;
  for (const double dy : {0.0, 1.0}) {
    for (const double dx : {0.0, 1.0}) {
      const float height_m = at(std::max(0.0, left + dx), std::max(0.0, top + dy));
      if (!std::isfinite(height_m)) continue;
      const double weight = (1.0 - std::abs(x - left - dx)) * (1.0 - std::abs(y - top - dy));
      sum += weight * height_m;
      weights += weight;
    }
  }
  return weights > 0.0 ? static_cast<float>(sum / weights) : kNoHeight;
}

// Unknown cells take the mean of those around them, first round by round from the known ones outwards, then
// over and over, until they lie as a membrane does that hangs from these: what goes on has no steps.
void FillFromAround(std::vector<float>& heights_m, int columns, int rows) {
  constexpr int kRounds = 400;
  std::vector<std::size_t> unknown;
  for (std::size_t i = 0; i < heights_m.size(); ++i) {
    if (!std::isfinite(heights_m[i])) unknown.push_back(i);
  }
  if (unknown.size() == heights_m.size()) {
    std::fill(heights_m.begin(), heights_m.end(), 0.0f);
    return;
  }
  std::size_t left = unknown.size();
  for (int round = 0; round < kRounds || left > 0; ++round) {
    const std::vector<float> before = heights_m;
    left = 0;
    for (const std::size_t cell : unknown) {
      const int column = static_cast<int>(cell % static_cast<std::size_t>(columns)),
                row = static_cast<int>(cell / static_cast<std::size_t>(columns));
      double sum = 0.0;
      int count = 0;
      for (int r = std::max(0, row - 1); r <= std::min(rows - 1, row + 1); ++r) {
        for (int c = std::max(0, column - 1); c <= std::min(columns - 1, column + 1); ++c) {
          const float beside = before[CellCount(columns, r) + static_cast<std::size_t>(c)];
          if (!std::isfinite(beside)) continue;
          sum += beside;
          ++count;
        }
      }
      if (count > 0)
        heights_m[cell] = static_cast<float>(sum / count);
      else
        ++left;
    }
  }
}

// Where `bounds` reach across the antimeridian, longitudes go on across it as theirs do.
geo::Boundary GoingOnAs(const geo::LatLonBounds& bounds, geo::Boundary area) {
  if (bounds.west_deg >= -180.0 && bounds.east_deg <= 180.0) return area;
  const double middle_deg = bounds.Middle().lon_deg;
  for (geo::Boundary::Polygon& polygon : area.polygons) {
    for (geo::Boundary::Ring& ring : polygon) {
      for (geo::LatLon& corner : ring)
        corner.lon_deg = middle_deg + std::remainder(corner.lon_deg - middle_deg, 360.0);
    }
  }
  return area;
}

// So far apart, in cells; not where nothing is known.
void AddHeightsAlong(const geo::RingEdge& edge, double apart, HeightCells& cells) {
  const Eigen::Vector2d from(edge.x0, edge.y0), along(edge.x1 - edge.x0, edge.y1 - edge.y0);
  const int steps = std::max(1, static_cast<int>(std::ceil(along.norm() / apart)));
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector2d place = from + static_cast<double>(i) / steps * along;
    const float height_m = Between(cells.heights_m, {0, 0, cells.columns, cells.rows}, place);
    if (std::isfinite(height_m)) cells.edge.push_back({place, height_m});
  }
}

// The coarsest level whose cells are no larger than `step` of the file's.
GDALRasterBand& LevelFor(GDALRasterBand& band, double step) {
  GDALRasterBand* found = &band;
  for (int i = 0; i < band.GetOverviewCount(); ++i) {
    GDALRasterBand* const level = band.GetOverview(i);
    if (level != nullptr && level->GetXSize() < found->GetXSize() &&
        static_cast<double>(band.GetXSize()) / level->GetXSize() <= 1.001 * step)
      found = level;
  }
  return *found;
}

Result<void> CheckSize(const MercGrid& grid) {
  constexpr int kMaxPx = HeightRaster::kMaxSidePx;
  if (grid.width_px >= 1 && grid.height_px >= 1 && grid.width_px <= kMaxPx && grid.height_px <= kMaxPx)
    return {};
  return Error{ErrorCode::kInvalidArgument, "More pixels are asked for than are read at once.", ""};
}

}  // namespace

Result<std::shared_ptr<HeightRaster>> HeightRaster::Open(const std::filesystem::path& heights,
                                                         const std::filesystem::path& measured) {
  const QuietGdal quiet;
  std::shared_ptr<HeightRaster> raster(new HeightRaster(heights, measured));
  SKYQUILT_TRY_ASSIGN(OpenGeotiff file, raster->heights_.Take());
  SKYQUILT_TRY_ASSIGN(OpenGeotiff flags, raster->measured_.Take());
  std::array<double, 6> transform{};
  const OGRSpatialReference* const zone = file->GetSpatialRef();
  const char* const code = zone == nullptr ? nullptr : zone->GetAuthorityCode(nullptr);
  if (code == nullptr || file->GetGeoTransform(transform.data()) != CE_None || !(transform[1] > 0.0) ||
      std::abs(transform[1] + transform[5]) > 1e-9 * transform[1] || transform[2] != 0.0 ||
      transform[4] != 0.0)
    return raster->heights_.Damaged("it does not lie in a UTM zone");
  raster->epsg_ = std::atoi(code);
  SKYQUILT_TRY_ASSIGN(const geo::MapProjection projection, geo::MapProjection::OfEpsg(raster->epsg_));
  raster->west_m_ = transform[0];
  raster->north_m_ = transform[3];
  raster->cell_m_ = transform[1];
  raster->columns_ = file->GetRasterXSize();
  raster->rows_ = file->GetRasterYSize();
  if (!raster->FindAround(projection)) return raster->heights_.Damaged("it does not lie in a UTM zone");
  if (file->GetRasterCount() != 1 || file->GetRasterBand(1)->GetRasterDataType() != GDT_Float32)
    return raster->heights_.Damaged("it has no heights");
  if (flags->GetRasterCount() != 1 || flags->GetRasterXSize() != raster->columns_ ||
      flags->GetRasterYSize() != raster->rows_)
    return raster->measured_.Damaged("it has other cells than the heights");
  SKYQUILT_TRY_ASSIGN(raster->sketch_, raster->MakeSketch(*file));
  raster->heights_.Give(std::move(file));
  raster->measured_.Give(std::move(flags));
  return raster;
}

bool HeightRaster::FindAround(const geo::MapProjection& zone) {
  // Its edges bend against meridians, by far less.
  constexpr double kBeyond = 0.125;
  constexpr int kSteps = 10;
  bool is_first = true;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const auto at = [](int step) { return -kBeyond + (1.0 + 2.0 * kBeyond) * step / kSteps; };
      const auto place =
          zone.LatLonOf({west_m_ + cell_m_ * columns_ * at(i), north_m_ - cell_m_ * rows_ * at(j)});
      if (!place) return false;
      const geo::LatLonBounds here{place->lon_deg, place->lat_deg, place->lon_deg, place->lat_deg};
      if (is_first) around_ = here;
      around_.Include(here.Beside(around_));
      is_first = false;
    }
  }
  return true;
}

Result<HeightRaster::Sketch> HeightRaster::MakeSketch(GDALDataset& file) const {
  Sketch sketch;
  const int longer = std::max({columns_, rows_, kSketchSide});
  sketch.columns = std::max(1, columns_ * kSketchSide / longer);
  sketch.rows = std::max(1, rows_ * kSketchSide / longer);
  sketch.heights_m.resize(CellCount(sketch.columns, sketch.rows));
  if (!ReadWindow(*file.GetRasterBand(1), {0, 0, columns_, rows_}, sketch.columns, sketch.rows,
                  sketch.heights_m.data(), GDT_Float32, GRIORA_Average))
    return heights_.Damaged("some of its cells are damaged");
  FillFromAround(sketch.heights_m, sketch.columns, sketch.rows);
  return sketch;
}

Result<std::vector<std::optional<double>>> HeightRaster::HeightsAt(std::span<const geo::LatLon> places) {
  const QuietGdal quiet;
  SKYQUILT_TRY_ASSIGN(const geo::MapProjection zone, geo::MapProjection::OfEpsg(epsg_));
  SKYQUILT_TRY_ASSIGN(OpenGeotiff file, heights_.Take());
  GDALRasterBand& band = *file->GetRasterBand(1);
  std::vector<std::optional<double>> found(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::optional<Eigen::Vector2d> in_zone = zone.PlaceOf(places[i]);
    if (!in_zone) continue;
    const Eigen::Vector2d cell = CellOf(*in_zone);
    const std::optional<HeightWindow> window = WindowAround(band, cell, cell);
    if (!window) continue;
    std::vector<float> around(CellCount(window->columns, window->rows));
    if (!ReadWindow(band, *window, window->columns, window->rows, around.data(), GDT_Float32,
                    GRIORA_NearestNeighbour))
      return heights_.Damaged("some of its cells are damaged");
    const float height_m = Between(around, *window, cell);
    if (std::isfinite(height_m)) found[i] = height_m;
  }
  heights_.Give(std::move(file));
  return found;
}

Result<SampledHeights> HeightRaster::Sample(const PlacesInZone& places) {
  Eigen::Vector2d low = CellOf(places.nodes().front()), high = low;
  for (const Eigen::Vector2d& node : places.nodes()) {
    low = low.cwiseMin(CellOf(node));
    high = high.cwiseMax(CellOf(node));
  }
  SampledHeights sampled;
  sampled.heights_m.assign(CellCount(places.columns(), places.rows()), kNoHeight);
  sampled.is_measured.assign(sampled.heights_m.size(), 0);
  SKYQUILT_TRY_ASSIGN(OpenGeotiff file, heights_.Take());
  SKYQUILT_TRY_ASSIGN(OpenGeotiff flags, measured_.Take());
  GDALRasterBand& own = *file->GetRasterBand(1);
  GDALRasterBand& level =
      LevelFor(own, std::min((high.x() - low.x()) / PlacesInZone::SpanOfNodes(places.columns()),
                             (high.y() - low.y()) / PlacesInZone::SpanOfNodes(places.rows())));
  const Eigen::Vector2d to_level(static_cast<double>(level.GetXSize()) / columns_,
                                 static_cast<double>(level.GetYSize()) / rows_);
  const std::optional<HeightWindow> window =
      WindowAround(level, low.cwiseProduct(to_level), high.cwiseProduct(to_level));
  if (window) {
    std::vector<float> around(CellCount(window->columns, window->rows));
    if (!ReadWindow(level, *window, window->columns, window->rows, around.data(), GDT_Float32,
                    GRIORA_NearestNeighbour))
      return heights_.Damaged("some of its cells are damaged");
    std::vector<std::uint8_t> measured(around.size());
    // The same cells of the finest level, of which GDAL takes the nearest.
    const auto finest = [](int cell, double to, int count) {
      return std::min(count, static_cast<int>(std::lround(cell / to)));
    };
    HeightWindow all{finest(window->left, to_level.x(), columns_), finest(window->top, to_level.y(), rows_),
                     0, 0};
    all.columns = finest(window->left + window->columns, to_level.x(), columns_) - all.left;
    all.rows = finest(window->top + window->rows, to_level.y(), rows_) - all.top;
    if (!ReadWindow(*flags->GetRasterBand(1), all, window->columns, window->rows, measured.data(), GDT_Byte,
                    GRIORA_NearestNeighbour))
      return measured_.Damaged("some of its cells are damaged");
    for (int row = 0; row < places.rows(); ++row) {
      for (int column = 0; column < places.columns(); ++column) {
        const std::size_t at = CellCount(places.columns(), row) + static_cast<std::size_t>(column);
        const Eigen::Vector2d cell = CellOf(places.At(column, row)).cwiseProduct(to_level);
        sampled.heights_m[at] = Between(around, *window, cell);
        if (!std::isfinite(sampled.heights_m[at])) continue;
        const int left = static_cast<int>(cell.x()) - window->left,
                  top = static_cast<int>(cell.y()) - window->top;
        sampled.is_measured[at] =
            measured[CellCount(window->columns, std::clamp(top, 0, window->rows - 1)) +
                     static_cast<std::size_t>(std::clamp(left, 0, window->columns - 1))];
      }
    }
  }
  heights_.Give(std::move(file));
  measured_.Give(std::move(flags));
  return sampled;
}

Result<SampledHeights> HeightRaster::Over(const MercGrid& grid) {
  SKYQUILT_TRY(CheckSize(grid));
  const QuietGdal quiet;
  SKYQUILT_TRY_ASSIGN(const geo::MapProjection zone, geo::MapProjection::OfEpsg(epsg_));
  const std::optional<PlacesInZone> places = PlacesInZone::Of(grid, zone);
  if (places) return Sample(*places);
  const std::size_t pixels = CellCount(grid.width_px, grid.height_px);
  return SampledHeights{std::vector<float>(pixels, kNoHeight), std::vector<std::uint8_t>(pixels, 0)};
}

Result<SampledHeights> HeightRaster::On(const HeightCells& cells, const Eigen::Vector2d& moved_by_merc_m) {
  const QuietGdal quiet;
  SKYQUILT_TRY_ASSIGN(const geo::MapProjection theirs, geo::MapProjection::OfEpsg(cells.epsg));
  SKYQUILT_TRY_ASSIGN(const geo::MapProjection zone, geo::MapProjection::OfEpsg(epsg_));
  const auto place_at = [&](int column, int row) -> std::optional<geo::LatLon> {
    const auto place = theirs.LatLonOf(cells.corner_in_zone_m +
                                       Eigen::Vector2d(column, -row).cwiseProduct(cells.sides_in_zone_m));
    if (!place) return std::nullopt;
    return geo::LatLonFromMerc(geo::MercFromLatLon(*place) - moved_by_merc_m);
  };
  const std::optional<PlacesInZone> places = PlacesInZone::Of(cells.columns, cells.rows, place_at, zone);
  if (places) return Sample(*places);
  return SampledHeights{std::vector<float>(cells.heights_m.size(), kNoHeight),
                        std::vector<std::uint8_t>(cells.heights_m.size(), 0)};
}

Result<std::vector<float>> HeightRaster::GoingOnOver(const MercGrid& grid) {
  SKYQUILT_TRY(CheckSize(grid));
  const QuietGdal quiet;
  SKYQUILT_TRY_ASSIGN(const geo::MapProjection zone, geo::MapProjection::OfEpsg(epsg_));
  const std::optional<PlacesInZone> places = PlacesInZone::Of(grid, zone);
  if (!places) return std::vector<float>(CellCount(grid.width_px, grid.height_px), sketch_.heights_m.front());
  SKYQUILT_TRY_ASSIGN(SampledHeights sampled, Sample(*places));
  const HeightWindow all{0, 0, sketch_.columns, sketch_.rows};
  for (int row = 0; row < grid.height_px; ++row) {
    for (int column = 0; column < grid.width_px; ++column) {
      float& height_m = sampled.heights_m[CellCount(grid.width_px, row) + static_cast<std::size_t>(column)];
      if (std::isfinite(height_m)) continue;
      const Eigen::Vector2d cell = CellOf(places->At(column, row));
      const Eigen::Vector2d on_sketch(
          std::clamp(cell.x() / columns_ * sketch_.columns, 0.5, sketch_.columns - 0.5),
          std::clamp(cell.y() / rows_ * sketch_.rows, 0.5, sketch_.rows - 0.5));
      height_m = Between(sketch_.heights_m, all, on_sketch);
    }
  }
  return std::move(sampled.heights_m);
}

HeightRaster::RingsInCells HeightRaster::RingsOf(const geo::Boundary& area,
                                                 const geo::MapProjection& zone) const {
  RingsInCells rings;
  for (const geo::Boundary::Polygon& polygon : geo::CutTo(GoingOnAs(around_, area), around_).polygons) {
    std::vector<geo::RingEdge>& edges = rings.polygons.emplace_back();
    for (const geo::Boundary::Ring& ring : polygon) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const auto from = zone.PlaceOf(ring[i]), to = zone.PlaceOf(ring[(i + 1) % ring.size()]);
        if (!from || !to) continue;
        const Eigen::Vector2d a = CellOf(*from), b = CellOf(*to);
        edges.push_back({a.x(), a.y(), b.x(), b.y()});
        rings.bounds.Include(a);
        rings.length += (b - a).norm();
      }
    }
  }
  return rings;
}

double HeightRaster::GroundCellM(const Eigen::Vector2d& cell, const geo::MapProjection& zone) const {
  constexpr double kHalf = 50.0;  // of a square of cells about it
  std::vector<geo::LatLon> square;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(-kHalf, -kHalf), Eigen::Vector2d(kHalf, -kHalf),
                                        Eigen::Vector2d(kHalf, kHalf), Eigen::Vector2d(-kHalf, kHalf)}) {
    const Eigen::Vector2d at = cell + corner;
    const auto place = zone.LatLonOf({west_m_ + cell_m_ * at.x(), north_m_ - cell_m_ * at.y()});
    if (place) square.push_back(*place);
  }
  return square.size() == 4 ? std::sqrt(geo::GeodesicAreaM2(square)) / (2.0 * kHalf) : cell_m_;
}

Result<std::optional<HeightCells>> HeightRaster::Within(const geo::Boundary& area) {
  const QuietGdal quiet;
  SKYQUILT_TRY_ASSIGN(const geo::MapProjection zone, geo::MapProjection::OfEpsg(epsg_));
  RingsInCells rings = RingsOf(area, zone);
  const auto clipped = [](double place, int count) {
    return static_cast<int>(std::clamp(place, 0.0, static_cast<double>(count)));
  };
  if (!rings.bounds.Intersects({{0.0, 0.0}, {columns_, rows_}})) return std::optional<HeightCells>();
  // With a cell more on all sides, for heights along the edge.
  HeightWindow window{clipped(std::floor(rings.bounds.min.x()) - 1.0, columns_),
                      clipped(std::floor(rings.bounds.min.y()) - 1.0, rows_), 0, 0};
  window.columns = clipped(std::ceil(rings.bounds.max.x()) + 1.0, columns_) - window.left;
  window.rows = clipped(std::ceil(rings.bounds.max.y()) + 1.0, rows_) - window.top;
  if (window.columns <= 0 || window.rows <= 0) return std::optional<HeightCells>();
  const double all = static_cast<double>(CellCount(window.columns, window.rows));
  const double step = std::max(1.0, std::ceil(std::sqrt(all / kMaxCells)));
  HeightCells cells;
  cells.columns = static_cast<int>(std::ceil(window.columns / step));
  cells.rows = static_cast<int>(std::ceil(window.rows / step));
  const double across = static_cast<double>(window.columns) / cells.columns,
               down = static_cast<double>(window.rows) / cells.rows;
  const Eigen::Vector2d corner(window.left, window.top);
  cells.cell_m = std::sqrt(across * down) *
                 GroundCellM(corner + 0.5 * Eigen::Vector2d(window.columns, window.rows), zone);
  cells.epsg = epsg_;
  cells.corner_in_zone_m = {west_m_ + cell_m_ * window.left, north_m_ - cell_m_ * window.top};
  cells.sides_in_zone_m = cell_m_ * Eigen::Vector2d(across, down);
  cells.heights_m.resize(CellCount(cells.columns, cells.rows));
  cells.is_measured.resize(cells.heights_m.size());
  cells.is_inside.assign(cells.heights_m.size(), 0);
  SKYQUILT_TRY_ASSIGN(OpenGeotiff heights, heights_.Take());
  SKYQUILT_TRY_ASSIGN(OpenGeotiff measured, measured_.Take());
  if (!ReadWindow(*heights->GetRasterBand(1), window, cells.columns, cells.rows, cells.heights_m.data(),
                  GDT_Float32, step > 1.0 ? GRIORA_Average : GRIORA_NearestNeighbour))
    return heights_.Damaged("some of its cells are damaged");
  if (!ReadWindow(*measured->GetRasterBand(1), window, cells.columns, cells.rows, cells.is_measured.data(),
                  GDT_Byte, GRIORA_NearestNeighbour))
    return measured_.Damaged("some of its cells are damaged");
  heights_.Give(std::move(heights));
  measured_.Give(std::move(measured));
  const double apart = std::max(1.0, rings.length / step / kMaxEdgePlaces);
  for (std::vector<geo::RingEdge>& edges : rings.polygons) {
    for (geo::RingEdge& edge : edges) {
      edge = {(edge.x0 - corner.x()) / across, (edge.y0 - corner.y()) / down, (edge.x1 - corner.x()) / across,
              (edge.y1 - corner.y()) / down};
      AddHeightsAlong(edge, apart, cells);
    }
    geo::MaskRings(edges,
                   {0.0, 0.0, static_cast<std::size_t>(cells.columns), static_cast<std::size_t>(cells.rows)},
                   cells.is_inside);
  }
  return std::optional(std::move(cells));
}

}  // namespace skyquilt::storage
