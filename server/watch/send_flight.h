// SendCardFlight: what a server lacks of one flight on a card, sent and remembered, so that it is sent once
// however often this is begun: what was sent is known by its content, and requests that are sent again by
// their key. Photos that join a flight go to it and its map is made again. Blocking. Errors: those of
// UploadFlight; kIo also where the card went away.
#pragma once

#include <string>

#include "core/base/result.h"
#include "server/client/server_client.h"
#include "server/watch/card_flights.h"
#include "server/watch/sent_ledger.h"

namespace skyquilt::server {

struct SendOptions {
  ClientSettings server;
  std::string name_prefix;
  bool makes_map = true;
};

struct SentNow {
  std::string flight_id;  // empty: nothing was to be sent
  int files = 0;
  bool is_new = false;  // the flight was made for it
};

Result<SentNow> SendCardFlight(const CardFlight& flight, CardFiles& card, SentLedger& ledger,
                               const SendOptions& options, Progress& progress);

}  // namespace skyquilt::server
