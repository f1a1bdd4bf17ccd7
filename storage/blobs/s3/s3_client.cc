#include "storage/blobs/s3/s3_client.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <random>
#include <thread>
#include <utility>

#include "core/base/process/file_descriptor.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/blobs/sha256.h"
#include "storage/db/ids.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace {

constexpr std::chrono::milliseconds kFirstPause{100};
constexpr std::chrono::milliseconds kLongestPause{5'000};
constexpr const char* kSha256Header = "x-amz-meta-sha256";
constexpr const char* kWriterHeader = "x-amz-meta-writer";

// Between nothing and twice as long as before, so that those who failed together do not come back together.
void Pause(int attempt) {
  thread_local std::minstd_rand random{std::random_device{}()};
  const auto longest = std::min(kLongestPause, kFirstPause * (1 << std::min(attempt, 10)));
  std::uniform_int_distribution<std::int64_t> pause_ms(longest.count() / 4, longest.count());
  std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms(random)));
}

std::int64_t IntegerOf(const std::string& text) {
  std::int64_t number = -1;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

// "Fri, 24 May 2013 00:00:00 GMT"; zero where it is none.
std::chrono::system_clock::time_point HttpDate(const std::string& text) {
  return UtcOf(text, "%a, %d %b %Y %H:%M:%S").value_or(std::chrono::system_clock::time_point());
}

// S3 wants it with a deletion of many.
std::string Md5Base64(std::string_view bytes) {
  return EncodeBase64(RawDigestOf(DigestAlgorithm::kMd5, bytes));
}

// Whether so many bytes are all that there is of a range, as far as "Content-Range: bytes 0-9/100" says how
// long the object is.
bool IsWholeRange(const HttpAnswer& answer, std::int64_t offset, std::int64_t length, std::int64_t got) {
  const std::string said = answer.Header("content-range");
  const std::size_t slash = said.rfind('/');
  const std::int64_t bytes = slash == std::string::npos ? -1 : IntegerOf(said.substr(slash + 1));
  return bytes < 0 || got == std::clamp<std::int64_t>(bytes - offset, 0, length);
}

// Of these keys, at this time, or in this region.
bool IsRefusal(const HttpAnswer& answer) {
  return answer.status == 400 || answer.status == 401 || answer.status == 403 || answer.status == 301 ||
         answer.status == 307;
}

S3Object ObjectOf(const HttpAnswer& answer) {
  return {IntegerOf(answer.Header("content-length")), answer.Header("etag"), answer.Header(kSha256Header),
          answer.Header(kWriterHeader), HttpDate(answer.Header("last-modified"))};
}

NamedValues HeadersOfPut(const S3PutOptions& options) {
  NamedValues headers = {{"Content-Type", "application/octet-stream"}};
  if (!options.sha256.empty()) headers.emplace_back(kSha256Header, options.sha256);
  return headers;
}

Error FileTrouble(const std::filesystem::path& path) {
  const int code = errno;
  const bool is_full = IsNoRoom(code);
  return {is_full ? ErrorCode::kOutOfSpace : ErrorCode::kIo,
          is_full ? "The server's disk is full. Free some space, or give less with --cache-bytes."
                  : "The server could not keep a file that it fetched.",
          path.string() + ": " + std::strerror(code)};
}

// A file that is written while it is fetched.
class Target {
 public:
  explicit Target(const std::filesystem::path& path)
      : path_(path), fd_(open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0640)) {}
  bool is_open() const { return fd_.is_open(); }
  std::int64_t bytes() const { return bytes_; }
  // What a cache renames next is whole after a power cut as well.
  Result<std::string> Finish() {
    if (fdatasync(fd_.get()) != 0) return FileTrouble(path_);
    return sum_.Finish();
  }

  Result<void> Write(std::string_view came) {
    const std::size_t wrote = fd_.Write(came.data(), came.size());
    bytes_ += static_cast<std::int64_t>(wrote);
    if (wrote < came.size()) return FileTrouble(path_);
    sum_.Add(came);
    return {};
  }

 private:
  std::filesystem::path path_;
  FileDescriptor fd_;
  std::int64_t bytes_ = 0;
  Sha256Sum sum_;
};

}  // namespace

S3Client::S3Client(S3Settings settings, Variable variable)
    : settings_(std::move(settings)), credentials_(std::move(variable)), region_(settings_.region) {}

std::string S3Client::Region() const {
  const std::lock_guard lock(mutex_);
  return region_;
}

std::chrono::system_clock::time_point S3Client::StoreTime() const {
  return std::chrono::system_clock::now() + std::chrono::seconds(skew_s_.load());
}

Result<HttpAnswer> S3Client::PerformOnce(const Ask& ask, const std::string& payload_sha256, int attempt) {
  SKYQUILT_TRY_ASSIGN(const S3Credentials keys, credentials_.Get(std::chrono::system_clock::now()));
  RequestToSign request{
      ask.method,    settings_.HostOfRequests(), settings_.PathOf(ask.key), ask.query, ask.headers,
      payload_sha256};
  HttpExchange exchange;
  exchange.method = ask.method;
  exchange.headers = SignRequest(request, keys, Region(), StoreTime());
  const std::string query = EncodedQuery(ask.query);
  exchange.url = fmt::format("{}://{}{}{}{}", settings_.scheme, request.host, UriEncode(request.path, true),
                             query.empty() ? "" : "?", query);
  exchange.body = ask.body;
  exchange.take = ask.take;
  exchange.begin = ask.begin;
  exchange.connect_patience = settings_.connect_patience;
  exchange.stall_patience = std::max(ask.stall_patience, settings_.stall_patience);
  // A store that is slow to store is waited for longer each time, or nothing would ever be put.
  if (ask.method != "GET" && ask.method != "HEAD") exchange.stall_patience *= attempt;
  return transfers_.Perform(exchange);
}

// True: the same request may go well now.
bool S3Client::Adapt(const HttpAnswer& answer, const S3Refusal& refusal) {
  if (refusal.code == "RequestTimeTooSkewed") {
    const auto theirs = HttpDate(answer.Header("date"));
    if (theirs == std::chrono::system_clock::time_point()) return false;
    skew_s_ =
        std::chrono::duration_cast<std::chrono::seconds>(theirs - std::chrono::system_clock::now()).count();
    return true;
  }
  if (refusal.code == "ExpiredToken" || refusal.code == "InvalidToken") {
    credentials_.Forget();
    return true;
  }
  const std::string header = answer.Header("x-amz-bucket-region");
  const std::string region = refusal.region.empty() ? header : refusal.region;
  const std::lock_guard lock(mutex_);
  if (region.empty() || region == region_ || region.size() > 64) return false;
  region_ = region;
  return true;
}

Error S3Client::Meaning(const Ask& ask, const HttpAnswer& answer, bool& may_retry) {
  const S3Refusal refusal = ParseRefusal(answer.body).value_or(S3Refusal());
  const std::string place = settings_.Address();
  const std::string detail = fmt::format("{} {}{}: {} {} {}", ask.method, place, ask.key, answer.status,
                                         refusal.code, refusal.message);
  may_retry = false;
  if (refusal.code == "NoSuchBucket") {
    return {has_worked_ ? ErrorCode::kUnavailable : ErrorCode::kNotFound,
            fmt::format("There is no bucket \"{}\" at {}. Make it, or give another with --blobs.",
                        settings_.bucket, settings_.host),
            detail};
  }
  if (answer.status == 404 && ask.key.empty()) {
    return {ErrorCode::kNotFound,
            fmt::format(
                "{} cannot be listed: what answers at {} is no S3 store, or not that one. Check --blobs and "
                "the address in AWS_ENDPOINT_URL.",
                place, settings_.host),
            detail};
  }
  if (answer.status == 404)
    return {ErrorCode::kNotFound, fmt::format("{}{} is not there.", place, ask.key), detail};
  if (answer.status == 412 || answer.status == 409)
    return {ErrorCode::kConflict, fmt::format("{}{} is there already.", place, ask.key), detail};
  if (answer.status == 501) {
    return {ErrorCode::kNotImplemented,
            fmt::format("The store of photos and maps at {} does not know a request that is needed ({}).",
                        place, refusal.message),
            detail};
  }
  if (answer.status == 416)
    return {ErrorCode::kRangeNotSatisfiable, "The range lies outside the object.", detail};
  if (IsRefusal(answer)) {
    may_retry = Adapt(answer, refusal) || refusal.code == "RequestTimeout";
    return {
        has_worked_ ? ErrorCode::kUnavailable : ErrorCode::kForbidden,
        fmt::format("{} refuses this server ({}). See that the keys in AWS_ACCESS_KEY_ID or the machine's "
                    "role are right, and that they may list, read, write and delete there.",
                    place, refusal.code.empty() ? std::to_string(answer.status) : refusal.code),
        detail};
  }
  may_retry = answer.status >= 500 || answer.status == 429 || answer.status == 408 || answer.IsGood();
  return flight::Because(ErrorCode::kUnavailable, {flight::RemarkCode::kFailStoreTrouble, {{"store", place}}},
                         detail);
}

Result<HttpAnswer> S3Client::Perform(Ask ask, int* attempts_made) {
  const std::string payload = ask.body.empty() ? kEmptySha256 : Sha256Hex(ask.body);
  const int attempts = ask.attempts > 0 ? ask.attempts : settings_.attempts;
  bool is_begun = false;
  if (ask.begin) {
    ask.begin = [&, begin = std::move(ask.begin)](const HttpAnswer& answer) {
      is_begun = true;
      return begin(answer);
    };
  }
  for (int attempt = 1;; ++attempt) {
    if (attempts_made != nullptr) *attempts_made = attempt;
    Result<HttpAnswer> answer = PerformOnce(ask, payload, attempt);
    if (answer && ask.method == "HEAD" && IsRefusal(*answer)) {
      // It has no body that could say why: that the clock is wrong, or the keys have expired.
      Ask aloud{"GET", ask.key};
      aloud.headers = {{"Range", "bytes=0-0"}};
      Result<HttpAnswer> told = PerformOnce(aloud, payload, attempt);
      if (told && IsRefusal(*told)) answer = std::move(told);
    }
    if (answer && answer->IsGood()) {
      has_worked_ = true;
      return answer;
    }
    bool may_retry = true;
    std::optional<Error> error;
    if (answer) {
      error = Meaning(ask, *answer, may_retry);
    } else {
      may_retry = answer.error().code == ErrorCode::kUnavailable;
      error = answer.error();
      if (may_retry) {
        error = flight::Because(
            ErrorCode::kUnavailable,
            {flight::RemarkCode::kFailStoreAway, {{"store", settings_.Address()}, {"host", settings_.host}}},
            fmt::format("{} {}: {}", ask.method, ask.key, answer.error().detail));
      }
    }
    if (!may_retry || is_begun || attempt >= attempts) return *error;
    Pause(attempt);
  }
}

Result<S3Object> S3Client::Head(const std::string& key) {
  SKYQUILT_TRY_ASSIGN(const HttpAnswer answer, Perform({"HEAD", key}));
  return ObjectOf(answer);
}

Result<std::string> S3Client::Get(const std::string& key, std::int64_t offset, std::int64_t length) {
  std::string bytes;
  const auto limit = static_cast<std::size_t>(length);
  Ask ask{"GET", key};
  ask.headers = {{"Range", fmt::format("bytes={}-{}", offset, offset + length - 1)}};
  ask.attempts = 1;
  ask.take = [&](std::string_view came) -> Result<void> {
    if (bytes.size() + came.size() > limit)
      return Error{ErrorCode::kCorrupt, "The store sent more than was asked for.", key};
    bytes.append(came);
    return {};
  };
  for (int attempt = 1;; ++attempt) {
    bytes.clear();
    const Result<HttpAnswer> answer = Perform(ask);
    if (answer && answer->status == 206 &&
        IntegerOf(answer->Header("content-length")) == static_cast<std::int64_t>(bytes.size()) &&
        IsWholeRange(*answer, offset, length, static_cast<std::int64_t>(bytes.size())))
      return bytes;
    // One that knows no ranges sends all of it; that it is all must be seen.
    if (answer && answer->status == 200 && offset == 0) return bytes;
    if (!answer && answer.error().code == ErrorCode::kRangeNotSatisfiable) return std::string();
    const bool may_retry = answer.ok() || answer.error().code == ErrorCode::kUnavailable;
    if (!may_retry || attempt >= settings_.attempts) {
      return answer ? Error{ErrorCode::kUnavailable, "The store sent less than it said.", key}
                    : answer.error();
    }
    Pause(attempt);
  }
}

Result<S3Object> S3Client::GetToFile(const std::string& key, const std::filesystem::path& path) {
  Target target(path);
  if (!target.is_open()) return FileTrouble(path);
  std::optional<S3Object> object;
  const auto know = [&](const HttpAnswer& answer) -> Result<void> {
    if (!object) object = ObjectOf(answer);
    if (object->bytes < 0)
      return Error{ErrorCode::kCorrupt, "The store does not say how long an object is.", key};
    return {};
  };
  for (int attempt = 1;; ++attempt) {
    Ask ask{"GET", key};
    ask.begin = know;
    ask.take = [&](std::string_view came) -> Result<void> {
      if (target.bytes() + static_cast<std::int64_t>(came.size()) > object->bytes)
        return Error{ErrorCode::kCorrupt, "The store sent more than was asked for.", key};
      return target.Write(came);
    };
    if (object) {
      ask.attempts = 1;
      ask.headers = {{"Range", fmt::format("bytes={}-{}", target.bytes(), object->bytes - 1)},
                     {"If-Match", object->etag}};
    }
    const std::int64_t before = target.bytes();
    const Result<HttpAnswer> answer = Perform(ask);
    if (answer) SKYQUILT_TRY(know(*answer));  // of an empty one no byte came
    if (object && target.bytes() == object->bytes) break;
    if (!answer && !object) return answer.error();  // it was tried again as often as is usual
    if (target.bytes() > before) attempt = 0;       // it goes on
    const bool may_retry = answer.ok() || answer.error().code == ErrorCode::kUnavailable;
    if (!may_retry) return answer.error();
    if (attempt >= settings_.attempts)
      return answer ? Error{ErrorCode::kUnavailable, "The store sent less than it said.", key}
                    : answer.error();
    Pause(attempt);
  }
  SKYQUILT_TRY_ASSIGN(const std::string sum, target.Finish());
  if (!object->sha256.empty() && sum != object->sha256) {
    return Error{ErrorCode::kCorrupt,
                 fmt::format("{}{} came with other bytes than were put there.", settings_.Address(), key),
                 sum + " instead of " + object->sha256};
  }
  object->sha256 = sum;
  return *std::move(object);
}

Result<void> S3Client::Put(const std::string& key, std::string_view bytes, const S3PutOptions& options) {
  Ask ask{"PUT", key};
  ask.headers = HeadersOfPut(options);
  ask.body = bytes;
  const std::string writer = NewId();
  if (options.if_absent) {
    // Not every store obeys the condition, and some refuse it; those that obey settle what comes between.
    const Result<S3Object> there = Head(key);
    if (there) return Error{ErrorCode::kConflict, fmt::format("{} is there already.", key), ""};
    if (there.error().code != ErrorCode::kNotFound) return there.error();
    ask.headers.emplace_back("If-None-Match", "*");
    ask.headers.emplace_back(kWriterHeader, writer);
  }
  int attempts = 0;
  Result<HttpAnswer> answer = Perform(ask, &attempts);
  if (!answer && options.if_absent && answer.error().code == ErrorCode::kNotImplemented) {
    // OpenStack Swift: the last of two who put at once stays, and the other one must see that.
    std::erase_if(ask.headers, [](const auto& header) { return header.first == "If-None-Match"; });
    answer = Perform(ask);
    if (answer) {
      SKYQUILT_TRY_ASSIGN(const S3Object kept, Head(key));
      if (kept.writer != writer)
        return Error{ErrorCode::kConflict, fmt::format("{} is there already.", key), ""};
    }
  }
  if (answer) return {};
  if (answer.error().code == ErrorCode::kConflict && attempts > 1) {
    // An earlier attempt may have arrived, and only its answer got lost.
    const Result<S3Object> there = Head(key);
    if (there && there->writer == writer) return {};
  }
  return answer.error();
}

Result<void> S3Client::Delete(const std::string& key) {
  const Result<HttpAnswer> answer = Perform({"DELETE", key});
  if (answer || answer.error().code == ErrorCode::kNotFound) return {};
  return answer.error();
}

Result<void> S3Client::DeleteAll(const std::vector<std::string>& keys) {
  std::vector<std::string> whole;
  for (const std::string& key : keys) whole.push_back(Whole(key));
  const std::string xml = DeletionXml(whole);
  Ask ask{"POST", ""};
  ask.query = {{"delete", ""}};
  ask.headers = {{"Content-Type", "application/xml"}, {"Content-MD5", Md5Base64(xml)}};
  ask.body = xml;
  SKYQUILT_TRY_ASSIGN(const HttpAnswer answer, Perform(ask));
  const std::optional<S3Refusal> refusal = ParseDeletionRefusal(answer.body);
  if (!refusal) return {};
  return Error{ErrorCode::kUnavailable, "The store of objects did not remove all that it was asked to.",
               refusal->code + " " + refusal->message};
}

Result<void> S3Client::Copy(const std::string& from, const std::string& to) {
  Ask ask{"PUT", to};
  ask.headers = {
      {"x-amz-copy-source", UriEncode(fmt::format("/{}/{}", settings_.bucket, Whole(from)), true)}};
  ask.stall_patience = std::chrono::seconds(300);  // a store copies before it answers
  SKYQUILT_TRY_ASSIGN(const HttpAnswer answer, Perform(ask));
  SKYQUILT_TRY(ParseCopiedEtag(answer.body));
  return {};
}

Result<ListedPage> S3Client::List(const std::string& prefix, const std::string& continuation) {
  Ask ask{"GET", ""};
  ask.query = {{"list-type", "2"}, {"prefix", Whole(prefix)}};
  if (!continuation.empty()) ask.query.emplace_back("continuation-token", continuation);
  SKYQUILT_TRY_ASSIGN(const HttpAnswer answer, Perform(ask));
  SKYQUILT_TRY_ASSIGN(ListedPage page, ParseListedPage(answer.body, Whole(prefix)));
  for (ListedObject& object : page.objects) object.key = Relative(object.key);
  return page;
}

}  // namespace skyquilt::storage
