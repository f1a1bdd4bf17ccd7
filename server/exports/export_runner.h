// ExportRunner: makes the exports that were asked for, one at a time, beside the requests: a thread of its
// own that claims them and watches over a sandboxed process each (server/exports/export_sandboxed.h). One
// whose server ends waits for the next; what was removed is stopped within a second. Owned by the main
// thread.
#pragma once

#include "api/service.h"
#include "server/background_thread.h"

namespace skyquilt::server {

class ExportRunner {
 public:
  // At its end what is under way is given back.
  explicit ExportRunner(api::Service& service);

 private:
  void Run();
  void Make(const storage::MapExport& claimed);
  Result<std::int64_t> MakeWhateverHappens(const storage::MapExport& claimed,
                                           const std::filesystem::path& staging);
  Result<std::int64_t> MakeIn(const storage::MapExport& claimed, const std::filesystem::path& staging);
  Result<void> Store(const storage::MapExport& claimed, const std::filesystem::path& made);

  api::Service& service_;
  BackgroundThread thread_;
};

// At the start of a server, before it takes requests: what ran waits again, and files that are no exports of
// the catalogue go to lost/.
Result<void> RecoverExports(api::Service& service);

}  // namespace skyquilt::server
