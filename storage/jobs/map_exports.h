// MapExports: which exports of maps were asked for, who makes them, and until when they are kept. One that
// waits is claimed by one server of the catalogue, under a lease with a fencing token; the files are the
// caller's matter (ExportKey says where). Bounded: kMaxOfFlight of a flight, kMaxOpen that wait or run. A
// link to one flight (a token for it alone) has one besides, which takes no place of these, is made when no
// other waits, and goes with the link. Expiry counts by the AgeClock. Any thread, any number of processes.
// Errors: kNotFound, kConflict (the flight has too many, or the link one that is not made yet), kForbidden
// (the link has ended), kRateLimited (too many wait), kOutOfSpace, kUnavailable, kIo.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"
#include "storage/db/clock.h"

namespace skyquilt::storage {

enum class ExportState { kAccepted, kRunning, kSuccessful, kFailed };
const char* NameOf(ExportState state);

struct MapExport {
  std::string id;
  std::string flight_id;
  std::int64_t revision = 0;
  std::string request;  // JSON, as ParseExportRequest reads it
  std::string format;   // as its NameOf has it
  std::string owner;    // id of the token that asked for it
  bool is_of_link = false;
  ExportState state = ExportState::kAccepted;
  double progress = 0.0;
  int attempts = 0;
  std::int64_t lease_token = 0;
  std::int64_t bytes = 0;
  std::string error_code, error_message;  // empty unless it failed
  std::string error_reason;               // as JobError::reason
  Time created;
  std::optional<Time> finished;
  std::optional<Time> expires;  // by the AgeClock

  bool HasEnded() const { return state == ExportState::kSuccessful || state == ExportState::kFailed; }
};

class MapExports {
 public:
  static constexpr int kMaxOfFlight = 12;
  static constexpr int kMaxOpen = 200;
  static constexpr int kMaxAttempts = 2;  // that ended with their server
  static constexpr std::chrono::hours kKept{24};
  static constexpr std::chrono::seconds kLease{60};

  explicit MapExports(CatalogueDb& db) : db_(db) {}

  // The same wish for the same map again is answered with the export that is there, unless that failed; one
  // of a link becomes that of whoever asks with more rights. A link's next export takes the place of its
  // last.
  Result<MapExport> Add(const MapExport& wish, Time now);
  Result<MapExport> Get(const std::string& flight_id, const std::string& id) const;
  // Newest first.
  Result<std::vector<MapExport>> List(const std::string& flight_id) const;
  // Whoever makes it learns of it at its next heartbeat. The caller removes its file.
  Result<void> Remove(const std::string& id);

  // Something was asked for here that no claim has looked for since.
  bool HasNew() const { return has_new_; }
  // The oldest that waits, or whose server has died; those of links last. One that did not survive
  // kMaxAttempts has failed. `prints`: this server can make a report a PDF; else it leaves those to others.
  Result<std::optional<MapExport>> Claim(Time now, bool prints = true);
  // False: it was removed, or is another's by now.
  Result<bool> Heartbeat(const MapExport& claimed, double progress, Time now);
  Result<bool> Succeed(const MapExport& claimed, std::int64_t bytes, Time now);
  Result<bool> Fail(const MapExport& claimed, const Error& error, Time now);
  // The server stops: it waits again, and the attempt does not count.
  Result<bool> GiveBack(const MapExport& claimed);
  // The only server of a catalogue starts: what ran waits again.
  Result<void> TakeUpAfterRestart();
  // Of links whose time is over, as EndExportsOf.
  Result<void> EndThoseOfEndedLinks(Time now);
  // Those whose time is over.
  Result<std::vector<MapExport>> Expired() const;
  bool HasExpired(const MapExport& made) const { return made.expires && *made.expires <= db_.ages().Now(); }

 private:
  Result<std::optional<MapExport>> ClaimOnce(Time now, bool prints);
  Result<bool> End(const MapExport& claimed, ExportState state, std::int64_t bytes, const Error& error,
                   Time now);
  CatalogueDb& db_;
  std::atomic<bool> has_new_{true};
};

// The key of an export's blob, "flights/<flight>/exports/<id>.tif", and the folder of such.
std::string ExportKey(const MapExport& made);
inline constexpr const char* kExportsFolder = "exports";

}  // namespace skyquilt::storage
