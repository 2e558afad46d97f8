#include "sightline/importers/view_json.h"

#include <cmath>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "sightline/tests/support/json_pointer.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers::view_json_test {
namespace {

using core::dvec3;
using core::dvec4;
using Json = json::Value;

const char* const kView = R"({"eye":[1,2,3],"target":[4,5,6],"up":[0,0,1],"fovy_deg":60,"near":0.1,"far":1000})";
const char* const kOrtho = R"({"eye":[1,2,3],"target":[4,5,6],"up":[0,0,1],"ortho_height":5,"near":0.1})";
const char* const kPath = R"({"keys":[{"t":0,"eye":[1,2,3],"target":[4,5,6],"up":[0,1,0],"fovy_deg":60},
  {"t":1.5,"eye":[2,2,3],"target":[4,5,6]}],"near":0.1,"far":50})";

std::string view_error(const std::string& text) {
  const auto view = parse_view(text, 1.5, "v.json");
  return view ? "" : view.error().message;
}
std::string path_error(const std::string& text) {
  const auto path = parse_path(text, "p.json");
  return path ? "" : path.error().message;
}

/// `text` with the value at a pointer replaced (or removed when `value` is discarded).
std::string with(const char* text, const std::string& pointer, const Json& value) {
  Json root = json::parse(text).value();
  tests::at_pointer(root, pointer) = value;
  return root.dump();
}
std::string without(const char* text, const std::string& object, const std::string& key) {
  Json root = json::parse(text).value();
  tests::at_pointer(root, object).erase(key);
  return root.dump();
}

/// A file of the running process, removed at the end.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text) { std::ofstream(file_, std::ios::binary) << text; }
  ~TemporaryFile() { std::filesystem::remove(file_); }
  const std::filesystem::path& path() const { return file_; }

 private:
  std::filesystem::path file_ =
      std::filesystem::path(::testing::TempDir()) / ("view_json_test_" + std::to_string(::getpid()) + ".json");
};

void expect_same_matrix(const core::dmat4& a, const core::dmat4& b, double tolerance) {
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) EXPECT_NEAR(a[c][r], b[c][r], tolerance) << c << "," << r;
}

TEST(ViewJson, ReadsAPerspectiveView) {
  const auto view = parse_view(kView, 1.5);
  ASSERT_TRUE(view) << view.error().message;
  const auto same = core::View::perspective({{1, 2, 3}, {4, 5, 6}, {0, 0, 1}}, std::acos(0.5), 1.5, 0.1, 1000);
  expect_same_matrix(view->clip_from_world(), same->clip_from_world(), 1e-12);
  EXPECT_EQ(view->layers, core::kDefaultLayerMask);
  EXPECT_TRUE(view->sections.empty());
}

TEST(ViewJson, FarAbsentIsInfinite) {
  const auto view = parse_view(without(kView, "", "far"), 1.5);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->clip_from_eye()[2][2], 0.0);
}

TEST(ViewJson, ReadsAnOrthographicViewWithTheDocumentedFar) {
  const auto view = parse_view(kOrtho, 2.0);
  ASSERT_TRUE(view) << view.error().message;
  const core::Pose pose{{1, 2, 3}, {4, 5, 6}, {0, 0, 1}};
  expect_same_matrix(view->clip_from_world(), core::View::orthographic(pose, 5, 2.0, 0.1, 10000.1)->clip_from_world(),
                     1e-12);
  const auto given = parse_view(with(kOrtho, "/far", 70), 2.0);
  ASSERT_TRUE(given);
  expect_same_matrix(given->clip_from_world(), core::View::orthographic(pose, 5, 2.0, 0.1, 70)->clip_from_world(),
                     1e-12);
}

TEST(ViewJson, ReadsSectionsModeAndLayers) {
  Json root = json::parse(kView).value();
  root["sections"] = {{{"n", {0, 0, 1}}, {"d", -2}}, {{"n", {1, 0, 0}}, {"d", 0.5}}};
  root["section_mode"] = "union";
  root["layers"] = 4294967295u;
  root["somebody_elses"] = {1, 2};
  const auto view = parse_view(root.dump(), 1.0);
  ASSERT_TRUE(view) << view.error().message;
  ASSERT_EQ(view->sections.size(), 2u);
  EXPECT_EQ(view->sections[1].normal, dvec3(1, 0, 0));
  EXPECT_EQ(view->sections[0].offset, -2.0);
  EXPECT_EQ(view->section_mode, core::SectionMode::kUnion);
  EXPECT_EQ(view->layers, 0xffffffffu);
  root["section_mode"] = "intersection";
  EXPECT_EQ(parse_view(root.dump(), 1.0)->section_mode, core::SectionMode::kIntersection);
}

TEST(ViewJson, UpIsZWhenAbsent) {
  const auto a = parse_view(kView, 1.5), b = parse_view(without(kView, "", "up"), 1.5);
  ASSERT_TRUE(a && b);
  expect_same_matrix(a->clip_from_world(), b->clip_from_world(), 0.0);
}

TEST(ViewJson, ErrorsNameFilePlaceAndWhatWasExpected) {
  EXPECT_EQ(view_error(without(kView, "", "eye")),
            "v.json: /eye: expected an array of three numbers, which is missing");
  EXPECT_EQ(view_error(with(kView, "/eye", {1, 2})),
            "v.json: /eye: expected an array of three numbers, found an array of 2");
  EXPECT_EQ(view_error(with(kView, "/target", "here")),
            "v.json: /target: expected an array of three numbers, found a string");
  EXPECT_EQ(view_error(with(kView, "/eye/1", "two")), "v.json: /eye/1: expected a finite number, found a string");
  EXPECT_EQ(view_error(with(kView, "/up/2", nullptr)), "v.json: /up/2: expected a finite number, found null");
  EXPECT_EQ(view_error(without(kView, "", "fovy_deg")),
            "v.json: /fovy_deg: expected a finite number, which is missing");
  EXPECT_EQ(view_error(without(kView, "", "near")), "v.json: /near: expected a finite number, which is missing");
  EXPECT_EQ(view_error(with(kView, "/far", true)), "v.json: /far: expected a finite number, found true");
  EXPECT_EQ(view_error(with(kOrtho, "/fovy_deg", 60)),
            "v.json: /fovy_deg: expected nothing beside /ortho_height, found the number 60");
  EXPECT_EQ(view_error(with(kView, "/section_mode", "both")),
            "v.json: /section_mode: expected \"intersection\" or \"union\", found a string");
  EXPECT_EQ(view_error(with(kView, "/layers", -1)),
            "v.json: /layers: expected a whole number from 0 to 4294967295, found the number -1");
  EXPECT_EQ(view_error(with(kView, "/layers", 4294967296)),
            "v.json: /layers: expected a whole number from 0 to 4294967295, found the number 4294967296");
  EXPECT_EQ(view_error(with(kView, "/sections", Json::array({{{"n", {0, 0, 1}}}}))),
            "v.json: /sections/0/d: expected a finite number, which is missing");
  EXPECT_EQ(view_error(with(kView, "/sections", Json::array({{{"n", {0, 0, 0}}, {"d", 1}}}))),
            "v.json: /sections/0/n: expected a normal other than zero, found an array of 3");
  EXPECT_EQ(view_error(with(kView, "/sections", Json::array({7}))),
            "v.json: /sections/0: expected an object, found the number 7");
  EXPECT_EQ(view_error(with(kView, "/sections", Json(std::vector(9, Json{{"n", {0, 0, 1}}, {"d", 1}})))),
            "v.json: /sections: expected an array of at most 8 planes, found an array of 9");
  EXPECT_EQ(view_error("[]"), "v.json: /: expected an object, found an array of 0");
  EXPECT_EQ(view_error("{\n \"eye\":[1,2,NaN]}").find("v.json: line 2, column 13: expected JSON: "), 0u)
      << view_error("{\n \"eye\":[1,2,NaN]}");
  EXPECT_EQ(view_error("").find("v.json: line 1, column 1: expected JSON"), 0u);
  EXPECT_NE(view_error("{\"eye\":[1,2,1e999]}").find("range"), std::string::npos);
}

TEST(ViewJson, WhatTheViewRefusesNamesTheFileToo) {
  for (const auto& text : {with(kView, "/eye", {4, 5, 6}), with(kView, "/fovy_deg", 180), with(kView, "/near", 0),
                           with(kView, "/far", 0.05), with(kOrtho, "/ortho_height", -1)})
    EXPECT_EQ(view_error(text).find("v.json: "), 0u) << text;
  const auto bad_aspect = parse_view(kView, 0.0, "v.json");
  EXPECT_FALSE(bad_aspect);
}

TEST(ViewJson, DeepNestingIsAnError) {
  for (const int depth : {65, 1000000}) {
    const std::string deep = "{\"x\":" + std::string(std::size_t(depth), '[');
    EXPECT_NE(view_error(deep).find("expected at most 64 nested"), std::string::npos);
    EXPECT_NE(view_error(deep + std::string(std::size_t(depth), ']') + "}").find("nested"), std::string::npos);
    EXPECT_NE(path_error(deep).find("nested"), std::string::npos);
  }
  const std::string allowed = std::string(63, '[') + std::string(63, ']');
  EXPECT_EQ(view_error(with(kView, "/x", json::parse(allowed).value())), "");
  EXPECT_EQ(view_error(with(kView, "/x", std::string(100, '[') + "\\\"" + std::string(100, '['))), "")
      << "brackets in strings do not count";
}

TEST(ViewJson, ReadsFiles) {
  const TemporaryFile file(kView);
  EXPECT_TRUE(read_view(file.path(), 1.5));
  EXPECT_FALSE(read_path(file.path()));
  const auto missing = read_view(file.path().string() + ".missing", 1.5);
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find(".missing: no such file"), std::string::npos);
  const auto folder = read_view(file.path().parent_path(), 1.5);
  ASSERT_FALSE(folder);
  EXPECT_NE(folder.error().message.find("found a directory"), std::string::npos);
}

TEST(ViewJson, ReadsTheReferenceViews) {
  SIGHTLINE_NEED_DATA("reference");
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(tests::data_path("reference"))) {
    if (entry.path().extension() != ".json") continue;
    const auto view = read_view(entry.path(), 1.5);
    EXPECT_TRUE(view) << view.error().message;
    ++count;
  }
  EXPECT_GE(count, 9);
}

TEST(PathJson, ReadsKeysAndInheritsUpAndFovy) {
  const auto path = parse_path(kPath);
  ASSERT_TRUE(path) << path.error().message;
  ASSERT_EQ(path->keys().size(), 2u);
  EXPECT_EQ(path->keys()[1].time, 1.5);
  EXPECT_EQ(path->keys()[1].pose.up, dvec3(0, 1, 0));
  EXPECT_EQ(path->keys()[1].fovy, path->keys()[0].fovy);
  EXPECT_EQ(path->near, 0.1);
  EXPECT_EQ(path->far, 50.0);
  EXPECT_EQ(parse_path(without(kPath, "", "far"))->far, core::kInfiniteFar);
}

TEST(PathJson, ErrorsNameFilePlaceAndWhatWasExpected) {
  EXPECT_EQ(path_error(without(kPath, "", "keys")),
            "p.json: /keys: expected an array of at least one key, which is missing");
  EXPECT_EQ(path_error(with(kPath, "/keys", Json::array())),
            "p.json: /keys: expected an array of at least one key, found an array of 0");
  EXPECT_EQ(path_error(with(kPath, "/keys/1", 5)), "p.json: /keys/1: expected an object, found the number 5");
  EXPECT_EQ(path_error(without(kPath, "/keys/1", "t")),
            "p.json: /keys/1/t: expected a finite number, which is missing");
  EXPECT_EQ(path_error(without(kPath, "/keys/0", "fovy_deg")),
            "p.json: /keys/0/fovy_deg: expected a finite number, which is missing");
  EXPECT_EQ(path_error(with(kPath, "/keys/1/eye/0", {})),
            "p.json: /keys/1/eye/0: expected a finite number, found null");
  EXPECT_EQ(path_error(with(kPath, "/near", 0)), "p.json: /near: expected a number greater than 0, found the number 0");
  EXPECT_EQ(path_error(with(kPath, "/far", 0.1)),
            "p.json: /far: expected a number greater than /near, found the number 0.1");
  EXPECT_EQ(path_error(with(kPath, "/keys/1/t", -1)),
            "p.json: /keys: camera key 1: time must not be earlier than that of the key before it");
  EXPECT_EQ(path_error(with(kPath, "/keys/1/eye", {4, 5, 6})),
            "p.json: /keys: camera key 1: eye and target must differ");
}

TEST(PathJson, RoundTrip) {
  std::vector<core::CameraKey> keys;
  for (int i = 0; i < 30; ++i) {
    const dvec3 from(std::cos(0.7 * i), std::sin(0.7 * i), 0.1 * i);
    keys.push_back(
        {1.0 / 3.0 * i, {dvec3(1e7 + 200, 50, 30) + 400.0 * from, dvec3(1e7, 1.0 / 7.0 * i, 0)}, 0.3 + 0.07 * i});
  }
  core::CameraPath tour = *core::CameraPath::create(std::move(keys));
  tour.near = 0.04;
  const TemporaryFile file("");
  ASSERT_TRUE(write_path(file.path(), tour));
  const auto back = read_path(file.path());
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_EQ(back->keys().size(), tour.keys().size());
  for (std::size_t i = 0; i < tour.keys().size(); ++i) {
    const core::CameraKey &a = tour.keys()[i], &b = back->keys()[i];
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.pose.eye, b.pose.eye);
    EXPECT_EQ(a.pose.target, b.pose.target);
    EXPECT_EQ(a.pose.up, b.pose.up);
    EXPECT_NEAR(a.fovy, b.fovy, 1e-15);
  }
  EXPECT_EQ(back->near, tour.near);
  EXPECT_EQ(back->far, tour.far);
  EXPECT_EQ(format_path(tour).find("far"), std::string::npos);
  EXPECT_FALSE(write_path(file.path().parent_path() / "no such folder" / "x.json", tour));
  EXPECT_FALSE(write_path(file.path().parent_path(), tour));
}

TEST(Translated, ViewAndModelMoveTogether) {
  const dvec3 offset(3e6, 7e6, 1e3);
  Json root = json::parse(kView).value();
  root["sections"] = {{{"n", {0, 0.6, 0.8}}, {"d", -2}}};
  root["layers"] = 5;
  const auto view = parse_view(root.dump(), 1.5);
  ASSERT_TRUE(view);
  const auto moved = translated(*view, offset);
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->layers, 5u);
  for (const dvec3& p : {dvec3(4, 5, 6), dvec3(40, 44, 70), dvec3(0, 0, 0)}) {
    const dvec4 a = view->eye_from_world() * dvec4(p, 1), b = moved->eye_from_world() * dvec4(p + offset, 1);
    EXPECT_LT(glm::length(a - b), 1e-8);
    EXPECT_NEAR(core::evaluate(view->sections[0], p), core::evaluate(moved->sections[0], p + offset), 1e-8);
  }
  const auto path = parse_path(kPath);
  const auto moved_path = translated(*path, offset);
  ASSERT_TRUE(moved_path);
  EXPECT_EQ(moved_path->keys()[1].pose.eye, path->keys()[1].pose.eye + offset);
  EXPECT_EQ(moved_path->far, path->far);
}

TEST(ViewJson, LimitsAndReach) {
  Json root = json::parse(kView).value();
  for (std::size_t i = 0; i < core::kMaxSectionPlanes; ++i) root["sections"].push_back({{"n", {0, 0, 1}}, {"d", i}});
  root["section_mode"] = "union";
  const auto view = parse_view(root.dump(), 1.0, "v.json");
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_EQ(view->sections.size(), core::kMaxSectionPlanes);
  const auto moved = translated(*view, dvec3(1, 2, 3));
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->section_mode, core::SectionMode::kUnion);
  // An orthographic view reaches ten times as far as its target is away.
  root = json::parse(kOrtho).value();
  root["eye"] = {0, 0, 0}, root["target"] = {0, 5000, 0};
  const auto ortho = parse_view(root.dump(), 1.0, "v.json");
  ASSERT_TRUE(ortho) << ortho.error().message;
  const auto depth = [&](double y) {
    const dvec4 clip = ortho->clip_from_eye() * (ortho->eye_from_world() * dvec4(0, y, 0, 1));
    return clip.z / clip.w;
  };
  const double span = std::abs(depth(50000.1) - depth(0.1));
  EXPECT_TRUE(std::abs(span - 1.0) < 1e-6 || std::abs(span - 2.0) < 1e-6) << span;
}

TEST(ViewJson, PathsKeepTheirRangeAndMoveWhole) {
  const auto path = parse_path(kPath, "p.json");
  ASSERT_TRUE(path) << path.error().message;
  const auto again = parse_path(format_path(*path), "p.json");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->near, 0.1);
  EXPECT_EQ(again->far, 50.0);
  const auto moved = translated(*path, dvec3(1, 2, 3));
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->near, 0.1);
  EXPECT_EQ(moved->far, 50.0);
  for (std::size_t i = 0; i < path->keys().size(); ++i) {
    EXPECT_EQ(moved->keys()[i].pose.eye, path->keys()[i].pose.eye + dvec3(1, 2, 3));
    EXPECT_EQ(moved->keys()[i].pose.target, path->keys()[i].pose.target + dvec3(1, 2, 3));
  }
}

}  // namespace
}  // namespace sightline::importers::view_json_test
