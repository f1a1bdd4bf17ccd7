#include "storage/uploads/unpack_archive.h"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>
#include <locale.h>

#include <algorithm>
#include <array>
#include <memory>
#include <system_error>

#include "core/base/text/file_names.h"
#include "core/base/text/plain_text.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/uploads/zip_directory.h"

namespace skyquilt::storage {
namespace {

constexpr std::size_t kBlockBytes = 256 * 1024;
constexpr std::int64_t kGrowthFrom = std::int64_t{1} << 20;

using Archive = std::unique_ptr<struct archive, decltype(&archive_read_free)>;

// The library hands out names by way of the thread's locale: in "C" those with other letters than ASCII's are
// lost, although the archive says that they are UTF-8.
class NamesInUtf8 {
 public:
  NamesInUtf8() : locale_(newlocale(LC_CTYPE_MASK, "C.UTF-8", locale_t{})) {
    if (locale_ != locale_t{}) before_ = uselocale(locale_);
  }
  ~NamesInUtf8() {
    if (locale_ == locale_t{}) return;
    uselocale(before_);
    freelocale(locale_);
  }
  NamesInUtf8(const NamesInUtf8&) = delete;
  NamesInUtf8& operator=(const NamesInUtf8&) = delete;

 private:
  locale_t locale_;
  locale_t before_{};
};

Error Refuse(std::string why, const char* detail = "") {
  return flight::Because(ErrorCode::kUnprocessable, {flight::RemarkCode::kFailArchive, {{"why_words", why}}},
                         detail);
}

const char* Words(struct archive* archive) {
  const char* text = archive_error_string(archive);
  return text == nullptr ? "" : text;
}

// The name as it stands in the archive; empty where it has none that can be read.
std::string FullName(struct archive_entry* entry) {
  const char* name = archive_entry_pathname_utf8(entry);
  if (name == nullptr) name = archive_entry_pathname(entry);
  return name == nullptr ? std::string() : std::string(name);
}

std::string LastPart(const std::string& name) { return name.substr(name.find_last_of('/') + 1); }

// What programs leave in archives beside the files, or below a folder of theirs.
bool IsClutter(std::string_view full_name) {
  for (std::string_view rest = full_name; !rest.empty();) {
    const std::string_view part = rest.substr(0, rest.find('/'));
    if (part != "." && part != ".." && IsOfPrograms(part)) return true;
    rest.remove_prefix(std::min(part.size() + 1, rest.size()));
  }
  return LastPart(std::string(full_name)) == "Thumbs.db";
}

// Whether an entry of a zip, just begun, is compressed in a way whose memory the format bounds. LZMA, xz,
// Zstandard and PPMd allocate what the entry declares, up to gigabytes, before the first byte of output.
// libarchive tells it only by a name: "ZIP 6.3 (lzma)".
bool HasBoundedMemory(struct archive* archive) {
  if ((archive_format(archive) & ARCHIVE_FORMAT_BASE_MASK) != ARCHIVE_FORMAT_ZIP) return true;
  const std::string_view name = archive_format_name(archive);
  return name.ends_with("(uncompressed)") || name.ends_with("(deflation)") || name.ends_with("(bzip)");
}

std::optional<Error> WrongWith(struct archive_entry* entry, const std::string& full_name) {
  const auto wrong = [](const char* why) { return Error{ErrorCode::kUnprocessable, why, ""}; };
  if (archive_entry_filetype(entry) != AE_IFREG || archive_entry_hardlink(entry) != nullptr) {
    return wrong("Links and devices in archives are not taken.");
  }
  const bool leaves = full_name.starts_with('/') || full_name.starts_with("../") ||
                      full_name.find("/../") != std::string::npos ||
                      full_name.find('\\') != std::string::npos ||
                      (full_name.size() > 1 && full_name[1] == ':');
  if (leaves) return wrong("A name that leads out of the archive is not taken.");
  if (full_name.empty()) return wrong("Its name in the archive cannot be read. Pack it under another one.");
  SKYQUILT_TRY(CheckFileName(LastPart(full_name)));
  if (IsArchiveName(full_name)) return wrong("An archive inside an archive is not opened. Unpack it first.");
  return std::nullopt;
}

// One archive on its way into the store.
class Unpacking {
 public:
  Unpacking(const PhotoStore& store, std::string flight_id, const ArchiveLimits& limits,
            std::int64_t archive_bytes)
      : store_(store), flight_id_(std::move(flight_id)), limits_(limits), archive_bytes_(archive_bytes) {}
  ~Unpacking() {
    if (is_kept_) return;
    for (const UnpackedFile& file : files_) {
      if (!file.error) store_.Remove(flight_id_, file.file.stored_name);
    }
  }
  Unpacking(const Unpacking&) = delete;
  Unpacking& operator=(const Unpacking&) = delete;

  Result<void> Take(struct archive* archive, struct archive_entry* entry) {
    if (++entries_ > limits_.entries)
      return Refuse(fmt::format("it has more than {} entries", limits_.entries));
    if (archive_entry_is_encrypted(entry) != 0) return Refuse("it is encrypted");
    const std::string full_name = FullName(entry);
    if (!HasBoundedMemory(archive)) {
      return Refuse(
          fmt::format("{} in it is compressed by another method than zip's usual one (deflate); pack it anew "
                      "with that",
                      IsValidUtf8(full_name) ? full_name : "a file"),
          archive_format_name(archive));
    }
    if (archive_entry_filetype(entry) == AE_IFDIR || IsClutter(full_name)) return PassOver(archive);
    UnpackedFile file;
    file.file.name = LastPart(full_name);
    file.error = WrongWith(entry, full_name);
    if (!file.error) {
      SKYQUILT_TRY_ASSIGN(Upload upload, store_.Begin(flight_id_, 0));
      SKYQUILT_TRY(Copy(archive, upload));
      file.file.bytes = upload.bytes();
      const Result<std::string> stored = upload.Finish();
      if (!stored && stored.error().code != ErrorCode::kUnprocessable) return stored.error();
      if (stored) file.file.stored_name = *stored;
      if (!stored) file.error = stored.error();
    }
    const bool was_read = !file.file.stored_name.empty() || !file.error;
    files_.push_back(std::move(file));
    full_names_.push_back(full_name.starts_with("./") ? full_name.substr(2) : full_name);
    return was_read ? Result<void>() : PassOver(archive);
  }

  std::vector<UnpackedFile> Keep() {
    is_kept_ = true;
    TellFoldersApart();
    return std::move(files_);
  }

 private:
  // Files of one name in several folders keep the folders in their names, as far as a name may be as long.
  void TellFoldersApart() {
    std::vector<std::size_t> taken;
    std::vector<std::string> paths;
    for (std::size_t i = 0; i < files_.size(); ++i) {
      if (files_[i].error) continue;
      taken.push_back(i);
      paths.push_back(std::move(full_names_[i]));
    }
    std::vector<std::string> names = NamesApart(paths);
    for (std::size_t k = 0; k < taken.size(); ++k) {
      std::string name = WithFoldersJoined(std::move(names[k]));
      if (CheckFileName(name)) files_[taken[k]].file.name = std::move(name);
    }
  }

  // To what follows an entry that is not taken, the archive is unpacked all the same.
  Result<void> PassOver(struct archive* archive) {
    const void* block = nullptr;
    std::size_t size = 0;
    la_int64_t offset = 0;
    while (true) {
      const int got = archive_read_data_block(archive, &block, &size, &offset);
      if (got == ARCHIVE_EOF) return {};
      if (got < ARCHIVE_WARN) return Refuse("it is damaged", Words(archive));
      total_ += static_cast<std::int64_t>(size);
      SKYQUILT_TRY(CheckTotal());
    }
  }

  Result<void> CheckTotal() const {
    if (total_ > limits_.room_bytes) {
      return Error{ErrorCode::kTooLarge, "The archive was not taken: there is no room for what is in it.",
                   ""};
    }
    if (total_ > limits_.total_bytes) return Refuse("it unpacks to more than the server takes");
    if (total_ > kGrowthFrom && total_ / limits_.growth > archive_bytes_) {
      return Refuse(fmt::format("it unpacks to more than {} times its size", limits_.growth));
    }
    return {};
  }

  // Counts what really comes out: the sizes that archives declare may lie.
  Result<void> Copy(struct archive* archive, Upload& upload) {
    std::vector<std::uint8_t> block(kBlockBytes);
    while (true) {
      const la_ssize_t got = archive_read_data(archive, block.data(), block.size());
      if (got < 0) return Refuse("it is damaged", Words(archive));
      if (got == 0) return {};
      total_ += got;
      if (upload.bytes() + got > limits_.file_bytes) {
        return Refuse(fmt::format("a file in it is larger than {} MiB", limits_.file_bytes >> 20));
      }
      SKYQUILT_TRY(CheckTotal());
      SKYQUILT_TRY(upload.Write({block.data(), static_cast<std::size_t>(got)}));
    }
  }

  const PhotoStore& store_;
  std::string flight_id_;
  ArchiveLimits limits_;
  std::int64_t archive_bytes_;
  int entries_ = 0;
  std::int64_t total_ = 0;
  std::vector<UnpackedFile> files_;
  std::vector<std::string> full_names_;  // of `files_`
  bool is_kept_ = false;
};

}  // namespace

bool IsArchiveName(std::string_view name) {
  constexpr std::array<std::string_view, 4> kEnds = {".zip", ".tar", ".tar.gz", ".tgz"};
  const std::string lower = LowerCase(name);
  return std::any_of(kEnds.begin(), kEnds.end(), [&](std::string_view end) { return lower.ends_with(end); });
}

Result<std::vector<UnpackedFile>> UnpackArchive(const PhotoStore& store, const std::string& flight_id,
                                                const std::filesystem::path& path,
                                                const ArchiveLimits& limits) {
  std::error_code error;
  const auto archive_bytes = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  if (error) return Error{ErrorCode::kIo, "The archive could not be read.", error.message()};
  if (CountZipEntries(path, limits.entries) > limits.entries)
    return Refuse(fmt::format("it has more than {} entries", limits.entries));
  if (HasZipNameWithNul(path))
    return Refuse("the name of a file in it has a NUL character, which no name can have");
  const NamesInUtf8 names_in_utf8;
  const Archive archive(archive_read_new(), &archive_read_free);
  archive_read_support_format_zip_seekable(archive.get());
  archive_read_support_format_tar(archive.get());
  archive_read_support_filter_gzip(archive.get());
  if (archive_read_open_filename(archive.get(), path.c_str(), kBlockBytes) != ARCHIVE_OK) {
    return Refuse("it is neither zip nor tar", Words(archive.get()));
  }
  Unpacking unpacking(store, flight_id, limits, archive_bytes);
  while (true) {
    struct archive_entry* entry = nullptr;
    const int got = archive_read_next_header(archive.get(), &entry);
    if (got == ARCHIVE_EOF) return unpacking.Keep();
    if (got != ARCHIVE_OK && got != ARCHIVE_WARN) return Refuse("it is damaged", Words(archive.get()));
    SKYQUILT_TRY(unpacking.Take(archive.get(), entry));
  }
}

}  // namespace skyquilt::storage
