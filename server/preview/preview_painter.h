// PreviewPainter: draws photos of one flight into its preview as they arrive: by recorded poses, coarse.
// Decodes what others uploaded, so it runs in a sandboxed process (server/preview/preview_sandboxed.h); it
// writes the tiles and knows no catalogue. Photos without a position take no part (a log may place them
// later, in the map), nor does what is no photo. Blocking; one thread.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "core/alignment/scene/aligned_flight.h"
#include "core/base/result.h"
#include "core/flight/photo.h"
#include "server/jobs/child_messages.h"

namespace skyquilt::server {

class PreviewPainter {
 public:
  // `begin_photo` is told the stored name of each photo before anything is done with it.
  PreviewPainter(std::filesystem::path files_dir, std::filesystem::path folder,
                 std::function<void(const std::string&)> begin_photo)
      : files_dir_(std::move(files_dir)), folder_(std::move(folder)), begin_photo_(std::move(begin_photo)) {}

  // Errors are the machine's (kOutOfSpace, kUnavailable, kIo): a photo that cannot be drawn is passed over;
  // one that the disk did not give is tried again with the next ones.
  Result<PreviewDrawn> Draw(const PreviewRequest& request);

 private:
  void Remember(const PreviewRequest& request);
  Result<flight::Photo> Read(const storage::StoredFile& file) const;
  Result<std::optional<storage::Preview>> DrawWaiting(std::optional<storage::Preview> preview);

  std::filesystem::path files_dir_;
  std::filesystem::path folder_;
  std::function<void(const std::string&)> begin_photo_;
  // What is known of the flight's photos, by the names of their files.
  std::map<std::string, flight::Photo> photos_;
  std::set<std::string> waiting_;  // to be drawn when more is known, or when they can be read
};

}  // namespace skyquilt::server
