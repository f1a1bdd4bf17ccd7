// What is said of command lines that name what does not exist.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include "server/usage/explain_usage.h"
#include "server/usage/option_values.h"

namespace skyquilt::server {
namespace {

// A program with commands, one with commands of its own, and one that help does not list.
struct Program {
  CLI::App app{"test"};
  std::string method = "auto";

  Program() {
    app.require_subcommand(1);
    CLI::App* stitch = app.add_subcommand("stitch", "");
    stitch->add_option("IN", inputs)->required();
    stitch->add_option("-o,--out", out);
    stitch->add_flag("--previews,!--no-previews", previews);
    stitch->add_option("--method", method)->check(OneOf({"auto", "imu"}));
    CLI::App* report = app.add_subcommand("report", "");
    report->add_option("MAP", inputs)->required();
    report->add_option("-o,--out", out)->required();
    report->add_flag("--overwrite", previews);
    app.add_subcommand("inspect", "");
    CLI::App* token = app.add_subcommand("token", "");
    token->require_subcommand(1);
    token->add_subcommand("add", "");
    app.add_subcommand("stitch-sandboxed", "")->group("");
  }
  std::string Of(const std::vector<std::string>& words) const {
    return WhatIsUnknown(app, words).value_or("");
  }

  std::vector<std::string> inputs;
  std::string out;
  bool previews = true;
};

TEST(WhatIsUnknown, NamesTheCommandThatWasMeant) {
  const Program program;
  EXPECT_EQ(
      program.Of({"stich", "photos"}),
      "skyquilt has no command \"stich\". Did you mean skyquilt stitch? \"skyquilt --help\" lists them.");
  EXPECT_EQ(
      program.Of({"insp"}),
      "skyquilt has no command \"insp\". Did you mean skyquilt inspect? \"skyquilt --help\" lists them.");
  EXPECT_EQ(
      program.Of({"tokens"}),
      "skyquilt has no command \"tokens\". Did you mean skyquilt token? \"skyquilt --help\" lists them.");
  EXPECT_EQ(
      program.Of({"token", "ad"}),
      "skyquilt token has no command \"ad\". Did you mean skyquilt token add? \"skyquilt token --help\" lists "
      "them.");
  EXPECT_EQ(program.Of({"wxyz"}), "skyquilt has no command \"wxyz\". \"skyquilt --help\" lists them.");
}

TEST(WhatIsUnknown, NamesTheOptionThatWasMeant) {
  const Program program;
  EXPECT_EQ(
      program.Of({"stitch", "--ot", "x", "y"}),
      "skyquilt stitch has no option --ot. Did you mean --out? \"skyquilt stitch --help\" explains all it has.");
  EXPECT_EQ(
      program.Of({"stitch", "x", "--methd=imu"}),
      "skyquilt stitch has no option --methd. Did you mean --method? \"skyquilt stitch --help\" explains all it "
      "has.");
  EXPECT_EQ(program.Of({"--hlp"}),
            "skyquilt has no option --hlp. Did you mean --help? \"skyquilt --help\" explains all it has.");
  EXPECT_NE(program.Of({"stitch", "--\x1b[31m" + std::string(200, 'x')}), "");
  EXPECT_EQ(program.Of({"stitch", "--\x1b[31m"}).find('\x1b'), std::string::npos);
}

TEST(WhatIsUnknown, LeavesWhatTheLibraryKnows) {
  const Program program;
  for (const std::vector<std::string>& words : {std::vector<std::string>{},
                                                {"--help"},
                                                {"stitch"},
                                                {"stitch", "--help"},
                                                {"stitch", "x", "-o", "y"},
                                                {"stitch", "x", "--out=y"},
                                                {"stitch", "--no-previews", "x"},
                                                {"stitch", "--", "--odd-name.jpg"},
                                                {"token", "add"},
                                                {"token", "--help"},
                                                {"stitch-sandboxed"},
                                                {"stitch", "inspekt"}}) {
    EXPECT_EQ(program.Of(words), "");
  }
}

TEST(NearWord, IsNearAndNotJustAnyWord) {
  const std::vector<std::string> known{"stitch", "serve", "place"};
  EXPECT_EQ(NearWord("sitch", known), "stitch");
  EXPECT_EQ(NearWord("sttich", known), "stitch");
  EXPECT_EQ(NearWord("plaec", known), "place");
  EXPECT_EQ(NearWord("ser", known), "serve");
  EXPECT_FALSE(NearWord("photos", known));
  EXPECT_FALSE(NearWord("", known));
  EXPECT_FALSE(NearWord(std::string(100'000, 's'), known));
  EXPECT_FALSE(NearWord("x", {}));
}

TEST(OneOf, ListsTheWordsThatItTakes) {
  enum class Kind { kFirst = 3, kSecond = 7 };
  CLI::App app;
  Kind kind = Kind::kFirst;
  app.add_option("--kind", kind)
      ->transform(OneOf(
          std::vector<std::pair<std::string, Kind>>{{"first", Kind::kFirst}, {"second", Kind::kSecond}}));
  app.parse("--kind second");
  EXPECT_EQ(kind, Kind::kSecond);
  for (const char* bad : {"--kind third", "--kind 7"}) {
    try {
      app.parse(bad);
      FAIL() << bad;
    } catch (const CLI::ParseError& error) {
      EXPECT_NE(std::string(error.what()).find("it takes first or second."), std::string::npos)
          << error.what();
    }
  }
  EXPECT_NE(app.help().find("first or second"), std::string::npos);
}

TEST(WhatWasToBeWritten, IsTheLastWordThatIsNotThere) {
  const Program program;
  const auto of = [&](const std::vector<std::string>& words) {
    return WhatWasToBeWritten(program.app, words).value_or("");
  };
  EXPECT_EQ(
      of({"report", "/", "no_such_map9"}),
      "skyquilt report: there is nothing at no_such_map9. If that is what to write, say -o no_such_map9. "
      "\"skyquilt report --help\" explains what it takes.");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{},
        {"report"},
        {"report", "no_such_map9"},  // the input, more likely
        {"report", "/", "/"},
        {"report", "/", "-o", "no_such_map9"},
        {"report", "/", "--out=no_such_map9"},
        {"report", "/", "--picture-px", "800"},
        {"report", "/", "--help"},
        {"stitch", "/", "no_such_map9"},  // of which no --out is wanted here
        {"inspect", "/", "no_such_map9"},
        {"reprt", "/", "no_such_map9"}}) {
    EXPECT_EQ(of(words), "") << testing::PrintToString(words);
  }
}

TEST(HelpAsOption, IsThatOfTheCommandNamed) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(HelpAsOption({"help"}), Words{"--help"});
  EXPECT_EQ(HelpAsOption({"help", "token", "add"}), (Words{"token", "add", "--help"}));
  EXPECT_EQ(HelpAsOption({"stitch", "help"}), (Words{"stitch", "help"}));  // a folder
  EXPECT_EQ(HelpAsOption({}), Words{});
}

TEST(ParseLengthM, TakesMetresAndUnits) {
  EXPECT_EQ(ParseLengthM("0.05"), 0.05);
  EXPECT_EQ(ParseLengthM("0.05m"), 0.05);
  EXPECT_EQ(ParseLengthM("5cm"), 0.05);
  EXPECT_EQ(ParseLengthM("5 cm"), 0.05);
  EXPECT_NEAR(*ParseLengthM("17.3mm"), 0.0173, 1e-12);
  EXPECT_NEAR(*ParseLengthM("2in"), 0.0508, 1e-12);
  EXPECT_NEAR(*ParseLengthM("1e-1ft"), 0.03048, 1e-12);
  EXPECT_EQ(ParseLengthM("-1"), -1.0);  // for the option to refuse
  for (const char* text :
       {"", "m", "cm5", "5 km", "5  cm", "5cm ", "nan", "inf", "1e999", "0,05", "5,cm", "0x5"})
    EXPECT_FALSE(ParseLengthM(text)) << text;
}

TEST(Length, BecomesMetresWithoutLosingDigits) {
  CLI::App app{"test"};
  std::optional<double> gsd_m;
  bool any_gsd = false;
  AddGsdOptions(app, gsd_m, any_gsd);
  app.parse("--gsd 1.7320508075688772cm --any-gsd");
  EXPECT_EQ(gsd_m, 1.7320508075688772 * 0.01);
  EXPECT_TRUE(any_gsd);
  app.parse("--gsd=0.017320508075688772");
  EXPECT_EQ(gsd_m, 0.017320508075688772);
  EXPECT_THROW(app.parse("--gsd 5furlongs"), CLI::ValidationError);
}

TEST(RefuseNoNumbers, HoldsForEveryOptionOfNumbersBelowAProgram) {
  CLI::App app{"test"};
  double memory_gib = 1.0, scale = 1.0;
  std::string word;
  CLI::App* stitch = app.add_subcommand("stitch", "");
  stitch->add_option("--max-memory", memory_gib)->check(CLI::Range(0.25, 64.0));
  stitch->add_option("--name", word);
  stitch->add_subcommand("again", "")->add_option("--scale", scale);
  RefuseNoNumbers(app);
  for (const char* line : {"stitch --max-memory nan", "stitch --max-memory=-NaN", "stitch again --scale nan"})
    EXPECT_THROW(app.parse(line), CLI::ValidationError) << line;
  app.parse("stitch --max-memory 2 --name nan again --scale 3");
  EXPECT_EQ(memory_gib, 2.0);
  EXPECT_EQ(word, "nan");
  EXPECT_EQ(scale, 3.0);
}

}  // namespace
}  // namespace skyquilt::server
