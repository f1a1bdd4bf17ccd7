#include "server/client/server_client.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "api/http/http_message.h"
#include "core/base/text/json_io.h"
#include "core/base/text/plain_text.h"
#include "core/base/try.h"
#include "storage/blobs/curl_transfer.h"

namespace skyquilt::server {
namespace {

using Clock = std::chrono::steady_clock;
using storage::SetOption;

constexpr long kConnectPatienceMs = 10'000;
constexpr long kSlowestBytesPerS = 1, kSlowForS = 60;  // a connection that stands still for so long is dead
constexpr std::size_t kMaxAnswerBytes = std::size_t{64} << 20;

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

struct Upload {
  std::unique_ptr<std::FILE, CloseFile> file;
  std::uint64_t left = 0, sent = 0;
  const std::function<void(std::uint64_t)>* on_sent = nullptr;
};

std::size_t ReadFile(char* into, std::size_t size, std::size_t count, void* of) {
  auto& upload = *static_cast<Upload*>(of);
  const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(size * count, upload.left));
  const std::size_t read = std::fread(into, 1, wanted, upload.file.get());
  if (read < wanted) return CURL_READFUNC_ABORT;
  upload.left -= read;
  upload.sent += read;
  if (*upload.on_sent) (*upload.on_sent)(upload.sent);
  return read;
}

std::size_t TakeBody(char* bytes, std::size_t size, std::size_t count, void* of) {
  auto& body = *static_cast<std::string*>(of);
  if (body.size() + size * count > kMaxAnswerBytes) return 0;
  body.append(bytes, size * count);
  return size * count;
}

std::size_t TakeHeader(char* bytes, std::size_t size, std::size_t count, void* of) {
  const std::string_view line(bytes, size * count);
  const std::size_t colon = line.find(':');
  if (colon != std::string_view::npos)
    static_cast<ClientAnswer*>(of)->headers.emplace_back(line.substr(0, colon), Trim(line.substr(colon + 1)));
  return size * count;
}

int Continues(void* of, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
  return static_cast<Progress*>(of)->IsCancelled() ? 1 : 0;
}

// In the server's own words.
Error Refusal(const ClientAnswer& answer) {
  const std::string said = TextIn(ParseJson(answer.body), "detail")
                               .value_or(fmt::format("The server answered {}.", answer.status));
  switch (answer.status) {
    case 401:
      return {ErrorCode::kUnauthorized, said + " Give it with --token or in SKYQUILT_TOKEN."};
    case 403:
      return {ErrorCode::kForbidden, said};
    case 404:
      return {ErrorCode::kNotFound, said};
    case 409:
      return {ErrorCode::kConflict, said};
    case 408:
    case 423:
    case 429:
    case 500:
    case 502:
    case 503:
    case 504:
      return {ErrorCode::kUnavailable, said};
    default:
      return {ErrorCode::kUnprocessable, said};
  }
}

// A server below a path of its host names its addresses with that path, which stands in `url` as well.
std::string AddressOf(const std::string& url, const std::string& path) {
  const std::size_t root = url.find('/', url.find("://") + 3);
  const std::string base = root == std::string::npos ? "" : url.substr(root);
  if (!base.empty() && path.starts_with(base + "/")) return url.substr(0, root) + path;
  return url + path;
}

}  // namespace

std::string ClientAnswer::Header(const std::string& name) const {
  for (const auto& [known, value] : headers) {
    if (api::EqualsIgnoringCase(known, name)) return value;
  }
  return "";
}

struct ServerClient::State {
  ClientSettings settings;
  Progress& progress;
  std::function<void(const std::string&)> waits;
  storage::CurlTransfer transfer = storage::NewTransfer();
  std::optional<Clock::time_point> failing_since = std::nullopt;
  std::chrono::milliseconds pause{500};
};

ServerClient::ServerClient(ClientSettings settings, Progress& progress,
                           std::function<void(const std::string&)> waits)
    : state_(new State{std::move(settings), progress, std::move(waits)}) {}

ServerClient::~ServerClient() = default;

Result<ClientAnswer> ServerClient::SendOnce(const ClientRequest& request) {
  CURL* transfer = state_->transfer.get();
  curl_easy_reset(transfer);  // the connection stays
  const bool is_whole = request.path.starts_with("http://") || request.path.starts_with("https://");
  // Nothing is sent anywhere but to the server that was named.
  if (is_whole && !request.path.starts_with(state_->settings.url + "/"))
    return Error{ErrorCode::kUnprocessable, "The server sent us elsewhere: " + request.path + "."};
  const std::string address = is_whole ? request.path : AddressOf(state_->settings.url, request.path);
  auto given = request.headers;
  if (!state_->settings.token.empty())
    given.emplace_back("Authorization", "Bearer " + state_->settings.token);
  const storage::CurlHeaders headers = storage::CurlHeadersOf(given);
  ClientAnswer answer;
  Upload upload;
  storage::CurlWords said{};
  storage::SetUsualOptions(transfer, address, headers, said);
  SetOption(transfer, CURLOPT_CUSTOMREQUEST, request.method);
  SetOption(transfer, CURLOPT_CONNECTTIMEOUT_MS, kConnectPatienceMs);
  SetOption(transfer, CURLOPT_LOW_SPEED_LIMIT, kSlowestBytesPerS);
  SetOption(transfer, CURLOPT_LOW_SPEED_TIME, kSlowForS);
  SetOption(transfer, CURLOPT_WRITEFUNCTION, &TakeBody);
  SetOption(transfer, CURLOPT_WRITEDATA, &answer.body);
  SetOption(transfer, CURLOPT_HEADERFUNCTION, &TakeHeader);
  SetOption(transfer, CURLOPT_HEADERDATA, &answer);
  SetOption(transfer, CURLOPT_NOPROGRESS, 0L);
  SetOption(transfer, CURLOPT_XFERINFOFUNCTION, &Continues);
  SetOption(transfer, CURLOPT_XFERINFODATA, &state_->progress);
  if (!request.file.empty()) {
    upload.file.reset(std::fopen(request.file.c_str(), "rb"));
    if (upload.file == nullptr || fseeko(upload.file.get(), static_cast<off_t>(request.from), SEEK_SET) != 0)
      return Error{ErrorCode::kIo, request.file.string() + " cannot be read."};
    upload.left = request.length;
    upload.on_sent = &request.on_sent;
    SetOption(transfer, CURLOPT_UPLOAD, 1L);
    SetOption(transfer, CURLOPT_READFUNCTION, &ReadFile);
    SetOption(transfer, CURLOPT_READDATA, &upload);
    SetOption(transfer, CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(request.length));
  } else if (std::string_view(request.method) == "HEAD") {
    SetOption(transfer, CURLOPT_NOBODY, 1L);
  } else if (std::string_view(request.method) != "GET") {
    SetOption(transfer, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(request.body.size()));
    SetOption(transfer, CURLOPT_POSTFIELDS, request.body.c_str());
  }
  const CURLcode sent = curl_easy_perform(transfer);
  curl_easy_getinfo(transfer, CURLINFO_RESPONSE_CODE, &answer.status);
  if (state_->progress.IsCancelled()) return Error{ErrorCode::kCancelled, "Cancelled."};
  if (sent == CURLE_ABORTED_BY_CALLBACK)
    return Error{ErrorCode::kIo, request.file.string() + " changed while it was sent."};
  if (sent == CURLE_URL_MALFORMAT || sent == CURLE_UNSUPPORTED_PROTOCOL)
    return Error{ErrorCode::kInvalidArgument,
                 address + " is no address of a server; one looks like http://127.0.0.1:8080."};
  // A refusal may come before all was sent.
  if (answer.status >= 400) return Refusal(answer);
  if (sent != CURLE_OK) {
    const std::string why = storage::CurlWordsOf(said, sent);
    return Error{ErrorCode::kUnavailable, state_->settings.url + " does not answer (" + why + ")."};
  }
  return answer;
}

Result<void> ServerClient::WaitAfter(const Error& failure) {
  constexpr std::chrono::milliseconds kLongestPause{15'000}, kStep{100};
  const Clock::time_point now = Clock::now();
  if (!state_->failing_since) state_->failing_since = now;
  const auto left =
      std::chrono::ceil<std::chrono::seconds>(state_->settings.patience - (now - *state_->failing_since));
  if (left <= std::chrono::seconds(0)) return failure;
  state_->waits(fmt::format("{} Trying again for {} s.", failure.message, left.count()));
  for (std::chrono::milliseconds slept{0}; slept < state_->pause; slept += kStep) {
    if (state_->progress.IsCancelled()) return Error{ErrorCode::kCancelled, "Cancelled."};
    std::this_thread::sleep_for(kStep);
  }
  state_->pause = std::min(2 * state_->pause, kLongestPause);
  return {};
}

void ServerClient::Succeeded() {
  state_->failing_since.reset();
  state_->pause = std::chrono::milliseconds(500);
}

Result<ClientAnswer> ServerClient::Send(const ClientRequest& request) {
  for (;;) {
    Result<ClientAnswer> answer = SendOnce(request);
    if (answer) {
      Succeeded();
      return answer;
    }
    if (answer.error().code != ErrorCode::kUnavailable) return answer;
    SKYQUILT_TRY(WaitAfter(answer.error()));
  }
}

}  // namespace skyquilt::server
