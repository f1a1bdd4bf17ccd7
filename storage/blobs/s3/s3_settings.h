// S3Settings: where a store of objects is and how it is spoken to: from "s3://bucket/prefix" and the
// variables that AWS's own programs and GDAL take. Values; read once, at the start. Errors:
// kInvalidArgument, with a sentence that says what to give.
//   AWS_REGION, AWS_DEFAULT_REGION            the region (us-east-1)
//   AWS_ENDPOINT_URL_S3, AWS_ENDPOINT_URL     http://host:port of a store that is not Amazon's
//   AWS_S3_ENDPOINT, AWS_HTTPS                the same as GDAL has it: host:port, and NO for http
//   AWS_VIRTUAL_HOSTING                       TRUE: bucket.host; FALSE: host/bucket, which other stores want
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "core/base/result.h"

namespace skyquilt::storage {

struct S3Settings {
  std::string bucket;
  std::string prefix;  // "" or "a/b/", with its slash
  std::string region = "us-east-1";
  std::string scheme = "https";
  std::string host;  // with port; without the bucket
  bool is_bucket_in_host = true;
  std::chrono::seconds connect_patience{5};
  std::chrono::seconds stall_patience{10};  // of a transfer that stands still
  int attempts = 6;                         // for each request, with growing pauses

  std::string HostOfRequests() const { return is_bucket_in_host ? bucket + "." + host : host; }
  // "/bucket/prefix/key" or "/prefix/key", not encoded. An empty key: the bucket itself.
  std::string PathOf(const std::string& key) const;
  // As it was given; names no secret.
  std::string Address() const { return "s3://" + bucket + "/" + prefix; }
};

// `variable`: the environment; empty where it is not set.
using Variable = std::function<std::string(const char*)>;
std::string EnvironmentVariable(const char* name);
Result<S3Settings> ReadS3Settings(const std::string& address, const Variable& variable);

}  // namespace skyquilt::storage
