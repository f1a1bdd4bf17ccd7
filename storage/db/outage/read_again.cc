#include "storage/db/outage/read_again.h"

#include <utility>

namespace skyquilt::storage {

ReadAgain::~ReadAgain() {
  {
    const std::lock_guard lock(mutex_);
    is_ended_ = true;
  }
  asked_.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool ReadAgain::IsWell() const {
  const std::lock_guard lock(mutex_);
  return is_well_;
}

std::shared_ptr<ReadAgain::Asked> ReadAgain::Enter(const std::string& key, Read read) {
  if (!thread_.joinable()) thread_ = std::thread([this] { Work(); });
  std::shared_ptr<Asked>& open = open_[key];
  if (open == nullptr) {
    open = std::make_shared<Asked>(Asked{key, std::move(read), std::nullopt});
    waiting_.push_back(open);
    asked_.notify_one();
  }
  return open;
}

void ReadAgain::Begin(const std::string& key, Read read) {
  const std::lock_guard lock(mutex_);
  Enter(key, std::move(read));
}

Result<void> ReadAgain::Ask(const std::string& key, Read read) {
  std::unique_lock lock(mutex_);
  const std::shared_ptr<Asked> mine = Enter(key, std::move(read));
  const auto patience = is_well_ ? patience_ : std::chrono::milliseconds(0);
  done_.wait_for(lock, patience, [&] { return mine->outcome.has_value(); });
  if (mine->outcome) return *mine->outcome;
  is_well_ = false;
  return Error{ErrorCode::kUnavailable, "The catalogue does not answer at the moment. Try again later.", key};
}

void ReadAgain::Work() {
  std::unique_lock lock(mutex_);
  while (true) {
    asked_.wait(lock, [this] { return is_ended_ || !waiting_.empty(); });
    if (is_ended_) return;
    const std::shared_ptr<Asked> next = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    const Result<void> outcome = next->read();
    lock.lock();
    next->outcome = outcome;
    open_.erase(next->key);
    is_well_ = outcome.ok() || outcome.error().code != ErrorCode::kUnavailable;
    done_.notify_all();
  }
}

}  // namespace skyquilt::storage
