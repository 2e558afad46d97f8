// The table of attacks on every reader (tests/hostile/), each import in this process. Run under
// -fsanitize=address,undefined this also shows that no read leaves the buffer.
#include "sightline/tests/importers/hostile.h"

#include <ostream>

#include <gtest/gtest.h>

#include "sightline/tests/hostile/check.h"
#include "sightline/tests/support/effort.h"

namespace sightline::importers::hostile_test {
namespace {

using hostile::Attack;
using hostile::Case;
using hostile::Target;

struct Row {
  Target target;
  Attack attack;
};

std::ostream& operator<<(std::ostream& out, const Row& row) {
  return out << row.target.name() << ", " << row.attack.name;
}

class HostileFiles : public testing::TestWithParam<Row> {
 protected:
  /// Imports the case strict and lenient, with its side files on the disk where it has any. Returns how many succeeded.
  int imports(const Target& target, Case made) {
    const auto where = made.files.size() > 1 ? folder_.write(made) : folder_.models() / target.model();
    for (hostile::File& file : made.files) file.content = folder_.content(file);
    return tests::survives_both(target, made, where);
  }
  hostile::Folder folder_;
};

TEST_P(HostileFiles, AreSurvived) {
  const auto& [target, attack] = GetParam();
  const bool random = attack.cases == hostile::kAnyNumber;
  const std::size_t cases = random ? std::size_t(tests::repeated(target.mutations)) : attack.cases;
  int succeeded = 0;
  for (std::size_t k = 0; k < cases; ++k) {
    SCOPED_TRACE(testing::Message() << target.name() << ", " << attack.name << ", case " << k);
    succeeded += imports(target, attack.make(k));
    ASSERT_FALSE(HasFailure());
  }
  if (attack.name == "mutation" && !target.seal) {
    EXPECT_GT(succeeded, int(cases) / 500) << "too little is read to the end";
  }
}

/// The attacks on all targets but truncation, which has a test of its own.
std::vector<Row> rows() {
  std::vector<Row> all;
  for (const Target& target : hostile::targets())
    for (const Attack& attack : hostile::attacks_on(target))
      if (attack.name != "truncation") all.push_back({target, attack});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Table, HostileFiles, testing::ValuesIn(rows()),
                         [](const auto& one) { return one.param.target.name() + "_" + one.param.attack.name; });

class TruncatedFiles : public testing::TestWithParam<Target> {};

/// Shorter than what it needs a file is an error, longer it is as good as whole. All lengths in a long run, and of
/// large files about 2500 in a short one.
TEST_P(TruncatedFiles, AreErrorsUntilNothingIsMissing) {
  const Target& target = GetParam();
  const std::filesystem::path where = testing::TempDir() + target.model();
  for (const std::string& seed : hostile::seeds_of(target)) {
    const std::size_t size = seed.size(), step = tests::long_run() ? 1 : 1 + size / 2500;
    const Case whole = hostile::one_file(target.model(), seed);
    const bool strict = tests::survives(target, whole, false, where);
    const bool lenient = tests::survives(target, whole, true, where);
    const hostile::Needs needs = target.needs ? target.needs(seed) : hostile::Needs();
    for (std::size_t cut = 0; cut <= size; cut += step) {
      SCOPED_TRACE(testing::Message() << "a seed of " << size << " bytes without the last " << cut);
      Case made = hostile::truncated(target, seed, size - cut);
      if (needs.strict > 0 && size - cut >= needs.strict && strict) made.strict = hostile::Expect::kSuccess;
      if (needs.lenient > 0 && size - cut >= needs.lenient && lenient) made.lenient = hostile::Expect::kSuccess;
      tests::survives_both(target, made, where);
      ASSERT_FALSE(HasFailure());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Table, TruncatedFiles, testing::ValuesIn(hostile::targets()),
                         [](const auto& one) { return one.param.name(); });

}  // namespace
}  // namespace sightline::importers::hostile_test
