// SandboxedPreview: draws the previews of flights that are uploading: waiting photos go to sandboxed
// processes, one per flight (server/preview/preview_painter.h), which may read that flight's photos and write
// its preview, nothing else; the rows of the catalogue are written here. A photo on which such a process
// dies, or that exceeds the limits of one photo, is skipped for good, and the others continue. Photos that
// the machine was in the way of (a full disk) wait again. Blocking; one thread, which lives as long as this.
// Errors: kOutOfSpace, kUnavailable, kIo, kNotFound (the flight is gone), kInternal (a process ended, at no
// photo).
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/jobs/child_messages.h"
#include "server/sandbox/sandboxed_child.h"
#include "storage/blobs/blob_store.h"
#include "storage/catalogue/previews.h"
#include "storage/files/data_dir.h"

namespace skyquilt::server {

// What drawing one photo may take.
struct PhotoLimits {
  double cpu_s = 60.0;
  std::int64_t memory_bytes = std::int64_t{2560} << 20;
};

class SandboxedPreview {
 public:
  // `blobs`: where the photos lie; the previews themselves are files of this machine's data folder.
  // `is_stopping` is the worker's own wish to end: photos that are not drawn by then wait again.
  SandboxedPreview(const storage::DataDir& dir, storage::BlobStore& blobs, storage::Previews& previews,
                   const PhotoLimits& limits, const std::atomic<bool>& is_stopping);
  ~SandboxedPreview();

  // Draws a few of the photos that wait. False: none waited.
  Result<bool> Step();

 private:
  using Clock = std::chrono::steady_clock;
  // The process of a flight. Its folder goes with it unless the preview in it is shown.
  class Session;
  // What became of a request.
  struct Answer {
    std::optional<PreviewDrawn> drawn;
    std::string culprit;  // stored name of the photo at which it ended; empty: at none
    std::string why;
    ErrorCode code = ErrorCode::kInternal;  // of the error, where no photo is to blame
  };
  // `request`: what was claimed; it keeps those that no answer came for.
  Result<void> DrawClaimed(const storage::PreviewWork& work, PreviewRequest& request);
  Result<Session*> SessionOf(const std::string& flight_id, const std::optional<storage::Preview>& preview);
  Answer Exchange(Session& session, const PreviewRequest& request) const;
  Result<void> Show(const storage::PreviewWork& work, const PreviewRequest& request,
                    const PreviewDrawn& drawn);
  void EndIdle();
  // The photos of a request on this machine, kept for as long as the answer lives.
  Result<std::vector<storage::LocalBlob>> Fetch(const std::string& flight_id, const PreviewRequest& request);

  storage::DataDir dir_;
  storage::BlobStore& blobs_;
  storage::Previews& previews_;
  const PhotoLimits limits_;
  const std::atomic<bool>& is_stopping_;
  std::map<std::string, std::unique_ptr<Session>> sessions_;  // by flight
  std::vector<storage::StoredFile> owed_;                     // to be given back once the catalogue can
};

// What such a process does: hears of its place and of photos on standard input, confines itself, draws, and
// tells of it on standard output. The exit code.
int PreviewInSandbox(int parent);

}  // namespace skyquilt::server
