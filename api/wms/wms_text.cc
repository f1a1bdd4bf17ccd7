#include "api/wms/wms_text.h"

#include <fmt/format.h>

#include "api/indices/index_legend.h"
#include "api/ogc/feature_info.h"
#include "api/wms/wms_request.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_format.h"
#include "core/indices/spectral_index.h"

namespace skyquilt::api {
namespace {

std::string BoxesText(const geo::LatLonBounds& bounds, bool is_newer) {
  const auto& [west, south, east, north] = bounds;
  const auto [low, high] = geo::MercFromLatLonBounds(bounds);
  const char* crs = is_newer ? "CRS" : "SRS";
  std::string boxes =
      is_newer ? fmt::format(
                     "<EX_GeographicBoundingBox>"
                     "<westBoundLongitude>{:.9f}</westBoundLongitude>"
                     "<eastBoundLongitude>{:.9f}</eastBoundLongitude>"
                     "<southBoundLatitude>{:.9f}</southBoundLatitude>"
                     "<northBoundLatitude>{:.9f}</northBoundLatitude>"
                     "</EX_GeographicBoundingBox>",
                     west, east, south, north)
               : fmt::format(
                     "<LatLonBoundingBox minx=\"{:.9f}\" miny=\"{:.9f}\" maxx=\"{:.9f}\" maxy=\"{:.9f}\"/>",
                     west, south, east, north);
  boxes += fmt::format(
      "<BoundingBox {}=\"EPSG:3857\" minx=\"{:.4f}\" miny=\"{:.4f}\" maxx=\"{:.4f}\" maxy=\"{:.4f}\"/>", crs,
      low.x(), low.y(), high.x(), high.y());
  // 1.3.0 has latitude first where EPSG says so.
  boxes += fmt::format(
      "<BoundingBox {}=\"EPSG:4326\" minx=\"{:.9f}\" miny=\"{:.9f}\" maxx=\"{:.9f}\" maxy=\"{:.9f}\"/>", crs,
      is_newer ? south : west, is_newer ? west : south, is_newer ? north : east, is_newer ? east : north);
  return boxes;
}

// The map itself, and the indices that its bands are enough for.
std::string StylesText(const ListedMaps& listed, const ListedMap& map) {
  std::string text = "<Style><Name>default</Name><Title>The map</Title></Style>";
  for (const indices::SpectralIndex* index : indices::IndicesOf(map.tiles.bands)) {
    text += fmt::format(
        R"(<Style><Name>{}</Name><Title>{}</Title><LegendURL width="{}" height="{}"><Format>image/png</Format>)"
        R"(<OnlineResource xmlns:xlink="http://www.w3.org/1999/xlink" xlink:type="simple" xlink:href="{}"/>)"
        R"(</LegendURL></Style>)",
        index->name, index->title, kLegendWidthPx, kLegendHeightPx,
        XmlText(listed.Link(LegendPath(map.shown.flight_id, index->name))));
  }
  return text;
}

// What all maps lie within; the world where there is none.
geo::LatLonBounds WholeOf(const ListedMaps& listed) {
  if (listed.maps.empty()) return {-180.0, -85.0, 180.0, 85.0};
  geo::LatLonBounds whole = listed.maps.front().shown.revision.bounds;
  for (const ListedMap& map : listed.maps) whole.Include(map.shown.revision.bounds);
  return whole;
}

}  // namespace

std::string WmsCapabilities(const ListedMaps& listed, bool is_newer) {
  const std::string href = XmlText(listed.Link("/wms" + listed.path) + (listed.token.empty() ? "?" : "&"));
  const std::string http = fmt::format(
      R"(<DCPType><HTTP><Get>)"
      R"(<OnlineResource xmlns:xlink="http://www.w3.org/1999/xlink" xlink:type="simple" xlink:href="{}"/>)"
      R"(</Get></HTTP></DCPType>)",
      href);
  const std::string root = is_newer
                               ? R"(<WMS_Capabilities version="1.3.0" xmlns="http://www.opengis.net/wms" )"
                                 R"(xmlns:sld="http://www.opengis.net/sld" )"
                                 R"(xmlns:xlink="http://www.w3.org/1999/xlink">)"
                               : R"(<WMT_MS_Capabilities version="1.1.1">)";
  std::string map_formats, info_formats;
  for (const image::PictureFormatRow& row : image::kPictureFormats)
    map_formats += fmt::format("<Format>{}</Format>", row.content_type);
  for (const char* type : kInfoFormats) info_formats += fmt::format("<Format>{}</Format>", type);
  std::string layers;
  for (const ListedMap& map : listed.maps) {
    layers += fmt::format(
        "<Layer queryable=\"1\" opaque=\"0\"><Name>{}</Name><Title>{}</Title>{}{}</Layer>\n", map.layer,
        XmlText(map.shown.name), BoxesText(map.shown.revision.bounds, is_newer), StylesText(listed, map));
  }
  return fmt::format(
      R"({0}
<Service><Name>{1}</Name><Title>{2}</Title>{13}
<OnlineResource xmlns:xlink="http://www.w3.org/1999/xlink" xlink:href="{3}"/>{4}</Service>
<Capability><Request>
<GetCapabilities><Format>{5}</Format>{6}</GetCapabilities>
<GetMap>{16}{6}</GetMap>
<GetFeatureInfo>{14}{6}</GetFeatureInfo>
<{15}><Format>image/png</Format><Format>image/svg+xml</Format>{6}</{15}>
</Request><Exception><Format>{7}</Format></Exception>
<Layer><Title>{2}</Title><{8}>EPSG:3857</{8}><{8}>EPSG:4326</{8}>{9}{10}
{11}</Layer>
</Capability>
{12}
)",
      root, is_newer ? "WMS" : "OGC:WMS", XmlText(listed.title), href,
      is_newer ? fmt::format("<LayerLimit>{0}</LayerLimit><MaxWidth>{1}</MaxWidth><MaxHeight>{1}</MaxHeight>",
                             listed.path.empty() ? kMaxWmsLayers : 1, kMaxWmsSidePx)
               : "",
      is_newer ? "text/xml" : "application/vnd.ogc.wms_xml", http,
      is_newer ? "XML" : "application/vnd.ogc.se_xml", is_newer ? "CRS" : "SRS",
      is_newer ? "<CRS>CRS:84</CRS>" : "", BoxesText(WholeOf(listed), is_newer), layers,
      is_newer ? "</WMS_Capabilities>" : "</WMT_MS_Capabilities>",
      listed.next_cursor ? "<Abstract>" + XmlText(listed.Note()) + "</Abstract>" : "", info_formats,
      is_newer ? "sld:GetLegendGraphic" : "GetLegendGraphic", map_formats);
}

}  // namespace skyquilt::api
