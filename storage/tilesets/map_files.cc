#include "storage/tilesets/map_files.h"

#include <system_error>
#include <utility>

namespace skyquilt::storage {

namespace fs = std::filesystem;

MapFiles FinishedMap(const fs::path& folder) { return {folder / "mosaic.mbtiles", folder / "mosaic.state"}; }
MapFiles TemporaryMap(const fs::path& folder) {
  return {folder / "mosaic.mbtiles.tmp", folder / "mosaic.state.tmp"};
}
MapFiles LeftOverMap(const fs::path& folder) {
  return {folder / "mosaic.mbtiles.part", folder / "mosaic.state.part"};
}

std::string JournalOf(const fs::path& file) { return file.string() + "-journal"; }

void RemoveMap(const MapFiles& paths) {
  std::error_code gone;  // a file that will not go is overwritten by the next run
  for (const fs::path& file : {paths.tiles, paths.state}) {
    fs::remove(file, gone);
    fs::remove(JournalOf(file), gone);
  }
}

void SetMapAside(const fs::path& folder) {
  const MapFiles from = TemporaryMap(folder), to = LeftOverMap(folder);
  std::error_code none;  // nothing left, or not to be moved: then there is nothing to go on from
  if (!fs::exists(from.state, none) || !fs::exists(from.tiles, none)) return;
  RemoveMap(to);
  for (const auto& [source, target] : {std::pair{from.tiles, to.tiles}, std::pair{from.state, to.state}}) {
    if (fs::exists(JournalOf(source), none)) fs::rename(JournalOf(source), JournalOf(target), none);
    fs::rename(source, target, none);
  }
}

}  // namespace skyquilt::storage
