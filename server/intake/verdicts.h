// Verdicts: each set of files with the same options is inspected once and the answer is kept. A request for
// what is being inspected waits for that inspection; the number of inspections and of waiting callers is
// limited, others are refused with kUnavailable. Refusals are kept for a short time only, because a busy
// machine may succeed later, and not at all where a disk was in the way. Any thread; blocking. Errors: those
// of the inspection, and kUnavailable.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "core/base/digest.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"

namespace skyquilt::server {

struct VerdictLimits {
  int at_once = 2;  // inspections
  int callers = 3;  // that are inside: they inspect or wait
  std::size_t kept_bytes = std::size_t{32} << 20;
  std::chrono::seconds refusals_kept{600};
};

class Verdicts {
 public:
  // `options`: the flight's, as JSON.
  using Inspect =
      std::function<Result<std::string>(const std::vector<flight::InputFile>&, const std::string& options)>;

  explicit Verdicts(Inspect inspect, const VerdictLimits& limits = {});

  // Files are told apart by their paths: what is stored under a path never changes.
  Result<std::string> Of(const std::vector<flight::InputFile>& files, const std::string& options);

 private:
  using Clock = std::chrono::steady_clock;
  struct Kept {
    Digest key;
    Result<std::string> answer;
    Clock::time_point since;
  };
  const Result<std::string>* Find(const Digest& key);
  void Keep(const Digest& key, const Result<std::string>& answer);

  Inspect inspect_;
  VerdictLimits limits_;
  std::mutex mutex_;
  std::condition_variable one_is_done_;
  std::set<Digest> running_;
  int callers_ = 0;
  std::list<Kept> kept_;  // the one that was asked for last comes first
  std::map<Digest, std::list<Kept>::iterator> by_key_;
  std::size_t bytes_ = 0;
};

}  // namespace skyquilt::server
