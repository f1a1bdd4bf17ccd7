// Seeded random numbers whose values do not depend on the standard library's distributions (those differ
// between implementations). One stream per thread. Method: SplitMix64 (Steele, Lea, Flood
// 2014), Box-Muller.
#pragma once

#include <cmath>
#include <cstdint>

namespace skyquilt::simulate {

class RandomStream {
 public:
  // Streams of one seed with different salts are independent.
  RandomStream(std::uint64_t seed, std::uint64_t salt) : state_(seed * 0x9e3779b97f4a7c15ull ^ salt) {
    Next();
  }

  std::uint64_t Next() {
    state_ += 0x9e3779b97f4a7c15ull;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  double Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }  // [0, 1)
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  double Gauss() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
    const double angle = 6.283185307179586 * Uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

 private:
  std::uint64_t state_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

// First-order Gauss-Markov process: stationary 1-sigma and correlation time; each Step moves it on by dt_s.
class GaussMarkov {
 public:
  GaussMarkov(double sigma, double correlation_s, RandomStream& random)
      : sigma_(sigma), correlation_s_(correlation_s), value_(sigma * random.Gauss()) {}
  double value() const { return value_; }
  double Step(double dt_s, RandomStream& random) {
    const double keep = std::exp(-dt_s / correlation_s_);
    value_ = keep * value_ + sigma_ * std::sqrt(1.0 - keep * keep) * random.Gauss();
    return value_;
  }

 private:
  double sigma_, correlation_s_, value_;
};

}  // namespace skyquilt::simulate
