// ReadAgain: what is known already is read again in a thread of its own, so that whoever asks waits for a
// database that does not answer only once, and goes on with what it knows: a frozen server holds a connection
// for as long as it likes. Reads of one key are made once for all who ask at the same time. Any thread; the
// end waits for the read that is under way. Errors: those of the read; kUnavailable (it is not known yet).
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/base/result.h"

namespace skyquilt::storage {

class ReadAgain {
 public:
  using Read = std::function<Result<void>()>;

  explicit ReadAgain(std::chrono::milliseconds patience = std::chrono::seconds(2)) : patience_(patience) {}
  ~ReadAgain();
  ReadAgain(const ReadAgain&) = delete;
  ReadAgain& operator=(const ReadAgain&) = delete;

  // How it ended; waited for no longer than the patience, and not at all while reads before are late or found
  // nobody.
  Result<void> Ask(const std::string& key, Read read);
  // The same for those who never wait: how it ended the next one learns who asks.
  void Begin(const std::string& key, Read read);
  // False: who asks now does not wait.
  bool IsWell() const;

 private:
  struct Asked {
    std::string key;
    Read read;
    std::optional<Result<void>> outcome;
  };
  void Work();
  // With the mutex held.
  std::shared_ptr<Asked> Enter(const std::string& key, Read read);

  const std::chrono::milliseconds patience_;
  mutable std::mutex mutex_;
  std::condition_variable asked_, done_;
  std::deque<std::shared_ptr<Asked>> waiting_;
  std::map<std::string, std::shared_ptr<Asked>> open_;  // waiting or under way
  bool is_well_ = true;
  bool is_ended_ = false;
  std::thread thread_;  // from the first read on
};

}  // namespace skyquilt::storage
