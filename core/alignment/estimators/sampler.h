// Sampler: numbers that look random and are the same on every machine and in every run, for estimators that
// try samples. One per estimate, seeded by what is estimated, so that the outcome depends on no other. Not
// for concurrent use.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace skyquilt::alignment {

class Sampler {
 public:
  explicit Sampler(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ULL + 0xD1B54A32D192ED03ULL) {}

  // Splitmix64 (G. Steele and others, OOPSLA 2014).
  std::uint64_t Next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }

  // In [0, count); count at least 1.
  int Below(int count) {
    return static_cast<int>(((Next() >> 32) * static_cast<std::uint64_t>(count)) >> 32);
  }

  // Different numbers in [0, count); count at least kSize.
  template <std::size_t kSize>
  std::array<int, kSize> Distinct(int count) {
    std::array<int, kSize> drawn{};
    for (std::size_t k = 0; k < kSize;) {
      drawn[k] = Below(count);
      bool is_new = true;
      for (std::size_t m = 0; m < k; ++m) is_new = is_new && drawn[m] != drawn[k];
      if (is_new) ++k;
    }
    return drawn;
  }

 private:
  std::uint64_t state_;
};

}  // namespace skyquilt::alignment
