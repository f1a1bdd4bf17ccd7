// The two files of a map in its folder (tiles, and the state that remembers what they were made from), under
// the names of a finished map, of a run, and of what a killed run left. Any thread; one run a folder.
#pragma once

#include <filesystem>
#include <string>

namespace skyquilt::storage {

struct MapFiles {
  std::filesystem::path tiles, state;
};

MapFiles FinishedMap(const std::filesystem::path& folder);
MapFiles TemporaryMap(const std::filesystem::path& folder);
MapFiles LeftOverMap(const std::filesystem::path& folder);

// SQLite's journal beside a file.
std::string JournalOf(const std::filesystem::path& file);

// With their journals.
void RemoveMap(const MapFiles& files);

// What a killed run left gets out of the way of this one's temporary files. Of several killed runs the last
// one that had got somewhere counts: it took over what the one before had.
void SetMapAside(const std::filesystem::path& folder);

}  // namespace skyquilt::storage
