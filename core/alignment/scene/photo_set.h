// PhotoSet: which photos of a flight, by their numbers, are in a set. A value; any thread.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace skyquilt::alignment {

class PhotoSet {
 public:
  PhotoSet() = default;  // tells of no photos
  explicit PhotoSet(std::size_t photos, bool all = false) : is_in_(photos, all) {}

  std::size_t Photos() const { return is_in_.size(); }  // that it tells of: those in the set and the others
  int Count() const { return static_cast<int>(std::count(is_in_.begin(), is_in_.end(), true)); }
  bool Has(std::integral auto photo) const { return is_in_[photo] != 0; }

  void Add(std::integral auto photo) { is_in_[photo] = true; }
  void Remove(std::integral auto photo) { is_in_[photo] = false; }
  void Append(bool is_in) { is_in_.push_back(is_in); }  // tells of one photo more, the next

 private:
  std::vector<std::uint8_t> is_in_;  // by photo
};

}  // namespace skyquilt::alignment
