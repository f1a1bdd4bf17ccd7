// The messages between the process that manages previews and the sandboxed one that draws them, as JSON
// texts: one PreviewPlace, then PreviewRequests; of the answers only values that are possible for photos are
// accepted. Pure. Error: kUnprocessable.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/base/result.h"
#include "storage/catalogue/previews.h"

namespace skyquilt::server {

// Of one flight, for the life of the process.
struct PreviewPlace {
  std::filesystem::path files_dir;  // of the flight
  std::filesystem::path folder;     // of its preview; is there
  std::int64_t memory_bytes = 0;    // address space beyond the program's own
};

struct PreviewRequest {
  std::vector<storage::StoredFile> fresh;   // to be drawn
  std::vector<storage::StoredFile> tried;   // before them: they say which way the flight goes
  std::optional<storage::Preview> preview;  // as far as it is
};

// The process begins to work on a photo: whatever happens to it until it says more is that photo's doing.
struct PhotoBegun {
  std::string stored_name;
};
struct PreviewDrawn {
  std::optional<storage::Preview> preview;  // what it is now; nothing: it did not change
  std::vector<std::string> forgone;         // stored names of those that have no part in it
};
using PreviewMessage = std::variant<PhotoBegun, PreviewDrawn, Error>;

std::string ToText(const PreviewPlace& place);
Result<PreviewPlace> ParsePlace(std::string_view text);
std::string ToText(const PreviewRequest& request);
Result<PreviewRequest> ParseRequest(std::string_view text);
std::string ToText(const PreviewMessage& message);
Result<PreviewMessage> ParsePreviewMessage(std::string_view text);

}  // namespace skyquilt::server
