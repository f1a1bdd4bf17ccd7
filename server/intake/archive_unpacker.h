// ArchiveUnpacker: what is in the archives that a server left which died while it unpacked them comes into
// their flights, one after another, beside the requests: however large or damaged they are, no server waits
// for them at its start. What cannot be unpacked stays, and the log says why. A thread of its own. Owned by
// the main thread.
#pragma once

#include <cstddef>
#include <vector>

#include "api/service.h"
#include "api/uploads/unpack.h"
#include "server/background_thread.h"

namespace skyquilt::server {

class ArchiveUnpacker {
 public:
  // `archives`: as FindCutOff found them before requests came. At its end the next start goes on.
  ArchiveUnpacker(api::Service& service, std::vector<api::CutOffArchive> archives);

 private:
  void Run();
  bool IsUnpacked(const api::CutOffArchive& archive);
  bool IsSettled(const api::CutOffArchive& archive);
  Result<std::size_t> UnpackWhateverHappens(const api::CutOffArchive& archive);

  api::Service& service_;
  const std::vector<api::CutOffArchive> archives_;
  BackgroundThread thread_;
};

}  // namespace skyquilt::server
