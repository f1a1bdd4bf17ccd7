#include "core/render/seams/seam_labels.h"

#include "core/base/check.h"

namespace skyquilt::render {

SeamLabels::SeamLabels(int columns, int rows)
    : columns_(columns),
      rows_(rows),
      chunk_columns_(static_cast<std::size_t>(columns + kChunk - 1) / kChunk) {
  chunks_.resize(chunk_columns_ * (static_cast<std::size_t>(rows + kChunk - 1) / kChunk));
}

SeamLabels::SeamLabels(const SeamLabels& other)
    : columns_(other.columns_), rows_(other.rows_), chunk_columns_(other.chunk_columns_) {
  chunks_.reserve(other.chunks_.size());
  for (const auto& chunk : other.chunks_)
    chunks_.push_back(chunk ? std::make_unique<Chunk>(*chunk) : nullptr);
}

SeamLabels& SeamLabels::operator=(const SeamLabels& other) { return *this = SeamLabels(other); }

void SeamLabels::Set(int column, int row, std::int32_t photo) {
  SKYQUILT_CHECK(column >= 0 && row >= 0 && column < columns_ && row < rows_, "a cell outside the seam grid");
  std::unique_ptr<Chunk>& chunk = chunks_[ChunkOf(column, row)];
  if (!chunk) {
    chunk = std::make_unique<Chunk>();
    chunk->fill(kNoPhoto);
  }
  (*chunk)[Within(column, row)] = photo;
}

}  // namespace skyquilt::render
