// UploadFlight: files to a flight on a running server, by tus 1.0, so that a connection that breaks goes on
// where it was, and the map made of them, waited for. What is there already under the same name and size, of
// lists and the like with the same bytes, is not sent again: the same call again goes on. Blocking. Errors:
// those of ServerClient; kUnprocessable (no files; the job failed, with its reason).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "server/client/server_client.h"

namespace skyquilt::server {

struct UploadOptions {
  ClientSettings server;
  std::string name;               // of a new flight
  std::vector<std::string> tags;  // of a new flight
  bool is_kept = false;           // a new flight never goes to the trash by itself
  std::string flight_id;          // of one that is there; empty: a new one
  // JSON, of the job and of a new flight; empty: those of the flight.
  std::string job_options = {};
  // Of the files that which the job makes the map, by its name; sent under another where that is another's.
  std::string import_file = {};
  // Of the files that which takes the place of another of its name there, by its name; empty: none does.
  std::string replaced_file = {};
  bool makes_map = true;
  bool waits = true;
  // By which a flight or a job that another call asks for is known to be the same; empty: it is another.
  std::string flight_once_key, job_once_key;
};

struct UploadedFlight {
  std::string flight_id;
  std::string job_id;  // empty: none was begun
  int sent = 0, skipped = 0;
  // Lists and the like of which another lies there under their name: that, and what they are called there.
  std::vector<std::pair<std::string, std::string>> beside;
};

// `on_flight` is told the flight's id as soon as there is one: with it a broken upload is continued.
Result<UploadedFlight> UploadFlight(const std::vector<flight::InputFile>& files, const UploadOptions& options,
                                    const std::function<void(const std::string& id)>& on_flight,
                                    Progress& progress);

}  // namespace skyquilt::server
