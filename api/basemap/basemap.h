// The basemap that the operator chose for the page: tiles of another server by their address, or a PMTiles
// file of this one, or a public one by its name. GET /basemap.json says which, as TileJSON; without a choice
// it has no tiles. Any thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "api/http/router.h"
#include "core/base/result.h"

namespace skyquilt::api {

struct Basemap {
  std::string tiles;              // "https://host/{z}/{x}/{y}.png"; or:
  std::filesystem::path pmtiles;  // of raster tiles
  std::string attribution;        // plain text, never markup: whom the page names beside the map
  int max_zoom = 0;               // of `tiles`; 0: not known
  // "https://host" of `tiles`, for the page's Content-Security-Policy; empty without.
  std::string Origin() const;
};

// Public basemaps that are known by name, with their makers. Each has terms of use that an operator must
// read.
std::vector<std::string> BasemapNames();

// `text`: one of these names, an address with {z}, {x} and {y}, or a path. Errors: kInvalidArgument,
// kNotFound.
Result<Basemap> BasemapFrom(const std::string& text, const std::string& attribution);

void AddBasemapRoutes(Router& router, const Basemap& basemap);

}  // namespace skyquilt::api
