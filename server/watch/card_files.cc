#include "server/watch/card_files.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/base/text/file_names.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/lists/sort_files.h"
#include "core/flight/metadata/capture_time.h"
#include "core/flight/photos/jpeg_segments.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kStandsStill{500};

bool IsPassedOver(const fs::path& path) {
  const std::string name = path.filename().string();
  if (IsOfPrograms(name) || name.starts_with('$')) return true;
  // Of Android, and DJI's thumbnails.
  constexpr std::array<std::string_view, 3> kFolders{"LOST.DIR", "MISC", "THM"};
  if (std::find(kFolders.begin(), kFolders.end(), name) != kFolders.end()) return true;
  const std::string ending = flight::LowerCase(path.extension().string());
  // Thumbnails and films of low resolution beside the true ones; and what copying programs leave unfinished.
  constexpr std::array<std::string_view, 7> kEndings{".thm", ".scr",  ".lrf",       ".lrv",
                                                     ".tmp", ".part", ".crdownload"};
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

// A JPEG or PNG without its end is cut; of other formats nothing tells.
bool HasItsEnd(flight::ByteSource& source) {
  const std::vector<std::uint8_t> head = source.ReadUpTo(0, 8);
  if (head.size() > 2 && head[0] == 0xFF && head[1] == 0xD8) {
    const auto segments = flight::ScanJpegSegments(source);
    return segments && flight::HasEndOfImage(source, segments->scan_offset);
  }
  if (head.size() == 8 && head[1] == 'P' && head[2] == 'N' && head[3] == 'G') {
    constexpr std::size_t kLastChunk = 12;
    if (source.size() < kLastChunk) return false;
    const std::vector<std::uint8_t> tail = source.ReadUpTo(source.size() - kLastChunk, kLastChunk);
    return tail.size() == kLastChunk && std::string(tail.begin() + 4, tail.begin() + 8) == "IEND";
  }
  return true;
}

CardKind KindOfPhoto(const flight::InputFile& input, CardFile& file) {
  const auto source = flight::OpenFileBytes(input.path);
  // Gone just now, or not for us to read: asked again as one that is not whole.
  if (!source) return CardKind::kCut;
  if (file.bytes == 0 || !HasItsEnd(**source)) return CardKind::kCut;
  Result<flight::Photo> photo = flight::ReadPhoto(input);
  if (!photo) return CardKind::kOther;
  if (!photo->captured_at) {
    if (const auto named = flight::TimeInName(input.name)) photo->captured_at = named->time;
  }
  file.taken_at = photo->captured_at;
  file.clock_minus_utc = photo->clock_minus_utc.value_or(std::chrono::minutes(0));
  file.model = photo->model;
  // Maker, model and serial number; size, focal length and band may change within one flight.
  std::size_t end = 0;
  for (int bars = 0; end < photo->camera_key.size(); ++end) {
    if (photo->camera_key[end] == '|' && ++bars == 3) break;
  }
  file.camera = photo->camera_key.substr(0, end);
  return CardKind::kPhoto;
}

void Read(const fs::path& path, CardFile& file) {
  file.read_at = CardFile::Clock::now();
  file.digest.reset();
  const flight::InputFile input{path.filename().string(), path};
  const flight::SortedFiles sorted = flight::SortFiles({input});
  if (!sorted.photos.empty()) {
    file.kind = KindOfPhoto(input, file);
  } else if (!sorted.films.empty()) {
    file.kind = CardKind::kFilm;
  } else if (!sorted.logs.empty() || !sorted.gcp_lists.empty() || !sorted.elevation_models.empty() ||
             !sorted.reflectance_lists.empty() || !sorted.sidecars.empty()) {
    file.kind = CardKind::kBeside;
  } else {
    file.kind = CardKind::kOther;
  }
}

}  // namespace

std::optional<std::pair<std::uint64_t, std::uint64_t>> PlaceOf(const fs::path& folder) {
  struct stat status {};
  if (stat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) return std::nullopt;
  return std::pair{static_cast<std::uint64_t>(status.st_dev), static_cast<std::uint64_t>(status.st_ino)};
}

void CardFiles::Take(const fs::directory_entry& entry) {
  std::error_code gone;
  if (!entry.is_regular_file(gone) || gone) return;
  const std::uint64_t bytes = entry.file_size(gone);
  if (gone) return;
  const fs::file_time_type written_at = entry.last_write_time(gone);
  if (gone) return;
  if (files_.size() >= kMaxFiles && !files_.contains(entry.path())) {
    has_too_many_ = true;
    return;
  }
  const auto [found, is_new] = files_.try_emplace(entry.path());
  CardFile& file = found->second;
  file.is_seen = true;
  if (!is_new && file.bytes == bytes && file.written_at == written_at) return;
  file.bytes = bytes;
  file.written_at = written_at;
  file.changed_at = CardFile::Clock::now();
  file.kind = CardKind::kUnread;
}

void CardFiles::Walk(const fs::path& root) {
  std::error_code error;
  fs::recursive_directory_iterator it(root, fs::directory_options::skip_permission_denied, error);
  if (error) {
    away_.push_back(root);
    return;
  }
  const auto add_folder = [this](const fs::path& folder) {
    folders_.push_back(folder);
    if (flight::IsDenied(folder)) denied_.push_back(folder);
  };
  add_folder(root);
  while (it != fs::recursive_directory_iterator()) {
    std::error_code gone;
    const bool is_folder = it->is_directory(gone) && !it->is_symlink(gone);
    if (IsPassedOver(it->path()) || (is_folder && it.depth() >= kMaxDepth)) {
      if (is_folder) it.disable_recursion_pending();
    } else if (is_folder) {
      add_folder(it->path());
    } else if (passes_over_ && passes_over_(it->path(), root)) {
      passed_over_.push_back(it->path());
    } else {
      Take(*it);
    }
    it.increment(error);
    if (error) return;  // a folder or the disk went away; the next look says
  }
}

void CardFiles::Look(const std::function<bool()>& go_on) {
  folders_.clear();
  away_.clear();
  passed_over_.clear();
  denied_.clear();
  has_too_many_ = false;
  for (auto& [path, file] : files_) file.is_seen = false;
  for (const fs::path& root : roots_) Walk(root);
  std::erase_if(files_, [](const auto& entry) { return !entry.second.is_seen; });
  const CardFile::Clock::time_point now = CardFile::Clock::now();
  for (auto& [path, file] : files_) {
    if (go_on && !go_on()) return;
    const bool is_still = now - file.changed_at >= std::min(kStandsStill, settle_);
    // A copying program may have made the file as long as it will be, and fill it.
    const bool may_have_ended = file.kind == CardKind::kCut && now - file.read_at >= settle_;
    if ((file.kind != CardKind::kUnread && !may_have_ended) || !is_still) continue;
    const bool was_cut = file.kind == CardKind::kCut;
    Read(path, file);
    if (was_cut && file.kind == CardKind::kPhoto) file.changed_at = now;
  }
}

}  // namespace skyquilt::server
