// Overviews: parents from children still in memory. Blocks arrive along a quadtree curve, so at most one
// unfinished parent per level is held, and of it what is not empty: memory does not grow with the map, nor
// with the levels above the one where it all fits in a tile. One thread.
#pragma once

#include <functional>
#include <vector>

#include "core/geo/tile_id.h"
#include "core/pyramid/tile_image.h"

namespace skyquilt::pyramid {

class OverviewBuilder {
 public:
  using Emit = std::function<void(const geo::TileId&, const image::RgbaImage&)>;
  using Reduce = std::function<image::RgbaImage(const image::RgbaImage&)>;
  // Emits every tile from first_zoom - 1 down to min_zoom, each once, when its last child has come. `reduce`
  // makes half the size of a tile.
  OverviewBuilder(int first_zoom, int min_zoom, int tile_size_px, Emit emit, Reduce reduce = Halve);

  // A finished tile of first_zoom. All tiles below one parent must come one after the other.
  void Add(const geo::TileId& tile, const image::RgbaImage& image) { AddHalf(tile, reduce_(image)); }
  // The same, already at half its size.
  void AddHalf(const geo::TileId& tile, const image::RgbaImage& half);
  // No more tiles: closes the parents still open.
  void Finish();

 private:
  struct Quarter {  // of a parent, from a pixel on
    int x = 0, y = 0;
    image::RgbaImage image;
  };
  struct OpenParent {
    bool is_open = false;
    geo::TileId tile;
    std::vector<Quarter> quarters;
  };
  void AddTo(int parent_zoom, const geo::TileId& child, const image::RgbaImage& child_half);
  void Close(int zoom);

  const int first_zoom_;
  const int min_zoom_;
  const int tile_size_px_;
  const Emit emit_;
  const Reduce reduce_;
  std::vector<OpenParent> open_;  // by zoom
};

}  // namespace skyquilt::pyramid
