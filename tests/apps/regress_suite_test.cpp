// Suites as files, results as files, the queue of tasks, and reports, without drawing.
#include <random>

#include "sightline/apps/regress/farm.h"
#include "sightline/apps/regress/reports.h"
#include "sightline/tests/apps/tool_test.h"

namespace sightline::tests::regress_suite_test {
namespace {

using namespace sightline::apps;
using Outcomes = std::vector<apps::Outcome>;

const std::string kEye = R"("eye":[-30,-12,6],"target":[5,2,3],"fovy_deg":60,"near":0.1)";

class RegressSuite : public ToolTest {
 protected:
  core::Expected<Suite> read(const std::string& text, const Limits& instead = {}) const {
    return read_suite(write("suite.json", text), instead);
  }
  static std::string model(const std::string& name, const std::string& views, const std::string& more = "") {
    return R"({"name":")" + name + R"(","files":[")" + name + R"(.rvm"],)" + more + R"("views":[)" + views + "]}";
  }
  static std::string suite(const std::string& models, const std::string& more = "") {
    return "{" + more + R"("models":[)" + models + "]}";
  }
};

TEST_F(RegressSuite, LimitsAndSizesAreInheritedOneByOne) {
  const auto made =
      read(suite(model("a", R"({"name":"plain"},{"name":"own","size":"64x32","limits":{"max":3,"mean":null}})",
                       R"("limits":{"ids":5},)") +
                     "," + model("b", R"({"name":"plain","samples":4})"),
                 R"("size":"100x50","limits":{"max":8,"mean":0.5},"references":"refs",)"));
  ASSERT_TRUE(made) << made.error().message;
  ASSERT_EQ(made->tasks.size(), 3u);
  EXPECT_EQ(made->name, "suite");
  EXPECT_EQ(limits_json(made->tasks[0].limits), json::parse(R"({"max":8.0,"mean":0.5,"ids":5})").value());
  EXPECT_EQ(limits_json(made->tasks[1].limits), json::parse(R"({"max":3.0,"ids":5})").value());
  EXPECT_EQ(limits_json(made->tasks[2].limits), json::parse(R"({"max":8.0,"mean":0.5})").value());
  EXPECT_EQ(made->tasks[1].size, (std::array<int, 2>{64, 32}));
  EXPECT_EQ(made->tasks[2].size, (std::array<int, 2>{100, 50}));
  EXPECT_EQ(made->tasks[2].samples, 4);
  EXPECT_EQ(made->reference(made->tasks[2]), fs::path(path("refs")) / "b/plain.png");
  Limits instead;
  instead.max = 1.0;
  const auto other = read(suite(model("a", R"({"name":"v"})")), instead);
  EXPECT_EQ(limits_json(other->tasks[0].limits), json::parse(R"({"max":1.0})").value());
  instead.ids = 9;
  const auto ids = read(suite(model("a", R"({"name":"v","limits":{"ids":3}},{"name":"w"})")), instead);
  EXPECT_EQ(limits_json(ids->tasks[0].limits), json::parse(R"({"max":1.0,"ids":9})").value());
  EXPECT_EQ(limits_json(ids->tasks[1].limits), json::parse(R"({"max":1.0})").value());
  EXPECT_EQ(limits_json(read(suite(model("a", R"({"name":"v"})")))->tasks[0].limits),
            json::parse(R"({"max":0.0})").value());
}

TEST_F(RegressSuite, APathIsManyTasksOrOne) {
  write("path.json", R"({"keys":[{"t":0,)" + kEye.substr(0, kEye.rfind(",")) + R"(},{"t":3,)" +
                         kEye.substr(0, kEye.rfind(",")) + R"(}],"near":0.1})");
  const auto made = read(suite(model("a", R"({"name":"all","path":"path.json","frames":3},)"
                                          R"({"name":"one","path":"path.json","frames":3,"frame":2})")));
  ASSERT_TRUE(made) << made.error().message;
  ASSERT_EQ(made->tasks.size(), 4u);
  EXPECT_EQ(made->tasks[0].name, "a/all-00000");
  EXPECT_EQ(made->tasks[2].name, "a/all-00002");
  EXPECT_EQ(made->tasks[3].name, "a/one");
  EXPECT_EQ(made->tasks[2].key, made->tasks[3].key);
  EXPECT_NE(made->tasks[1].key, made->tasks[2].key);
}

TEST_F(RegressSuite, KeysFollowWhatIsDrawnAndNotTheLimits) {
  const auto key = [&](const std::string& view, const std::string& more = "") {
    const auto made = read(suite(model("a", view, more)));
    EXPECT_TRUE(made) << made.error().message;
    return made ? made->tasks[0].key : "";
  };
  const std::string plain = key(R"({"name":"v"})");
  EXPECT_EQ(plain, key(R"({"name":"v","limits":{"max":7,"flip":0.1}})"));
  EXPECT_NE(plain, key(R"({"name":"v","limits":{"ids":7}})"));
  EXPECT_NE(plain, key(R"({"name":"v","samples":2})"));
  EXPECT_NE(plain, key(R"({"name":"v","looks":"standard"})"));
  EXPECT_EQ(plain, key(R"({"name":"v","looks":"plain"})"));
  EXPECT_NE(plain, key(R"({"name":"v","colour_by":"@kind"})"));
  EXPECT_EQ(plain, key(R"({"name":"v","colour_by":null})", R"("colour_by":"@kind",)"));
  EXPECT_NE(plain, key(R"({"name":"v","size":"64x64"})"));
  EXPECT_NE(plain, key(R"({"name":"v"})", R"("up":"y",)"));
  EXPECT_NE(plain, key(R"({"name":"v"})", R"("translate":"1,0,0",)"));
  EXPECT_NE(plain, key(R"({"name":"v","view":{)" + kEye + "}}"));
}

TEST_F(RegressSuite, BrokenSuitesAreRefusedByName) {
  const std::string view = R"({"name":"v"})";
  const std::vector<std::pair<std::string, std::string>> bad = {
      {"", "expected JSON"},
      {"no JSON", "expected JSON"},
      {"{", "line 1"},
      {"[]", "expected an object"},
      {"{}", "/models"},
      {R"({"models":[]})", "/models"},
      {R"({"models":{}})", "/models"},
      {R"({"models":[3]})", "/models/0"},
      {suite(model("a", view), R"("limit":{},)"), "/limit: unknown"},
      {suite(model("a", view), R"("limits":{"maximum":1},)"), "/limits/maximum: unknown"},
      {suite(model("a", view), R"("limits":{"max":-1},)"), "/limits/max"},
      {suite(model("a", view), R"("limits":{"max":256},)"), "/limits/max"},
      {suite(model("a", view), R"("limits":{"flip":"low"},)"), "/limits/flip"},
      {suite(model("a", view), R"("limits":{"ids":1.5},)"), "/limits/ids"},
      {suite(model("a", view), R"("limits":[],)"), "/limits"},
      {suite(model("a", view), R"("size":"0x5",)"), "/size"},
      {suite(model("a", view), R"("size":640,)"), "/size"},
      {suite(model("a", view), R"("samples":33,)"), "/samples"},
      {suite(model("a", view), R"("looks":"nice",)"), "/looks: expected plain or standard"},
      {suite(model("a", view), R"("looks":1,)"), "/looks"},
      {suite(model("a", view), R"("references":"",)"), "/references"},
      {suite(model("../a", view)), "/models/0/name"},
      {suite(model("a.b", view)), "/models/0/name"},
      {suite(model("", view)), "/models/0/name"},
      {suite(model("a", view) + "," + model("a", view)), "/models/1/name"},
      {suite(model("a", view + "," + view)), "two views"},
      {suite(model("a", "")), "/models/0/views"},
      {suite(R"({"name":"a","views":[{"name":"v"}]})"), "/models/0/files"},
      {suite(R"({"name":"a","files":"a.rvm","views":[{"name":"v"}]})"), "/models/0/files"},
      {suite(model("a", view, R"("units":"mile",)")), "/models/0/units"},
      {suite(model("a", view, R"("up":"x",)")), "/models/0/up"},
      {suite(model("a", view, R"("translate":"1,2",)")), "/models/0/translate"},
      {suite(model("a", view, R"("lenient":1,)")), "/models/0/lenient"},
      {suite(model("a", R"({})")), "/models/0/views/0: expected a \"name\""},
      {suite(model("a", R"({"name":"v","view":"missing.json"})")), "missing.json"},
      {suite(model("a", R"({"name":"v","view":{"eye":[0,0,0]}})")), "/models/0/views/0/view"},
      {suite(model("a", R"({"name":"v","view":7})")), "/models/0/views/0/view"},
      {suite(model("a", R"({"name":"v","path":"missing.json","frames":2})")), "missing.json"},
      {suite(model("a", R"({"name":"v","path":"p.json","view":"v.json"})")), "a view and a path"},
      {suite(model("a", R"({"name":"v","frames":2})")), "/models/0/views/0/frames"},
      {suite(model("a", R"({"name":"v","size":"8x8","limits":{"flip":0.1}})")), "11 pixels"},
      {std::string(1 << 16, '['), "nested"},
  };
  for (const auto& [text, named] : bad) {
    SCOPED_TRACE(text.substr(0, 200));
    const auto made = read(text);
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().message.find("suite.json"), std::string::npos) << made.error().message;
    EXPECT_NE(made.error().message.find(named), std::string::npos) << made.error().message;
    EXPECT_EQ(made.error().message.find('\n'), std::string::npos);
    EXPECT_EQ(made.error().message.find(": : "), std::string::npos) << made.error().message;
  }
  EXPECT_FALSE(read_suite(path("missing.json"), {}));
  EXPECT_FALSE(read_suite(path(""), {}));
}

TEST(RegressNames, PatternsFitAsInAShell) {
  EXPECT_TRUE(fits("plant/near", "plant/near"));
  EXPECT_TRUE(fits("plant/near", "*"));
  EXPECT_TRUE(fits("plant/near", "plant/*"));
  EXPECT_TRUE(fits("plant/near", "*/near"));
  EXPECT_TRUE(fits("plant/near", "*n*a?"));
  EXPECT_TRUE(fits("", "**"));
  EXPECT_FALSE(fits("plant/near", "plant"));
  EXPECT_FALSE(fits("plant/near", "?"));
  EXPECT_FALSE(fits("plant/near", "*x*"));
  EXPECT_FALSE(fits("", "?"));
  EXPECT_FALSE(fits("a", ""));
}

TaskResult result(const Task& task, int max) {
  TaskResult r;
  r.key = task.key;
  r.files_key = "files";
  r.difference = {max, max / 10.0, std::uint64_t(max)};
  r.flip = max / 300.0;
  r.wrong_ids = std::uint64_t(2 * max);
  r.renderer = "paint";
  r.seconds = 0.25;
  return r;
}

TEST_F(RegressSuite, AVerdictFollowsFromEachLimit) {
  const auto made = read(suite(model("a", R"({"name":"v"})")));
  ASSERT_TRUE(made);
  const TaskResult r = result(made->tasks[0], 30);
  const auto status = [&](const Limits& limits) { return judge(r, limits); };
  EXPECT_EQ(status({30.0, {}, {}, {}}), Status::kPassed);
  EXPECT_EQ(status({29.0, {}, {}, {}}), Status::kFailed);
  EXPECT_EQ(status({{}, 3.0, {}, {}}), Status::kPassed);
  EXPECT_EQ(status({{}, 2.9, {}, {}}), Status::kFailed);
  EXPECT_EQ(status({{}, {}, 0.1, {}}), Status::kPassed);
  EXPECT_EQ(status({{}, {}, 0.09, {}}), Status::kFailed);
  EXPECT_EQ(status({{}, {}, {}, 60}), Status::kPassed);
  EXPECT_EQ(status({{}, {}, {}, 59}), Status::kFailed);
  EXPECT_EQ(status({255.0, 255.0, 1.0, 59}), Status::kFailed);
  EXPECT_EQ(judge(std::nullopt, {}), Status::kMissing);
  TaskResult broken = r;
  broken.error = "no model";
  EXPECT_EQ(judge(broken, {255.0, {}, {}, {}}), Status::kError);
  broken.error = "";
  broken.unlike = "no reference";
  EXPECT_EQ(judge(broken, {255.0, {}, {}, {}}), Status::kFailed);
  EXPECT_EQ(reason(r, {29.0, 2.5, {}, {}}), "max 30 above 29, mean 3 above 2.5");
}

TEST_F(RegressSuite, ResultsComeBackAsTheyWereWritten) {
  const auto made = read(suite(model("a", R"({"name":"v"},{"name":"w"})")));
  ASSERT_TRUE(made);
  const Task& task = made->tasks[0];
  const ResultFolder folder(path("out")), other(path("other"));
  EXPECT_FALSE(folder.read(task));
  ASSERT_TRUE(folder.write(task, result(task, 12)));
  const auto back = folder.read(task);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->difference.max, 12);
  EXPECT_EQ(back->difference.mean, 1.2);
  EXPECT_EQ(back->wrong_ids, 24u);
  EXPECT_EQ(back->renderer, "paint");
  Task changed = task;
  changed.key = "another";
  EXPECT_FALSE(folder.read(changed));

  write("out/a/v/image.png", "an image");
  EXPECT_TRUE(other.take(task, folder).value());
  EXPECT_EQ(read_bytes(other.image(task)), "an image");
  EXPECT_EQ(other.read(task)->difference.max, 12);
  EXPECT_FALSE(other.take(made->tasks[1], folder).value());
  EXPECT_TRUE(folder.take(task, ResultFolder(path("out/../out"))).value());  // itself
  EXPECT_TRUE(folder.read(task));

  for (const char* text : {"", "{", "[]", "{}", R"({"key":7})", "null"}) {
    write("out/a/v/result.json", text);
    EXPECT_FALSE(folder.read(task)) << text;
  }
  ASSERT_TRUE(folder.remove(task));
  ASSERT_TRUE(folder.remove(task));
}

/// Workers that take tasks in random order and die at random, until all is done.
TEST_F(RegressSuite, AQueueLosesNoTask) {
  const auto made = read(suite(model("a", R"({"name":"1"},{"name":"2"},{"name":"3"})") + "," +
                               model("b", R"({"name":"1"},{"name":"2"})") + "," + model("c", R"({"name":"1"})")));
  ASSERT_TRUE(made);
  for (unsigned seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::vector<std::size_t> asked;
    for (std::size_t i = 0; i < made->tasks.size(); ++i)
      if (random() % 4 > 0) asked.push_back(i);
    TaskQueue queue(*made, asked);
    EXPECT_EQ(queue.count(), asked.size());
    std::vector<std::size_t> held, done;
    std::vector<int> deaths(made->tasks.size());
    while (!queue.complete()) {
      const auto task = queue.take(random() % 3);
      if (task) {
        EXPECT_NE(std::find(asked.begin(), asked.end(), *task), asked.end());
        EXPECT_EQ(std::find(held.begin(), held.end(), *task), held.end());
        EXPECT_EQ(std::find(done.begin(), done.end(), *task), done.end());
        held.push_back(*task);
      }
      if (held.empty()) continue;
      if (task && random() % 2) continue;
      const std::size_t at = random() % held.size(), ended = held[at];
      held.erase(held.begin() + std::ptrdiff_t(at));
      if (random() % 3 == 0) {
        const bool again = queue.lost(ended);
        EXPECT_EQ(again, ++deaths[ended] < 2);
        if (!again) done.push_back(ended);
      } else {
        queue.done(ended);
        done.push_back(ended);
      }
    }
    EXPECT_TRUE(held.empty());
    EXPECT_EQ(done.size(), asked.size());
    EXPECT_FALSE(queue.take(std::nullopt));
  }
}

TEST_F(RegressSuite, AWorkerKeepsItsModel) {
  const auto made = read(suite(model("a", R"({"name":"1"})") + "," + model("b", R"({"name":"1"},{"name":"2"})")));
  ASSERT_TRUE(made);
  TaskQueue queue(*made, {0, 1, 2});
  EXPECT_EQ(queue.take(std::nullopt), 1u);  // of the model with most tasks
  EXPECT_EQ(queue.take(std::size_t(0)), 0u);
  EXPECT_EQ(queue.take(std::size_t(0)), 2u);
}

/// What tools that read JUnit need, parsed without an XML library: every element closes, attributes are quoted.
struct Xml {
  std::vector<std::string> elements;  ///< names, in the order in which they begin
  bool sound = true;

  explicit Xml(const std::string& text) {
    std::vector<std::string> open;
    for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
      std::size_t end = at;
      bool quoted = false;
      for (; end < text.size() && (quoted || text[end] != '>'); ++end) {
        if (text[end] == '"') quoted = !quoted;
        sound &= end == at || text[end] != '<';
      }
      const std::string tag = text.substr(at + 1, end - at - 1);
      if (tag[0] == '?') continue;
      const std::string name = tag.substr(tag[0] == '/', tag.find_first_of(" /", 1) - (tag[0] == '/'));
      if (tag[0] == '/') {
        sound &= !open.empty() && open.back() == name;
        if (!open.empty()) open.pop_back();
        continue;
      }
      elements.push_back(name);
      if (tag.back() != '/') open.push_back(name);
    }
    sound &= open.empty();
  }
  std::ptrdiff_t count(const std::string& name) const { return std::count(elements.begin(), elements.end(), name); }
};

TEST_F(RegressSuite, JUnitTellsAllThatHappened) {
  const auto made = read(suite(model("a", R"({"name":"good"},{"name":"bad"},{"name":"none"})") + "," +
                               model("b", R"({"name":"broken"},{"name":"new"})")));
  ASSERT_TRUE(made);
  const ResultFolder folder(path("out"));
  ASSERT_TRUE(folder.write(made->tasks[0], result(made->tasks[0], 0)));
  ASSERT_TRUE(folder.write(made->tasks[1], result(made->tasks[1], 9)));
  TaskResult broken = result(made->tasks[3], 0);
  broken.error = "crash of <a> & \"b\" \x01\xff";
  ASSERT_TRUE(folder.write(made->tasks[3], broken));
  ASSERT_TRUE(folder.write(made->tasks[4], result(made->tasks[4], 9)));
  Outcomes all = outcomes(*made, folder, {0, 1, 2, 3, 4});
  all[4].status = Status::kAccepted;
  const std::string text = junit_xml(*made, all);
  const Xml xml(text);
  EXPECT_TRUE(xml.sound) << text;
  EXPECT_EQ(xml.count("testsuites"), 1);
  EXPECT_EQ(xml.count("testsuite"), 2);
  EXPECT_EQ(xml.count("testcase"), 5);
  EXPECT_EQ(xml.count("failure"), 1);
  EXPECT_EQ(xml.count("error"), 2);
  EXPECT_EQ(xml.count("system-out"), 1);
  EXPECT_NE(text.find(R"(<testsuites name="suite" tests="5" failures="1" errors="2" time="1.000">)"), std::string::npos)
      << text;
  EXPECT_NE(text.find(R"(classname="suite.a" name="bad")"), std::string::npos) << text;
  EXPECT_NE(text.find("&lt;a&gt; &amp; &quot;b&quot;"), std::string::npos) << text;
  EXPECT_EQ(summary(all), "5 images: 1 passed, 1 accepted, 1 failed, 1 error, 1 missing");
  EXPECT_FALSE(all_good(all));
  const Json json = to_json(*made, all);
  EXPECT_EQ(json["failed"], 1);
  EXPECT_EQ(json["tasks"].size(), 5u);
  EXPECT_EQ(json["tasks"][1]["reason"], "max 9 above 0");
}

}  // namespace
}  // namespace sightline::tests::regress_suite_test
