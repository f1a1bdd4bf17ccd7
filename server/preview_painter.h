// PreviewPainter: draws photos into their flights' previews as they arrive: by recorded poses, coarse.
// Decodes what others uploaded, so it belongs into a process of its own. Photos without a position take no
// part (a log may place them later, in the map), nor does what is no photo. Blocking; one thread.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "core/alignment/aligned_flight.h"
#include "core/base/result.h"
#include "core/flight/photo.h"
#include "storage/data_dir.h"
#include "storage/photo_store.h"
#include "storage/previews.h"

namespace skyquilt::server {

class PreviewPainter {
 public:
  PreviewPainter(const storage::DataDir& dir, storage::Previews& previews)
      : dir_(dir), store_(dir), previews_(previews) {}

  // Draws a few of the photos that wait. False: none waited. Errors are the machine's (kOutOfSpace,
  // kUnavailable, kIo): of a photo that cannot be drawn the log tells, and the others go on.
  Result<bool> Step();

 private:
  // What is known of a flight's photos, by the names of their files.
  struct Track {
    std::map<std::string, flight::Photo> photos;
    std::set<std::string> waiting;  // to be drawn when more is known
  };
  Track& TrackOf(const storage::PreviewWork& work);
  Result<void> Draw(const std::string& flight_id, Track& track);
  Result<storage::Preview> Begin(const std::string& flight_id) const;

  storage::DataDir dir_;
  storage::PhotoStore store_;
  storage::Previews& previews_;
  std::map<std::string, Track> tracks_;  // by flight
};

}  // namespace skyquilt::server
