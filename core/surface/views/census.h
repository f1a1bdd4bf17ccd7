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

// Of columns x rows cells in the middle of a patch that is larger by kCensusRadius on each side. What is kept
// by cell runs on from row to row as the patch does, without its first and last cells: cell (column, row) has
// number row * patch_columns + column, and the few numbers between rows stand for nothing. So loops are long.
struct CensusShape {
  int columns = 0, rows = 0;

  int PatchColumns() const { return columns + 2 * kCensusRadius; }
  std::size_t IndexOf(int column, int row) const {
    return static_cast<std::size_t>(row) * PatchColumns() + column;
  }
  std::size_t Used() const { return IndexOf(columns, rows - 1); }
  // Rounded up to whole vectors.
  std::size_t PlaneSize() const { return (Used() + 63) / 64 * 64; }
};

// Plane p of cell i is planes[p * PlaneSize() + i]. The cell's own gray may come from another patch than that
// of those around it, which lies at other heights.
void FillCensus(const std::uint8_t* own, const std::uint8_t* around, const CensusShape& shape,
                std::uint8_t* planes);

// What one photo shows of the cells of a tile at one height.
struct CensusView {
  const std::uint8_t* planes = nullptr;
  const std::uint8_t* unseen = nullptr;  // by cell: 255 where the photo does not see it, else 0
};

// Bits in which the two differ, by cell, from `first` on, both multiples of 8.
void FillDistances(const CensusView& a, const CensusView& b, std::size_t plane_size, std::size_t first,
                   std::size_t count, std::uint8_t* distances);

// What it costs, from 0 to 96, that a cell lies at a height: twice the mean of the least of the
// distances between all pairs of views: one pair of three views, two of four, three of five, as many as are
// left where something hides the cell from one or two of them. The same for each height where no two photos
// see the cell. Source: Kang, Szeliski and Chai (2001).
class BetterHalf {
 public:
  static constexpr std::uint8_t kMaxCost = 2 * kCensusBits;

  explicit BetterHalf(int views);
  // costs: plane_size bytes, as of the views.
  void Fill(const std::vector<CensusView>& views, std::size_t plane_size, std::uint8_t* costs) const;

 private:
  int kept_;  // pairs
};

// By cell: how many views agree with the one that most agree with, itself included; 0 where none agrees with
// any.
void CountAgreeing(const std::vector<CensusView>& views, std::size_t plane_size, std::uint8_t most_distance,
                   std::uint8_t* agreeing);

}  // namespace skyquilt::surface
