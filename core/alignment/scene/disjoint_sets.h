// DisjointSets: which of many numbers belong together by the pairs joined so far; the smallest stands for its
// set. One thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace skyquilt::alignment {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : up_(count) { std::iota(up_.begin(), up_.end(), 0); }
  std::size_t size() const { return up_.size(); }
  int SetOf(int number) {
    while (up_[number] != number) number = up_[number] = up_[up_[number]];
    return number;
  }
  // Two sets by what stands for them.
  void Join(int a, int b) { up_[std::max(a, b)] = std::min(a, b); }

 private:
  std::vector<int> up_;
};

}  // namespace skyquilt::alignment
