// StreamedFile: a file in another format that is nowhere on the disk: a head, and behind it pieces, each of
// which is made from a tile of a map when it is read. It has a length, and every range of it the same bytes
// whenever it is asked for, like any file. Immutable; any number of threads.
//
// StreamedReader: a range of one, from front to back. One thread at a time. Errors: kCorrupt (a tile that is
// not what the tileset says of it), those of the tileset.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

struct StreamedPiece {
  std::uint64_t offset = 0;  // in the file; it ends where the next one begins
  std::int64_t what = 0;     // as the format names it
};

class StreamedFile {
 public:
  virtual ~StreamedFile() = default;
  StreamedFile(const StreamedFile&) = delete;
  StreamedFile& operator=(const StreamedFile&) = delete;

  std::uint64_t length() const { return length_; }
  // Of the head: whatever changes a byte behind it, but the tiles themselves, changes this.
  std::uint64_t digest() const { return digest_; }
  // Of memory.
  std::size_t memory_bytes() const;

  const std::string& head() const { return head_; }
  std::size_t PieceCount() const { return pieces_.size(); }
  const StreamedPiece& Piece(std::size_t i) const { return pieces_[i]; }
  std::uint64_t BytesOf(std::size_t i) const;
  // The piece that has this byte, which is none of the head's.
  std::size_t PieceAt(std::uint64_t offset) const;
  // Exactly BytesOf(i).
  Result<std::string> MakePiece(std::size_t i, MapTiles& tiles) const;

 protected:
  StreamedFile(std::string head, std::vector<StreamedPiece> pieces, std::uint64_t length);
  // `bytes` of them.
  virtual Result<std::string> Make(std::int64_t what, std::uint64_t bytes, MapTiles& tiles) const = 0;

 private:
  const std::string head_;
  const std::vector<StreamedPiece> pieces_;
  const std::uint64_t length_;
  const std::uint64_t digest_;
};

class StreamedReader {
 public:
  // The range lies within the file.
  StreamedReader(std::shared_ptr<const StreamedFile> file, std::shared_ptr<MapTiles> tiles,
                 std::uint64_t offset, std::uint64_t length);
  std::uint64_t length() const { return length_; }
  // Fills from the front; 0 only at the range's end.
  Result<std::size_t> Read(std::span<std::uint8_t> into);

 private:
  const std::shared_ptr<const StreamedFile> file_;
  const std::shared_ptr<MapTiles> tiles_;
  std::uint64_t at_;
  const std::uint64_t end_;
  const std::uint64_t length_;
  std::size_t piece_ = 0;  // whose bytes are at hand
  std::string bytes_;      // empty: none
};

}  // namespace skyquilt::storage
