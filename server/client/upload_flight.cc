#include "server/client/upload_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>
#include <thread>
#include <utility>

#include "api/http/digest.h"
#include "api/http/links.h"
#include "core/base/text/file_names.h"
#include "core/base/text/json_io.h"
#include "core/base/text/printable.h"
#include "core/base/try.h"
#include "storage/blobs/sha256.h"
#include "storage/db/ids.h"

namespace skyquilt::server {
namespace {

using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

// One request's share of a file: a proxy between may keep it whole.
constexpr std::uint64_t kPartBytes = std::uint64_t{32} << 20;

struct Outgoing {
  flight::InputFile file;
  std::uint64_t bytes = 0;
};

// What goes on in the one line that a person sees.
class Tally {
 public:
  Tally(std::size_t files, std::uint64_t bytes, Progress& progress)
      : files_(files), bytes_(bytes), progress_(progress) {}

  void Sent(std::uint64_t of_this_file) {
    const double seconds = std::chrono::duration<double>(Clock::now() - began_).count();
    const std::uint64_t sent = done_bytes_ + of_this_file;
    most_sent_ = std::max(most_sent_, sent);
    progress_.Report(bytes_ == 0 ? 1.0 : static_cast<double>(most_sent_) / static_cast<double>(bytes_),
                     fmt::format("{} of {} files, {:.0f} of {:.0f} MB, {:.1f} MB/s", done_files_, files_,
                                 1e-6 * static_cast<double>(sent), 1e-6 * static_cast<double>(bytes_),
                                 1e-6 * static_cast<double>(sent) / std::max(seconds, 0.1)));
  }
  void Waits(const std::string& why) {
    progress_.Report(bytes_ == 0 ? 0.0 : static_cast<double>(most_sent_) / static_cast<double>(bytes_), why);
  }
  void Done(std::uint64_t bytes) {
    ++done_files_;
    done_bytes_ += bytes;
    Sent(0);
  }

 private:
  const std::size_t files_;
  const std::uint64_t bytes_;
  Progress& progress_;
  std::size_t done_files_ = 0;
  std::uint64_t done_bytes_ = 0, most_sent_ = 0;
  const Clock::time_point began_ = Clock::now();
};

Result<nlohmann::json> Parsed(const ClientAnswer& answer) {
  nlohmann::json value = ParseJson(answer.body);
  if (value.is_object()) return value;
  return Error{ErrorCode::kUnprocessable, "The server's answer is no JSON; is it a Skyquilt?"};
}

Result<std::string> TextAt(const nlohmann::json& value, const char* key) {
  if (auto text = TextIn(value, key)) return *std::move(text);
  return Error{ErrorCode::kUnprocessable,
               fmt::format("The server's answer has no \"{}\"; is it a Skyquilt?", key)};
}

// Sent again where its answer was lost, it is carried out once all the same.
Result<nlohmann::json> PostJson(ServerClient& client, const std::string& path, const nlohmann::json& value,
                                const std::string& once_key) {
  ClientRequest request;
  request.method = "POST";
  request.path = path;
  request.headers = {{"Content-Type", "application/json"},
                     {"Idempotency-Key", once_key.empty() ? storage::NewId() : once_key}};
  request.body = JsonText(value);
  SKYQUILT_TRY_ASSIGN(const ClientAnswer answer, client.Send(request));
  return Parsed(answer);
}

using NamesAndSizes = std::set<std::pair<std::string, std::uint64_t>>;

Result<NamesAndSizes> FilesThere(ServerClient& client, const std::string& flight_id) {
  ClientRequest request;
  request.path = "/api/v1/flights/" + flight_id + "/files";
  SKYQUILT_TRY_ASSIGN(const ClientAnswer answer, client.Send(request));
  SKYQUILT_TRY_ASSIGN(const nlohmann::json value, Parsed(answer));
  NamesAndSizes there;
  for (const nlohmann::json& file : value.value("files", nlohmann::json::array())) {
    SKYQUILT_TRY_ASSIGN(std::string name, TextAt(file, "name"));
    there.emplace(std::move(name), file.value("bytes", std::uint64_t{0}));
  }
  return there;
}

Result<std::uint64_t> OffsetSaid(const ClientAnswer& answer) {
  const std::string text = answer.Header("Upload-Offset");
  std::uint64_t offset = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), offset);
  if (failed == std::errc() && !text.empty()) return offset;
  return Error{ErrorCode::kUnprocessable, "The server does not say how much of the file it has."};
}

Result<void> SendFile(ServerClient& client, const std::string& flight_id, const Outgoing& outgoing,
                      Tally& tally) {
  ClientRequest begin;
  begin.method = "POST";
  begin.path = "/api/v1/uploads";
  begin.headers = {{"Tus-Resumable", "1.0.0"},
                   {"Upload-Length", std::to_string(outgoing.bytes)},
                   {"Upload-Metadata", fmt::format("flight {},filename {}", api::EncodeBase64(flight_id),
                                                   api::EncodeBase64(outgoing.file.name))}};
  SKYQUILT_TRY_ASSIGN(const ClientAnswer begun, client.Send(begin));
  const std::string location = begun.Header("Location");
  if (location.empty()) return Error{ErrorCode::kUnprocessable, "The server takes no uploads by tus."};
  std::uint64_t offset = 0;
  while (offset < outgoing.bytes) {
    ClientRequest part;
    part.method = "PATCH";
    part.path = location;
    part.headers = {{"Tus-Resumable", "1.0.0"},
                    {"Content-Type", "application/offset+octet-stream"},
                    {"Upload-Offset", std::to_string(offset)}};
    part.file = outgoing.file.path;
    part.from = offset;
    part.length = std::min(kPartBytes, outgoing.bytes - offset);
    part.on_sent = [&](std::uint64_t sent) { tally.Sent(offset + sent); };
    const Result<ClientAnswer> taken = client.SendOnce(part);
    if (taken) {
      client.Succeeded();
      SKYQUILT_TRY_ASSIGN(offset, OffsetSaid(*taken));
      continue;
    }
    // The server knows how much of it has arrived.
    const bool may_go_on =
        taken.error().code == ErrorCode::kUnavailable || taken.error().code == ErrorCode::kConflict;
    if (!may_go_on) return taken.error();
    SKYQUILT_TRY(client.WaitAfter(taken.error()));
    ClientRequest ask;
    ask.method = "HEAD";
    ask.path = location;
    ask.headers = {{"Tus-Resumable", "1.0.0"}};
    const Result<ClientAnswer> known = client.SendOnce(ask);
    if (known) {
      SKYQUILT_TRY_ASSIGN(offset, OffsetSaid(*known));
    } else if (known.error().code != ErrorCode::kUnavailable) {
      // A finished upload is gone: the last part arrived, and its answer was lost.
      SKYQUILT_TRY_ASSIGN(const NamesAndSizes there, FilesThere(client, flight_id));
      if (there.contains({outgoing.file.name, outgoing.bytes})) return {};
      return known.error();
    }
  }
  return {};
}

std::string PathOfFile(const std::string& flight_id, const std::string& name) {
  return fmt::format("/api/v1/flights/{}/files/{}", flight_id, api::EncodedForQuery(name));
}

Result<void> PutInItsPlace(ServerClient& client, const std::string& flight_id, const Outgoing& one) {
  ClientRequest put;
  put.method = "PUT";
  put.path = PathOfFile(flight_id, one.file.name);
  put.headers = {{"If-Match", "*"}};
  put.file = one.file.path;
  put.length = one.bytes;
  SKYQUILT_TRY(client.Send(put));
  return {};
}

// What the server says of a file does not name it.
Error About(const Outgoing& one, Error refusal) {
  if (refusal.code == ErrorCode::kUnprocessable)
    refusal.message = Printable(one.file.name) + ": " + refusal.message;
  return refusal;
}

// The member "options" of a flight or a job, where any are given.
nlohmann::json Wish(const UploadOptions& options, const std::string& import_file) {
  nlohmann::json wish = nlohmann::json::object();
  if (!options.job_options.empty()) wish["options"] = ParseJson(options.job_options);
  if (!import_file.empty()) wish["options"]["import_file"] = import_file;
  return wish;
}

// Whether what the server has under the file's name is that file. One that is lost there is another.
Result<bool> HasSameBytes(ServerClient& client, const std::string& flight_id, const Outgoing& one,
                          Progress& progress) {
  std::ifstream file(one.file.path, std::ios::binary);
  ClientRequest ask;
  ask.path = PathOfFile(flight_id, one.file.name);
  for (std::uint64_t at = 0; at < one.bytes; at += kPartBytes) {
    progress.Report(static_cast<double>(at) / static_cast<double>(one.bytes), "compared with what is there");
    std::string here(std::min(kPartBytes, one.bytes - at), '\0');
    ask.headers = {{"Range", fmt::format("bytes={}-{}", at, at + here.size() - 1)}};
    const Result<ClientAnswer> there = client.Send(ask);
    if (!there && there.error().code != ErrorCode::kNotFound) return there.error();
    if (!there || !file.read(here.data(), static_cast<std::streamsize>(here.size())) || there->body != here)
      return false;
  }
  return true;
}

// A file that counts by what is in it must not be taken for another that lies there under its name, or be
// kept under a name that nobody knows: it has a name by its content, so that the same one is known again.
Result<void> TellApart(ServerClient& client, const std::string& flight_id, const NamesAndSizes& there,
                       Outgoing& one, Progress& progress) {
  constexpr std::size_t kMarkLetters = 8;
  const auto of_name = there.lower_bound({one.file.name, 0});
  if (of_name == there.end() || of_name->first != one.file.name) return {};
  SKYQUILT_TRY_ASSIGN(const std::string sum, storage::Sha256OfFile(one.file.path));
  std::string marked = NumberedName(one.file.name, sum.substr(0, kMarkLetters));
  const bool may_be_it = !there.contains({marked, one.bytes}) && there.contains({one.file.name, one.bytes});
  if (may_be_it) {
    SKYQUILT_TRY_ASSIGN(const bool is_it, HasSameBytes(client, flight_id, one, progress));
    if (is_it) return {};
  }
  one.file.name = std::move(marked);
  return {};
}

// A list, a log, a sidecar: small, and somebody may have edited it since it was sent.
bool MayBeEdited(const Outgoing& one) { return !IsNamedAsPicture(one.file.name) && one.bytes <= kPartBytes; }

Result<void> WaitForJob(ServerClient& client, const std::string& job_id, Progress& progress) {
  std::string stage_before;
  ClientRequest ask;
  ask.path = "/api/v1/jobs/" + job_id;
  for (;;) {
    SKYQUILT_TRY_ASSIGN(const ClientAnswer answer, client.Send(ask));
    SKYQUILT_TRY_ASSIGN(const nlohmann::json job, Parsed(answer));
    SKYQUILT_TRY_ASSIGN(const std::string state, TextAt(job, "state"));
    if (state == "successful") return {};
    if (state == "failed" || state == "dismissed") {
      const nlohmann::json error = job.value("error", nlohmann::json());
      const std::string why = error.is_object() ? error.value("message", std::string()) : std::string();
      return Error{ErrorCode::kUnprocessable,
                   state == "failed" ? "The map could not be made: " + why : "The job was cancelled."};
    }
    const std::string stage = job.value("stage", std::string());
    if (!stage.empty() && stage != stage_before) progress.BeginStage(stage);
    stage_before = stage;
    progress.Report(job.value("progress", 0.0), job.value("message", std::string()));
    for (int i = 0; i < 5; ++i) {
      if (progress.IsCancelled())
        return Error{ErrorCode::kCancelled, "No longer waited for; the server goes on with the map."};
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
}

}  // namespace

Result<UploadedFlight> UploadFlight(const std::vector<flight::InputFile>& files, const UploadOptions& options,
                                    const std::function<void(const std::string& id)>& on_flight,
                                    Progress& progress) {
  std::vector<Outgoing> outgoing;
  for (const flight::InputFile& file : files) {
    std::error_code failed;
    const std::uint64_t bytes = fs::file_size(file.path, failed);
    if (failed) return Error{ErrorCode::kIo, file.path.string() + ": " + failed.message() + "."};
    if (bytes == 0) continue;  // an empty file says nothing
    outgoing.push_back({file, bytes});
    std::string& name = outgoing.back().file.name;
    name = WithFoldersJoined(std::move(name));
  }
  if (outgoing.empty()) return Error{ErrorCode::kUnprocessable, "There are no files to send."};
  Tally* counting = nullptr;
  ServerClient client(options.server, progress, [&](const std::string& why) {
    if (counting != nullptr) counting->Waits(why);
    if (counting == nullptr) progress.Report(0.0, why);
  });
  UploadedFlight uploaded;
  uploaded.flight_id = options.flight_id;
  progress.BeginStage("upload");
  if (uploaded.flight_id.empty()) {
    nlohmann::json fields = {{"name", options.name}};
    // Servers of before know neither: they are asked for nothing that nobody wants.
    if (!options.tags.empty()) fields["tags"] = options.tags;
    if (options.is_kept) fields["keep"] = true;
    fields.update(Wish(options, options.import_file));
    SKYQUILT_TRY_ASSIGN(const nlohmann::json made,
                        PostJson(client, "/api/v1/flights", fields, options.flight_once_key));
    SKYQUILT_TRY_ASSIGN(uploaded.flight_id, TextAt(made, "id"));
  }
  on_flight(uploaded.flight_id);
  SKYQUILT_TRY_ASSIGN(const NamesAndSizes there, FilesThere(client, uploaded.flight_id));
  std::string import_file = options.import_file;
  for (Outgoing& one : outgoing) {
    const std::string own = one.file.name;
    const bool is_map = own == options.import_file;
    if (!is_map && (own == options.replaced_file || !MayBeEdited(one))) continue;
    SKYQUILT_TRY(TellApart(client, uploaded.flight_id, there, one, progress));
    if (is_map) import_file = one.file.name;
    if (!is_map && own != one.file.name) uploaded.beside.emplace_back(own, one.file.name);
  }
  const std::size_t all = outgoing.size();
  const auto is_replaced = [&](const Outgoing& one) { return one.file.name == options.replaced_file; };
  std::erase_if(outgoing, [&](const Outgoing& one) {
    return !is_replaced(one) && there.contains({one.file.name, one.bytes});
  });
  uploaded.skipped = static_cast<int>(all - outgoing.size());
  std::uint64_t bytes = 0;
  for (const Outgoing& one : outgoing) bytes += one.bytes;
  Tally tally(outgoing.size(), bytes, progress);
  counting = &tally;
  for (const Outgoing& one : outgoing) {
    const Result<void> taken = is_replaced(one) ? PutInItsPlace(client, uploaded.flight_id, one)
                                                : SendFile(client, uploaded.flight_id, one, tally);
    if (!taken) return About(one, taken.error());
    tally.Done(one.bytes);
    ++uploaded.sent;
  }
  counting = nullptr;
  if (!options.makes_map) return uploaded;
  SKYQUILT_TRY_ASSIGN(const nlohmann::json job,
                      PostJson(client, "/api/v1/flights/" + uploaded.flight_id + "/jobs",
                               Wish(options, import_file), options.job_once_key));
  SKYQUILT_TRY_ASSIGN(uploaded.job_id, TextAt(job, "id"));
  if (options.waits) SKYQUILT_TRY(WaitForJob(client, uploaded.job_id, progress));
  return uploaded;
}

}  // namespace skyquilt::server
