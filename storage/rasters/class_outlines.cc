#include "storage/rasters/class_outlines.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal_alg.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {
namespace {

using GdalFile = std::unique_ptr<GDALDataset>;

constexpr int kEdgesConnect = 4;  // corners do not

Error OutlineFailure(const char* what) {
  return {ErrorCode::kInternal, fmt::format("The zones cannot be outlined: {}.", what), CPLGetLastErrorMsg()};
}

GdalFile CreateIn(const char* driver_name, const std::string& path, int width, int height, int bands) {
  GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName(driver_name);
  if (driver == nullptr) return nullptr;
  return GdalFile(driver->Create(path.c_str(), width, height, bands, GDT_Byte, nullptr));
}

Result<GdalFile> AsRaster(const ClassGrid& grid) {
  const MercGrid& place = grid.grid;
  GdalFile raster = CreateIn("MEM", "", place.width_px, place.height_px, 1);
  if (!raster) return OutlineFailure("there is no memory");
  std::array<double, 6> transform = {place.west_m, place.pixel_width_m,  0.0, place.north_m,
                                     0.0,          -place.pixel_height_m};
  raster->SetGeoTransform(transform.data());
  auto* const cells = const_cast<std::uint8_t*>(grid.classes.data());  // GDAL reads them only
  if (raster->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, place.width_px, place.height_px, cells,
                                         place.width_px, place.height_px, GDT_Byte, 0, 0, nullptr) != CE_None)
    return OutlineFailure("the cells cannot be kept");
  return raster;
}

// A file in memory under a name of its own, gone at the end of the scope.
class MemoryFile {
 public:
  explicit MemoryFile(const char* ending) {
    static std::atomic<std::uint64_t> count = 0;
    path_ = fmt::format("/vsimem/zones-{}{}", ++count, ending);
  }
  ~MemoryFile() { VSIUnlink(path_.c_str()); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  const std::string& path() const { return path_; }
  std::string Bytes() const {
    vsi_l_offset length = 0;
    const GByte* const bytes = VSIGetMemFileBuffer(path_.c_str(), &length, FALSE);
    return bytes == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(bytes), length);
  }

 private:
  std::string path_;
};

// A part of the grid, and how far it moves to lie within the web map's square.
struct GridPart {
  ClassGrid cells;
  double east_by_m = 0.0;
};

ClassGrid ColumnsOf(const ClassGrid& grid, int from, int to) {
  const MercGrid& all = grid.grid;
  ClassGrid part{all, {}};
  part.grid.west_m += from * all.pixel_width_m;
  part.grid.width_px = to - from;
  for (int row = 0; row < all.height_px; ++row) {
    const auto first = grid.classes.begin() + static_cast<std::ptrdiff_t>(row) * all.width_px;
    part.classes.insert(part.classes.end(), first + from, first + to);
  }
  return part;
}

// Of a map across the antimeridian both sides of it; a column that it goes through belongs to both.
std::vector<GridPart> PartsOf(const ClassGrid& grid) {
  constexpr double kOnEdge = 1e-6;  // of a cell
  const double line = (geo::kMercHalfWidthM - grid.grid.west_m) / grid.grid.pixel_width_m;
  if (line + kOnEdge >= grid.grid.width_px) return {{grid, 0.0}};
  const auto west_end = static_cast<int>(std::ceil(line - kOnEdge)),
             east_begin = static_cast<int>(std::floor(line + kOnEdge));
  return {{ColumnsOf(grid, 0, west_end), 0.0},
          {ColumnsOf(grid, east_begin, grid.grid.width_px), -2.0 * geo::kMercHalfWidthM}};
}

void BringInside(OGRPolygon& polygon, double east_by_m) {
  for (OGRLinearRing* ring : polygon) {
    for (int i = 0; i < ring->getNumPoints(); ++i) {
      const double x = ring->getX(i) + east_by_m;
      ring->setPoint(i, std::clamp(x, -geo::kMercHalfWidthM, geo::kMercHalfWidthM), ring->getY(i));
    }
  }
}

// To each class the polygons of its cells, in Web Mercator.
Result<void> AddPolygonsOf(const GridPart& part, std::vector<OGRMultiPolygon>& polygons) {
  SKYQUILT_TRY_ASSIGN(const GdalFile raster, AsRaster(part.cells));
  const GdalFile shapes = CreateIn("Memory", "", 0, 0, 0);
  OGRLayer* const layer = shapes ? shapes->CreateLayer("zones", nullptr, wkbPolygon, nullptr) : nullptr;
  OGRFieldDefn field("zone", OFTInteger);
  if (layer == nullptr || layer->CreateField(&field) != OGRERR_NONE)
    return OutlineFailure("there is no memory");
  GDALRasterBandH band = GDALRasterBand::ToHandle(raster->GetRasterBand(1));
  // The cells of class 0 are their own mask.
  if (GDALPolygonize(band, band, OGRLayer::ToHandle(layer), 0, nullptr, nullptr, nullptr) != CE_None)
    return OutlineFailure("their edges cannot be followed");
  if (layer->GetFeatureCount() > kMaxParts)
    return Error{ErrorCode::kUnprocessable,
                 fmt::format("The zones have {} separate parts; the most are {}. Ask for larger cells "
                             "(resolution_m) or fewer classes.",
                             layer->GetFeatureCount(), kMaxParts),
                 ""};
  for (const auto& feature : *layer) {
    const int zone = feature->GetFieldAsInteger(0);
    if (zone < 1 || static_cast<std::size_t>(zone) > polygons.size()) continue;
    OGRPolygon* const polygon = feature->StealGeometry()->toPolygon();
    BringInside(*polygon, part.east_by_m);
    polygons[static_cast<std::size_t>(zone) - 1].addGeometryDirectly(polygon);
  }
  return {};
}

Result<void> FillLayer(OGRLayer& layer, std::vector<OGRMultiPolygon>& polygons,
                       std::span<const ClassFacts> facts, OGRCoordinateTransformation& to_degrees) {
  OGRFieldDefn zone_field("zone", OFTInteger);
  if (layer.CreateField(&zone_field) != OGRERR_NONE) return OutlineFailure("a field cannot be made");
  for (const char* name : {"min", "max", "mean", "area_m2"}) {
    OGRFieldDefn field(name, OFTReal);
    field.SetWidth(18);
    field.SetPrecision(6);
    if (layer.CreateField(&field) != OGRERR_NONE) return OutlineFailure("a field cannot be made");
  }
  for (std::size_t i = 0; i < polygons.size(); ++i) {
    if (polygons[i].IsEmpty()) continue;
    if (polygons[i].transform(&to_degrees) != OGRERR_NONE) return OutlineFailure("they lie nowhere");
    OGRFeature feature(layer.GetLayerDefn());
    feature.SetField("zone", static_cast<int>(i) + 1);
    feature.SetField("min", facts[i].min);
    feature.SetField("max", facts[i].max);
    feature.SetField("mean", facts[i].mean);
    feature.SetField("area_m2", facts[i].area_m2);
    feature.SetGeometry(&polygons[i]);
    if (layer.CreateFeature(&feature) != OGRERR_NONE) return OutlineFailure("a zone cannot be written");
  }
  return {};
}

}  // namespace

Result<void> SieveClasses(ClassGrid& grid, int min_cells) {
  RegisterGdalOnce();
  const QuietGdal quiet;
  SKYQUILT_TRY_ASSIGN(const GdalFile raster, AsRaster(grid));
  GDALRasterBandH band = GDALRasterBand::ToHandle(raster->GetRasterBand(1));
  if (GDALSieveFilter(band, band, band, min_cells, kEdgesConnect, nullptr, nullptr, nullptr) != CE_None)
    return OutlineFailure("small patches cannot be joined");
  if (raster->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, grid.grid.width_px, grid.grid.height_px,
                                         grid.classes.data(), grid.grid.width_px, grid.grid.height_px,
                                         GDT_Byte, 0, 0, nullptr) != CE_None)
    return OutlineFailure("the cells cannot be read");
  return {};
}

Result<std::string> OutlineClasses(const ClassGrid& grid, std::span<const ClassFacts> facts,
                                   OutlineFormat format) {
  RegisterGdalOnce();
  const QuietGdal quiet;
  std::vector<OGRMultiPolygon> polygons(facts.size());
  for (const GridPart& part : PartsOf(grid)) SKYQUILT_TRY(AddPolygonsOf(part, polygons));
  OGRSpatialReference merc, degrees;
  merc.importFromEPSG(3857);
  degrees.importFromEPSG(4326);
  degrees.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> to_degrees(
      OGRCreateCoordinateTransformation(&merc, &degrees));
  if (!to_degrees) return OutlineFailure("PROJ has no way from Web Mercator to degrees");
  const bool is_shapefile = format == OutlineFormat::kShapefile;
  const MemoryFile file(is_shapefile ? ".shz" : ".geojson");
  GdalFile written = CreateIn(is_shapefile ? "ESRI Shapefile" : "GeoJSON", file.path(), 0, 0, 0);
  CPLStringList options;
  if (!is_shapefile) options.SetNameValue("RFC7946", "YES");
  if (!is_shapefile) options.SetNameValue("COORDINATE_PRECISION", "8");
  OGRLayer* const layer =
      written ? written->CreateLayer("zones", &degrees, is_shapefile ? wkbPolygon : wkbMultiPolygon,
                                     options.List())
              : nullptr;
  if (layer == nullptr) return OutlineFailure("no file can be made");
  SKYQUILT_TRY(FillLayer(*layer, polygons, facts, *to_degrees));
  if (!IsClosedWell(std::move(written))) return OutlineFailure("the file cannot be finished");
  return file.Bytes();
}

}  // namespace skyquilt::storage
