// The façade for command lines, in one process: what options store, and what is bad usage.
#include <filesystem>
#include <optional>

#include <gtest/gtest.h>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"

namespace sightline::apps::options_test {
namespace {

enum class Fruit { kPear, kApple };

struct Outcome {
  int code;
  std::string out, err;
};

Outcome run(CommandLine& line, std::vector<std::string> words) {
  words.insert(words.begin(), "tool");
  std::vector<char*> argv;
  argv.reserve(words.size());
  for (std::string& word : words) argv.push_back(word.data());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int code = line.run(int(argv.size()), argv.data(), [] { return kExitOk; });
  return {code, testing::internal::GetCapturedStdout(), testing::internal::GetCapturedStderr()};
}

CommandLine make_line() {
  return CommandLine("What it does", "tool", "  tool --fruit pear");
}

TEST(Options, AChoiceIsStoredListedAndChecked) {
  CommandLine line = make_line();
  Fruit fruit = Fruit::kPear;
  line.add_choice("--fruit", fruit, {{"pear", Fruit::kPear}, {"apple", Fruit::kApple}}, "To eat").shows_default();
  EXPECT_EQ(run(line, {"--fruit", "apple"}).code, kExitOk);
  EXPECT_EQ(fruit, Fruit::kApple);
  const Outcome refused = run(line, {"--fruit", "plum"});
  EXPECT_EQ(refused.code, kExitUsage);
  EXPECT_EQ(refused.err, "tool: --fruit: plum not in {apple,pear} (see --help)\n");
  const Outcome help = run(line, {"--help"});
  EXPECT_EQ(help.code, kExitOk);
  EXPECT_NE(help.out.find("--fruit apple|pear (pear)"), std::string::npos) << help.out;
  EXPECT_NE(help.out.find("Examples:\n  tool --fruit pear"), std::string::npos) << help.out;
}

TEST(Options, ParsedValuesOptionalOnesAndPathsWithSpaces) {
  CommandLine line = make_line();
  double number = 0.0;
  std::optional<double> given, absent;
  std::filesystem::path folder;
  line.add_parsed("--number", number, parse_finite, "A number");
  line.add("--given", given, "Optional");
  line.add("--absent", absent, "Optional");
  line.add("--folder", folder, "A path");
  EXPECT_EQ(run(line, {"--number", "1.5", "--given", "2", "--folder", "a b/c"}).code, kExitOk);
  EXPECT_EQ(number, 1.5);
  EXPECT_EQ(given, 2.0);
  EXPECT_FALSE(absent);
  EXPECT_EQ(folder, "a b/c");
  EXPECT_EQ(run(line, {"--number", "nan"}).err,
            "tool: --number: expected a finite number, found \"nan\" (see --help)\n");
}

TEST(Options, RangesWriteBoundsAsTheirTypeDoes) {
  CommandLine line = make_line();
  int whole = 0;
  double real = 0.0;
  line.add("--whole", whole, "").in_range(1, 9);
  line.add("--real", real, "").in_range(0.5, 9.0);
  EXPECT_EQ(run(line, {"--whole", "10"}).err, "tool: --whole: Value 10 not in range 1 to 9 (see --help)\n");
  EXPECT_EQ(run(line, {"--real", "0"}).err, "tool: --real: Value 0 not in range 0.500000 to 9.000000 (see --help)\n");
}

TEST(Options, RulesRunInOrderAfterAllOptionsAndMayAdjustThem) {
  CommandLine line = make_line();
  int number = 0;
  line.add("--number", number, "");
  line.check([&]() -> core::Expected<void> {
    number *= 2;
    return {};
  });
  line.check([&]() -> core::Expected<void> {
    if (number > 10) return core::fail("--number: too large");
    return {};
  });
  EXPECT_EQ(run(line, {"--number", "5"}).code, kExitOk);
  EXPECT_EQ(number, 10);
  const Outcome refused = run(line, {"--number", "6"});
  EXPECT_EQ(refused.code, kExitUsage);
  EXPECT_EQ(refused.err, "tool: --number: too large (see --help)\n");
}

TEST(Options, HandlesOfPartsKeepTheCommandLine) {
  std::optional<CommandLine> line = make_line();
  CommandLine one = line->subcommand("one", "First"), two = line->subcommand("two", "Second");
  line->require_subcommand();
  bool flag = true;
  const Option option = two.add_flag("!--no-flag", flag);
  EXPECT_EQ(run(*line, {}).code, kExitUsage);
  EXPECT_EQ(run(*line, {"two", "--no-flag"}).code, kExitOk);
  line.reset();
  EXPECT_FALSE(one.chosen());
  EXPECT_TRUE(two.chosen());
  EXPECT_TRUE(option.given());
  EXPECT_FALSE(flag);
}

TEST(Options, ExactlyOneOfAGroupHasToBeGiven) {
  CommandLine line = make_line();
  int a = 0, b = 0;
  CommandLine group = line.exactly_one_of("source");
  group.add("--a", a, "");
  group.add("--b", b, "");
  EXPECT_EQ(run(line, {}).code, kExitUsage);
  EXPECT_EQ(run(line, {"--a", "1", "--b", "2"}).code, kExitUsage);
  EXPECT_EQ(run(line, {"--b", "2"}).code, kExitOk);
  EXPECT_EQ(b, 2);
}

TEST(Options, RelationsBetweenOptions) {
  CommandLine line = make_line();
  bool a = false, b = false, c = false;
  const Option first = line.add_flag("--a", a);
  line.add_flag("--b", b).needs(first);
  line.add_flag("--c", c).excludes({"--a", "--b"});
  EXPECT_EQ(run(line, {"--b"}).err, "tool: --b requires --a (see --help)\n");
  EXPECT_EQ(run(line, {"--a", "--c"}).err, "tool: --a excludes --c (see --help)\n");
  EXPECT_EQ(run(line, {"--a", "--b"}).code, kExitOk);
}

TEST(Options, AModeSupportsOptionsOfItsGroupsAlone) {
  CommandLine line = make_line();
  bool parts = false, other_mode = false;
  int general = 0, import = 0, plain = 0, later = 0;
  line.group(OptionGroup::kGeneral).add("--general", general, "");
  line.group(OptionGroup::kImport).add("-i,--import", import, "");
  line.add("--plain", plain, "");
  const Option mode = line.add_flag("--parts", parts, "Draw parts");
  const Option other = line.add_flag("--other", other_mode, "Draw pages");
  line.mode(mode, {OptionGroup::kGeneral, OptionGroup::kImport});
  line.mode(other, {OptionGroup::kGeneral});
  line.add("--later", later, "");
  EXPECT_EQ(run(line, {"--parts", "--general", "1", "--import", "2"}).code, kExitOk);
  EXPECT_EQ(run(line, {"--plain", "1", "--later", "2", "--import", "3"}).code, kExitOk) << "without a mode";
  const Outcome refused = run(line, {"--plain", "1", "--parts"});
  EXPECT_EQ(refused.code, kExitUsage);
  EXPECT_EQ(refused.err, "tool: --plain is not available with --parts (see --help)\n");
  EXPECT_EQ(run(line, {"--parts", "--later", "1"}).err, "tool: --later is not available with --parts (see --help)\n");
  EXPECT_EQ(run(line, {"--other", "-i", "1"}).err, "tool: --import is not available with --other (see --help)\n");
  EXPECT_EQ(run(line, {"--parts", "--other"}).code, kExitUsage) << "two modes at once";
}

TEST(Options, HelpDescribesEverydayOnesAndNamesTheOthers) {
  CommandLine line = make_line();
  int number = 3, other = 0;
  bool quiet = true;
  const Option first = line.add("--number", number, "How many").shows_default().in_range(1, 9);
  line.add("--other", other, "How many others").metavar("COUNT").excludes(first).advanced();
  line.add_flag("!--loud", quiet, "Say all");
  line.add_flag("--secret", quiet).hidden();
  line.appendix("At the end.\n");
  const std::string help = run(line, {"--help"}).out, all = run(line, {"--help-all"}).out;
  for (const char* part : {"--number N (3)            How many\n", "--loud                    Say all\n",
                           "More (--help-all):\n  --other\n"})
    EXPECT_NE(help.find(part), std::string::npos) << part << help;
  for (const char* part : {"--number N (3)", "--other COUNT             How many others\n", "At the end.\n"})
    EXPECT_NE(all.find(part), std::string::npos) << part << all;
  for (const char* part : {"How many others", "At the end", "secret", "Excludes", "{false}"})
    EXPECT_EQ(help.find(part), std::string::npos) << part << help;
}

}  // namespace
}  // namespace sightline::apps::options_test
