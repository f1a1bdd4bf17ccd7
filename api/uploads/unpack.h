// Replaces an uploaded archive by the files in it. Every upload route calls it with what it has stored. Any
// thread.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "api/json/json_codec.h"
#include "api/service.h"

namespace skyquilt::api {

// One outcome a file: the file itself, or those of the archive that it was. Errors: those of the store and of
// UnpackArchive, kTooLarge (beyond its owner's quota); then the archive is gone too.
Result<std::vector<FileOutcome>> UnpackStored(Service& service, const std::string& flight_id,
                                              const storage::StoredFile& file);

// The same for requests of one file. Also kUnprocessable, with the first reason, where an archive has files
// and none of them was taken.
Result<std::vector<FileOutcome>> UnpackOnly(Service& service, const std::string& flight_id,
                                            const storage::StoredFile& file);

// An archive that is still there when a server starts, as no request leaves it: one died while it unpacked
// it.
struct CutOffArchive {
  std::string flight_id;
  storage::StoredFile file;
};

// Before requests come, and where no other server may be at them; none of flights in the trash. Errors: those
// of the catalogue.
Result<std::vector<CutOffArchive>> FindCutOff(Service& service);

// What is in it comes in, but for what came before; how many files. It is there still, and stays where it
// cannot be unpacked. Errors: as UnpackStored, kNotFound (removed meanwhile).
Result<std::size_t> UnpackCutOff(Service& service, const CutOffArchive& archive);

// When it is unpacked. Errors: kConflict (not now: a job reads the flight), those of the catalogue.
Result<void> RemoveCutOff(Service& service, const CutOffArchive& archive);

// Of two files of a flight. kNotFound: the bytes of one are lost.
Result<bool> HaveSameBytes(Service& service, const std::string& flight_id, const storage::StoredFile& one,
                           const storage::StoredFile& other);

}  // namespace skyquilt::api
