#include "api/downloads/zip_layout.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <utility>

#include "api/downloads/streamed_product.h"
#include "api/http/conditional.h"
#include "core/base/check.h"
#include "core/base/parallel_for.h"
#include "core/base/process/file_descriptor.h"
#include "core/base/try.h"
#include "storage/blobs/lru_memory.h"

namespace skyquilt::api {
namespace {

constexpr std::uint32_t kBig = 0xffffffff;  // "see the Zip64 field"
constexpr std::uint16_t kVersion = 45;      // Zip64
constexpr std::uint16_t kUtf8 = 1 << 11;
constexpr std::uint16_t kDosDate = (1 << 5) | 1;  // 1980-01-01: no clock, so that the bytes repeat
constexpr std::size_t kSlice = 256 * 1024;

int OpenToRead(const std::filesystem::path& path) {
  return open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
}

Error ReadError(const std::filesystem::path& path) {
  return {errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo, "A file of the archive could not be read.",
          path.string() + ": " + std::strerror(errno)};
}

struct Measured {
  std::uint64_t size = 0;
  std::uint32_t crc = 0;
};

// The checksum of what this name stands for; computed where it is not one of those asked for lately.
Result<std::uint32_t> KnownCrc(const std::string& name,
                               const std::function<Result<std::uint32_t>()>& compute) {
  constexpr std::size_t kMaxKnown = 4096;
  static storage::LruMemory<std::uint32_t> known(kMaxKnown);  // each counts as one
  if (const auto found = known.Find(name)) return *found;
  SKYQUILT_TRY_ASSIGN(const std::uint32_t crc, compute());
  known.Keep(name, std::make_shared<const std::uint32_t>(crc), 1);
  return crc;
}

Result<Measured> MeasureFile(const std::filesystem::path& path) {
  const FileDescriptor file(OpenToRead(path));
  struct stat status {};
  if (!file.is_open() || fstat(file.get(), &status) != 0) return ReadError(path);
  const auto size = static_cast<std::uint64_t>(status.st_size);
  const auto compute = [&]() -> Result<std::uint32_t> {
    std::vector<std::uint8_t> slice(kSlice);
    uLong crc = crc32(0, nullptr, 0);
    std::uint64_t total = 0;
    while (true) {
      const ssize_t got = file.ReadAt(total, slice.data(), slice.size());
      if (got < 0) return ReadError(path);
      if (got == 0) break;
      crc = crc32(crc, slice.data(), static_cast<uInt>(got));
      total += static_cast<std::uint64_t>(got);
    }
    if (total != size)
      return Error{ErrorCode::kIo, "A file of the archive changed meanwhile.", path.string()};
    return static_cast<std::uint32_t>(crc);
  };
  // Finished maps never change, and no inode is reused at the same nanosecond with the same size.
  const std::string identity = fmt::format("{}:{}:{}:{}.{}", status.st_dev, status.st_ino, size,
                                           status.st_mtim.tv_sec, status.st_mtim.tv_nsec);
  SKYQUILT_TRY_ASSIGN(const std::uint32_t crc, KnownCrc(identity, compute));
  return Measured{size, crc};
}

Result<Measured> MeasureStreamed(const storage::OpenStreamed& streamed) {
  const auto compute = [&]() -> Result<std::uint32_t> {
    const auto add = [](uLong crc, const std::string& bytes) {
      return crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
    };
    uLong crc = add(crc32(0, nullptr, 0), streamed.file->head());
    std::optional<Error> failure;
    constexpr std::size_t kWindow = 32;
    ParallelOrdered<Result<std::string>>(
        streamed.file->PieceCount(), 0, kWindow,
        [&](std::size_t i) { return streamed.file->MakePiece(i, *streamed.tiles); },
        [&](std::size_t, Result<std::string>&& piece) {
          if (!piece && !failure) failure = piece.error();
          if (piece) crc = add(crc, *piece);
        });
    if (failure) return *failure;
    return static_cast<std::uint32_t>(crc);
  };
  SKYQUILT_TRY_ASSIGN(const std::uint32_t crc, KnownCrc(streamed.identity, compute));
  return Measured{streamed.file->length(), crc};
}

Result<Measured> Measure(const ZipEntry& entry) {
  if (entry.streamed) return MeasureStreamed(*entry.streamed);
  if (!entry.path.empty()) return MeasureFile(entry.path);
  Measured content;
  content.size = entry.bytes.size();
  content.crc = static_cast<std::uint32_t>(
      crc32_z(crc32(0, nullptr, 0), reinterpret_cast<const Bytef*>(entry.bytes.data()), entry.bytes.size()));
  return content;
}

void Put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>((value >> (8 * i)) & 0xff));
}

struct Placed {
  std::string name;
  Measured content;
  std::uint64_t offset = 0;
};

// The fields that local and central headers share.
void PutCommon(std::string& out, const Placed& entry, std::uint16_t extra_bytes) {
  Put(out, kVersion, 2);
  Put(out, kUtf8, 2);
  Put(out, 0, 2);  // stored
  Put(out, 0, 2);
  Put(out, kDosDate, 2);
  Put(out, entry.content.crc, 4);
  Put(out, kBig, 4);
  Put(out, kBig, 4);
  Put(out, entry.name.size(), 2);
  Put(out, extra_bytes, 2);
}

std::string LocalHeader(const Placed& entry) {
  std::string out("PK\3\4");
  PutCommon(out, entry, 20);
  out += entry.name;
  Put(out, 1, 2);  // Zip64
  Put(out, 16, 2);
  Put(out, entry.content.size, 8);
  Put(out, entry.content.size, 8);
  return out;
}

void PutCentral(std::string& out, const Placed& entry) {
  out += "PK\1\2";
  Put(out, (3 << 8) | kVersion, 2);  // made on Unix
  PutCommon(out, entry, 28);
  Put(out, 0, 2);                             // comment
  Put(out, 0, 2);                             // disk
  Put(out, 0, 2);                             // internal attributes
  Put(out, std::uint64_t{0100644} << 16, 4);  // a plain file
  Put(out, kBig, 4);
  out += entry.name;
  Put(out, 1, 2);
  Put(out, 24, 2);
  Put(out, entry.content.size, 8);
  Put(out, entry.content.size, 8);
  Put(out, entry.offset, 8);
}

std::string Directory(const std::vector<Placed>& placed, std::uint64_t offset) {
  std::string out;
  for (const Placed& entry : placed) PutCentral(out, entry);
  const std::uint64_t size = out.size();
  out += "PK\6\6";
  Put(out, 44, 8);
  Put(out, (3 << 8) | kVersion, 2);
  Put(out, kVersion, 2);
  Put(out, 0, 8);  // disks
  Put(out, placed.size(), 8);
  Put(out, placed.size(), 8);
  Put(out, size, 8);
  Put(out, offset, 8);
  out += "PK\6\7";
  Put(out, 0, 4);
  Put(out, offset + size, 8);
  Put(out, 1, 4);
  out += "PK\5\6";
  Put(out, 0, 4);
  const std::uint64_t count = std::min<std::uint64_t>(placed.size(), 0xffff);
  Put(out, count, 2);
  Put(out, count, 2);
  Put(out, std::min<std::uint64_t>(size, kBig), 4);
  Put(out, std::min<std::uint64_t>(offset, kBig), 4);
  Put(out, 0, 2);
  return out;
}

class ZipSource final : public BodySource {
 public:
  // `files` are those of the pieces from `first_piece` on, as far as the range goes.
  ZipSource(std::shared_ptr<const ZipLayout> layout, std::size_t first_piece,
            std::vector<FileDescriptor> files, std::uint64_t offset, std::uint64_t length)
      : layout_(std::move(layout)),
        first_piece_(first_piece),
        piece_(first_piece),
        files_(std::move(files)),
        at_(offset),
        end_(offset + length),
        length_(length) {}
  std::uint64_t length() const override { return length_; }

  Result<std::size_t> Read(std::span<std::uint8_t> into) override {
    if (at_ == end_) return std::size_t{0};
    while (at_ >= layout_->pieces[piece_].offset + layout_->pieces[piece_].length) ++piece_;
    const ZipPiece& piece = layout_->pieces[piece_];
    const std::uint64_t inside = at_ - piece.offset;
    const auto wanted =
        static_cast<std::size_t>(std::min<std::uint64_t>({into.size(), piece.length - inside, end_ - at_}));
    std::size_t got = wanted;
    if (piece.streamed) {
      if (streamed_ == nullptr || streamed_piece_ != piece_) {
        SKYQUILT_TRY_ASSIGN(streamed_, ReadStreamed(*piece.streamed, inside, piece.length - inside));
        streamed_piece_ = piece_;
      }
      SKYQUILT_TRY_ASSIGN(got, streamed_->Read(into.first(wanted)));
      if (got == 0) return Error{ErrorCode::kIo, "A file of the archive could not be read.", "short"};
    } else if (piece.path.empty()) {
      std::memcpy(into.data(), piece.bytes.data() + inside, wanted);
    } else {
      const ssize_t read = files_[piece_ - first_piece_].ReadAt(inside, into.data(), wanted);
      if (read <= 0) return ReadError(piece.path);
      got = static_cast<std::size_t>(read);
    }
    at_ += got;
    return got;
  }

 private:
  std::shared_ptr<const ZipLayout> layout_;
  std::size_t first_piece_;
  std::size_t piece_;
  std::vector<FileDescriptor> files_;
  std::unique_ptr<BodySource> streamed_;  // of the piece streamed_piece_, from where the last read ended
  std::size_t streamed_piece_ = 0;
  std::uint64_t at_;
  std::uint64_t end_;
  std::uint64_t length_;
};

}  // namespace

Result<ZipLayout> PlanZip(const std::vector<ZipEntry>& entries) {
  ZipLayout layout;
  std::vector<Placed> placed;
  const auto add = [&](ZipPiece piece) {
    piece.offset = layout.length;
    layout.length += piece.length;
    if (piece.length > 0) layout.pieces.push_back(std::move(piece));
  };
  for (const ZipEntry& entry : entries) {
    SKYQUILT_CHECK(!entry.name.empty() && entry.name.size() < 0xffff, "an entry needs a name");
    SKYQUILT_TRY_ASSIGN(const Measured content, Measure(entry));
    placed.push_back({entry.name, content, layout.length});
    std::string header = LocalHeader(placed.back());
    const std::uint64_t header_bytes = header.size();
    add({std::move(header), {}, {}, 0, header_bytes});
    add({entry.bytes, entry.path, entry.streamed, 0, content.size});
  }
  std::string directory = Directory(placed, layout.length);
  const std::uint64_t directory_bytes = directory.size();
  add({std::move(directory), {}, {}, 0, directory_bytes});
  return layout;
}

std::string ZipEtag(const ZipLayout& layout) {
  return StrongEtag(std::hash<std::string>()(layout.pieces.back().bytes), "zip");
}

Result<std::unique_ptr<BodySource>> ReadZip(std::shared_ptr<const ZipLayout> layout, std::uint64_t offset,
                                            std::uint64_t length) {
  SKYQUILT_CHECK(offset < layout->length && length <= layout->length - offset, "a range outside the archive");
  const std::vector<ZipPiece>& pieces = layout->pieces;
  const auto first =
      std::upper_bound(pieces.begin(), pieces.end(), offset,
                       [](std::uint64_t value, const ZipPiece& piece) { return value < piece.offset; });
  const auto first_piece = static_cast<std::size_t>(first - pieces.begin() - 1);
  std::vector<FileDescriptor> files;
  for (std::size_t i = first_piece; i < pieces.size() && pieces[i].offset < offset + length; ++i) {
    files.emplace_back(OpenToRead(pieces[i].path));
    if (!pieces[i].path.empty() && !files.back().is_open()) return ReadError(pieces[i].path);
  }
  return std::unique_ptr<BodySource>(
      std::make_unique<ZipSource>(std::move(layout), first_piece, std::move(files), offset, length));
}

}  // namespace skyquilt::api
