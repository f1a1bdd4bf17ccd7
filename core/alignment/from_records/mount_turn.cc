#include "core/alignment/from_records/mount_turn.h"

#include <array>
#include <cmath>
#include <numbers>

namespace skyquilt::alignment {
namespace {

using Complex = std::complex<double>;

constexpr double kQuarterRad = 0.5 * std::numbers::pi;
constexpr double kNearRad = 0.45;
constexpr int kMinLinks = 8;
constexpr double kShare = 0.8;
constexpr double kBaselineSigmas = 3.0;
constexpr double kMaxStretch = 2.0;  // of the way in the pictures against the recorded one

}  // namespace

double CommonQuarterTurn(const std::vector<GroundPrior>& recorded, const std::vector<VerifiedPair>& pairs) {
  std::array<int, 4> votes{};
  int asked = 0;
  for (const VerifiedPair& pair : pairs) {
    const Complex first = recorded[pair.first].middle;
    const Complex second = recorded[pair.second].middle;
    const Complex way = second - first;
    if (std::abs(way) < kBaselineSigmas * recorded[pair.first].sigma_m) continue;
    // One place of the ground, seen from both middles: were all photos turned right, the difference were the
    // way.
    const Complex between = 0.5 * (first + second);
    const Complex shown = (between - first) - (pair.second_from_first * between - second);
    if (std::abs(shown) < std::abs(way) / kMaxStretch || std::abs(shown) > kMaxStretch * std::abs(way))
      continue;
    ++asked;
    const double turn = std::arg(way / shown);
    const double quarters = std::round(turn / kQuarterRad);
    if (std::abs(turn - quarters * kQuarterRad) > kNearRad) continue;
    ++votes[(static_cast<int>(quarters) + 4) % 4];
  }
  for (int quarters = 1; quarters < 4; ++quarters) {
    const int agree = votes[quarters];
    if (agree >= kMinLinks && agree >= kShare * asked) {
      return quarters == 3 ? -kQuarterRad : quarters * kQuarterRad;
    }
  }
  return 0.0;
}

}  // namespace skyquilt::alignment
