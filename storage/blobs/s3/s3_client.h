// S3Client: the operations of S3 that blobs need, on keys relative to the store's prefix. What fails for a
// passing reason (500, 502, 503, 504, 429, no connection, a stall, an answer that broke off) is tried again
// with pauses that double and are cut at random; a clock that differs from the store's and a region other
// than the one named are taken from its answers. Blocking; any number of threads. Errors: kNotFound;
// kUnavailable (it is away or overloaded); kForbidden (it refuses these keys; kUnavailable
// where it once took them), each with a sentence that says
// what to do; kConflict (a condition that did not hold); kCorrupt (an answer that is none of S3).
// Source: Amazon S3 API Reference.
//
// Signed here and not by libcurl's --aws-sigv4: that of 7.88 (Debian 12) signs another text than S3 does
// for queries without values ("?uploads") and for keys with some characters.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "storage/blobs/s3/http_transfer.h"
#include "storage/blobs/s3/s3_answers.h"
#include "storage/blobs/s3/s3_credentials.h"
#include "storage/blobs/s3/s3_settings.h"
#include "storage/blobs/s3/sign_request.h"

namespace skyquilt::storage {

struct S3Object {
  std::int64_t bytes = 0;
  std::string etag;
  std::string sha256;  // as its writer stated it; empty where it did not
  std::string writer;  // whose conditional put it was
  std::chrono::system_clock::time_point changed;
};

struct S3PutOptions {
  std::string sha256;  // of the whole, in hex; kept with the object
  bool if_absent = false;
};

class S3Client {
 public:
  S3Client(S3Settings settings, Variable variable);

  const S3Settings& settings() const { return settings_; }

  Result<S3Object> Head(const std::string& key);
  // `length` bytes from `offset` on, or as many as there are.
  Result<std::string> Get(const std::string& key, std::int64_t offset, std::int64_t length);
  // The whole object into a file that is made or emptied, and its checksum held against what is stated, by
  // one request. A transfer that breaks off goes on where it was. Durable when this returns.
  Result<S3Object> GetToFile(const std::string& key, const std::filesystem::path& path);
  // kConflict: with `if_absent`, where it is there already.
  Result<void> Put(const std::string& key, std::string_view bytes, const S3PutOptions& options);
  Result<void> Delete(const std::string& key);  // good also where there was none
  // Up to a thousand at once.
  Result<void> DeleteAll(const std::vector<std::string>& keys);
  Result<void> Copy(const std::string& from, const std::string& to);
  // One page of up to a thousand; keys relative to the store's prefix.
  Result<ListedPage> List(const std::string& prefix, const std::string& continuation);

  Result<std::string> BeginUpload(const std::string& key, const S3PutOptions& options);
  Result<UploadedPart> PutPart(const std::string& key, const std::string& upload_id, int number,
                               std::string_view bytes);
  // `bytes`: of the whole: by it a completion whose answer was lost is recognised.
  Result<void> Complete(const std::string& key, const std::string& upload_id,
                        const std::vector<UploadedPart>& parts, std::int64_t bytes);
  Result<void> Abort(const std::string& key, const std::string& upload_id);  // good also where it is gone

 private:
  struct Ask {
    std::string method;
    std::string key;  // relative; empty: the bucket
    NamedValues query = {};
    NamedValues headers = {};
    std::string_view body = {};
    std::function<Result<void>(std::string_view)> take = nullptr;
    // Of a good answer with a body, before that is taken; its request is not repeated after that.
    std::function<Result<void>(const HttpAnswer&)> begin = nullptr;
    std::chrono::seconds stall_patience{0};  // 0: the usual
    int attempts = 0;                        // 0: the usual
  };
  Result<HttpAnswer> Perform(Ask ask, int* attempts_made = nullptr);
  Result<HttpAnswer> PerformOnce(const Ask& ask, const std::string& payload_sha256, int attempt);
  // What an answer that is not good means; `may_retry` says whether it may pass.
  Error Meaning(const Ask& ask, const HttpAnswer& answer, bool& may_retry);
  bool Adapt(const HttpAnswer& answer, const S3Refusal& refusal);
  std::chrono::system_clock::time_point StoreTime() const;
  std::string Region() const;
  std::string Whole(const std::string& key) const { return settings_.prefix + key; }
  std::string Relative(const std::string& whole) const { return whole.substr(settings_.prefix.size()); }

  const S3Settings settings_;
  CredentialSource credentials_;
  HttpTransfers transfers_;
  mutable std::mutex mutex_;
  std::string region_;
  std::atomic<std::int64_t> skew_s_{0};  // the store's clock less ours
  std::atomic<bool> has_worked_{false};  // then a refusal is the store's trouble, not what was typed
};

}  // namespace skyquilt::storage
