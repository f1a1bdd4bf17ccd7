#include "api/forms/multipart.h"

#include <gtest/gtest.h>

#include <random>

namespace skyquilt::api {
namespace {

struct Part {
  std::string field;
  std::string file_name;  // "-" for none
  std::string bytes;
  bool operator==(const Part&) const = default;
};

class Recorder final : public PartReceiver {
 public:
  Result<void> BeginPart(const PartHeader& header) override {
    open_ = Part{header.field, header.file_name.value_or("-"), ""};
    return {};
  }
  Result<void> PartBytes(std::span<const std::uint8_t> bytes) override {
    ++pieces;
    open_.bytes.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return {};
  }
  Result<void> EndPart() override {
    parts.push_back(open_);
    return {};
  }
  std::vector<Part> parts;
  int pieces = 0;

 private:
  Part open_;
};

struct Outcome {
  bool ok = false;
  std::vector<Part> parts;
  bool operator==(const Outcome&) const = default;
};

// The body in pieces that end at the given offsets.
Outcome Parse(const std::string& boundary, const std::string& body,
              const std::vector<std::size_t>& cuts = {}) {
  Recorder recorder;
  MultipartParser parser(boundary, recorder);
  std::size_t from = 0;
  Result<void> pushed;
  std::vector<std::size_t> ends = cuts;
  ends.push_back(body.size());
  for (const std::size_t end : ends) {
    const auto* data = reinterpret_cast<const std::uint8_t*>(body.data());
    pushed = parser.Push({data + from, end - from});
    from = end;
    if (!pushed) return {false, recorder.parts};
  }
  return {parser.Finish().ok(), recorder.parts};
}

std::string FilePart(const std::string& boundary, const std::string& name, const std::string& bytes) {
  return "--" + boundary + "\r\nContent-Disposition: form-data; name=\"f\"; filename=\"" + name +
         "\"\r\nContent-Type: image/jpeg\r\n\r\n" + bytes + "\r\n";
}

const std::string kTwoFiles =
    FilePart("XyZ", "a.jpg", "one\r\n--XyZno\r\n--Xy\r\n-") + FilePart("XyZ", "b.jpg", "") +
    "--XyZ\r\ncontent-disposition: form-data; name=name\r\n\r\nfield\r\n--XyZ--\r\nrest";
const std::vector<Part> kTwoFilesParts = {
    {"f", "a.jpg", "one\r\n--XyZno\r\n--Xy\r\n-"}, {"f", "b.jpg", ""}, {"name", "-", "field"}};

TEST(Multipart, GivesEveryPartItsBytes) {
  const Outcome outcome = Parse("XyZ", kTwoFiles);
  EXPECT_TRUE(outcome.ok);
  EXPECT_EQ(outcome.parts, kTwoFilesParts);
}

// Each piece is written to the disk by itself.
TEST(Multipart, HandsOnAtOnceWhatOnlyLooksLikeDelimiters) {
  std::string bytes;
  for (int i = 0; i < 10'000; ++i) bytes += "\r\n--bx";
  const std::string body = FilePart("b", "a.jpg", bytes) + "--b--\r\n";
  Recorder recorder;
  MultipartParser parser("b", recorder);
  ASSERT_TRUE(parser.Push({reinterpret_cast<const std::uint8_t*>(body.data()), body.size()}));
  ASSERT_TRUE(parser.Finish());
  EXPECT_EQ(recorder.parts, (std::vector<Part>{{"f", "a.jpg", bytes}}));
  EXPECT_EQ(recorder.pieces, 1);
}

TEST(Multipart, DoesNotCareWhereTheBodyIsCut) {
  const Outcome whole = Parse("XyZ", kTwoFiles);
  for (std::size_t cut = 0; cut <= kTwoFiles.size(); ++cut) {
    EXPECT_EQ(Parse("XyZ", kTwoFiles, {cut}), whole) << cut;
  }
  std::vector<std::size_t> every;
  for (std::size_t cut = 1; cut < kTwoFiles.size(); ++cut) every.push_back(cut);
  EXPECT_EQ(Parse("XyZ", kTwoFiles, every), whole);
}

TEST(Multipart, AgreesWithItselfOnRandomBodiesAndCuts) {
  std::mt19937 random(7);
  const std::string alphabet = "\r\n-bB \":;=x";
  for (int round = 0; round < 3000; ++round) {
    std::string body = round % 2 == 0 ? "--b\r\nContent-Disposition: form-data; name=x\r\n\r\n" : "";
    const std::size_t length = random() % 60;
    for (std::size_t i = 0; i < length; ++i) body.push_back(alphabet[random() % alphabet.size()]);
    if (round % 3 == 0) body += "\r\n--b--";
    const Outcome whole = Parse("b", body);
    std::vector<std::size_t> cuts;
    for (std::size_t at = random() % 5; at < body.size(); at += 1 + random() % 5) cuts.push_back(at);
    ASSERT_EQ(Parse("b", body, cuts), whole) << testing::PrintToString(body);
  }
}

TEST(Multipart, DropsThePreambleAndWhatFollowsTheEnd) {
  const std::string body = "hello\r\n" + FilePart("b", "a", "x") + "--b--" + FilePart("b", "z", "y");
  EXPECT_EQ(Parse("b", body).parts, (std::vector<Part>{{"f", "a", "x"}}));
}

TEST(Multipart, TakesPaddingBehindADelimiter) {
  const std::string body = "--b \t \r\nContent-Disposition: form-data; name=x\r\n\r\n1\r\n--b--";
  EXPECT_EQ(Parse("b", body).parts, (std::vector<Part>{{"x", "-", "1"}}));
}

TEST(Multipart, RefusesWhatIsCutOffOrBroken) {
  const std::string good = FilePart("b", "a", "x") + "--b--";
  for (std::size_t length = 0; length < good.size(); ++length)
    EXPECT_FALSE(Parse("b", good.substr(0, length)).ok);
  for (const char* header :
       {"", "Content-Type: text/plain", "Content-Disposition: attachment; name=x",
        "Content-Disposition: form-data", "Content-Disposition: form-data; name=\"x",
        "Content-Disposition: form-data; name=x; name=y", "no colon here",
        "Content-Disposition: form-data; name=x\r\n folded: y",
        "Content-Disposition: form-data; name=x\r\nContent-Transfer-Encoding: base64",
        "Content-Disposition: form-data; name=x\r\nContent-Disposition: form-data; name=x",
        "Content-Disposition: form-data; name=\"a\nb\"",
        "Content-Disposition: form-data; name=x; filename*=latin1''a"}) {
    EXPECT_FALSE(Parse("b", std::string("--b\r\n") + header + "\r\n\r\nx\r\n--b--").ok) << header;
  }
}

TEST(Multipart, KeepsItsMemoryWhenAHeaderNeverEnds) {
  Recorder recorder;
  MultipartParser parser("b", recorder);
  const std::string start = "--b\r\n";
  ASSERT_TRUE(parser.Push({reinterpret_cast<const std::uint8_t*>(start.data()), start.size()}));
  const std::vector<std::uint8_t> junk(1000, 'a');
  int pushes = 0;
  while (parser.Push(junk) && pushes < 100) ++pushes;
  EXPECT_LT(pushes, 10);
}

TEST(Multipart, StopsAtTooManyParts) {
  std::string body;
  for (int i = 0; i <= kMaxParts; ++i) body += "--b\r\nContent-Disposition: form-data; name=x\r\n\r\n\r\n";
  EXPECT_FALSE(Parse("b", body + "--b--").ok);
}

TEST(PartHeader, ReadsFileNamesAsClientsSendThem) {
  const auto name_of = [](const std::string& parameters) {
    const auto header = ParsePartHeader("Content-Disposition: form-data; name=\"f\"; " + parameters);
    return header && header->file_name ? *header->file_name : "(none)";
  };
  EXPECT_EQ(name_of("filename=\"a b.jpg\""), "a b.jpg");
  EXPECT_EQ(name_of("filename=a.jpg"), "a.jpg");
  EXPECT_EQ(name_of("filename=\"a%22b;c.jpg\""), "a\"b;c.jpg");
  EXPECT_EQ(name_of("filename=\"a\\\"b.jpg\""), "a\"b.jpg");
  EXPECT_EQ(name_of("filename=\"C:\\dir\\a.jpg\""), "C:\\dir\\a.jpg");
  EXPECT_EQ(name_of("filename=\"50%.jpg\""), "50%.jpg");
  EXPECT_EQ(name_of("filename*=UTF-8''..%2fa"), "../a");
  EXPECT_EQ(name_of("filename=\"=?utf-8?B?RmzDtno=?=\"; filename*=utf-8''Fl%C3%B6z.jpg"), "Fl\xc3\xb6z.jpg");
  EXPECT_EQ(name_of("filename=a.jpg; filename*=latin1''b"), "a.jpg");
  EXPECT_EQ(name_of("filename=\"\""), "");
  EXPECT_EQ(name_of("x=y"), "(none)");
}

TEST(MultipartBoundary, IsFoundOrRefused) {
  EXPECT_EQ(*MultipartBoundary("multipart/form-data; boundary=abc"), "abc");
  EXPECT_EQ(*MultipartBoundary("Multipart/Form-Data; charset=x; Boundary=\"a b'()+_,-./:=?c\""),
            "a b'()+_,-./:=?c");
  EXPECT_EQ(MultipartBoundary("text/plain").error().code, ErrorCode::kUnsupportedFormat);
  EXPECT_EQ(MultipartBoundary("").error().code, ErrorCode::kUnsupportedFormat);
  for (const std::string& bad :
       {std::string("multipart/form-data"), std::string("multipart/form-data; boundary="),
        std::string("multipart/form-data; boundary=\"a \""),
        "multipart/form-data; boundary=" + std::string(71, 'a'),
        std::string("multipart/form-data; boundary=\"a\r\nb\""),
        std::string("multipart/form-data; boundary=\"a")}) {
    EXPECT_EQ(MultipartBoundary(bad).error().code, ErrorCode::kInvalidArgument) << bad;
  }
}

}  // namespace
}  // namespace skyquilt::api
