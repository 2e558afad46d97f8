// sightline-report: one HTML page about a model. What it holds, how it is culled and drawn, how long that takes, and
// how wrong the images are.

#include <array>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <thread>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/style_options.h"
#include "sightline/apps/report/report.h"
#include "sightline/core/internal/platform/clock.h"
#include "sightline/core/internal/platform/console.h"
#include "sightline/importers/view_json.h"

namespace sightline::apps {
namespace {

#if SIGHTLINE_HAS_RAYTRACE
constexpr auto kVisibilitySection = visibility_section, kErrorSection = error_section;
#else
Section without_rays(const Report&, const SectionProgress&) {
  Section section;
  section.left_out = "this build has no ray tracing";
  return section;
}
constexpr auto kVisibilitySection = without_rays, kErrorSection = without_rays;
#endif

constexpr SectionMaker kMakers[] = {
    {"glance", "At a glance", glance_section, false},
    {"model", "What is in the model", model_section, false},
    {"plan", "The plan", plan_section, false},
    {"images", "Images", images_section},
    {"culling", "Culling", culling_section},
    {"visibility", "Cullers against exact visibility", kVisibilitySection},
    {"frames", "Frame times along the tour", frames_section},
    {"error", "Error against frame time", kErrorSection},
    {"stability", "Stability of the primitives", stability_section},
};

void add_options(CommandLine& line, ReportOptions& o) {
  o.model.import.crease_angle = kCreaseAngle;
  add_model_options(line, o.model);
  line.add("--out", o.out, "The page, HTML").required();
  line.add("--size", o.size, "Pixels of all images and timed frames, 64x36 at least")
      .shows_default()
      .accepted_by(parse_report_size);
  line.add("--frames", o.frames, "Frames of the tour that is flown").shows_default().in_range(4, 100000);
  line.add("--save-path", o.save_path, "Write the tour, for sightline-replay --path").metavar("FILE");
  std::vector<std::string> ids;
  std::string list;
  for (const SectionMaker& maker : kMakers) {
    ids.emplace_back(maker.id);
    list += (list.empty() ? "" : ", ") + ids.back();
  }
  line.add("--sections", o.sections, "These alone, and in the page's order: " + list)
      .one_of(ids)
      .separated_by(',')
      .usage_text("NAME,…");
  add_colour_option(line, o.colour_by);
  add_context_option(line, o.platform);
  add_json_option(line, o.json);
  line.add_flag("--quiet", o.model.quiet, "No progress bar, no warnings; errors alone");
}

/// The processor's name, or "unknown".
std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos)
      return line.substr(line.find(": ") + 2);
  return "unknown";
}

std::string utc_time() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  char text[32] = "";
  if (core::platform::utc_of(now, utc)) std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &utc);
  return text;
}

bool wanted(const ReportOptions& o, const SectionMaker& maker) {
  return o.sections.empty() || std::find(o.sections.begin(), o.sections.end(), maker.id) != o.sections.end();
}

struct Page {
  std::string glance, opening;
  std::vector<PageSection> sections;
  Json results = Json::object();  ///< by section
};

Section make_section(const SectionMaker& maker, const Report& report, const SectionProgress& progress) {
  if (maker.of_images && report.empty()) {
    Section section;
    section.left_out = "the scene has nothing to draw";
    return section;
  }
  try {
    return maker.make(report, progress);
  } catch (const Failure& failure) {
    fail(std::string("section ") + maker.id + ": " + failure.what());
  }
}

Page make_sections(const Report& report) {
  std::vector<const SectionMaker*> makers;
  for (const SectionMaker& maker : kMakers)
    if (wanted(report.options(), maker)) makers.push_back(&maker);
  Page page;
  std::optional<Progress> bar;
  if (!report.options().model.quiet) bar.emplace("measuring");
  for (std::size_t i = 0; i < makers.size(); ++i) {
    const SectionMaker& maker = *makers[i];
    const auto advance = [&](double share) {
      if (bar) bar->advance(std::size_t(1000.0 * (double(i) + share) / double(makers.size())));
    };
    advance(0.0);
    Section section = make_section(maker, report, advance);
    page.opening += section.opening.text();
    if (maker.make == glance_section) {
      page.glance = section.html.text();
      page.results[maker.id] = std::move(section.results);
    } else if (section.left_out.empty()) {
      page.sections.push_back({maker.id, maker.title, section.headline, section.html.text()});
      page.results[maker.id] = std::move(section.results);
    } else {
      HtmlBody body;
      body.paragraph("left out: " + section.left_out);
      page.sections.push_back({maker.id, maker.title, "left out: " + section.left_out, body.text()});
      page.results[maker.id] = {{"left_out", section.left_out}};
    }
  }
  return page;
}

/// Fails when `file` lies in no folder, before a minute's work rather than after it.
void check_folder(const std::string& file) {
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  std::error_code error;
  if (file.empty() || folder.empty() || std::filesystem::is_directory(folder, error)) return;
  fail(file + ": cannot be written: " + folder.string() + " is no folder");
}

void save_tour(const Report& report) {
  if (report.options().save_path.empty()) return;
  const auto path = need(importers::translated(report.tour(), -report.model().offset));  // readers add it again
  need(importers::write_path(report.options().save_path, path));
}

std::string command_line(int argc, char** argv) {
  std::string line = "sightline-report";
  const std::vector<std::string> arguments = core::platform::begin_program(argc, argv);
  for (std::size_t i = 1; i < arguments.size(); ++i) line += " " + core::platform::shell_word(arguments[i]);
  return line;
}

core::Expected<int> write_report(const ReportOptions& options, const std::string& command) {
  const double begin = now_ms();
  for (const std::string& file : {options.out, options.json, options.save_path}) check_folder(file);
  const Report report(options);
  save_tour(report);
  if (options.model.explain) explain(report.engine().plan());
  auto page = make_sections(report);
  for (const std::string& error : report.context().take_errors()) fail("GL: " + error);

  const std::string version = std::string("sightline ") + SIGHTLINE_VERSION, date = utc_time();
  const Json machine = {{"processor", processor()},
                        {"threads", std::thread::hardware_concurrency()},
                        {"renderer", report.context().renderer()},
                        {"gl", report.context().version()}};
  const double seconds = 1e-3 * (now_ms() - begin);
  HtmlBody made;
  made.text_table({"", ""},
                  {{"processor", machine["processor"].get<std::string>() + ", " +
                                     std::to_string(std::thread::hardware_concurrency()) + " threads"},
                   {"renderer", report.context().renderer()},
                   {"OpenGL", report.context().version()},
                   {"date", date},
                   {"version", version},
                   {"time taken, s", number(seconds)}},
                  {"Where and when these figures were measured.", command});
  page.sections.push_back({"made", "How this page was made", "", made.text()});

  std::string names;
  for (const std::string& file : options.model.files)
    names += (names.empty() ? "" : ", ") + std::filesystem::path(file).filename().string();
  const std::vector<std::string> intro = {
      "Made by " + version + " on " + date + ". Images and frames have " + options.size +
      " pixels, times are milliseconds of wall clock unless stated otherwise. Below each figure stands the command "
      "that gives it again."};
  const std::string html =
      html_page("Report: " + names, intro, page.sections, page.glance + page.opening, Collapsed::kYes);
  need(write_text(options.out, html));
  const Json results = {{"command", command},
                        {"version", version},
                        {"date", date},
                        {"machine", machine},
                        {"models", options.model.files},
                        {"size", {report.width(), report.height()}},
                        {"frames", options.frames},
                        {"seconds", seconds},
                        {"sections", page.results}};
  need(write_json(options.json, results));
  return kExitOk;
}

}  // namespace
}  // namespace sightline::apps

int main(int argc, char** argv) {
  using namespace sightline;
  apps::CommandLine line(
      "One HTML page about a model: content, culling, frame times, and the error of images against time",
      "sightline-report",
      "  sightline-report plant.rvm --out report.html\n"
      "  sightline-report a.rvm b.rvm --out report.html --size 1280x720 --frames 300 --json figures.json\n"
      "  sightline-report plant.rvm --out report.html --sections model,images --quiet");
  apps::ReportOptions options;
  apps::add_options(line, options);
  return line.run(argc, argv, [&] { return apps::write_report(options, apps::command_line(argc, argv)); });
}
