// One small file of a flight that clients read and write as a whole, against its ETag: control points, notes.
// Replacing it counts towards the quota; replacing and removing fail where another replaced it meanwhile. Any
// thread. Errors: kPreconditionFailed (it was changed elsewhere), kConflict (a job reads the flight's files),
// those of the store, the catalogue and the quota.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "api/service.h"

namespace skyquilt::api {

// The file of this name, in any case, as a user may have sent it.
Result<std::optional<storage::StoredFile>> FindDocument(Service& service, const std::string& flight_id,
                                                        std::string_view name);

// Runs `read` with that file. One that is replaced between being found and being read is gone: what is in its
// place is read then.
Result<void> ReadDocument(Service& service, const std::string& flight_id, std::string_view name,
                          const std::function<Result<void>(const std::optional<storage::StoredFile>&)>& read);

// "none" in quotes where there is no file.
std::string EtagOfDocument(const std::string& stored_name);
std::string EtagOfDocument(const std::optional<storage::StoredFile>& file);

// How a write says what it replaces. No header: whatever is there.
struct WantedDocument {
  std::optional<std::string> stored_name;  // what has to be there still; empty text: nothing
};
Result<WantedDocument> CheckIfMatch(const Request& request, const std::optional<storage::StoredFile>& known,
                                    const char* refusal);

// Keeps `text` in place of `known`, under its name or, where there was none, under `name`. `check` is asked
// with the stored name before the flight has it; what it refuses is not kept. The new file's stored name.
Result<std::string> ReplaceDocument(Service& service, const std::string& flight_id,
                                    const std::optional<storage::StoredFile>& known, const char* name,
                                    const WantedDocument& wanted, const std::string& text,
                                    const std::function<Result<void>(const std::string& stored_name)>& check);

Result<void> RemoveDocument(Service& service, const std::string& flight_id,
                            const std::optional<storage::StoredFile>& known, const WantedDocument& wanted);

}  // namespace skyquilt::api
