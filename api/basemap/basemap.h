// What may lie below the maps on the page. The operator chooses tiles of another server by their address, a
// PMTiles file of this one, or a public one by its name; or leaves it to whoever looks: each browser is
// offered the public ones, and asks nobody before one is chosen there. GET /basemap.json says which, as
// TileJSON; without a choice of the operator's it has no tiles. Any thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::api {

struct Basemap {
  std::string tiles;              // "https://host/{z}/{x}/{y}.png"; or:
  std::filesystem::path pmtiles;  // of raster tiles
  std::string attribution;        // plain text, never markup: whom the page names beside the map
  int max_zoom = 0;               // of `tiles`; 0: not known
  bool offers_public = true;      // nobody chose, so that each browser may
  // "https://host" of all tiles that a browser may ask for, with blanks between, for the page's
  // Content-Security-Policy; empty where it asks for none.
  std::string Origins() const;
};

// Public basemaps that are known by name, with their makers. Each has terms of use that an operator must
// read.
std::vector<std::string> BasemapNames();

// `text`: one of these names, an address with {z}, {x} and {y}, a path, "none" for nothing at all, or empty.
// Errors: kInvalidArgument, kNotFound.
Result<Basemap> BasemapFrom(const std::string& text, const std::string& attribution);

}  // namespace skyquilt::api
