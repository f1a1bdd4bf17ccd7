#include "server/watch/sent_ledger.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

constexpr const char* kLedgerHead = "{\"skyquilt\":\"sent\",\"version\":1}";
constexpr std::size_t kMaxLineBytes = std::size_t{64} << 20;

std::optional<Digest> DigestOf(const std::string& hex) {
  Digest digest{};
  if (hex.size() != 2 * digest.size()) return std::nullopt;
  for (std::size_t i = 0; i < digest.size(); ++i) {
    const char* at = hex.data() + 2 * i;
    const auto [end, failed] = std::from_chars(at, at + 2, digest[i], 16);
    if (failed != std::errc() || end != at + 2) return std::nullopt;
  }
  return digest;
}

// While it lives no other process writes.
class LedgerLock {
 public:
  explicit LedgerLock(int file) : file_(file) {
    while (flock(file_, LOCK_EX) != 0 && errno == EINTR) {
    }
  }
  ~LedgerLock() { flock(file_, LOCK_UN); }
  LedgerLock(const LedgerLock&) = delete;
  LedgerLock& operator=(const LedgerLock&) = delete;

 private:
  int file_;
};

}  // namespace

std::string HexOf(const Digest& digest) {
  std::string hex;
  for (const std::uint8_t byte : digest) hex += fmt::format("{:02x}", byte);
  return hex;
}

Result<SentLedger> SentLedger::Open(const std::filesystem::path& path) {
  std::error_code failed;
  std::filesystem::create_directories(path.parent_path(), failed);
  if (failed) return storage::FileError("cannot make", path.parent_path(), failed.value());
  FileDescriptor file(open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0600));
  if (!file.is_open()) return storage::FileError("cannot open", path, errno);
  SentLedger ledger(path, std::move(file));
  {
    const LedgerLock lock(ledger.file_.get());
    if (lseek(ledger.file_.get(), 0, SEEK_END) == 0) {
      SKYQUILT_TRY(ledger.Append(kLedgerHead));
      SKYQUILT_TRY(storage::SyncFolder(path.parent_path()));
    }
  }
  std::string head(std::string_view(kLedgerHead).size(), '\0');
  const ssize_t read = ledger.file_.ReadAt(0, head.data(), head.size());
  if (read != static_cast<ssize_t>(head.size()) || head != kLedgerHead)
    return Error{ErrorCode::kCorrupt,
                 path.string() + " is no list of what was sent. Move it away, or name another with --state."};
  SKYQUILT_TRY(ledger.Refresh());
  return ledger;
}

Result<void> SentLedger::Refresh() {
  std::array<char, 1 << 16> block{};
  for (;;) {
    const ssize_t read = file_.ReadAt(read_bytes_, block.data(), block.size());
    if (read < 0) return storage::FileError("cannot read", path_, errno);
    if (read == 0) return {};
    read_bytes_ += static_cast<std::uint64_t>(read);
    for (const char c : std::string_view(block.data(), static_cast<std::size_t>(read))) {
      if (c == '\n') {
        Apply(begun_line_);
        begun_line_.clear();
      } else if (begun_line_.size() < kMaxLineBytes) {
        begun_line_ += c;
      }
    }
  }
}

void SentLedger::Apply(const std::string& line) {
  const nlohmann::json value = ParseJson(line);
  if (!value.is_object()) return;
  const std::string key = TextIn(value, "flight").value_or("");
  if (key.empty()) return;
  const auto [found, is_new] = flights_.try_emplace(key);
  SentFlight& flight = found->second;
  if (is_new) {
    flight.key = key;
    order_.push_back(key);
  }
  if (value.contains("name")) flight.name = TextIn(value, "name").value_or("");
  if (value.contains("id")) flight.id = TextIn(value, "id").value_or("");
  if (value.contains("gone")) flight.is_gone = true;
  if (const auto files = value.find("files"); files != value.end() && files->is_object()) {
    for (const auto& [hex, name] : files->items()) {
      const auto digest = DigestOf(hex);
      if (!digest || !name.is_string()) continue;
      flight.files[*digest] = name.get<std::string>();
      last_with_[*digest] = key;
    }
  }
  if (const auto sent = value.find("sent"); sent != value.end() && sent->is_array()) {
    for (const nlohmann::json& hex : *sent) {
      const auto digest = hex.is_string() ? DigestOf(hex.get<std::string>()) : std::nullopt;
      if (digest) flight.sent[*digest] = true;
    }
  }
}

Result<void> SentLedger::Append(const std::string& line) {
  // After a line that a kill tore a new one begins.
  const off_t end = lseek(file_.get(), 0, SEEK_END);
  char last = '\n';
  if (end > 0 && file_.ReadAt(static_cast<std::uint64_t>(end - 1), &last, 1) != 1)
    return storage::FileError("cannot read", path_, errno);
  const std::string text = (last == '\n' ? "" : "\n") + line + "\n";
  if (file_.Write(text.data(), text.size()) != text.size() || fsync(file_.get()) != 0)
    return storage::FileError("cannot write", path_, errno);
  return Refresh();
}

bool SentLedger::IsSent(const Digest& digest) const {
  const auto last = last_with_.find(digest);
  return last != last_with_.end() && flights_.at(last->second).sent.contains(digest);
}

const SentFlight* SentLedger::Find(const std::vector<Digest>& digests) const {
  for (auto key = order_.rbegin(); key != order_.rend(); ++key) {
    const SentFlight& flight = flights_.at(*key);
    if (flight.is_gone) continue;
    for (const Digest& digest : digests) {
      if (flight.files.contains(digest)) return &flight;
    }
  }
  return nullptr;
}

Result<void> SentLedger::Tell(const std::string& key, const char* what, nlohmann::json value) {
  const nlohmann::json line = {{"flight", key}, {what, std::move(value)}};
  const LedgerLock lock(file_.get());
  return Append(JsonText(line));
}

Result<void> SentLedger::Begin(const std::string& key, const std::string& name) {
  return Tell(key, "name", name);
}

Result<void> SentLedger::WillSend(const std::string& key, const std::map<Digest, std::string>& files) {
  nlohmann::json named = nlohmann::json::object();
  for (const auto& [digest, name] : files) named[HexOf(digest)] = name;
  return Tell(key, "files", std::move(named));
}

Result<void> SentLedger::Made(const std::string& key, const std::string& id) { return Tell(key, "id", id); }

Result<void> SentLedger::Sent(const std::string& key, const std::vector<Digest>& digests) {
  nlohmann::json hexes = nlohmann::json::array();
  for (const Digest& digest : digests) hexes.push_back(HexOf(digest));
  return Tell(key, "sent", std::move(hexes));
}

Result<void> SentLedger::Gone(const std::string& key) { return Tell(key, "gone", true); }

}  // namespace skyquilt::server
