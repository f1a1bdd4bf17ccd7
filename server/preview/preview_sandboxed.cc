#include "server/preview/preview_sandboxed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/base/try.h"
#include "server/preview/preview_painter.h"
#include "server/routing/request_log.h"
#include "server/sandbox/sandbox.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;
using storage::Preview;
using storage::StoredFile;

constexpr int kPhotosAtOnce = 3;
constexpr std::size_t kMaxSessions = 4;
constexpr std::chrono::seconds kIdle{20};
constexpr std::chrono::milliseconds kPreviewPollInterval{50};
// A process that waits for the disk takes no processor time; on a machine with other work to do it gets a
// share.
constexpr double kWallPerCpu = 5.0;

bool Has(const std::vector<StoredFile>& files, const std::string& stored_name) {
  return std::any_of(files.begin(), files.end(),
                     [&](const StoredFile& file) { return file.stored_name == stored_name; });
}

}  // namespace

class SandboxedPreview::Session {
 public:
  Session(std::unique_ptr<SandboxedChild> child, fs::path folder, bool is_shown)
      : child_(std::move(child)), folder_(std::move(folder)), is_shown_(is_shown) {}
  ~Session() {
    child_->Kill();
    std::error_code ignored;  // what stays is swept at the next start
    if (!is_shown_) fs::remove_all(folder_, ignored);
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  SandboxedChild& child() { return *child_; }
  std::string folder() const { return folder_.filename().string(); }
  bool is_shown() const { return is_shown_; }
  void SetShown(bool is_shown) { is_shown_ = is_shown; }
  Clock::time_point used = Clock::now();

 private:
  std::unique_ptr<SandboxedChild> child_;
  fs::path folder_;
  bool is_shown_;
};

SandboxedPreview::SandboxedPreview(const storage::DataDir& dir, storage::BlobStore& blobs,
                                   storage::Previews& previews, const PhotoLimits& limits,
                                   const std::atomic<bool>& is_stopping)
    : dir_(dir), blobs_(blobs), previews_(previews), limits_(limits), is_stopping_(is_stopping) {}
SandboxedPreview::~SandboxedPreview() = default;

void SandboxedPreview::EndIdle() {
  const auto oldest = [&] {
    return std::min_element(sessions_.begin(), sessions_.end(),
                            [](const auto& a, const auto& b) { return a.second->used < b.second->used; });
  };
  while (!sessions_.empty()) {
    const auto session = oldest();
    if (sessions_.size() < kMaxSessions && Clock::now() - session->second->used < kIdle) return;
    sessions_.erase(session);
  }
}

Result<SandboxedPreview::Session*> SandboxedPreview::SessionOf(const std::string& flight_id,
                                                               const std::optional<Preview>& preview) {
  const auto found = sessions_.find(flight_id);
  if (found != sessions_.end()) {
    Session& session = *found->second;
    session.used = Clock::now();
    const bool is_its = preview && session.folder() == preview->folder;
    if (is_its && !session.child().is_silent()) return &session;
    session.SetShown(is_its);  // begun anew since, after a photo was taken out
    sessions_.erase(found);
  }
  EndIdle();
  const fs::path folder = dir_.Flight(flight_id) / (preview ? preview->folder : storage::NewPreviewFolder());
  std::error_code error;
  // Of a flight that lies elsewhere there may be nothing here yet; else one without a folder is gone.
  if (blobs_.IsFolder()) {
    fs::create_directory(folder, error);
  } else {
    fs::create_directories(folder, error);
  }
  if (error == std::errc::no_such_file_or_directory)
    return Error{ErrorCode::kNotFound, "The folder of a flight is gone.", folder.string()};
  if (error) return storage::FileError("cannot make", folder, error.value());
  const PreviewPlace place{blobs_.FolderOf(storage::FilesPrefix(flight_id)), folder, limits_.memory_bytes};
  Result<std::unique_ptr<SandboxedChild>> child =
      SandboxedChild::Start("preview-sandboxed", ToText(place), [this] { return !is_stopping_; });
  if (!child) {
    if (!preview) fs::remove(folder, error);
    return child.error();
  }
  auto session = std::make_unique<Session>(*std::move(child), folder, preview.has_value());
  return (sessions_[flight_id] = std::move(session)).get();
}

Result<std::vector<storage::LocalBlob>> SandboxedPreview::Fetch(const std::string& flight_id,
                                                                const PreviewRequest& request) {
  std::vector<storage::LocalBlob> photos;
  if (blobs_.IsFolder()) return photos;
  for (const auto* files : {&request.fresh, &request.tried}) {
    for (const StoredFile& file : *files) {
      Result<storage::LocalBlob> photo = blobs_.Local(storage::FilesPrefix(flight_id) + file.stored_name);
      // One that is gone was taken out a moment ago; whoever draws finds no such file.
      if (!photo && photo.error().code == ErrorCode::kNotFound) continue;
      if (!photo) return photo.error();
      photos.push_back(*std::move(photo));
    }
  }
  return photos;
}

SandboxedPreview::Answer SandboxedPreview::Exchange(Session& session, const PreviewRequest& request) const {
  SandboxedChild& child = session.child();
  Answer answer;
  if (!child.Tell(ToText(request))) {
    answer.why = "its process does not listen";
    return answer;
  }
  // Each photo is read once and drawn once: who begins more is at none of them, and has no time of its own.
  std::size_t may_begin = 2 * (request.fresh.size() + request.tried.size());
  double cpu_before_s = child.CpuS();
  auto began = Clock::now();
  while (!child.is_silent()) {
    if (is_stopping_) return answer;
    if (child.MemoryBytes() > limits_.memory_bytes) {
      answer.why = fmt::format("it takes more than {} MiB of memory", limits_.memory_bytes >> 20);
      return answer;
    }
    const std::chrono::duration<double> wall = Clock::now() - began;
    if (child.CpuS() - cpu_before_s > limits_.cpu_s || wall.count() > kWallPerCpu * limits_.cpu_s) {
      answer.why = fmt::format("it takes more than {:.0f} seconds of processor time", limits_.cpu_s);
      return answer;
    }
    const std::optional<std::string> text = child.Listen(kPreviewPollInterval);
    if (!text) continue;
    Result<PreviewMessage> message = ParsePreviewMessage(*text);
    if (!message) {
      answer.why = message.error().message + " " + message.error().detail;
      return answer;
    }
    if (const auto* begun = std::get_if<PhotoBegun>(&*message)) {
      if (!Has(request.fresh, begun->stored_name) && !Has(request.tried, begun->stored_name)) {
        answer.why = "it speaks of a photo that is none of its";
        return answer;
      }
      answer.culprit = begun->stored_name;
      if (may_begin-- == 0) {
        answer.why = "it begins photos without end";
        return answer;
      }
      cpu_before_s = child.CpuS();
      began = Clock::now();
    } else if (auto* drawn = std::get_if<PreviewDrawn>(&*message)) {
      answer.drawn = std::move(*drawn);
      return answer;
    } else {
      const Error& error = std::get<Error>(*message);
      return {{}, "", error.message + " " + error.detail, error.code};
    }
  }
  answer.why = "its decoder ended " + HowItEnded(child.Kill().wait_status);
  return answer;
}

Result<void> SandboxedPreview::Show(const storage::PreviewWork& work, const PreviewRequest& request,
                                    const PreviewDrawn& drawn) {
  std::vector<StoredFile> without_part;
  for (const StoredFile& file : request.fresh) {
    if (std::find(drawn.forgone.begin(), drawn.forgone.end(), file.stored_name) != drawn.forgone.end())
      without_part.push_back(file);
  }
  if (!without_part.empty()) {
    if (auto forgone = previews_.Forgo(without_part); !forgone) return forgone;
  }
  const auto session = sessions_.find(work.flight_id);
  if (!drawn.preview) {
    // No preview yet, so no folder; what is known of the photos is read again when there are more.
    if (!session->second->is_shown()) sessions_.erase(session);
    return {};
  }
  Preview preview = *drawn.preview;
  preview.flight_id = work.flight_id;
  preview.folder = session->second->folder();
  preview.edition = request.preview ? request.preview->edition + 1 : 1;
  SKYQUILT_TRY_ASSIGN(const bool shown, previews_.Show(preview));
  session->second->SetShown(shown);
  // The map came first, or a photo was taken out: what was drawn is nobody's now.
  if (!shown) sessions_.erase(session);
  return {};
}

Result<bool> SandboxedPreview::Step() {
  // The catalogue may lie on the disk that was full.
  if (!owed_.empty()) {
    SKYQUILT_TRY(previews_.GiveBack(owed_));
    owed_.clear();
  }
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::PreviewWork> claimed, previews_.Claim(kPhotosAtOnce));
  if (!claimed) {
    std::erase_if(sessions_, [](const auto& one) { return Clock::now() - one.second->used > kIdle; });
    return false;
  }
  PreviewRequest request{claimed->fresh, claimed->tried, std::nullopt};
  const Result<void> drawn = DrawClaimed(*claimed, request);
  if (drawn) return true;
  // What befalls all flights (a full disk, a store that is away) is no fault of these photos: they are drawn
  // once it has passed. For trouble of this flight alone the others would wait for ever.
  const ErrorCode code = drawn.error().code;
  if (code == ErrorCode::kOutOfSpace || code == ErrorCode::kUnavailable) {
    owed_ = std::move(request.fresh);
    if (previews_.GiveBack(owed_)) owed_.clear();
  }
  return drawn.error();
}

Result<void> SandboxedPreview::DrawClaimed(const storage::PreviewWork& work, PreviewRequest& request) {
  bool may_retry = true;
  while (true) {
    SKYQUILT_TRY_ASSIGN(std::optional<Preview> preview, previews_.Find(work.flight_id));
    request.preview = std::move(preview);
    SKYQUILT_TRY_ASSIGN(const std::vector<storage::LocalBlob> photos, Fetch(work.flight_id, request));
    SKYQUILT_TRY_ASSIGN(Session* const session, SessionOf(work.flight_id, request.preview));
    Answer answer = Exchange(*session, request);
    if (answer.drawn) return Show(work, request, *answer.drawn);
    sessions_.erase(work.flight_id);
    if (is_stopping_) return previews_.GiveBack(request.fresh);
    if (answer.culprit.empty()) {
      // No photo is to blame: killed from outside while it waited, or the disk is full.
      if (std::exchange(may_retry, false)) continue;
      return Error{answer.code, "A preview could not be drawn.", answer.why};
    }
    // Passed over for good: no later process reads it again.
    const auto is_it = [&](const StoredFile& file) { return file.stored_name == answer.culprit; };
    std::vector<StoredFile> culprit;
    std::copy_if(request.fresh.begin(), request.fresh.end(), std::back_inserter(culprit), is_it);
    std::copy_if(request.tried.begin(), request.tried.end(), std::back_inserter(culprit), is_it);
    SKYQUILT_TRY(previews_.Forgo(culprit));
    LogEvent(fmt::format("{} is not in the preview: {}", culprit.front().name, answer.why));
    for (std::vector<StoredFile>* files : {&request.fresh, &request.tried}) std::erase_if(*files, is_it);
    if (request.fresh.empty()) return {};
  }
}

// What such a process does.
namespace {

constexpr std::chrono::hours kRequestPatience{24};

PreviewMessage Answer(PreviewPainter& painter, const std::string& text) {
  SKYQUILT_TRY_ASSIGN(const PreviewRequest request, ParseRequest(text));
  SKYQUILT_TRY_ASSIGN(PreviewDrawn drawn, painter.Draw(request));
  return drawn;
}

}  // namespace

int PreviewInSandbox(int parent) {
  return WorkForParent(
      parent, [](const std::string& task, MessageReader& from_parent, MessageWriter& to_parent) {
        const Result<PreviewPlace> place = ParsePlace(task);
        if (!place) return 1;
        setenv("SQLITE_TMPDIR", place->folder.c_str(), 1);
        const Result<void> confined =
            EnterSandbox({.limits = {.more_memory_bytes = place->memory_bytes},
                          .files = {.reads = {place->files_dir}, .writes = {place->folder}}});
        if (!confined) {
          to_parent.Write(ToText(PreviewMessage(confined.error())));
          return 1;
        }
        PreviewPainter painter(place->files_dir, place->folder, [&](const std::string& stored_name) {
          to_parent.Write(ToText(PreviewMessage(PhotoBegun{stored_name})));
        });
        while (const std::optional<std::string> text = from_parent.Read(kRequestPatience)) {
          // Out of memory: the photo that was begun is to blame, and the parent finds it in the manner of the
          // end.
          if (!to_parent.Write(ToText(Answer(painter, *text)))) return 1;
        }
        return 0;  // the parent has no more
      });
}

}  // namespace skyquilt::server
