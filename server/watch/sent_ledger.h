// SentLedger: what was sent to one server, by the content of the files, so that a card put in twice, a
// restart or a kill makes nothing twice. One file of JSON lines that is only added to, fsynced before what it
// promises is done; processes on one machine share it (flock). A torn last line is passed over. One thread
// per object. Errors: kIo, kOutOfSpace, kCorrupt (a file that is no such ledger).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/base/digest.h"
#include "core/base/process/file_descriptor.h"
#include "core/base/result.h"

namespace skyquilt::server {

struct SentFlight {
  std::string key;   // by which requests sent again are known to be the same
  std::string name;  // of the flight
  std::string id;    // on the server; empty while it was not made
  bool is_gone = false;
  std::map<Digest, std::string> files;  // with the names under which they are sent
  std::map<Digest, bool> sent;
};

class SentLedger {
 public:
  // The file is made, with its folder, where it is missing.
  static Result<SentLedger> Open(const std::filesystem::path& file);
  SentLedger(SentLedger&&) = default;
  SentLedger& operator=(SentLedger&&) = delete;
  SentLedger(const SentLedger&) = delete;

  // Takes in what other processes wrote.
  Result<void> Refresh();
  // Whether a flight that is there has it, or one that was deleted since.
  bool IsSent(const Digest& digest) const;
  // The one begun last, of those not gone, with any of these files; null: none has.
  const SentFlight* Find(const std::vector<Digest>& digests) const;
  const SentFlight& At(const std::string& key) const { return flights_.at(key); }

  Result<void> Begin(const std::string& key, const std::string& name);
  Result<void> WillSend(const std::string& key, const std::map<Digest, std::string>& files);
  Result<void> Made(const std::string& key, const std::string& id);
  Result<void> Sent(const std::string& key, const std::vector<Digest>& digests);
  Result<void> Gone(const std::string& key);

 private:
  SentLedger(std::filesystem::path path, FileDescriptor file)
      : path_(std::move(path)), file_(std::move(file)) {}
  // A line of a flight, while no other process writes.
  Result<void> Tell(const std::string& key, const char* what, nlohmann::json value);
  Result<void> Append(const std::string& line);
  void Apply(const std::string& line);

  std::filesystem::path path_;
  FileDescriptor file_;
  std::uint64_t read_bytes_ = 0;
  std::string begun_line_;  // of which the end was not read yet
  std::map<std::string, SentFlight> flights_;
  std::vector<std::string> order_;
  std::map<Digest, std::string> last_with_;  // the flight begun last with a file
};

std::string HexOf(const Digest& digest);

}  // namespace skyquilt::server
