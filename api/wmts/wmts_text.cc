#include "api/wmts/wmts_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <vector>

#include "api/ogc/feature_info.h"
#include "api/tiles/cut_tile.h"
#include "core/geo/web_mercator.h"

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
  const char* type;
  const char* extension;
};
// Programs take the first. That is what is stored, where all tiles are of one format; maps of JPEG have PNG
// at their fringe, and a JPEG there would be black where nothing was seen: of them PNG comes first.
std::vector<TileType> TypesOf(const TileFacts& tiles) {
  std::vector<TileType> types = {{"image/png", "png"}, {"image/jpeg", "jpg"}, {"image/webp", "webp"}};
  if (tiles.is_webp) std::rotate(types.begin(), types.end() - 1, types.end());
  return types;
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
  const std::vector<TileType> types = TypesOf(map.tiles);
  for (const TileType& type : types) text += fmt::format("      <Format>{}</Format>\n", type.type);
  for (const char* type : kInfoFormats) text += fmt::format("      <InfoFormat>{}</InfoFormat>\n", type);
  for (const int side_px : TileSizesOf(map.tiles.side_px)) {
    text += fmt::format("      <TileMatrixSetLink><TileMatrixSet>{}</TileMatrixSet><TileMatrixSetLimits>\n",
                        MatrixSetName(side_px));
    for (const TileMatrix& matrix : MatricesOf(revision, map.tiles.side_px, side_px)) {
      text += fmt::format(
          "        <TileMatrixLimits><TileMatrix>{}</TileMatrix>"
          "<MinTileRow>{}</MinTileRow><MaxTileRow>{}</MaxTileRow>"
          "<MinTileCol>{}</MinTileCol><MaxTileCol>{}</MaxTileCol></TileMatrixLimits>\n",
          matrix.zoom, matrix.min_row, matrix.max_row, matrix.min_column, matrix.max_column);
    }
    text += "      </TileMatrixSetLimits></TileMatrixSetLink>\n";
  }
  for (const auto& [type, extension] : types) {
    // Tiles have the address of their own map's service also in the document of all.
    const std::string path =
        fmt::format("/wmts/{}/map/{{Style}}/{{TileMatrixSet}}/{{TileMatrix}}/{{TileRow}}/{{TileCol}}.{}",
                    map.shown.flight_id, extension);
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
