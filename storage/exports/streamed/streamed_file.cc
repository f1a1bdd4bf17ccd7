#include "storage/exports/streamed/streamed_file.h"

#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/base/check.h"
#include "core/base/try.h"

namespace skyquilt::storage {

StreamedFile::StreamedFile(std::string head, std::vector<StreamedPiece> pieces, std::uint64_t length)
    : head_(std::move(head)),
      pieces_(std::move(pieces)),
      length_(length),
      digest_(XXH3_64bits(head_.data(), head_.size())) {
  SKYQUILT_CHECK(pieces_.empty() ? length_ == head_.size() : pieces_.front().offset == head_.size(),
                 "a gap behind the head of a file");
}

std::size_t StreamedFile::memory_bytes() const {
  return sizeof(StreamedFile) + head_.capacity() + pieces_.capacity() * sizeof(StreamedPiece);
}

std::uint64_t StreamedFile::BytesOf(std::size_t i) const {
  return (i + 1 < pieces_.size() ? pieces_[i + 1].offset : length_) - pieces_[i].offset;
}

std::size_t StreamedFile::PieceAt(std::uint64_t offset) const {
  SKYQUILT_CHECK(offset >= head_.size() && offset < length_, "a byte that no piece has");
  const auto behind =
      std::upper_bound(pieces_.begin(), pieces_.end(), offset,
                       [](std::uint64_t value, const StreamedPiece& piece) { return value < piece.offset; });
  return static_cast<std::size_t>(behind - pieces_.begin()) - 1;
}

Result<std::string> StreamedFile::MakePiece(std::size_t i, MapTiles& tiles) const {
  const std::uint64_t wanted = BytesOf(i);
  Result<std::string> made = Make(pieces_[i].what, wanted, tiles);
  if (made && made->size() != wanted)
    return Error{ErrorCode::kCorrupt, "A tile of the map is damaged. Stitch the flight again.", ""};
  return made;
}

StreamedReader::StreamedReader(std::shared_ptr<const StreamedFile> file, std::shared_ptr<MapTiles> tiles,
                               std::uint64_t offset, std::uint64_t length)
    : file_(std::move(file)), tiles_(std::move(tiles)), at_(offset), end_(offset + length), length_(length) {
  SKYQUILT_CHECK(offset <= file_->length() && length <= file_->length() - offset, "a range outside the file");
}

Result<std::size_t> StreamedReader::Read(std::span<std::uint8_t> into) {
  std::size_t filled = 0;
  while (filled < into.size() && at_ < end_) {
    std::string_view from = file_->head();
    std::uint64_t begins = 0;
    if (at_ >= from.size()) {
      const std::size_t wanted = bytes_.empty() ? file_->PieceAt(at_) : piece_;
      const bool is_here = !bytes_.empty() && at_ < file_->Piece(wanted).offset + bytes_.size();
      if (!is_here) {
        const std::size_t next = bytes_.empty() ? wanted : wanted + 1;
        // What was read before the failure is given away first.
        Result<std::string> made = file_->MakePiece(next, *tiles_);
        if (!made && filled > 0) return filled;
        if (!made) return made.error();
        bytes_ = *std::move(made);
        piece_ = next;
      }
      from = bytes_;
      begins = file_->Piece(piece_).offset;
    }
    const std::uint64_t inside = at_ - begins;
    const auto count = static_cast<std::size_t>(
        std::min<std::uint64_t>({into.size() - filled, from.size() - inside, end_ - at_}));
    std::memcpy(into.data() + filled, from.data() + inside, count);
    filled += count;
    at_ += count;
  }
  return filled;
}

}  // namespace skyquilt::storage
