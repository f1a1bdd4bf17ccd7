// MapKeeper: the memory of a map between runs, in a file `mosaic.state` beside `mosaic.mbtiles`: for every
// block a digest of what it was made from, and the pipeline's facts about the flight. No pixels: the tiles
// have them. A run looks for what earlier ones left: its own folder's
// temporary files (a run that was killed) and a finished map (of the same folder or of `previous`). Blocks of
// the same digest are copied tile by tile, so their bytes and entity tags stay. Everything is checked to be
// there before it is believed; what is not is rendered anew.
//
// The file is SQLite: blocks(zoom, column, row, levels, digest, tiles, base_tiles, covered_pixels, west,
// south, east, north), rows from the north, bounds in EPSG:3857 metres (earlier versions kept the block as a
// small picture, too, which is not read); facts(name, bytes): 'flight' (core/pipeline/report/flight_facts.h),
// 'tiles' (how many the map has: a state of another map is not believed). Deleting it costs time on the next
// run, nothing else. One thread at a time, but DigestOf. Errors: kOutOfSpace, kIo, kCorrupt.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/pyramid/map_memory.h"
#include "core/pyramid/tile_sink.h"
#include "storage/tilesets/mbtiles_writer.h"

namespace skyquilt::storage {

// What other processes made of this very map: its facts, and folders with ranges of its blocks, each as a
// keeper published it.
struct MapParts {
  std::string facts;  // empty: none
  std::vector<std::filesystem::path> folders;
};

class MapKeeper final : public pyramid::MapMemory, public pyramid::TileSink {
 public:
  // `previous`: folder of a finished map of the same flight; empty: none but what is in `folder`.
  static Result<std::unique_ptr<MapKeeper>> Create(const std::filesystem::path& folder,
                                                   const std::filesystem::path& previous,
                                                   MapParts parts = {});
  ~MapKeeper() override;
  // What the finished map in a folder remembers of its flight. Errors: kNotFound (no map, or none with a
  // memory).
  static Result<std::string> FactsOf(const std::filesystem::path& folder);
  // What the state in a folder says by itself, also where it does not fit the map beside it (or the run was
  // killed between giving the map its name and giving the state its own): enough to know whose map it is.
  // Errors: kNotFound (no state that can be read).
  static Result<std::string> StatedFacts(const std::filesystem::path& folder);

  Result<void> Put(const geo::TileId& tile, image::PictureFormat format,
                   std::span<const std::uint8_t> bytes) override;
  std::optional<Digest> DigestOf(const geo::TileId& block) const override;
  Result<pyramid::KeptBlock> Reuse(const geo::TileId& block, const Digest& digest,
                                   std::optional<int> fringe_quality) override;
  Result<void> Keep(const geo::TileId& block, const Digest& digest, const pyramid::KeptBlock& kept) override;
  const std::string& Recall() const override;
  Result<void> Remember(std::string_view facts) override;

  // Gives map and state their names; the earlier ones are gone then.
  Result<void> Publish(const TilesetMetadata& metadata);

 private:
  struct State;
  explicit MapKeeper(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace skyquilt::storage
