#include "api/http/compress.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <string>

namespace skyquilt::api {
namespace {

Request Asking(const std::string& accepted) {
  Request request;
  request.headers.Add("Accept-Encoding", accepted);
  return request;
}

Response Answer(std::string body, const std::string& type = "application/json") {
  Response response;
  response.body = std::move(body);
  response.headers.Add("Content-Type", type);
  response.headers.Add("ETag", "\"a\"");
  return response;
}

std::string Unpacked(const std::string& packed, std::size_t size) {
  std::string text(size + 1, '\0');
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, 15 + 16), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(text.data());
  stream.avail_out = static_cast<uInt>(text.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  text.resize(stream.total_out);
  inflateEnd(&stream);
  return text;
}

class Bytes final : public BodySource {
 public:
  explicit Bytes(std::string bytes) : bytes_(std::move(bytes)) {}
  std::uint64_t length() const override { return bytes_.size(); }
  Result<std::size_t> Read(std::span<std::uint8_t> into) override {
    const std::size_t count = std::min<std::size_t>({into.size(), bytes_.size() - at_, 700});
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), count, into.begin());
    at_ += count;
    return count;
  }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

const std::string kText = std::string(3000, 'a') + std::string(3000, 'b');

TEST(CompressAnswer, PacksTextForWhoTakesIt) {
  Response response = Answer(kText);
  ASSERT_TRUE(CompressAnswer(Asking("br, gzip"), response));
  EXPECT_EQ(response.headers.Find("Content-Encoding"), "gzip");
  EXPECT_EQ(response.headers.Find("Vary"), "Accept-Encoding");
  EXPECT_EQ(response.headers.Find("ETag"), "W/\"a\"");
  EXPECT_LT(response.body.size(), 200U);
  EXPECT_EQ(Unpacked(response.body, kText.size()), kText);
}

TEST(CompressAnswer, PacksFilesToo) {
  Response response = Answer("", "application/geo+json");
  response.source = std::make_unique<Bytes>(kText);
  ASSERT_TRUE(CompressAnswer(Asking("gzip"), response));
  EXPECT_EQ(response.source, nullptr);
  EXPECT_EQ(Unpacked(response.body, kText.size()), kText);
}

TEST(CompressAnswer, LeavesTheRestAsItIs) {
  const auto is_as_it_was = [](const Request& request, Response response) {
    const std::string before = response.body;
    EXPECT_TRUE(CompressAnswer(request, response));
    return response.body == before && !response.headers.Has("Content-Encoding") &&
           response.headers.Find("ETag") == "\"a\"";
  };
  EXPECT_TRUE(is_as_it_was(Asking("identity"), Answer(kText)));
  EXPECT_TRUE(is_as_it_was(Asking("gzip;q=0"), Answer(kText)));
  EXPECT_TRUE(is_as_it_was(Asking("br, gzip; q=0.000"), Answer(kText)));
  EXPECT_TRUE(is_as_it_was(Asking("gzip"), Answer(kText, "image/png")));
  EXPECT_TRUE(is_as_it_was(Asking("gzip"), Answer("short")));
  Request part = Asking("gzip");
  part.headers.Add("Range", "bytes=0-9");
  EXPECT_TRUE(is_as_it_was(part, Answer(kText)));
  Response partial = Answer(kText);
  partial.status = 206;
  EXPECT_TRUE(is_as_it_was(Asking("gzip"), std::move(partial)));
}

}  // namespace
}  // namespace skyquilt::api
