// What a data folder holds of flights by itself, whatever a catalogue says: their folders, the stored files,
// the finished maps. Reads names and sizes only. Any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/catalogue/catalogue.h"
#include "storage/db/clock.h"

namespace skyquilt::storage {

struct DiskFile {
  std::string stored_name;
  std::int64_t bytes = 0;
  Time changed;
};

struct DiskFlight {
  std::string id;
  std::filesystem::path folder;
  std::vector<DiskFile> files;          // under names of ours, by name
  std::vector<std::int64_t> revisions;  // of folders with a map in them, oldest first
};

// Folders named by an id below a folder of flights, in order of their ids; links are followed.
std::vector<DiskFlight> FlightsOnDisk(const std::filesystem::path& flights_folder);
// True where there are files or maps in it.
inline bool HoldsAnything(const DiskFlight& flight) {
  return !flight.files.empty() || !flight.revisions.empty();
}

// The same of flights whose files and maps lie in blobs. Errors: those of the blobs.
Result<std::vector<DiskFlight>> FlightsInBlobs(BlobStore& blobs);

// What a finished map says of itself. Errors: kNotFound, kCorrupt (its tiles cannot be read).
Result<Revision> RevisionOnDisk(const std::filesystem::path& revision_folder, std::int64_t number);

}  // namespace skyquilt::storage
