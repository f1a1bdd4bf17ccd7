// SeamLabels: which photo shows each cell of the seam grid. Stored by chunks, so that a long thin flight
// costs no more than the ground it covers. A value; reading from any thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/render/seams/seam_grid.h"

namespace skyquilt::render {

inline constexpr std::int32_t kNoPhoto = -1;

class SeamLabels {
 public:
  static constexpr int kChunk = 64;  // cells a side

  SeamLabels() = default;
  SeamLabels(int columns, int rows);
  SeamLabels(const SeamLabels& other);
  SeamLabels& operator=(const SeamLabels& other);
  SeamLabels(SeamLabels&&) = default;
  SeamLabels& operator=(SeamLabels&&) = default;

  std::int32_t At(int column, int row) const {
    const Chunk* chunk = Find(column, row);
    return chunk == nullptr ? kNoPhoto : (*chunk)[Within(column, row)];
  }
  void Set(int column, int row, std::int32_t photo);  // inside the grid only

  int columns() const { return columns_; }
  int rows() const { return rows_; }

 private:
  using Chunk = std::array<std::int32_t, kChunk * kChunk>;
  static std::size_t Within(int column, int row) {
    return static_cast<std::size_t>(row % kChunk) * kChunk + static_cast<std::size_t>(column % kChunk);
  }
  std::size_t ChunkOf(int column, int row) const {
    return static_cast<std::size_t>(row / kChunk) * chunk_columns_ +
           static_cast<std::size_t>(column / kChunk);
  }
  const Chunk* Find(int column, int row) const {
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return nullptr;
    return chunks_[ChunkOf(column, row)].get();
  }

  int columns_ = 0, rows_ = 0;
  std::size_t chunk_columns_ = 0;
  std::vector<std::unique_ptr<Chunk>> chunks_;
};

// What an earlier run decided, for a flight of which these photos came first.
struct KnownLabels {
  SeamGrid grid;
  SeamLabels labels;
  std::size_t photos = 0;

  // Of a cell of the world, as the grid counts them.
  std::int32_t AtWorld(std::int64_t column, std::int64_t row) const {
    return labels.At(static_cast<int>(column - grid.first_column), static_cast<int>(row - grid.first_row));
  }
};

}  // namespace skyquilt::render
