// LruMemory: values by name within a bound of memory; those that were used least recently go. Values are
// immutable and shared: who has one keeps it. Any thread.
#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>

namespace skyquilt::storage {

template <typename Value>
class LruMemory {
 public:
  explicit LruMemory(std::size_t budget_bytes) : budget_bytes_(budget_bytes) {}
  // Before the first use.
  void SetBudget(std::size_t bytes) { budget_bytes_ = bytes; }
  std::size_t budget_bytes() const { return budget_bytes_; }

  // Null where it is not here.
  std::shared_ptr<const Value> Find(const std::string& name) {
    const std::lock_guard lock(mutex_);
    const auto found = by_name_.find(name);
    if (found == by_name_.end()) return nullptr;
    used_.splice(used_.begin(), used_, found->second);
    return found->second->value;
  }

  bool Has(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    return by_name_.contains(name);
  }

  // `bytes`: what the value takes.
  void Keep(const std::string& name, std::shared_ptr<const Value> value, std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (by_name_.contains(name)) return;
    bytes_ += bytes;
    used_.push_front({name, std::move(value), bytes});
    by_name_[name] = used_.begin();
    while (bytes_ > budget_bytes_ && used_.size() > 1) {
      bytes_ -= used_.back().bytes;
      by_name_.erase(used_.back().name);
      used_.pop_back();
    }
  }

  std::size_t bytes() const {
    const std::lock_guard lock(mutex_);
    return bytes_;
  }
  std::size_t count() const {
    const std::lock_guard lock(mutex_);
    return used_.size();
  }

 private:
  struct Entry {
    std::string name;
    std::shared_ptr<const Value> value;
    std::size_t bytes;
  };

  std::size_t budget_bytes_;
  mutable std::mutex mutex_;
  std::list<Entry> used_;  // the latest first
  std::unordered_map<std::string, typename std::list<Entry>::iterator> by_name_;
  std::size_t bytes_ = 0;
};

}  // namespace skyquilt::storage
