// Census: around each pixel of a gray patch, which of the other 48 of its 7 x 7 neighbourhood are brighter:
// 48 bits that no change of light alters, in six planes of bytes so that plain loops over planes are vector
// instructions on any processor; and the number of bits in which photos differ. Pure; any thread; the same
// bits on any processor. Source: Zabih and Woodfill, "Non-parametric local transforms for computing visual
// correspondence" (1994).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace skyquilt::surface {

inline constexpr int kCensusRadius = 3;
inline constexpr int kCensusPlanes = 6;
inline constexpr int kCensusBits = 48;
inline constexpr std::uint8_t kNotCompared = 255;  // a distance where one of the two does not see the cell

// Rounded up so that loops over cells have no remainder.
inline std::size_t PaddedCount(std::size_t cells) { return (cells + 63) / 64 * 64; }

// Bits of columns x rows cells in the middle of a patch that is larger by kCensusRadius on each side; plane p
// of cell i is planes[p * plane_size + i].
void FillCensus(const std::uint8_t* patch, int columns, int rows, std::size_t plane_size,
                std::uint8_t* planes);

// What one photo shows of the cells of a tile at one height.
struct CensusView {
  const std::uint8_t* planes = nullptr;
  const std::uint8_t* unseen = nullptr;  // by cell: 255 where the photo does not see it, else 0
};

// Bits in which the two differ, by cell, from `first` on, both multiples of 8.
void FillDistances(const CensusView& a, const CensusView& b, std::size_t plane_size, std::size_t first,
                   std::size_t count, std::uint8_t* distances);

// What it costs, from 0 to 96, that a cell lies at a height: twice the mean of the better half of the
// distances between all pairs of views (so that a photo from which something hides the cell has no say). The
// same for each height where no two photos see the cell. Source: Kang, Szeliski and Chai (2001).
class BetterHalf {
 public:
  static constexpr std::uint8_t kMostCost = 2 * kCensusBits;

  explicit BetterHalf(int views);
  // costs: PaddedCount(cells) bytes; plane_size as of the views.
  void Fill(const std::vector<CensusView>& views, std::size_t plane_size, std::uint8_t* costs) const;

 private:
  int kept_;  // pairs
};

// By cell: how many views agree with the one that most agree with, itself included; 0 where none agrees with
// any.
void CountAgreeing(const std::vector<CensusView>& views, std::size_t plane_size, std::uint8_t most_distance,
                   std::uint8_t* agreeing);

}  // namespace skyquilt::surface
