// Chance in the simulated world: seeded streams of random numbers, whose values do not depend on the standard
// library's distributions (those differ between implementations), and hash-based value noise with band
// limits, which is texture. Noise is a pure function of its arguments, without tables and without period; all
// have the same bits on every machine. One stream per thread. Methods: SplitMix64 (Steele, Lea, Flood 2014),
// Box-Muller; lattice value noise (K. Perlin, Improving Noise, 2002, for the quintic fade), each octave
// turned so that the lattices do not line up.
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

// A well-mixed 32-bit hash of a lattice cell.
inline std::uint32_t HashCell(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  std::uint32_t h =
      static_cast<std::uint32_t>(x) * 0x8da6b343u ^ static_cast<std::uint32_t>(y) * 0xd8163841u ^ seed;
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  h ^= h >> 12;
  h *= 0x297a2d39u;
  h ^= h >> 15;
  return h;
}

// [0, 1) from a hash; `draw` picks independent numbers from one hash.
inline float Uniform(std::uint32_t hash, std::uint32_t draw) {
  std::uint32_t h = hash + 0x9e3779b9u * (draw + 1u);
  h ^= h >> 16;
  h *= 0x7feb352du;
  h ^= h >> 15;
  h *= 0x846ca68bu;
  return static_cast<float>(h >> 8) * (1.0f / 16777216.0f);
}

inline float SmoothStep(float low, float high, float x) {
  float t = (x - low) / (high - low);
  t = t < 0.0f ? 0.0f : (t > 1.0f ? 1.0f : t);
  return t * t * (3.0f - 2.0f * t);
}

// The next integer below, without a call into the mathematics library (places lie within +-2^31 cells).
inline std::int32_t FloorToInt(double x) {
  const auto cut = static_cast<std::int32_t>(x);
  return cut - (x < static_cast<double>(cut) ? 1 : 0);
}

// Smooth noise of about one hill per unit cell, in [-1, 1].
inline float ValueNoise(double x, double y, std::uint32_t seed) {
  const std::int32_t ix = FloorToInt(x);
  const std::int32_t iy = FloorToInt(y);
  const auto fx = static_cast<float>(x - ix);
  const auto fy = static_cast<float>(y - iy);
  const float wx = fx * fx * fx * (fx * (fx * 6.0f - 15.0f) + 10.0f);
  const float wy = fy * fy * fy * (fy * (fy * 6.0f - 15.0f) + 10.0f);
  const auto corner = [seed](std::int32_t cx, std::int32_t cy) {
    return static_cast<float>(static_cast<std::int32_t>(HashCell(cx, cy, seed))) * (1.0f / 2147483648.0f);
  };
  const float a = corner(ix, iy);
  const float b = corner(ix + 1, iy);
  const float c = corner(ix, iy + 1);
  const float d = corner(ix + 1, iy + 1);
  const float low = a + wx * (b - a);
  const float high = c + wx * (d - c);
  return low + wy * (high - low);
}

// How much of a pattern of this wavelength a filter of this width lets through: all at 4 widths a wave,
// nothing at 2 (the Nyquist limit), so that distant views do not alias.
inline float BandWeight(float wavelength_m, float footprint_m) {
  return SmoothStep(2.0f, 4.0f, wavelength_m / footprint_m);
}

// ValueNoise of a wavelength in metres, turned by an angle of its own, faded below the footprint.
inline float BandNoise(double east, double north, float wavelength_m, std::uint32_t octave, float footprint_m,
                       std::uint32_t seed) {
  const float weight = BandWeight(wavelength_m, footprint_m);
  if (weight == 0.0f) return 0.0f;
  // Pythagorean-like turns, one of eight by octave: exact constants, no trigonometry per sample.
  static constexpr double kCos[8] = {1.0,      0.923880, 0.798636,  0.608761,
                                     0.382683, 0.130526, -0.195090, -0.555570};
  static constexpr double kSin[8] = {0.0,      0.382683, 0.601815, 0.793353,
                                     0.923880, 0.991445, 0.980785, 0.831470};
  const double c = kCos[octave & 7u];
  const double s = kSin[octave & 7u];
  const double scale =
      1.0 / static_cast<double>(wavelength_m) * 2.0;  // a wave is a hill and a dale: two cells
  return weight * ValueNoise((c * east - s * north) * scale, (s * east + c * north) * scale,
                             seed + 0x632be59bu * (octave + 1u));
}

// The share of a soft-edged shape at a signed distance inside its border, for a filter of this width.
inline float Cover(double distance_inside_m, float footprint_m) {
  const float t = 0.5f + static_cast<float>(distance_inside_m) / footprint_m;
  return t < 0.0f ? 0.0f : (t > 1.0f ? 1.0f : t);
}

}  // namespace skyquilt::simulate
