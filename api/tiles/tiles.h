// Tiles of the map that a flight shows and of the layers beside it: XYZ images with content-hash ETags.
#pragma once

#include <optional>
#include <string>

#include "api/common/index_look.h"
#include "api/http/http_message.h"
#include "api/service.h"
#include "core/geo/tile_id.h"
#include "core/image/picture_format.h"
#include "core/render/map_layer.h"

namespace skyquilt::api {

enum class EmptyTile { kBlank, kNoContent, kNotFound };

// The answer to a tile request, for every kind of address.
struct TileRequest {
  std::string flight_id;
  std::optional<render::MapLayer> layer;  // beside the map; absent: the map itself
  geo::TileId tile;
  std::optional<image::PictureFormat> format;  // absent: as stored
  bool is_double = false;                      // twice the side, for dense screens
  std::optional<int>
      side_px;  // of a tiling with tiles of that side; absent, or 256 where there are none: as stored
  EmptyTile empty = EmptyTile::kBlank;  // where the map has nothing, unless ?empty= says
  bool is_of_world = false;             // of a tiling of the whole world: nothing lies outside it
  bool is_of_any_zoom = false;          // also of zooms that the map does not have, drawn from its nearest
  std::optional<IndexLook> look;        // an index in colours; absent: the map as it is
};
// Where the fringe is stored as WebP and no format is asked for, who does not name it in Accept gets PNG.
Result<Response> AnswerTile(Service& service, const Request& request, const TileRequest& wanted);
// Says once that another Accept may have another answer.
void TellByAccept(Response& answer);

// An address without a revision means the map, or the preview while there is no map; one with a revision
// always means that one, so that nobody gets tiles of both.
bool ShowsPreview(Service& service, const Request& request, const std::string& flight_id);
inline constexpr int kPreviewTileSizePx = 256;

// The side of a tileset's tiles, from its metadata; 256 where it does not say.
int TileSizePx(const storage::Tileset& tileset);
// The tileset of a layer. kNotFound: no such layer, or the map was made without it.
Result<std::shared_ptr<storage::MapTiles>> FindLayer(const storage::Tileset& tileset, render::MapLayer layer);
Result<render::MapLayer> ParseLayer(std::string_view name);

}  // namespace skyquilt::api
