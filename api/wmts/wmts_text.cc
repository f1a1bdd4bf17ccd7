#include "api/wmts/wmts_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <vector>

#include "api/indices/index_legend.h"
#include "api/tiles/recode_tile.h"
#include "api/views/feature_info.h"
#include "core/base/text/xml_text.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_format.h"
#include "core/indices/spectral_index.h"

namespace skyquilt::api {
namespace {

std::string WmtsOperation(const char* name,
                          const std::vector<std::pair<std::string, const char*>>& addresses) {
  std::string gets;
  for (const auto& [href, encoding] : addresses) {
    gets += fmt::format(
        R"(<ows:Get xlink:href="{}"><ows:Constraint name="GetEncoding">)"
        R"(<ows:AllowedValues><ows:Value>{}</ows:Value></ows:AllowedValues></ows:Constraint></ows:Get>)",
        XmlText(href), encoding);
  }
  return fmt::format(
      "    <ows:Operation name=\"{}\"><ows:DCP><ows:HTTP>{}</ows:HTTP></ows:DCP></ows:Operation>\n", name,
      gets);
}

struct TileType {
  std::string type;
  std::string ending;
};
// Programs take the first. That is what is stored, where all tiles are of one format; maps of JPEG have PNG
// at their fringe, and a JPEG there would be black where nothing was seen: of them PNG comes first.
std::vector<TileType> TypesOf(const TileFacts& tiles) {
  std::vector<TileType> types;
  for (const image::PictureFormatRow& row : image::kPictureFormats)
    types.push_back({row.content_type, std::string(".") + row.extension});
  if (tiles.is_webp) {
    const auto webp = std::find_if(types.begin(), types.end(), [](const TileType& type) {
      return type.type == image::ContentTypeOf(image::PictureFormat::kWebp);
    });
    std::rotate(types.begin(), webp, webp + 1);
  } else {
    types.push_back({kStoredTileType, ""});
  }
  return types;
}

std::string LimitsText(int level, std::int64_t min_row, std::int64_t max_row, std::int64_t min_column,
                       std::int64_t max_column) {
  return fmt::format(
      "        <TileMatrixLimits><TileMatrix>{}</TileMatrix>"
      "<MinTileRow>{}</MinTileRow><MaxTileRow>{}</MaxTileRow>"
      "<MinTileCol>{}</MinTileCol><MaxTileCol>{}</MaxTileCol></TileMatrixLimits>\n",
      level, min_row, max_row, min_column, max_column);
}

// Empty: the map has no tiles in it.
std::string GridLink(const MapGrid& grid, const storage::Revision& revision, int stored_size_px) {
  std::string limits;
  for (const GridMatrix& matrix : MatricesOf(grid, revision, stored_size_px)) {
    limits += LimitsText(matrix.level, matrix.min_row, matrix.max_row, matrix.min_column, matrix.max_column);
  }
  if (limits.empty()) return limits;
  return fmt::format(
      "      <TileMatrixSetLink><TileMatrixSet>{}</TileMatrixSet><TileMatrixSetLimits>\n{}"
      "      </TileMatrixSetLimits></TileMatrixSetLink>\n",
      grid.name(), limits);
}

std::string WmtsLayer(const ListedMaps& listed, const ListedMap& map) {
  const storage::Revision& revision = map.shown.revision;
  const auto& [west, south, east, north] = revision.bounds;
  std::string text = fmt::format(
      R"(    <Layer>
      <ows:Title>{0}</ows:Title>
      <ows:WGS84BoundingBox>
        <ows:LowerCorner>{1:.9f} {2:.9f}</ows:LowerCorner><ows:UpperCorner>{3:.9f} {4:.9f}</ows:UpperCorner>
      </ows:WGS84BoundingBox>
      <ows:Identifier>{5}</ows:Identifier>
      <Style isDefault="true"><ows:Identifier>default</ows:Identifier></Style>
)",
      XmlText(map.shown.name), west, south, east, north, map.layer);
  for (const indices::SpectralIndex* index : indices::IndicesOf(map.tiles.bands)) {
    text += fmt::format(
        "      <Style><ows:Title>{}</ows:Title><ows:Identifier>{}</ows:Identifier>"
        "<LegendURL format=\"image/png\" width=\"{}\" height=\"{}\" xlink:href=\"{}\"/></Style>\n",
        index->title, index->name, kLegendWidthPx, kLegendHeightPx,
        XmlText(listed.Link(LegendPath(map.shown.flight_id, index->name))));
  }
  const std::vector<TileType> types = TypesOf(map.tiles);
  for (const TileType& type : types) text += fmt::format("      <Format>{}</Format>\n", type.type);
  for (const char* type : kInfoFormats) text += fmt::format("      <InfoFormat>{}</InfoFormat>\n", type);
  for (const int side_px : TileSizesOf(map.tiles.side_px)) {
    text += fmt::format("      <TileMatrixSetLink><TileMatrixSet>{}</TileMatrixSet><TileMatrixSetLimits>\n",
                        MatrixSetName(side_px));
    for (const TileMatrix& matrix : MatricesOf(revision, map.tiles.side_px, side_px)) {
      text += LimitsText(matrix.zoom, matrix.min_row, matrix.max_row, matrix.min_column, matrix.max_column);
    }
    text += "      </TileMatrixSetLimits></TileMatrixSetLink>\n";
  }
  for (const MapGrid& grid : GridsOf(revision)) text += GridLink(grid, revision, map.tiles.side_px);
  for (const auto& [type, ending] : types) {
    // Tiles have the address of their own map's service also in the document of all.
    const std::string path =
        fmt::format("/wmts/{}/map/{{Style}}/{{TileMatrixSet}}/{{TileMatrix}}/{{TileRow}}/{{TileCol}}{}",
                    map.shown.flight_id, ending);
    text += fmt::format("      <ResourceURL format=\"{}\" resourceType=\"tile\" template=\"{}\"/>\n", type,
                        XmlText(listed.Link(path)));
  }
  return text + "    </Layer>\n";
}

// The zooms that tiles of each size are listed of.
struct Zooms {
  int first = 0;
  int last = 0;
};
std::map<int, Zooms> ZoomsOf(const ListedMaps& listed) {
  std::map<int, Zooms> zooms;
  for (const ListedMap& map : listed.maps) {
    for (const int side_px : TileSizesOf(map.tiles.side_px)) {
      const int depth = CutDepth(side_px, map.tiles.side_px).value_or(0);
      const Zooms own{map.shown.revision.min_zoom + depth, map.shown.revision.max_zoom + depth};
      Zooms& all = zooms.try_emplace(side_px, own).first->second;
      all = {std::min(all.first, own.first), std::max(all.last, own.last)};
    }
  }
  return zooms;
}

// The levels of each grid that maps are listed in.
std::map<std::string, Zooms> LevelsOf(const ListedMaps& listed) {
  std::map<std::string, Zooms> levels;
  for (const ListedMap& map : listed.maps) {
    for (const MapGrid& grid : GridsOf(map.shown.revision)) {
      const std::vector<GridMatrix> matrices = MatricesOf(grid, map.shown.revision, map.tiles.side_px);
      if (matrices.empty()) continue;
      const Zooms own{matrices.front().level, matrices.back().level};
      Zooms& all = levels.try_emplace(grid.name(), own).first->second;
      all = {std::min(all.first, own.first), std::max(all.last, own.last)};
    }
  }
  return levels;
}

std::string WmtsGrid(const MapGrid& grid, const Zooms& levels) {
  std::string text = fmt::format(
      R"(    <TileMatrixSet>
      <ows:Identifier>{}</ows:Identifier>
      <ows:SupportedCRS>{}</ows:SupportedCRS>
)",
      grid.name(), grid.crs_urn());
  if (*grid.scale_set() != '\0') {
    text += fmt::format("      <WellKnownScaleSet>urn:ogc:def:wkss:OGC:1.0:{}</WellKnownScaleSet>\n",
                        grid.scale_set());
  }
  const Eigen::Vector2d corner = grid.UpperLeft();
  for (int level = levels.first; level <= levels.last; ++level) {
    text += fmt::format(
        "      <TileMatrix><ows:Identifier>{0}</ows:Identifier><ScaleDenominator>{1:.12f}</ScaleDenominator>"
        "<TopLeftCorner>{2:.15g} {3:.15g}</TopLeftCorner><TileWidth>{4}</TileWidth><TileHeight>{4}</TileHeight>"
        "<MatrixWidth>{5}</MatrixWidth><MatrixHeight>{6}</MatrixHeight></TileMatrix>\n",
        level, grid.ScaleDenominator(level), corner.x(), corner.y(), MapGrid::kTilePx, grid.Columns(level),
        grid.Rows(level));
  }
  return text + "    </TileMatrixSet>\n";
}

std::string WmtsMatrixSet(int side_px, const Zooms& zooms) {
  std::string text = fmt::format(
      R"(    <TileMatrixSet>
      <ows:Identifier>{}</ows:Identifier>
      <ows:SupportedCRS>urn:ogc:def:crs:EPSG::3857</ows:SupportedCRS>
)",
      MatrixSetName(side_px));
  if (side_px == kUsualTilePx) {
    text += "      <WellKnownScaleSet>urn:ogc:def:wkss:OGC:1.0:GoogleMapsCompatible</WellKnownScaleSet>\n";
  }
  for (int zoom = zooms.first; zoom <= zooms.last; ++zoom) {
    text += fmt::format(
        "      <TileMatrix><ows:Identifier>{0}</ows:Identifier><ScaleDenominator>{1:.12f}</ScaleDenominator>"
        "<TopLeftCorner>-{2:.9f} "
        "{2:.9f}</TopLeftCorner><TileWidth>{3}</TileWidth><TileHeight>{3}</TileHeight>"
        "<MatrixWidth>{4}</MatrixWidth><MatrixHeight>{4}</MatrixHeight></TileMatrix>\n",
        zoom, geo::PixelSizeInMercM(zoom, side_px) / kOgcPixelM, geo::kMercHalfWidthM, side_px,
        std::uint64_t{1} << zoom);
  }
  return text + "    </TileMatrixSet>\n";
}

}  // namespace

std::string WmtsCapabilities(const ListedMaps& listed) {
  const std::string at = "/wmts" + listed.path;
  const std::string rest = listed.Link(at + "/1.0.0/WMTSCapabilities.xml");
  const std::string kvp = listed.Link(at) + (listed.token.empty() ? "?" : "&");
  std::vector<std::pair<std::string, const char*>> tiles = {{kvp, "KVP"}};
  if (!listed.path.empty()) {
    const std::string set = MatrixSetName(TileSizesOf(listed.maps.front().tiles.side_px).front());
    tiles.emplace_back(listed.Link(at + "/map/default/" + set + "/"), "RESTful");
  }
  std::string layers, sets;
  for (const ListedMap& map : listed.maps) layers += WmtsLayer(listed, map);
  for (const auto& [side_px, zooms] : ZoomsOf(listed)) sets += WmtsMatrixSet(side_px, zooms);
  for (const auto& [name, levels] : LevelsOf(listed)) {
    if (const std::optional<MapGrid> grid = MapGrid::Named(name)) sets += WmtsGrid(*grid, levels);
  }
  return fmt::format(
             R"(<Capabilities version="1.0.0" xmlns="http://www.opengis.net/wmts/1.0"
  xmlns:ows="http://www.opengis.net/ows/1.1" xmlns:xlink="http://www.w3.org/1999/xlink"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="http://www.opengis.net/wmts/1.0
  http://schemas.opengis.net/wmts/1.0/wmtsGetCapabilities_response.xsd">
  <ows:ServiceIdentification>
    <ows:Title>{}</ows:Title>{}
    <ows:ServiceType>OGC WMTS</ows:ServiceType>
    <ows:ServiceTypeVersion>1.0.0</ows:ServiceTypeVersion>
  </ows:ServiceIdentification>
  <ows:ServiceProvider>
    <ows:ProviderName>Skyquilt</ows:ProviderName><ows:ServiceContact/>
  </ows:ServiceProvider>
  <ows:OperationsMetadata>
)",
             XmlText(listed.title),
             listed.next_cursor ? "<ows:Abstract>" + XmlText(listed.Note()) + "</ows:Abstract>" : "") +
         WmtsOperation("GetCapabilities", {{kvp, "KVP"}, {rest, "RESTful"}}) +
         WmtsOperation("GetTile", tiles) + WmtsOperation("GetFeatureInfo", {{kvp, "KVP"}}) +
         "  </ows:OperationsMetadata>\n  <Contents>\n" + layers + sets + "  </Contents>\n" +
         fmt::format("  <ServiceMetadataURL xlink:href=\"{}\"/>\n</Capabilities>\n", XmlText(rest));
}

}  // namespace skyquilt::api
