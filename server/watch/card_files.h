// CardFiles: what lies in folders that fill, empty and vanish while they are looked at (cards, hot folders):
// photos with their camera and time, and what belongs beside them (logs, lists, elevation models). A file
// counts when its size and time stand still and a photo has its end; nothing is ever written there. Hidden
// files, thumbnails of cameras and films are passed over, and what the caller says. Bounded: kMaxFiles,
// kMaxDepth. One thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/digest.h"
#include "core/flight/photo.h"
#include "core/flight/read_flight.h"

namespace skyquilt::server {

enum class CardKind {
  kUnread,  // still changing, or not looked at yet
  kPhoto,
  kBeside,  // a log, a list of positions or control points, an elevation model
  kFilm,
  kCut,    // a photo without its end (still being written, or broken), or that cannot be read
  kOther,  // nothing of a flight's
};

struct CardFile {
  using Clock = std::chrono::steady_clock;
  std::uint64_t bytes = 0;
  std::filesystem::file_time_type written_at;
  Clock::time_point changed_at;  // when this program saw it change last
  Clock::time_point read_at;
  CardKind kind = CardKind::kUnread;
  std::string model, camera;
  std::optional<flight::UtcTime> taken_at;
  std::chrono::minutes clock_minus_utc{0};
  bool is_seen = true;
  std::optional<Digest> digest;  // once somebody asked
};

class CardFiles {
 public:
  static constexpr std::size_t kMaxFiles = 200'000;
  static constexpr int kMaxDepth = 12;

  CardFiles(std::vector<std::filesystem::path> roots, std::chrono::milliseconds settle,
            flight::PassesOver passes_over = {})
      : roots_(std::move(roots)), settle_(settle), passes_over_(std::move(passes_over)) {}

  // Looks again. What changed is read when it has stood still, and, as that takes minutes on a full card,
  // while `go_on` (absent: always) says so.
  void Look(const std::function<bool()>& go_on = nullptr);
  const std::map<std::filesystem::path, CardFile>& files() const { return files_; }
  std::map<std::filesystem::path, CardFile>& files() { return files_; }
  const std::vector<std::filesystem::path>& folders() const { return folders_; }  // found by the last look
  const std::vector<std::filesystem::path>& roots() const { return roots_; }
  std::vector<std::filesystem::path> roots_away() const { return away_; }
  bool has_too_many() const { return has_too_many_; }
  // By the caller's word, in the last look.
  const std::vector<std::filesystem::path>& passed_over() const { return passed_over_; }
  // Folders that may not be looked into, in the last look.
  const std::vector<std::filesystem::path>& denied() const { return denied_; }

 private:
  void Walk(const std::filesystem::path& root);
  void Take(const std::filesystem::directory_entry& entry);

  const std::vector<std::filesystem::path> roots_;
  const std::chrono::milliseconds settle_;
  const flight::PassesOver passes_over_;
  std::map<std::filesystem::path, CardFile> files_;
  std::vector<std::filesystem::path> folders_, away_, passed_over_, denied_;
  bool has_too_many_ = false;
};

// What device and folder a path leads to now: another one after something was mounted there. Nothing: none.
std::optional<std::pair<std::uint64_t, std::uint64_t>> PlaceOf(const std::filesystem::path& folder);

}  // namespace skyquilt::server
