// Forms with any number of files, either into a flight or to make one and queue its job at once.
#include <array>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "api/flights/flights.h"
#include "api/flights/trash.h"
#include "api/forms/multipart.h"
#include "api/http/digest.h"
#include "api/http/once.h"
#include "api/http/responses.h"
#include "api/json/job_options.h"
#include "api/json/json_codec.h"
#include "api/routes.h"
#include "api/uploads/form_receiver.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

// The content of a form as one SHA-256: fields, file names and bytes in their order, independent of the
// boundary, because a client that sends its form again chooses another one. Passes the parts on as they
// arrive.
class FormDigest final : public PartReceiver {
 public:
  // `next` takes the parts; none: they are only looked at.
  explicit FormDigest(PartReceiver* next) : next_(next) {}

  Result<void> BeginPart(const PartHeader& header) override;
  Result<void> PartBytes(std::span<const std::uint8_t> bytes) override;
  Result<void> EndPart() override;
  // Once, at the end.
  std::string Finish() { return digest_.Finish(); }

 private:
  void AddText(const std::string& text);
  void AddNumber(std::uint64_t number);

  PartReceiver* next_;
  Digest digest_{DigestAlgorithm::kSha256};
  std::uint64_t part_bytes_ = 0;
};

void FormDigest::AddNumber(std::uint64_t number) {
  std::array<std::uint8_t, 8> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(number >> (8 * i));
  digest_.Add(bytes);
}

// With its length before it, so that no two forms add up to the same bytes.
void FormDigest::AddText(const std::string& text) {
  AddNumber(text.size());
  digest_.Add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

Result<void> FormDigest::BeginPart(const PartHeader& header) {
  AddText(header.field);
  AddNumber(header.file_name ? 1 : 0);
  AddText(header.file_name.value_or(""));
  part_bytes_ = 0;
  return next_ == nullptr ? Result<void>() : next_->BeginPart(header);
}

Result<void> FormDigest::PartBytes(std::span<const std::uint8_t> bytes) {
  digest_.Add(bytes);
  part_bytes_ += bytes.size();
  return next_ == nullptr ? Result<void>() : next_->PartBytes(bytes);
}

Result<void> FormDigest::EndPart() {
  AddNumber(part_bytes_);
  return next_ == nullptr ? Result<void>() : next_->EndPart();
}

Error NothingUsable(const std::vector<FileOutcome>& files) {
  if (files.empty())
    return {ErrorCode::kUnprocessable, "The form has no files. Add photos and send it again."};
  return {ErrorCode::kUnprocessable, "None of the files could be taken. The first, \"" + files.front().name +
                                         "\": " + files.front().error->message};
}

// Files into a flight that is there.
class AddFiles final : public BodySink {
 public:
  AddFiles(Service& service, Request request, const std::string& boundary)
      : request_(std::move(request)),
        receiver_(service, request_.Parameter("flight")),
        parser_(boundary, receiver_) {}

  Result<void> Write(std::span<const std::uint8_t> bytes) override { return parser_.Push(bytes); }

  Response Finish() override {
    // What came whole stays even when the form was cut: sending the rest is then all that is left to do.
    const Result<void> whole = parser_.Finish();
    if (!whole) return Problem(whole.error(), request_);
    if (receiver_.stored_count() == 0) return Problem(NothingUsable(receiver_.files()), request_);
    return JsonOf(201, {{"files", FileOutcomesJson(receiver_.files())}});
  }

 private:
  Request request_;
  FormReceiver receiver_;
  MultipartParser parser_;
};

// A new flight with its files, queued at once. A form that breaks leaves no flight behind.
class NewFlight final : public BodySink {
 public:
  NewFlight(Service& service, Request request, const std::string& boundary, std::string flight_id)
      : service_(service),
        request_(std::move(request)),
        flight_id_(std::move(flight_id)),
        receiver_(service, flight_id_),
        digest_(&receiver_),
        parser_(boundary, digest_) {}

  ~NewFlight() override {
    if (is_kept_) return;
    // A flight that cannot be deleted now shows as one with files and no job; its owner can delete it.
    (void)RemoveFlight(service_, flight_id_).ok();
  }

  Result<void> Write(std::span<const std::uint8_t> bytes) override { return parser_.Push(bytes); }

  Response Finish() override {
    const Result<void> whole = parser_.Finish();
    if (!whole) return Problem(whole.error(), request_);
    return OnceBy(service_, request_, digest_.Finish(), [&] { return QueueAndAnswer(); });
  }

 private:
  Result<Response> QueueAndAnswer() {
    if (receiver_.stored_count() == 0) return NothingUsable(receiver_.files());
    SKYQUILT_TRY_ASSIGN(const storage::Job job, Start());
    is_kept_ = true;
    SKYQUILT_TRY_ASSIGN(FlightView view, ViewFlight(service_, flight_id_));
    view.base_path = request_.base_path;
    const storage::Time now = storage::Now();
    Response response = JsonOf(202, {{"flight", FlightJson(view, now)},
                                     {"job", JobJson(job, now)},
                                     {"files", FileOutcomesJson(receiver_.files())}});
    response.headers.Add("Location", "/api/v1/jobs/" + job.id);
    return response;
  }

  Result<storage::Job> Start() {
    const std::optional<std::string> name = receiver_.Text("name");
    const std::optional<std::string> chosen = receiver_.Text("options");
    if (chosen) SKYQUILT_TRY(ParseJobOptions(*chosen));
    nlohmann::ordered_json members = nlohmann::ordered_json::object();
    if (name && !name->empty()) members["name"] = *name;  // an empty box means no name
    if (chosen) members["options"] = ParseOrderedJson(*chosen);
    SKYQUILT_TRY_ASSIGN(const storage::FlightChange fields, ParseFlightFields(JsonText(members)));
    if (fields.IsAny()) SKYQUILT_TRY(service_.catalogue.ChangeFlight(flight_id_, fields));
    return service_.queue.Add(flight_id_, fields.options.value_or("{}"), storage::Now(), {0, request_.owner});
  }

  Service& service_;
  Request request_;
  std::string flight_id_;
  FormReceiver receiver_;
  FormDigest digest_;
  MultipartParser parser_;
  bool is_kept_ = false;
};

// The same form again under its key: it is only compared with the first, and nothing of it stored.
class FormAgain final : public BodySink {
 public:
  FormAgain(Service& service, Request request, const std::string& boundary)
      : service_(service), request_(std::move(request)), parser_(boundary, digest_) {}

  Result<void> Write(std::span<const std::uint8_t> bytes) override { return parser_.Push(bytes); }

  Response Finish() override {
    const Result<void> whole = parser_.Finish();
    if (!whole) return Problem(whole.error(), request_);
    return OnceBy(service_, request_, digest_.Finish(), [] {
      return Error{ErrorCode::kUnavailable,
                   "The first answer under this key is no longer kept. Send it again."};
    });
  }

 private:
  Service& service_;
  Request request_;
  FormDigest digest_{nullptr};
  MultipartParser parser_;
};

Result<Response> MakeEmptyFlight(Service& service, const Request& request, const std::string& body) {
  SKYQUILT_TRY_ASSIGN(const storage::FlightChange fields, ParseFlightFields(body));
  const storage::Time now = storage::Now();
  SKYQUILT_TRY_ASSIGN(storage::Flight flight,
                      service.catalogue.AddFlight(fields.name.value_or(DefaultFlightName(now)),
                                                  fields.options.value_or("{}"), now, request.owner, fields));
  FlightView view;
  view.flight = std::move(flight);
  Response response = JsonOf(201, FlightJson(view, now));
  response.headers.Add("Location", "/api/v1/flights/" + view.flight.id);
  return response;
}

UploadBegun BeginFlight(Service& service, const Request& request) {
  if (IsJson(request)) {
    return CollectBody(request, [&service](const Request& of, const std::string& body) {
      return Once(service, of, body, [&] { return MakeEmptyFlight(service, of, body); });
    });
  }
  SKYQUILT_TRY_ASSIGN(const std::string boundary, MultipartBoundary(request.headers.Find("Content-Type")));
  SKYQUILT_TRY_ASSIGN(const bool is_again, HasKeptAnswer(service, request));
  if (is_again) return std::make_unique<FormAgain>(service, request, boundary);
  const storage::Time now = storage::Now();
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight,
                      service.catalogue.AddFlight(DefaultFlightName(now), "{}", now, request.owner));
  return std::make_unique<NewFlight>(service, request, boundary, flight.id);
}

UploadBegun BeginFiles(Service& service, const Request& request) {
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY_ASSIGN(const std::string boundary, MultipartBoundary(request.headers.Find("Content-Type")));
  SKYQUILT_TRY_ASSIGN(const bool is_known, service.catalogue.HasFlight(flight_id));
  if (!is_known) return Error{ErrorCode::kNotFound, "There is no such flight."};
  return std::make_unique<AddFiles>(service, request, boundary);
}

}  // namespace

void AddMultipartRoutes(Router& router, Service& service) {
  router.AddUpload(Method::kPost, "/api/v1/flights", On(service, BeginFlight));
  router.AddUpload(Method::kPost, "/api/v1/flights/{flight}/files", On(service, BeginFiles));
}

}  // namespace skyquilt::api
