#include "server/intake/verdicts.h"

#include <utility>

namespace skyquilt::server {
namespace {

// A kept answer costs more than its text.
constexpr std::size_t kOverheadBytes = 512;

Digest KeyOf(const std::vector<flight::InputFile>& files, const std::string& options) {
  Hasher hasher;
  hasher.Add(options).Add(files.size());
  for (const flight::InputFile& file : files) hasher.Add(file.name).Add(file.path.native());
  return hasher.Finish();
}

std::size_t BytesOf(const Result<std::string>& answer) {
  return kOverheadBytes +
         (answer ? answer->size() : answer.error().message.size() + answer.error().detail.size());
}

// What the machine was in the way of.
bool MayDoBetter(const Result<std::string>& answer) {
  if (answer) return false;
  const ErrorCode code = answer.error().code;
  return code == ErrorCode::kUnavailable || code == ErrorCode::kIo || code == ErrorCode::kOutOfSpace;
}

Error TooMany() {
  return {ErrorCode::kUnavailable, "The server is inspecting other flights. Ask again in a few seconds."};
}

}  // namespace

Verdicts::Verdicts(Inspect inspect, const VerdictLimits& limits)
    : inspect_(std::move(inspect)), limits_(limits) {}

Result<std::string> Verdicts::Of(const std::vector<flight::InputFile>& files, const std::string& options) {
  const Digest key = KeyOf(files, options);
  std::unique_lock lock(mutex_);
  if (const Result<std::string>* kept = Find(key)) return *kept;
  if (callers_ >= limits_.callers) return TooMany();
  ++callers_;
  struct Leave {
    int& callers;
    ~Leave() { --callers; }  // under the lock, which is older
  } const leave{callers_};
  if (running_.contains(key)) {
    one_is_done_.wait(lock, [&] { return !running_.contains(key); });
    const Result<std::string>* kept = Find(key);
    return kept == nullptr ? Result<std::string>(TooMany()) : *kept;
  }
  if (running_.size() >= static_cast<std::size_t>(limits_.at_once)) return TooMany();
  running_.insert(key);
  Result<std::string> answer = Error{};
  const auto end = [&] {
    lock.lock();
    running_.erase(key);
    one_is_done_.notify_all();
  };
  lock.unlock();
  try {
    answer = inspect_(files, options);
  } catch (...) {
    end();
    throw;  // the machine is out of something
  }
  end();
  Keep(key, answer);
  return answer;
}

const Result<std::string>* Verdicts::Find(const Digest& key) {
  const auto found = by_key_.find(key);
  if (found == by_key_.end()) return nullptr;
  const auto kept = found->second;
  if (!kept->answer && Clock::now() - kept->since > limits_.refusals_kept) {
    bytes_ -= BytesOf(kept->answer);
    kept_.erase(kept);
    by_key_.erase(found);
    return nullptr;
  }
  kept_.splice(kept_.begin(), kept_, kept);
  return &kept->answer;
}

void Verdicts::Keep(const Digest& key, const Result<std::string>& answer) {
  if (MayDoBetter(answer) || BytesOf(answer) > limits_.kept_bytes) return;
  kept_.push_front({key, answer, Clock::now()});
  by_key_[key] = kept_.begin();
  bytes_ += BytesOf(answer);
  while (bytes_ > limits_.kept_bytes) {
    bytes_ -= BytesOf(kept_.back().answer);
    by_key_.erase(kept_.back().key);
    kept_.pop_back();
  }
}

}  // namespace skyquilt::server
