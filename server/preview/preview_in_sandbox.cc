// The sandboxed side of SandboxedPreview.
#include <chrono>
#include <cstdlib>
#include <optional>
#include <string>

#include "core/base/process/late_library.h"
#include "core/base/try.h"
#include "server/preview/preview_painter.h"
#include "server/preview/preview_sandboxed.h"
#include "server/sandbox/process_limits.h"
#include "server/sandbox/sandbox.h"

namespace skyquilt::server {
namespace {

constexpr std::chrono::minutes kPlacePatience{1};
constexpr std::chrono::hours kRequestPatience{24};

PreviewMessage Answer(PreviewPainter& painter, const std::string& text) {
  SKYQUILT_TRY_ASSIGN(const PreviewRequest request, ParseRequest(text));
  SKYQUILT_TRY_ASSIGN(PreviewDrawn drawn, painter.Draw(request));
  return drawn;
}

}  // namespace

int PreviewInSandbox(int parent) {
  auto writer = MeetParent(parent);
  if (!writer) return 1;
  MessageReader reader = ParentsMessages();
  const std::optional<std::string> place_text = reader.Read(kPlacePatience);
  if (!place_text) return 1;
  const Result<PreviewPlace> place = ParsePlace(*place_text);
  if (!place) return 1;
  setenv("SQLITE_TMPDIR", place->folder.c_str(), 1);
  const Result<void> confined = [&]() -> Result<void> {
    SKYQUILT_TRY(LoadLate());
    LimitThisProcess({.more_memory_bytes = place->memory_bytes});
    return Confine({.reads = {place->files_dir}, .writes = {place->folder}});
  }();
  if (!confined) {
    writer->Write(ToText(PreviewMessage(confined.error())));
    return 1;
  }
  PreviewPainter painter(place->files_dir, place->folder, [&](const std::string& stored_name) {
    writer->Write(ToText(PreviewMessage(PhotoBegun{stored_name})));
  });
  while (true) {
    const std::optional<std::string> text = reader.Read(kRequestPatience);
    if (!text) return 0;  // the parent has no more
    // Out of memory: the photo that was begun is to blame, and the parent finds it in the manner of the end.
    if (!writer->Write(ToText(Answer(painter, *text)))) return 1;
  }
}

}  // namespace skyquilt::server
