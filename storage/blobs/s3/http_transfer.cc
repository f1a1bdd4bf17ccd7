#include "storage/blobs/s3/http_transfer.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "core/base/text/plain_text.h"
#include "storage/blobs/curl_transfer.h"

namespace skyquilt::storage {
namespace {

constexpr std::size_t kMaxHeaders = 200;
constexpr std::size_t kMaxIdle = 32;

// What the callbacks of one exchange share.
struct UnderWay {
  const HttpExchange& exchange;
  CURL* transfer;
  HttpAnswer answer;
  std::size_t sent = 0;
  bool is_taking = false;
  std::optional<Error> refusal;
};

std::size_t GiveBytes(char* into, std::size_t size, std::size_t count, void* of) {
  auto& under_way = *static_cast<UnderWay*>(of);
  const std::string_view rest = under_way.exchange.body.substr(under_way.sent);
  const std::size_t given = std::min(size * count, rest.size());
  std::memcpy(into, rest.data(), given);
  under_way.sent += given;
  return given;
}

// Where a connection broke before the answer, libcurl sends the body again on another.
int Rewind(void* of, curl_off_t offset, int origin) {
  auto& under_way = *static_cast<UnderWay*>(of);
  if (origin != SEEK_SET || offset < 0 || static_cast<std::size_t>(offset) > under_way.exchange.body.size())
    return CURL_SEEKFUNC_FAIL;
  under_way.sent = static_cast<std::size_t>(offset);
  return CURL_SEEKFUNC_OK;
}

std::size_t TakeBytes(char* bytes, std::size_t size, std::size_t count, void* of) {
  auto& under_way = *static_cast<UnderWay*>(of);
  const std::string_view came(bytes, size * count);
  curl_easy_getinfo(under_way.transfer, CURLINFO_RESPONSE_CODE, &under_way.answer.status);
  const HttpExchange& exchange = under_way.exchange;
  if (exchange.take && under_way.answer.IsGood()) {
    Result<void> taken;
    if (exchange.begin && !under_way.is_taking) taken = exchange.begin(under_way.answer);
    under_way.is_taking = true;
    if (taken) taken = exchange.take(came);
    if (taken) return came.size();
    under_way.refusal = taken.error();
    return 0;
  }
  if (under_way.answer.body.size() + came.size() > under_way.exchange.max_answer_bytes) {
    under_way.refusal = Error{ErrorCode::kTooLarge, "An answer was larger than it may be.", ""};
    return 0;
  }
  under_way.answer.body.append(came);
  return came.size();
}

std::size_t TakeHeaderLine(char* bytes, std::size_t size, std::size_t count, void* of) {
  auto& headers = static_cast<UnderWay*>(of)->answer.headers;
  const std::string_view line(bytes, size * count);
  if (line.starts_with("HTTP/")) headers.clear();  // of another answer before this one: 100 Continue
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || headers.size() >= kMaxHeaders) return line.size();
  headers[LowerCase(line.substr(0, colon))] = Trim(line.substr(colon + 1));
  return line.size();
}

void SetBody(CURL* transfer, UnderWay& under_way) {
  const HttpExchange& exchange = under_way.exchange;
  if (exchange.method == "HEAD") {
    SetOption(transfer, CURLOPT_NOBODY, 1L);
    return;
  }
  if (exchange.method == "PUT") {
    SetOption(transfer, CURLOPT_UPLOAD, 1L);
    SetOption(transfer, CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(exchange.body.size()));
  } else if (exchange.method == "POST") {
    SetOption(transfer, CURLOPT_POST, 1L);
    SetOption(transfer, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(exchange.body.size()));
  } else {
    SetOption(transfer, CURLOPT_HTTPGET, 1L);
    SetOption(transfer, CURLOPT_CUSTOMREQUEST, exchange.method.c_str());
  }
  SetOption(transfer, CURLOPT_READFUNCTION, &GiveBytes);
  SetOption(transfer, CURLOPT_READDATA, &under_way);
  SetOption(transfer, CURLOPT_SEEKFUNCTION, &Rewind);
  SetOption(transfer, CURLOPT_SEEKDATA, &under_way);
}

}  // namespace

struct HttpTransfers::Idle {
  std::vector<CurlTransfer> handles;
};

HttpTransfers::HttpTransfers() : idle_(std::make_unique<Idle>()) {}

HttpTransfers::~HttpTransfers() = default;

std::string HttpAnswer::Header(const std::string& name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? "" : found->second;
}

Result<HttpAnswer> HttpTransfers::Perform(const HttpExchange& exchange) {
  CurlTransfer owner;
  {
    const std::lock_guard lock(mutex_);
    if (!idle_->handles.empty()) {
      owner = std::move(idle_->handles.back());
      idle_->handles.pop_back();
    }
  }
  if (owner == nullptr) owner = NewTransfer();
  CURL* transfer = owner.get();
  curl_easy_reset(transfer);  // its connections stay
  UnderWay under_way{exchange, transfer, {}, 0, false, std::nullopt};
  const CurlHeaders headers = CurlHeadersOf(exchange.headers);
  CurlWords said{};
  SetUsualOptions(transfer, exchange.url, headers, said);
  SetOption(transfer, CURLOPT_PATH_AS_IS, 1L);  // what was signed is what is sent
  SetOption(transfer, CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
  SetOption(transfer, CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(exchange.connect_patience.count()));
  SetOption(transfer, CURLOPT_LOW_SPEED_LIMIT, 1L);
  SetOption(transfer, CURLOPT_LOW_SPEED_TIME, static_cast<long>(exchange.stall_patience.count()));
  SetOption(transfer, CURLOPT_BUFFERSIZE, 256L << 10);
  SetOption(transfer, CURLOPT_UPLOAD_BUFFERSIZE, 256L << 10);
  SetOption(transfer, CURLOPT_WRITEFUNCTION, &TakeBytes);
  SetOption(transfer, CURLOPT_WRITEDATA, &under_way);
  SetOption(transfer, CURLOPT_HEADERFUNCTION, &TakeHeaderLine);
  SetOption(transfer, CURLOPT_HEADERDATA, &under_way);
  SetBody(transfer, under_way);
  const CURLcode done = curl_easy_perform(transfer);
  curl_easy_getinfo(transfer, CURLINFO_RESPONSE_CODE, &under_way.answer.status);
  if (done == CURLE_OK) {
    const std::lock_guard lock(mutex_);
    if (idle_->handles.size() < kMaxIdle) idle_->handles.push_back(std::move(owner));
    return std::move(under_way.answer);
  }
  if (under_way.refusal) return *under_way.refusal;
  // A server that refuses may close before it has heard all of the body.
  if (under_way.answer.status >= 400 && done == CURLE_SEND_ERROR) return std::move(under_way.answer);
  return Error{ErrorCode::kUnavailable,
               done == CURLE_OPERATION_TIMEDOUT ? "It did not answer in time." : "It did not answer.",
               CurlWordsOf(said, done)};
}

}  // namespace skyquilt::storage
