// The ground graph against a known truth: photos of one plane, projected on it with errors that the links
// must show.
#include "core/alignment/from_records/ground_graph.h"

#include <gtest/gtest.h>

#include <numbers>
#include <utility>

#include "core/alignment/matching/verified_pair.h"

namespace skyquilt::alignment {
namespace {

using Complex = std::complex<double>;

constexpr double kHalfWidthM = 20.0;

// A block of 3 x 4 photos over level ground with a point on every metre. Each photo's record is off by
// `recorded_turn_rad`; its position is exact.
struct Block {
  std::vector<PhotoGround> photos;
  GroundKeypoints projected;
  std::vector<PhotoPair> links;
};

Block MakeBlock(double step_m, double sigma_m, const std::vector<double>& recorded_turn_rad) {
  Block block;
  for (int i = 0; i < 12; ++i) block.photos.push_back({step_m * Complex(i % 3, i / 3), sigma_m, 0.05});
  std::vector<std::vector<Complex>> seen(12);
  for (int i = 0; i < 12; ++i) {
    const Complex middle = block.photos[i].middle;
    std::vector<GroundKeypoint>& projected = block.projected.emplace_back();
    for (int east = -60; east <= 90; east += 4) {
      for (int north = -60; north <= 90; north += 4) {
        const Complex truth(east, north);
        if (std::abs((truth - middle).real()) > kHalfWidthM ||
            std::abs((truth - middle).imag()) > kHalfWidthM)
          continue;
        seen[i].push_back(truth);
        projected.emplace_back().place = middle + std::polar(1.0, recorded_turn_rad[i]) * (truth - middle);
      }
    }
  }
  for (int i = 0; i < 12; ++i) {
    for (int j = i + 1; j < 12; ++j) {
      PhotoPair link{i, j, {}, {}, 0.0};
      std::vector<std::pair<Complex, Complex>> places;
      for (std::size_t a = 0; a < seen[i].size(); ++a) {
        const auto same = std::find(seen[j].begin(), seen[j].end(), seen[i][a]);
        if (same == seen[j].end()) continue;
        const auto b = static_cast<std::size_t>(same - seen[j].begin());
        link.matches.push_back({static_cast<std::uint16_t>(a), static_cast<std::uint16_t>(b)});
        places.emplace_back(block.projected[i][a].place, block.projected[j][b].place);
      }
      if (link.matches.size() < 10) continue;
      link.second_from_first = FitSimilarity(places);
      block.links.push_back(std::move(link));
    }
  }
  return block;
}

void ExpectTurnedBack(const Block& block, const std::vector<double>& recorded_turn_rad) {
  const GroundGraph graph = SolveGroundGraph(block.photos, block.links, block.projected, 1.0);
  for (std::size_t i = 0; i < block.photos.size(); ++i) {
    const Complex turned = graph.photos[i].correction.turn_and_scale * std::polar(1.0, recorded_turn_rad[i]);
    EXPECT_LT(std::abs(turned - 1.0), 0.02) << i;
    EXPECT_LT(std::abs(graph.photos[i].correction.shift), 0.2) << i;
  }
  EXPECT_EQ(std::count(graph.is_inlier.begin(), graph.is_inlier.end(), false), 0);
}

TEST(SolveGroundGraph, LeavesABlockThatAgreesAlone) {
  const std::vector<double> turns(12, 0.0);
  ExpectTurnedBack(MakeBlock(10.0, 2.0, turns), turns);
}

TEST(SolveGroundGraph, TurnsALineBackThatIsStoredUpsideDown) {
  std::vector<double> turns(12, 0.0);
  for (const int i : {3, 4, 5}) turns[i] = std::numbers::pi;
  ExpectTurnedBack(MakeBlock(10.0, 2.0, turns), turns);
}

// So near to each other that no single link contradicts the record: the turned ground moves by less than the
// positions are worth.
TEST(SolveGroundGraph, FindsACameraMountedTurnedEvenWhereNeighboursStandClose) {
  for (const double turn : {0.5, -0.5, 1.0}) {
    const std::vector<double> turns(12, turn * std::numbers::pi);
    ExpectTurnedBack(MakeBlock(5.0, 2.0, turns), turns);
    ExpectTurnedBack(MakeBlock(12.0, 2.0, turns), turns);
  }
}

// As photos from high above, whose chance matches with many from far below say nothing of where they lie.
TEST(SolveGroundGraph, DoesNotShrinkAPhotoIntoTheMiddleOfFalsePairs) {
  Block block = MakeBlock(10.0, 2.0, std::vector<double>(12, 0.0));
  std::erase_if(block.links, [](const PhotoPair& link) { return link.first == 0; });
  const std::size_t true_links = block.links.size();
  block.photos[0].sigma_m = 20.0;
  for (int other = 4; other < 10; ++other) {
    PhotoPair link{0, other, {}, {}, 0.0};
    const auto middle =
        static_cast<std::uint16_t>(block.projected[static_cast<std::size_t>(other)].size() / 2);
    for (std::uint16_t k = 0; k < 24; ++k)
      link.matches.push_back({static_cast<std::uint16_t>(5 * k), middle});
    block.links.push_back(std::move(link));
  }
  const GroundGraph graph = SolveGroundGraph(block.photos, block.links, block.projected, 1.0);
  EXPECT_EQ(graph.photos[0].component, -1);
  EXPECT_EQ(graph.photos[0].correction.shift, Complex(0.0, 0.0));
  for (std::size_t l = true_links; l < block.links.size(); ++l) EXPECT_FALSE(graph.is_inlier[l]) << l;
  for (std::size_t i = 1; i < 12; ++i) EXPECT_GE(graph.photos[i].component, 0) << i;
}

}  // namespace
}  // namespace skyquilt::alignment
