// Replaces an uploaded archive by the files in it. Every upload route calls it with what it has stored. Any
// thread.
#pragma once

#include <functional>
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

// Archives that are still there, as no request leaves them: a server died while it unpacked one. At the
// start, where no other server may be at it. What cannot be unpacked stays; `tell` hears of each. Errors:
// those of the catalogue.
Result<void> UnpackCutOff(Service& service, const std::function<void(const std::string&)>& tell);

// Of two files of a flight. kNotFound: the bytes of one are lost.
Result<bool> HaveSameBytes(Service& service, const std::string& flight_id, const storage::StoredFile& one,
                           const storage::StoredFile& other);

}  // namespace skyquilt::api
