// WatchFolders: folders and cards become flights on a server as they fill, until a signal, or once. A folder
// may be missing, a disk may go away at any moment, the server may be away: all of them are waited for.
// Nothing on the folders is changed. Blocking, one per process. Errors end it: kUnauthorized,
// kInvalidArgument (no address), those of the ledger; with `once` also whatever kept a flight from being
// sent.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/flight/read_flight.h"
#include "server/watch/card_flights.h"
#include "server/watch/send_flight.h"
#include "server/watch/watch_talk.h"

namespace skyquilt::server {

struct WatchOptions {
  std::vector<std::filesystem::path> folders;
  flight::PassesOver passes_over;  // what below them is parts of maps
  std::filesystem::path ledger;
  FlightRules rules;
  SendOptions send;
  std::chrono::seconds patience{600};  // with `once`: for a server that is away
  bool once = false;
};

struct WatchEnd {
  int flights = 0, files = 0, refused = 0;
};

Result<WatchEnd> WatchFolders(const WatchOptions& options, WatchTalk& talk);

}  // namespace skyquilt::server
