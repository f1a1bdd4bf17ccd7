// What somebody sends as notes, or put among a flight's files in their place; what is kept of it is read
// again as it is.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "api/notes/note_list.h"
#include "core/base/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt;
  const auto notes = api::ReadNotes({reinterpret_cast<const char*>(bytes), size});
  if (!notes) {
    SKYQUILT_CHECK(!notes.error().message.empty(), "a refusal without a word");
    return 0;
  }
  SKYQUILT_CHECK(notes->count <= api::kMaxNotes, "more notes than are taken");
  SKYQUILT_CHECK(notes->json.size() <= api::kMaxNotesBytes, "more bytes than are kept");
  const auto again = api::ReadNotes(notes->json);
  SKYQUILT_CHECK(again.ok(), "what was kept is refused");
  SKYQUILT_CHECK(again->json == notes->json && again->count == notes->count, "what was kept reads otherwise");
  return 0;
}
