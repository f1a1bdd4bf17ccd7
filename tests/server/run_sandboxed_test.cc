// What a sandboxed process answers its parent.
#include "server/sandbox/run_sandboxed.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdio.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "core/base/progress.h"
#include "core/base/text/json_io.h"
#include "core/flight/remarks/because.h"
#include "core/simulate/simulate_flight.h"
#include "server/exports/export_sandboxed.h"
#include "server/intake/unpack_sandboxed.h"
#include "server/preview/preview_painter.h"
#include "server/sandbox/sandboxed_child.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::server {
namespace {

// The message of a process that works so on "the task".
std::string SaidBy(const std::function<Result<std::string>(const std::string& task)>& work) {
  int to[2];
  int from[2];
  if (pipe2(to, O_CLOEXEC) != 0 || pipe2(from, O_CLOEXEC) != 0) std::abort();
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child == 0) {
    dup2(to[0], STDIN_FILENO);
    dup2(from[1], STDOUT_FILENO);
    _exit(AnswerParent(parent, work));
  }
  close(to[0]);
  close(from[1]);
  EXPECT_TRUE(MessageWriter(to[1]).Write("the task"));
  const std::optional<std::string> said = MessageReader(from[0], 1 << 20).Read(std::chrono::seconds(20));
  EXPECT_EQ(WaitOrKill(child, std::chrono::seconds(20)).wait_status, 0);
  close(to[1]);
  close(from[0]);
  return said.value_or("");
}

TEST(ExportSandboxed, AFolderThatIsGoneIsNoFullDisk) {
  ExportTask task;
  task.work_dir = "/nonexistent/work";
  const Result<std::int64_t> made = ExportSandboxed(task, {}, [](double) { return true; });
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kIo) << made.error().message;
}

TEST(UnpackSandboxed, WhatTheDiskSaysIsSaid) {
  const test::TemporaryFolder folder;
  const auto dir = test::ValueOf(storage::DataDir::Open(folder.path() / "data"));
  std::filesystem::remove_all(dir.Incoming());
  const auto unpacked = UnpackSandboxed(storage::PhotoStore(dir), "flight", folder.path() / "a.zip", 1);
  ASSERT_FALSE(unpacked);
  EXPECT_EQ(unpacked.error().code, ErrorCode::kIo) << unpacked.error().message;
}

TEST(PreviewPainter, APhotoThatTheDiskDoesNotGiveIsNotPassedOverForGood) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("looped", folder / "looped");  // cannot be opened
  folder.Write("damaged", "no photo");
  std::vector<std::string> begun;
  PreviewPainter painter(folder.path(), folder.path(),
                         [&](const std::string& stored_name) { begun.push_back(stored_name); });
  PreviewRequest request{{{"a.jpg", "looped", 8}, {"b.jpg", "damaged", 8}}, {}, std::nullopt};
  const auto drawn = test::ValueOf(painter.Draw(request));
  EXPECT_EQ(drawn.forgone, std::vector<std::string>{"damaged"});
  EXPECT_EQ(begun, (std::vector<std::string>{"looped", "damaged"}));
}

// Which way it flies, the first photo cannot say without another; by then its process is gone.
TEST(PreviewPainter, TheFirstPhotoIsDrawnOnceTheSecondSaysHowItIsTurned) {
  const test::TemporaryFolder folder;
  simulate::SimulateOptions simulated;
  simulated.trajectory.photos = 2;
  simulated.intrinsics = camera::Intrinsics::Centered(640, 480, 480.0);
  simulated.noise = simulate::NoiseClass::kNoAttitude;
  simulated.write_world = false;
  SilentProgress progress;
  const auto flown = test::ValueOf(simulate::SimulateFlight(simulated, folder.path(), progress));
  const auto stored = [&](std::size_t photo) {
    const std::string& name = flown.photos.at(photo).photo.name;
    return storage::StoredFile{name, name, 1};
  };
  const auto drawn_by_another_process = [&](const PreviewRequest& request) {
    PreviewPainter painter(folder / "photos", folder.path(), [](const std::string&) {});
    return test::ValueOf(painter.Draw(request));
  };
  const PreviewDrawn alone = drawn_by_another_process({{stored(0)}, {}, std::nullopt});
  EXPECT_FALSE(alone.preview);
  EXPECT_TRUE(alone.forgone.empty());
  const PreviewDrawn both = drawn_by_another_process({{stored(1)}, {stored(0)}, std::nullopt});
  ASSERT_TRUE(both.preview);
  EXPECT_EQ(both.preview->photos, 2);
}

TEST(AnswerParent, WhatALibraryPrintsIsNoPartOfTheAnswer) {
  EXPECT_EQ(SaidBy([](const std::string& task) -> Result<std::string> {
              dprintf(STDOUT_FILENO, "a library prints\n");
              return "\"" + task + "\"";
            }),
            "\"the task\"");
}

TEST(AnswerParent, AnErrorKeepsItsReason) {
  const Error refused =
      flight::Because(ErrorCode::kUnprocessable,
                      {flight::RemarkCode::kFailArchive, {{"why_words", "it is encrypted"}}}, "entry 3");
  const std::string said = SaidBy([&](const std::string&) -> Result<std::string> { return refused; });
  const std::optional<Error> error = ErrorOfJson(ParseJson(said).at("error"));
  ASSERT_TRUE(error) << said;
  EXPECT_EQ(error->code, refused.code);
  EXPECT_EQ(error->message, refused.message);
  EXPECT_EQ(error->detail, "entry 3");
  ASSERT_NE(error->reason, nullptr);
  EXPECT_EQ(*error->reason, *refused.reason);
}

}  // namespace
}  // namespace skyquilt::server
