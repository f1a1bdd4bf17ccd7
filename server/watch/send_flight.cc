#include "server/watch/send_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <system_error>
#include <vector>

#include "api/json/json_codec.h"
#include "core/base/text/file_names.h"
#include "core/base/text/plain_text.h"
#include "core/base/try.h"
#include "core/flight/read_flight.h"
#include "server/client/upload_flight.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

struct KnownFile {
  fs::path path;
  Digest digest{};
  bool is_photo = true;
};

Result<std::vector<KnownFile>> FilesByContent(const CardFlight& flight, CardFiles& card, Progress& progress) {
  std::vector<KnownFile> files;
  std::set<Digest> seen;
  const std::size_t all = flight.photos.size() + flight.beside.size();
  const auto add = [&](const fs::path& path, bool is_photo) -> Result<void> {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "Cancelled."};
    CardFile& file = card.files().at(path);
    if (!file.digest) {
      SKYQUILT_TRY_ASSIGN(const Digest digest, DigestOfFile(path));
      file.digest = digest;
    }
    progress.Report(static_cast<double>(files.size()) / static_cast<double>(all),
                    fmt::format("looking whether {} was sent before", path.filename().string()));
    if (seen.insert(*file.digest).second) files.push_back({path, *file.digest, is_photo});
    return {};
  };
  for (const fs::path& path : flight.photos) SKYQUILT_TRY(add(path, true));
  for (const fs::path& path : flight.beside) SKYQUILT_TRY(add(path, false));
  return files;
}

std::vector<Digest> DigestsOf(const std::vector<KnownFile>& files) {
  std::vector<Digest> digests;
  digests.reserve(files.size());
  for (const KnownFile& file : files) digests.push_back(file.digest);
  return digests;
}

std::string NewKey(const std::vector<Digest>& digests) {
  Hasher hasher;
  for (const Digest& digest : digests) hasher.AddBytes(digest.data(), digest.size());
  hasher.Add(std::chrono::system_clock::now().time_since_epoch().count());
  return "watch-" + HexOf(hasher.Finish());
}

std::string JobKey(const std::string& key, std::vector<Digest> digests) {
  std::sort(digests.begin(), digests.end());
  Hasher hasher;
  for (const Digest& digest : digests) hasher.AddBytes(digest.data(), digest.size());
  return key + "-" + HexOf(hasher.Finish());
}

// Names under which `lacking` are sent, some of `files`: those they had before, else as files of several
// folders are called everywhere.
std::map<Digest, std::string> NamesFor(const std::vector<KnownFile>& files,
                                       const std::vector<KnownFile>& lacking, const SentFlight* before) {
  std::vector<std::string> paths;
  for (const KnownFile& file : files) {
    std::error_code gone;
    const fs::path whole = fs::absolute(file.path, gone);
    paths.push_back((gone ? file.path : whole).lexically_normal().generic_string());
  }
  const std::vector<std::string> apart = NamesApart(paths);
  std::map<Digest, std::string> own;
  for (std::size_t i = 0; i < files.size(); ++i) own[files[i].digest] = WithFoldersJoined(apart[i]);
  std::map<Digest, std::string> names;
  std::set<std::string> taken;
  if (before != nullptr) {
    for (const auto& [digest, name] : before->files) taken.insert(name);
  }
  for (const KnownFile& file : lacking) {
    if (before != nullptr && before->files.contains(file.digest)) {
      names[file.digest] = before->files.at(file.digest);
      continue;
    }
    std::string name = own.at(file.digest);
    for (int copy = 2; !taken.insert(name).second; ++copy)
      name = NumberedName(own.at(file.digest), std::to_string(copy));
    names[file.digest] = std::move(name);
  }
  return names;
}

}  // namespace

Result<SentNow> SendCardFlight(const CardFlight& flight, CardFiles& card, SentLedger& ledger,
                               const SendOptions& options, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const std::vector<KnownFile> files, FilesByContent(flight, card, progress));
  SKYQUILT_TRY(ledger.Refresh());
  std::vector<KnownFile> lacking;
  for (const KnownFile& file : files) {
    if (!ledger.IsSent(file.digest)) lacking.push_back(file);
  }
  if (lacking.empty()) return SentNow{};
  const SentFlight* before = ledger.Find(DigestsOf(files));
  // The flight was deleted on the server, and more came: a new one of all.
  if (before == nullptr) lacking = files;
  SentNow now;
  const std::map<Digest, std::string> names = NamesFor(files, lacking, before);
  std::string key = before != nullptr ? before->key : "";
  if (before == nullptr) {
    key = NewKey(DigestsOf(files));
    SKYQUILT_TRY(ledger.Begin(key, options.name_prefix + flight.name));
  }
  SKYQUILT_TRY(ledger.WillSend(key, names));
  UploadOptions upload;
  upload.server = options.server;
  upload.name = CutToBytes(ledger.At(key).name, api::kMaxFlightNameBytes);
  upload.flight_id = ledger.At(key).id;
  upload.makes_map = options.makes_map;
  upload.waits = false;
  upload.flight_once_key = key;
  upload.job_once_key = JobKey(key, DigestsOf(lacking));
  now.is_new = ledger.At(key).sent.empty();
  std::vector<flight::InputFile> inputs;
  for (const KnownFile& file : lacking) inputs.push_back({names.at(file.digest), file.path});
  Result<void> kept;
  const Result<UploadedFlight> uploaded = UploadFlight(
      inputs, upload,
      [&](const std::string& id) {
        now.flight_id = id;
        if (upload.flight_id.empty()) kept = ledger.Made(key, id);
      },
      progress);
  if (!kept) return kept.error();
  if (!uploaded) {
    // It was deleted there: what comes next is a flight of its own.
    if (uploaded.error().code == ErrorCode::kNotFound && !upload.flight_id.empty()) {
      SKYQUILT_TRY(ledger.Gone(key));
      return SendCardFlight(flight, card, ledger, options, progress);
    }
    return uploaded.error();
  }
  SKYQUILT_TRY(ledger.Sent(key, DigestsOf(lacking)));
  now.files = uploaded->sent + uploaded->skipped;
  return now;
}

}  // namespace skyquilt::server
