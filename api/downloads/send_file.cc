#include "api/downloads/send_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "api/http/conditional.h"
#include "api/http/responses.h"
#include "core/base/process/file_descriptor.h"
#include "core/base/text/percent.h"
#include "core/base/try.h"
#include "storage/blobs/range_cache.h"
#include "storage/blobs/sha256.h"

namespace skyquilt::api {
namespace {

class FileSource final : public BodySource {
 public:
  FileSource(FileDescriptor file, std::uint64_t offset, std::uint64_t length)
      : file_(std::move(file)), offset_(offset), length_(length), left_(length) {}
  std::uint64_t length() const override { return length_; }

  Result<std::size_t> Read(std::span<std::uint8_t> into) override {
    const std::size_t wanted = static_cast<std::size_t>(std::min<std::uint64_t>(into.size(), left_));
    if (wanted == 0) return std::size_t{0};
    const ssize_t got = file_.ReadAt(offset_, into.data(), wanted);
    if (got <= 0)
      return Error{ErrorCode::kIo, "The file could not be read.", got < 0 ? std::strerror(errno) : "short"};
    offset_ += static_cast<std::uint64_t>(got);
    left_ -= static_cast<std::uint64_t>(got);
    return static_cast<std::size_t>(got);
  }

 private:
  FileDescriptor file_;
  std::uint64_t offset_;
  std::uint64_t length_;
  std::uint64_t left_;
};

// How bytes of a blob are held against what was published: not at all, by the sum of a whole one, or each
// range by its own.
struct Proof {
  std::optional<std::string> whole = {};  // in hex
  bool is_by_ranges = false;
};

// What is at hand of a blob: a window at a time. Where its sum is known, the last window of another blob is
// held back, so that nobody takes it for whole.
class BlobSource final : public BodySource {
 public:
  BlobSource(storage::BlobStore& blobs, std::string key, std::uint64_t offset, std::uint64_t length,
             Proof proof)
      : blobs_(blobs),
        key_(std::move(key)),
        next_(offset),
        left_(length),
        length_(length),
        proof_(std::move(proof)) {}
  std::uint64_t length() const override { return length_; }

  Result<std::size_t> Read(std::span<std::uint8_t> into) override {
    if (at_ == window_.size() && left_ > 0) SKYQUILT_TRY(ReadWindow());
    const std::size_t given = std::min(into.size(), window_.size() - at_);
    std::memcpy(into.data(), window_.data() + at_, given);
    at_ += given;
    return given;
  }

  // The next one. Before the first Read: so that its error is an answer.
  Result<void> ReadWindow() {
    const std::uint64_t wanted = std::min(left_, kWindowBytes);
    const auto from = static_cast<std::int64_t>(next_), length = static_cast<std::int64_t>(wanted);
    window_.clear();
    at_ = 0;
    SKYQUILT_TRY_ASSIGN(window_, proof_.is_by_ranges ? blobs_.ReadNear(key_, from, length)
                                                     : blobs_.ReadRange(key_, from, length));
    if (window_.size() != wanted)
      return Error{ErrorCode::kIo, "The file could not be read.", key_ + ": short"};
    next_ += wanted;
    left_ -= wanted;
    if (proof_.whole) sum_.Add(window_);
    if (proof_.whole && left_ == 0 && sum_.Finish() != *proof_.whole) {
      window_.clear();
      return Error{ErrorCode::kUnavailable, "The store has another file than was published there.", key_};
    }
    return {};
  }

 private:
  static constexpr std::uint64_t kWindowBytes = std::uint64_t{4} << 20;
  storage::BlobStore& blobs_;
  const std::string key_;
  std::uint64_t next_;  // behind the window
  std::uint64_t left_;  // from there on
  const std::uint64_t length_;
  const Proof proof_;
  storage::Sha256Sum sum_;
  std::string window_;
  std::size_t at_ = 0;
};

}  // namespace

Result<Response> SendBlob(const Request& request, storage::BlobStore& blobs, const std::string& key,
                          const std::string& content_type, const std::string& etag) {
  constexpr std::int64_t kFetchedBytes = std::int64_t{4} << 20;
  if (blobs.IsFolder()) return SendFile(request, blobs.FolderOf(key), content_type, etag);
  SKYQUILT_TRY_ASSIGN(const storage::BlobInfo blob, blobs.Find(key));
  Proof proof;
  SKYQUILT_TRY_ASSIGN(proof.whole, blobs.KnownSum(key));
  const bool is_range = request.headers.Has("Range");
  if (proof.whole && is_range && storage::IsReadByRanges(key)) {
    SKYQUILT_TRY_ASSIGN(const std::optional<std::string> sums, blobs.KnownSum(storage::RangeSumsKey(key)));
    proof.is_by_ranges = sums && !sums->empty();
    if (proof.is_by_ranges) proof.whole.reset();
  }
  // What a part is worth only the whole file tells then.
  if (blob.bytes <= kFetchedBytes || (proof.whole && is_range)) {
    const Result<storage::LocalBlob> fetched = blobs.Local(key);
    // It may be put right where it lies.
    if (!fetched && fetched.error().code == ErrorCode::kCorrupt)
      return Error{ErrorCode::kUnavailable, fetched.error().message, fetched.error().detail};
    if (!fetched) return fetched.error();
    return SendFile(request, fetched->path, content_type, etag);
  }
  const OpenPart part = [&](std::uint64_t offset,
                            std::uint64_t length) -> Result<std::unique_ptr<BodySource>> {
    auto source = std::make_unique<BlobSource>(blobs, key, offset, length, proof);
    if (proof.is_by_ranges) SKYQUILT_TRY(source->ReadWindow());
    return std::unique_ptr<BodySource>(std::move(source));
  };
  return SendParts(request, static_cast<std::uint64_t>(blob.bytes), content_type, etag, part);
}

Result<Response> SendParts(const Request& request, std::uint64_t size, const std::string& content_type,
                           const std::string& etag, const OpenPart& open) {
  if (request.headers.Has("If-Match") && !EtagListMatches(request.headers.Find("If-Match"), etag)) {
    return Error{ErrorCode::kPreconditionFailed, "The file is no more the one that If-Match names."};
  }
  Response response;
  response.headers.Add("ETag", etag);
  response.headers.Add("Accept-Ranges", "bytes");
  if (EtagListMatches(request.headers.Find("If-None-Match"), etag)) {
    response.status = 304;
    return response;
  }
  response.headers.Add("Content-Type", content_type);
  ByteRange range;
  if (request.headers.Has("Range") &&
      (!request.headers.Has("If-Range") || IfRangeMatches(request.headers.Find("If-Range"), etag))) {
    range = ParseRange(request.headers.Find("Range"), size);
  }
  if (range.kind == RangeKind::kUnsatisfiable) {
    return Error{ErrorCode::kRangeNotSatisfiable, fmt::format("bytes */{}", size)};
  }
  if (range.kind == RangeKind::kPart) {
    response.status = 206;
    response.headers.Add("Content-Range",
                         fmt::format("bytes {}-{}/{}", range.first, range.first + range.length - 1, size));
  }
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<BodySource> source,
                      range.kind == RangeKind::kPart ? open(range.first, range.length) : open(0, size));
  response.source = std::move(source);
  return response;
}

Response Downloaded(Result<Response> sent, const Request& request) {
  if (sent || sent.error().code != ErrorCode::kRangeNotSatisfiable) return Answered(std::move(sent), request);
  Response response = Problem({ErrorCode::kRangeNotSatisfiable, "The range lies outside the file."}, request);
  response.headers.Add("Content-Range", sent.error().message);
  return response;
}

std::string Disposition(const std::string& stem, const char* extension) {
  return fmt::format("attachment; filename=\"mosaic.{0}\"; filename*=UTF-8''{1}.{0}", extension,
                     PercentEncoded(stem, "-_"));
}

Result<Response> SendFile(const Request& request, const std::filesystem::path& path,
                          const std::string& content_type, const std::string& etag) {
  FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  struct stat status {};
  if (!file.is_open() || fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) {
    if (file.is_open() || errno == ENOENT || errno == ENOTDIR || errno == ELOOP) {
      return Error{ErrorCode::kNotFound, "There is no such file.", path.string()};
    }
    return Error{ErrorCode::kIo, "The file could not be opened.",
                 path.string() + ": " + std::strerror(errno)};
  }
  const OpenPart part = [&](std::uint64_t offset,
                            std::uint64_t length) -> Result<std::unique_ptr<BodySource>> {
    return std::unique_ptr<BodySource>(std::make_unique<FileSource>(std::move(file), offset, length));
  };
  return SendParts(request, static_cast<std::uint64_t>(status.st_size), content_type, etag, part);
}

}  // namespace skyquilt::api
