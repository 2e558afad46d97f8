// The list of views and its files: JSON and BCF, of our own, of other programs, and hostile ones.
#include "sightline/apps/view/view_list.h"

#include <fstream>
#include <set>

#include <gtest/gtest.h>

#include "sightline/apps/viewpoints/bcf.h"
#include "sightline/importers/view_json.h"
#if SIGHTLINE_HAS_BCF
#include "sightline/apps/viewpoints/zip_archive.h"
#include "sightline/tests/support/effort.h"
#endif

namespace sightline::apps::view_list_test {
namespace {

Viewpoint view_of(int i, bool orthographic) {
  Viewpoint view;
  view.pose = {{10.5 + i, -20.25, 1e5}, {14.5 + i, -17.25, 1e5}, {0, 0, 1}};
  view.fovy = 0.9;
  view.orthographic = orthographic;
  view.near = 0.25;
  view.sections = {{{0, 0, 1}, -3.5}, {{-0.6, 0.8, 0}, 7.0}};
  view.shown = {{{i % 2 == 1, {{"site/pump & <x>", 0, {}, {}}, {"a?b", 2, 3, {}}}},
                 {false, {{"faint", 0, {}, {}}}},
                 {false, {{"", 0, {}, {}}}}}};
  view.name = "Näme <" + std::to_string(i) + ">";
  view.comment = "two\nlines & more";
  view.author = "someone@example.com";
  view.date = "2026-01-31T12:00:00Z";
  view.guid = new_guid();
  return view;
}

void expect_same(const Viewpoint& read, const Viewpoint& written, bool bcf) {
  const double tolerance = bcf ? 1e-9 : 0.0;
  EXPECT_NEAR(glm::length(read.pose.eye - written.pose.eye), 0.0, tolerance);
  const core::dvec3 ahead = read.pose.target - read.pose.eye, was = written.pose.target - written.pose.eye;
  EXPECT_NEAR(glm::length(glm::normalize(ahead) - glm::normalize(was)), 0.0, 1e-9);
  EXPECT_EQ(read.orthographic, written.orthographic);
  if (read.orthographic)
    EXPECT_NEAR(glm::length(ahead) * std::tan(0.5 * read.fovy), glm::length(was) * std::tan(0.5 * written.fovy), 1e-9);
  else
    EXPECT_NEAR(read.fovy, written.fovy, 1e-12);
  ASSERT_EQ(read.sections.size(), written.sections.size());
  for (std::size_t i = 0; i < read.sections.size(); ++i) {
    EXPECT_NEAR(glm::length(read.sections[i].normal - written.sections[i].normal), 0.0, 1e-12);
    EXPECT_NEAR(read.sections[i].offset, written.sections[i].offset, 1e-9);
  }
  ASSERT_TRUE(read.shown);
  EXPECT_EQ(read.shown->hidden, written.shown->hidden);
  EXPECT_EQ(read.shown->ghosts, written.shown->ghosts);
  EXPECT_EQ(read.shown->selection, written.shown->selection);
  for (const auto text :
       {&Viewpoint::name, &Viewpoint::comment, &Viewpoint::author, &Viewpoint::date, &Viewpoint::guid})
    EXPECT_EQ(read.*text, written.*text);
}

TEST(ViewListTest, JsonComesBackAndIsAViewForOtherTools) {
  const std::vector<Viewpoint> written{view_of(1, false), view_of(2, true)};
  const std::string text = format_viewpoints(written);
  const auto read = parse_viewpoints(text, "views");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) expect_same((*read)[i], written[i], false);
  const auto view = importers::parse_view(text, 1.0);
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_EQ(view->sections.size(), 2u);
  EXPECT_TRUE(parse_viewpoints(format_viewpoints({}), "views")->empty());
}

TEST(ViewListTest, OldViewFilesLeaveVisibilityAsItIs) {
  const auto read = parse_viewpoints(R"({"eye":[0,0,0],"target":[0,1,0],"fovy_deg":60,"near":1})", "old");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_FALSE((*read)[0].shown);
}

TEST(ViewListTest, BadJsonSaysWhere) {
  const std::string camera = R"("eye":[0,0,0],"target":[0,1,0],"fovy_deg":60,"near":1)";
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"{\"views\":3}", "f: /views: expected an array"},
           {"{\"views\":[{}]}", "f: /views/0: /eye: expected"},
           {"{" + camera + ",\"hidden\":3}", "f: /hidden: expected an array"},
           {"{" + camera + ",\"name\":[]}", "f: /name: expected a string"},
           {"{", "f: line 1"},
           {std::string(100000, '['), "f: line 1"}}) {
    const auto read = parse_viewpoints(text, "f");
    ASSERT_FALSE(read) << text.substr(0, 40);
    EXPECT_EQ(read.error().message.find(message), 0u) << read.error().message;
  }
}

TEST(ViewListTest, AddsFindsAndRemoves) {
  ViewList list;
  EXPECT_FALSE(list.find(""));
  for (const char* name : {"a", "", "2"}) list.add(view_of(0, false), name);
  EXPECT_EQ(list.all()[1].name, "View 2");
  EXPECT_EQ(*list.find("a"), 0u);
  EXPECT_EQ(*list.find("2"), 2u) << "names come before numbers";
  EXPECT_EQ(*list.find("3"), 2u);
  EXPECT_EQ(*list.find(""), 2u);
  for (const char* none : {"0", "4", "b", "1x", "-1"}) EXPECT_FALSE(list.find(none)) << none;
  std::set<std::string> guids;
  for (const Viewpoint& view : list.all()) guids.insert(view.guid);
  EXPECT_EQ(guids.size(), 3u);
  list.move_current(-1);
  list.move_current(-1);
  list.move_current(-1);
  EXPECT_EQ(list.current_index(), 0);
  EXPECT_EQ(list.current()->name, "2");
  list.remove(1);
  EXPECT_EQ(list.current_index(), 0);
  list.remove(0);
  EXPECT_EQ(list.current(), nullptr);
  Viewpoint changed = list.all()[0];
  changed.name = "changed";
  list.merge({changed, view_of(3, false)});
  EXPECT_EQ(list.size(), 2u) << "the same GUID is the same view";
  EXPECT_EQ(list.all()[0].name, "changed");
}

#if SIGHTLINE_HAS_BCF

TEST(ViewListTest, BcfComesBackInItsOrder) {
  std::vector<Viewpoint> written;
  for (int i = 0; i < 20; ++i) written.push_back(view_of(i, i % 3 == 0));
  written[0].snapshot = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 1, 2, 3};
  const auto bytes = format_bcf(written);
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto read = parse_bcf(*bytes, "file");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->left_out, 0u);
  ASSERT_EQ(read->views.size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) expect_same(read->views[i], written[i], true);
  EXPECT_EQ(read->views[0].snapshot, written[0].snapshot);
  const auto entries = unzip(*bytes, 1u << 30);
  EXPECT_TRUE(entries->contains("bcf.version"));
  EXPECT_TRUE(entries->contains(written[3].guid + "/markup.bcf"));
}

constexpr const char* kForeignMarkup = R"(<?xml version="1.0" encoding="utf-8"?>
<Markup xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
 <Header><File IsExternal="true"><Filename>house.ifc</Filename></File></Header>
 <Topic Guid="7DF3C0B2-1111-4222-8333-444455556666" TopicType="Clash" TopicStatus="Open">
  <Title>Duct meets beam</Title><CreationDate>2019-05-06T07:08:09+02:00</CreationDate>
  <CreationAuthor>a@b.c</CreationAuthor><Description>From the clash run</Description></Topic>
 <Comment Guid="1"><Date>2019-05-06T07:08:09Z</Date><Author>x</Author><Comment>First</Comment><Viewpoint Guid="v1"/></Comment>
 <Comment Guid="2"><Date>2019-05-06T07:08:09Z</Date><Author>y</Author><Comment>General</Comment></Comment>
 <Comment Guid="3"><Date>2019-05-06T07:08:09Z</Date><Author>y</Author><Comment>Second</Comment><Viewpoint Guid="v2"/></Comment>
 <Viewpoints Guid="v1"><Viewpoint>Viewpoint_v1.bcfv</Viewpoint><Snapshot>missing.png</Snapshot></Viewpoints>
 <Viewpoints Guid="v2"><Viewpoint>other.bcfv</Viewpoint></Viewpoints>
 <Viewpoints Guid="v3"><Viewpoint>absent.bcfv</Viewpoint></Viewpoints>
</Markup>)";
constexpr const char* kForeignPerspective = R"(<VisualizationInfo Guid="v1">
 <Components><ViewSetupHints SpacesVisible="false"/>
  <Selection><Component IfcGuid="0123456789abcdefghijkl"/></Selection>
  <Visibility DefaultVisibility="false"><Exceptions>
   <Component IfcGuid="abcdefghijkl0123456789"><OriginatingSystem>Other</OriginatingSystem></Component><Component/>
  </Exceptions></Visibility></Components>
 <PerspectiveCamera><CameraViewPoint><X>1</X><Y> 2.5 </Y><Z>+3e0</Z></CameraViewPoint>
  <CameraDirection><X>0</X><Y>2</Y><Z>0</Z></CameraDirection><CameraUpVector><X>0</X><Y>0</Y><Z>0</Z></CameraUpVector>
  <FieldOfView>60</FieldOfView></PerspectiveCamera>
 <ClippingPlanes><ClippingPlane><Location><X>0</X><Y>0</Y><Z>4</Z></Location>
  <Direction><X>0</X><Y>0</Y><Z>1</Z></Direction></ClippingPlane>
  <ClippingPlane><Location><X>nan</X></Location></ClippingPlane></ClippingPlanes>
</VisualizationInfo>)";
constexpr const char* kForeignParallel = R"(<VisualizationInfo Guid="v2"><OrthogonalCamera>
 <CameraViewPoint><X>0</X><Y>0</Y><Z>9</Z></CameraViewPoint><CameraDirection><X>0</X><Y>0</Y><Z>-1</Z></CameraDirection>
 <CameraUpVector><X>0</X><Y>1</Y><Z>0</Z></CameraUpVector><ViewToWorldScale>12</ViewToWorldScale>
</OrthogonalCamera></VisualizationInfo>)";

TEST(ViewListTest, ReadsWhatOtherProgramsWrite) {
  const auto bytes = zip({{"bcf.version", "<Version VersionId=\"2.1\"/>"},
                          {"topic\\markup.bcf", kForeignMarkup},
                          {"topic\\Viewpoint_v1.bcfv", kForeignPerspective},
                          {"topic\\other.bcfv", kForeignParallel}});
  const auto read = parse_bcf(*bytes, "file");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->views.size(), 2u);
  EXPECT_EQ(read->left_out, 1u);
  const Viewpoint &first = read->views[0], &second = read->views[1];
  EXPECT_EQ(first.name, "Duct meets beam");
  EXPECT_EQ(second.name, "Duct meets beam (2)");
  EXPECT_EQ(first.comment, "First\nGeneral");
  EXPECT_EQ(second.comment, "Second");
  EXPECT_EQ(first.guid, "7df3c0b2-1111-4222-8333-444455556666");
  EXPECT_EQ(first.pose.eye, core::dvec3(1, 2.5, 3));
  EXPECT_EQ(first.pose.target, core::dvec3(1, 3.5, 3));
  EXPECT_EQ(first.pose.up, core::dvec3(0, 0, 1)) << "where none is given";
  EXPECT_NEAR(glm::degrees(first.fovy), 60.0, 1e-12);
  ASSERT_EQ(first.sections.size(), 1u);
  EXPECT_GT(core::evaluate(first.sections[0], core::dvec3(0, 0, 3)), 0.0) << "what the direction points at is cut away";
  EXPECT_LT(core::evaluate(first.sections[0], core::dvec3(0, 0, 5)), 0.0);
  ASSERT_TRUE(first.shown);
  EXPECT_TRUE(first.shown->hidden.all_but);
  ASSERT_EQ(first.shown->hidden.parts.size(), 1u);
  EXPECT_EQ(first.shown->hidden.parts[0].guid, "abcdefghijkl0123456789");
  EXPECT_EQ(first.shown->selection.parts.at(0).guid, "0123456789abcdefghijkl");
  EXPECT_TRUE(second.orthographic);
  EXPECT_NEAR(2.0 * glm::length(second.pose.target - second.pose.eye) * std::tan(0.5 * second.fovy), 12.0, 1e-9);
}

ZipEntries foreign_entries() {
  return {{"bcf.version", "<Version VersionId=\"2.1\"/>"},
          {"extensions.xsd", "<schema/>"},
          {"topic/markup.bcf", kForeignMarkup},
          {"topic/Viewpoint_v1.bcfv", kForeignPerspective},
          {"topic/other.bcfv", kForeignParallel},
          {"topic/document.pdf", "%PDF"},
          {"no camera/markup.bcf", "<Markup><Topic Guid=\"n\"><Title>No view</Title></Topic></Markup>"}};
}

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(ViewListTest, TopicsOfOtherProgramsStayWhole) {
  const ZipEntries before = foreign_entries();
  auto read = parse_bcf(*zip(before), "file");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->views[0].status, "Open");
  EXPECT_EQ(read->views[0].type, "Clash");
  const auto untouched = unzip(*format_bcf(read->views), 1u << 30);
  ASSERT_TRUE(untouched);
  for (const auto& [path, bytes] : before) {
    ASSERT_TRUE(untouched->contains(path)) << path;
    if (path.ends_with("markup.bcf")) continue;
    EXPECT_EQ(untouched->at(path), bytes) << path;
  }
  const std::string& markup = untouched->at("topic/markup.bcf");
  for (const char* kept : {"house.ifc", "From the clash run", "<Author>y</Author>", "absent.bcfv", "missing.png"})
    EXPECT_NE(markup.find(kept), std::string::npos) << kept;
  EXPECT_EQ(markup.find("Modified"), std::string::npos);
  // Words, a state, another camera, and one view less.
  Viewpoint& view = read->views[0];
  view.status = "Closed";
  view.comment += "\nMoved the duct";
  view.pose.eye.x = 8.0;
  view.snapshot = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 7};
  read->views.pop_back();
  const auto bytes = format_bcf(read->views);
  const auto changed = unzip(*bytes, 1u << 30);
  const std::string& now = changed->at("topic/markup.bcf");
  EXPECT_NE(now.find("TopicStatus=\"Closed\""), std::string::npos) << now;
  EXPECT_NE(now.find("<Comment>Moved the duct</Comment>"), std::string::npos) << now;
  EXPECT_EQ(occurrences(now, "<Comment Guid="), 4u) << now;
  EXPECT_NE(now.find("ModifiedDate"), std::string::npos);
  EXPECT_EQ(now.find("other.bcfv"), std::string::npos);
  EXPECT_FALSE(changed->contains("topic/other.bcfv"));
  EXPECT_TRUE(changed->contains("topic/missing.png"));
  EXPECT_TRUE(changed->contains("no camera/markup.bcf"));
  EXPECT_NE(changed->at("topic/Viewpoint_v1.bcfv").find("SpacesVisible"), std::string::npos);
  const auto again = parse_bcf(*bytes, "file");
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_EQ(again->views.size(), 1u);
  EXPECT_EQ(again->views[0].pose.eye.x, 8.0);
  EXPECT_EQ(again->views[0].comment, view.comment);
  EXPECT_EQ(again->views[0].snapshot, view.snapshot);
}

Viewpoint marked_view() {
  using Kind = Markup::Kind;
  Viewpoint view = view_of(1, false);
  view.measurements = {{{1, 2, 3}, {1.1, 2.7, 3}, "edge to edge"}};
  view.markups = {{Kind::kArrow, {{12.1, -18.3, 1e5}, {12.7, -18.9, 1e5 + 0.1}}, "too near"},
                  {Kind::kCloud, {{11, -19, 1e5}, {12, -18, 1e5}, {12, -18, 1e5 + 1}, {11, -19, 1e5 + 1}}, ""},
                  {Kind::kText, {{12, -18, 1e5}}, "Näher <ansehen>"},
                  {Kind::kLine, {{0.1, 0, 0}, {1, 0, 0}, {1, 1, 0.7}}, ""}};
  return view;
}

TEST(ViewListTest, MarkUpsComeBackFromBcf) {
  for (const bool orthographic : {false, true}) {
    Viewpoint written = marked_view();
    written.orthographic = orthographic;
    const auto bytes = format_bcf(std::vector{written, view_of(2, true)});
    ASSERT_TRUE(bytes) << bytes.error().message;
    auto read = parse_bcf(*bytes, "file");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->views[0].markups, written.markups);
    EXPECT_EQ(read->views[0].measurements, written.measurements);
    EXPECT_TRUE(read->views[1].markups.empty());
    // Written again, with another camera: lines are there once.
    read->views[0].pose.eye.x += 1.0;
    const auto again = parse_bcf(*format_bcf(read->views), "file");
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(again->views[0].markups, written.markups);
    EXPECT_EQ(again->views[0].measurements, written.measurements);
    // Without marks the file that tells of them is gone, too.
    read->views[0].markups.clear();
    read->views[0].measurements.clear();
    const auto bare = unzip(*format_bcf(read->views), 1u << 30);
    EXPECT_FALSE(bare->contains(written.guid + "/viewpoint.sightline.json"));
    EXPECT_EQ(occurrences(bare->at(written.guid + "/viewpoint.bcfv"), "<Line>"), 0u);
  }
}

/// Other programs show arrows and clouds as lines; they may take some away.
TEST(ViewListTest, MarkUpsAreLinesOfBcf) {
  const Viewpoint written = marked_view();
  ZipEntries entries = *unzip(*format_bcf(std::vector{written}), 1u << 30);
  std::string& file = entries.at(written.guid + "/viewpoint.bcfv");
  EXPECT_GT(occurrences(file, "<Line>"), 1u + 3u + 24u + 2u);
  EXPECT_LT(file.find("<Lines>"), file.find("<ClippingPlanes>")) << "in the order of the schema";
  std::size_t begin = 0;
  for (int i = 0; i < 4; ++i) begin = file.find("<Line>", begin + 1);  // of the measurement, then three of the arrow
  file.erase(begin, file.find("</Line>", begin) + std::string("</Line>").size() - begin);
  const auto read = parse_bcf(*zip(entries), "file");
  ASSERT_TRUE(read) << read.error().message;
  const std::vector<Markup>& markups = read->views[0].markups;
  ASSERT_EQ(markups.size(), 5u);
  EXPECT_EQ(markups[0], written.markups[1]) << "all but the arrow";
  EXPECT_EQ(markups[3].points, written.markups[0].points) << "its shaft, and half of its head are left as lines";
  EXPECT_EQ(markups[4].points[1], written.markups[0].points[1]);
}

TEST(ViewListTest, DamagedMarksLeaveLines) {
  const Viewpoint written = marked_view();
  const ZipEntries good = *unzip(*format_bcf(std::vector{written}), 1u << 30);
  const std::string name = written.guid + "/viewpoint.sightline.json";
  ASSERT_TRUE(good.contains(name));
  for (const std::string& damaged : {std::string(), std::string("{"), good.at(name).substr(0, good.at(name).size() / 2),
                                     std::string("{\"views\":[]}"), std::string(100000, '[')}) {
    ZipEntries entries = good;
    entries[name] = damaged;
    auto read = parse_bcf(*zip(entries), "file");
    ASSERT_TRUE(read) << read.error().message;
    const std::vector<Markup>& markups = read->views[0].markups;
    EXPECT_GE(markups.size(), 4u) << "measurement, shaft, head, cloud, line";
    for (const Markup& one : markups) EXPECT_EQ(one.kind, Markup::Kind::kLine);
    // Words alone make the file anew.
    read->views[0].markups.push_back({Markup::Kind::kText, {{0, 0, 0}}, "new"});
    const auto again = parse_bcf(*format_bcf(read->views), "file");
    ASSERT_TRUE(again);
    EXPECT_EQ(again->views[0].markups, read->views[0].markups);
  }
}

TEST(ViewListTest, LinesOfOtherProgramsAreMarkUps) {
  const auto line = [](const char* from, const char* to) {
    return std::string("<Line><StartPoint><X>") + from + "</X><Y>0</Y><Z>0</Z></StartPoint><EndPoint><X>" + to +
           "</X><Y>0</Y><Z>0</Z></EndPoint></Line>";
  };
  ZipEntries before = foreign_entries();
  std::string& file = before["topic/Viewpoint_v1.bcfv"];
  file.insert(file.find("<ClippingPlanes>"),
              "<Lines>" + line("1", "2.50") + line("2.5", "4") + line("7", "8") + "<Line><StartPoint/></Line></Lines>");
  auto read = parse_bcf(*zip(before), "file");
  ASSERT_TRUE(read) << read.error().message;
  Viewpoint& view = read->views[0];
  ASSERT_EQ(view.markups.size(), 2u);
  EXPECT_EQ(view.markups[0].points, (std::vector<core::dvec3>{{1, 0, 0}, {2.5, 0, 0}, {4, 0, 0}}));
  EXPECT_EQ(view.markups[1].kind, Markup::Kind::kLine);
  EXPECT_TRUE(view.measurements.empty());
  const auto same = unzip(*format_bcf(read->views), 1u << 30);
  EXPECT_EQ(same->at("topic/Viewpoint_v1.bcfv"), file) << "untouched";
  view.markups.push_back({Markup::Kind::kArrow, {{0, 0, 0}, {1, 0, 0}}, "look"});
  const auto bytes = format_bcf(read->views);
  const auto changed = unzip(*bytes, 1u << 30);
  EXPECT_EQ(occurrences(changed->at("topic/Viewpoint_v1.bcfv"), "<Line>"), 3u + 3u);
  EXPECT_NE(changed->at("topic/Viewpoint_v1.bcfv").find("SpacesVisible"), std::string::npos);
  const auto again = parse_bcf(*bytes, "file");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->views[0].markups, view.markups);
  // A view that is taken from the list takes its file with it.
  read->views.erase(read->views.begin());
  EXPECT_FALSE(unzip(*format_bcf(read->views), 1u << 30)->contains("topic/Viewpoint_v1.sightline.json"));
  auto other = *again;
  other.views.erase(other.views.begin());
  EXPECT_FALSE(unzip(*format_bcf(other.views), 1u << 30)->contains("topic/Viewpoint_v1.sightline.json"));
}

/// With views of our own beside them, topics of BCF 3.0 become such of 2.1.
TEST(ViewListTest, TopicsOfAnotherVersionAreTranslated) {
  const std::string camera = R"(<VisualizationInfo Guid="v"><PerspectiveCamera><CameraViewPoint><X>0</X><Y>0</Y><Z>0</Z>
   </CameraViewPoint><CameraDirection><X>0</X><Y>1</Y><Z>0</Z></CameraDirection></PerspectiveCamera></VisualizationInfo>)";
  const ZipEntries newer{{"bcf.version", "<Version VersionId=\"3.0\"/>"},
                         {"t/v.bcfv", camera},
                         {"t/markup.bcf",
                          "<Markup><Topic Guid=\"t\" TopicStatus=\"Open\"><Title>Pump</Title><Labels><Label>a</Label>"
                          "<Label>b</Label></Labels><CreationDate>d</CreationDate><Comments><Comment Guid=\"c\">"
                          "<Comment>Why</Comment></Comment></Comments><Viewpoints><ViewPoint Guid=\"v\"><Viewpoint>"
                          "v.bcfv</Viewpoint></ViewPoint></Viewpoints></Topic></Markup>"}};
  auto read = parse_bcf(*zip(newer), "file");
  ASSERT_TRUE(read);
  const auto alone = unzip(*format_bcf(read->views), 1u << 30);
  EXPECT_NE(alone->at("bcf.version").find("3.0"), std::string::npos);
  EXPECT_NE(alone->at("t/markup.bcf").find("<Label>"), std::string::npos);
  read->views.push_back(view_of(1, false));
  const auto mixed = format_bcf(read->views);
  const auto entries = unzip(*mixed, 1u << 30);
  EXPECT_NE(entries->at("bcf.version").find("2.1"), std::string::npos);
  const std::string& markup = entries->at("t/markup.bcf");
  EXPECT_EQ(occurrences(markup, "<Labels>"), 2u) << markup;
  EXPECT_LT(markup.find("</Topic>"), markup.find("<Comment Guid")) << markup;
  const auto again = parse_bcf(*mixed, "file");
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_EQ(again->views.size(), 2u);
  const auto pump =
      std::find_if(again->views.begin(), again->views.end(), [](const Viewpoint& v) { return v.name == "Pump"; });
  ASSERT_NE(pump, again->views.end());
  EXPECT_EQ(pump->comment, "Why");
  // A topic whose views are all taken from the list is gone.
  read->views.erase(read->views.begin());
  EXPECT_FALSE(unzip(*format_bcf(read->views), 1u << 30)->contains("t/markup.bcf"));
}

/// Libraries for .NET write a byte order mark, list viewpoints in any order with an index, and change the case of
/// GUIDs.
TEST(ViewListTest, ViewpointsStandInTheOrderOfTheirIndices) {
  const std::string camera = R"(<PerspectiveCamera><CameraViewPoint><X>%</X><Y>0</Y><Z>0</Z></CameraViewPoint>
   <CameraDirection><X>0</X><Y>1</Y><Z>0</Z></CameraDirection><FieldOfView>45</FieldOfView></PerspectiveCamera>)";
  ZipEntries entries;
  std::string list;
  const std::pair<const char*, const char*> parts[] = {
      {"c", "<Index>7</Index>"}, {"none", ""}, {"b", "<Index>3</Index>"}, {"a", "<Index>0</Index>"}};
  for (std::size_t i = 0; i < std::size(parts); ++i) {
    const std::string name = parts[i].first;
    std::string own = camera;
    entries["t/" + name + ".bcfv"] =
        "\xef\xbb\xbf<VisualizationInfo>" + own.replace(own.find('%'), 1, std::to_string(i)) + "</VisualizationInfo>";
    list += "<Viewpoints Guid=\"" + name + "\"><Viewpoint>" + name + ".bcfv</Viewpoint>" + parts[i].second +
            "</Viewpoints>";
  }
  entries["t/markup.bcf"] =
      "\xef\xbb\xbf<Markup><Topic Guid=\"T\"><Title>Pump</Title></Topic><Comment Guid=\"1\"><Comment>Of b</Comment>"
      "<Viewpoint Guid=\"B\"/></Comment><Comment Guid=\"2\"><Comment>Of all</Comment></Comment>" +
      list + "</Markup>";
  const auto read = parse_bcf(*zip(entries), "file");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->views.size(), 4u);
  const double eyes[] = {3.0, 2.0, 0.0, 1.0};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(read->views[i].pose.eye.x, eyes[i]) << i;
  EXPECT_EQ(read->views[0].name, "Pump");
  EXPECT_EQ(read->views[0].comment, "Of all");
  EXPECT_EQ(read->views[1].comment, "Of b");
  EXPECT_EQ(read->views[2].comment, "");
}

TEST(ViewListTest, HostileArchivesAreErrors) {
  const std::string good = *format_bcf(std::vector{view_of(0, false), view_of(1, true)});
  for (std::size_t length = 0; length < good.size(); length += 1 + length / 40)
    EXPECT_FALSE(parse_bcf(good.substr(0, length), "file")) << length;
  for (const char* path :
       {"../markup.bcf", "a/../../markup.bcf", "/etc/markup.bcf", "..\\markup.bcf", "C:\\markup.bcf"}) {
    const auto read = parse_bcf(*zip({{"bcf.version", ""}, {path, kForeignMarkup}}), "file");
    ASSERT_FALSE(read) << path;
    EXPECT_NE(read.error().message.find("outside the archive"), std::string::npos) << read.error().message;
  }
  const std::string bomb =
      *zip({{"a", std::string(std::size_t(150) << 20, '\0')}, {"b", std::string(std::size_t(150) << 20, '\0')}});
  ASSERT_LT(bomb.size(), std::size_t(1) << 20);
  const auto swollen = parse_bcf(bomb, "file");
  ASSERT_FALSE(swollen);
  EXPECT_NE(swollen.error().message.find("more than it may"), std::string::npos) << swollen.error().message;
  EXPECT_FALSE(parse_bcf(*zip({{"readme.txt", "no BCF"}}), "file"));
  EXPECT_FALSE(parse_bcf(*zip({{"t/markup.bcf", "<Markup><Topic>"}}), "file"));
  std::string deep;
  for (int i = 0; i < 1'000'000; ++i) deep += "<a>";
  EXPECT_FALSE(parse_bcf(*zip({{"t/markup.bcf", deep}}), "file"));
  const std::size_t step = tests::long_run() ? 1 : 10;
  for (std::size_t at = 0; at < good.size(); at += step) {  // any answer, but no crash
    std::string bad = good;
    bad[at] = char(bad[at] ^ 0x55);
    (void)parse_bcf(bad, "file");
  }
}

TEST(ViewListTest, FilesAreChosenByTheirExtension) {
  const std::vector<Viewpoint> views{view_of(0, false)};
  for (const char* name : {"views.bcfzip", "views.BCF", "views.json"}) {
    const auto file = std::filesystem::path(testing::TempDir()) / name;
    ASSERT_TRUE(write_views(file, views)) << name;
    const auto read = read_views(file);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->views.size(), 1u);
    std::filesystem::remove(file);
  }
}

#else

TEST(ViewListTest, WithoutItsLibrariesBcfSaysSo) {
  const auto written = write_views("views.bcfzip", {});
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("libzip"), std::string::npos);
}

#endif

TEST(ViewListTest, MissingFilesAreErrors) {
  EXPECT_FALSE(read_views("/no/such/file.json"));
  EXPECT_FALSE(read_views("/no/such/file.bcf"));
  EXPECT_FALSE(read_views("/"));
}

TEST(ViewList, KnowsWhatNoFileHas) {
  ViewList views;
  EXPECT_EQ(views.unsaved(), 0u);
  views.add({}, "one");
  views.add({}, "two");
  EXPECT_EQ(views.unsaved(), 2u);
  views.mark_saved();
  EXPECT_EQ(views.unsaved(), 0u);
  views.current()->comment = "look here";
  EXPECT_EQ(views.unsaved(), 1u);
  views.current()->comment.clear();
  EXPECT_EQ(views.unsaved(), 0u) << "as it was saved";
  views.move_current(-1);
  views.remove(1);
  EXPECT_EQ(views.unsaved(), 0u) << "the order and what was deleted are in the file";
  Viewpoint read;
  read.name = "three";
  views.merge({read, read});
  EXPECT_EQ(views.unsaved(), 0u) << "they are from a file";
  views.set_current(1);
  Viewpoint seen;
  seen.pose.eye = {1, 2, 3};
  views.update_current(seen);
  EXPECT_EQ(views.unsaved(), 1u);
}

}  // namespace
}  // namespace sightline::apps::view_list_test
