#include "sightline/apps/regress/reports.h"

#include <algorithm>
#include <set>

#include "sightline/apps/common/html_images.h"
#include "sightline/apps/common/markup.h"
#include "sightline/core/internal/platform/console.h"

namespace sightline::apps {
namespace {

namespace fs = std::filesystem;
using Json = json::Value;

std::string view_of(const Task& task) {
  return task.name.substr(task.name.find('/') + 1);
}

double seconds(const Outcome& outcome) {
  return outcome.result ? outcome.result->seconds : 0.0;
}

std::string renderers(const std::vector<Outcome>& outcomes) {
  std::set<std::string> names;
  for (const Outcome& o : outcomes)
    if (o.result && !o.result->renderer.empty()) names.insert(o.result->renderer);
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : "; ") + name;
  return text;
}

/// White where two images of the same size show different colours.
image::Image mask(const image::Image& a, const image::Image& b) {
  image::Image out{a.width, a.height, std::vector<std::uint8_t>(a.pixels.size())};
  for (std::size_t i = 0; i + 2 < a.pixels.size(); i += 3)
    if (!std::equal(&a.pixels[i], &a.pixels[i] + 3, &b.pixels[i])) std::fill_n(&out.pixels[i], 3, std::uint8_t(255));
  return out;
}

bool same_size(const core::Expected<image::Image>& a, const core::Expected<image::Image>& b) {
  return a && b && a->width == b->width && a->height == b->height;
}

/// Reference, image and difference, as far as they are there; of ids where they differ.
std::vector<LabelledImage> images_of(const Suite& suite, const ResultFolder& results, const Outcome& outcome) {
  std::vector<LabelledImage> out;
  const auto reference = image::read_png(suite.reference(*outcome.task));
  const auto image = image::read_png(results.image(*outcome.task));
  if (reference) out.push_back({outcome.status == Status::kAccepted ? "reference, accepted" : "reference", *reference});
  if (image) out.push_back({"image", *image});
  if (same_size(reference, image))
    out.push_back({"difference, four times amplified", image::difference_image(*image, *reference)});
  if (!outcome.result || outcome.result->wrong_ids == 0) return out;
  const auto ids = image::read_png(results.ids(*outcome.task));
  const auto reference_ids = image::read_png(suite.id_reference(*outcome.task));
  if (same_size(reference_ids, ids)) out.push_back({"pixels of another item", mask(*ids, *reference_ids)});
  return out;
}

/// The mark says the same as the colour, for who sees red as green.
Badge badge_of(Status status, const std::string& words) {
  switch (status) {
    case Status::kPassed:
      return {"\u2713 " + words, {0.0f, 0.45f, 0.32f}};
    case Status::kAccepted:
      return {"\u2713 " + words, {0.04f, 0.36f, 0.68f}};
    case Status::kFailed:
      return {"\u2717 " + words, {0.75f, 0.12f, 0.12f}};
    case Status::kError:
      return {"! " + words, {0.75f, 0.12f, 0.12f}};
    case Status::kMissing:
      break;
  }
  return {"? " + words, {0.35f, 0.35f, 0.35f}};
}

Badge badge_of(const Outcome& outcome) {
  return badge_of(outcome.status, std::string(name_of(outcome.status)));
}

std::vector<std::string> table_row(const Outcome& o) {
  const bool compared = o.result && o.result->error.empty() && o.result->unlike.empty();
  const auto cell = [&](const std::string& text, bool there) { return compared && there ? text : "-"; };
  const TaskResult& r = o.result ? *o.result : TaskResult();
  return {o.task->name,
          cell(std::to_string(r.difference.max), true),
          cell(number(r.difference.mean), true),
          cell(number(r.flip), true),
          cell(std::to_string(r.difference.pixels), true),
          cell(std::to_string(r.wrong_ids), o.task->limits.ids.has_value()),
          number(r.seconds, "%.2f")};
}

}  // namespace

std::vector<Outcome> outcomes(const Suite& suite, const ResultFolder& results, const std::vector<std::size_t>& tasks) {
  std::vector<Outcome> out;
  for (const std::size_t index : tasks) {
    const Task& task = suite.tasks[index];
    auto result = results.read(task);
    const Status status = judge(result, task.limits);
    std::string why = status == Status::kPassed ? "" : reason(result, task.limits);
    out.push_back({&task, std::move(result), status, std::move(why)});
  }
  return out;
}

std::size_t count(const std::vector<Outcome>& outcomes, Status status) {
  return std::size_t(
      std::count_if(outcomes.begin(), outcomes.end(), [&](const Outcome& o) { return o.status == status; }));
}

bool all_good(const std::vector<Outcome>& outcomes) {
  return count(outcomes, Status::kPassed) + count(outcomes, Status::kAccepted) == outcomes.size();
}

std::string summary(const std::vector<Outcome>& outcomes) {
  std::string text = std::to_string(outcomes.size()) + (outcomes.size() == 1 ? " image" : " images");
  const char* separator = ": ";
  for (const Status status : {Status::kPassed, Status::kAccepted, Status::kFailed, Status::kError, Status::kMissing}) {
    if (count(outcomes, status) == 0) continue;
    text += separator + std::to_string(count(outcomes, status)) + " " + std::string(name_of(status));
    separator = ", ";
  }
  return text;
}

Json to_json(const Suite& suite, const std::vector<Outcome>& outcomes) {
  Json out = {{"suite", suite.name}, {"count", outcomes.size()}, {"ok", all_good(outcomes)}, {"tasks", Json::array()}};
  for (const Status status : {Status::kPassed, Status::kAccepted, Status::kFailed, Status::kError, Status::kMissing})
    out[std::string(name_of(status))] = count(outcomes, status);
  for (const Outcome& o : outcomes) {
    Json task = {{"name", o.task->name},
                 {"status", std::string(name_of(o.status))},
                 {"reason", o.reason},
                 {"limits", limits_json(o.task->limits)},
                 {"seconds", seconds(o)}};
    if (o.result && o.result->error.empty()) {
      task["renderer"] = o.result->renderer;
      if (o.result->unlike.empty()) {
        task.update({{"max", o.result->difference.max},
                     {"mean", o.result->difference.mean},
                     {"pixels", o.result->difference.pixels},
                     {"flip", o.result->flip}});
        if (o.task->limits.ids) task["ids"] = o.result->wrong_ids;
      }
    }
    out["tasks"].push_back(std::move(task));
  }
  return out;
}

std::string junit_xml(const Suite& suite, const std::vector<Outcome>& outcomes) {
  const auto head = [](const char* element, const std::string& name, const std::vector<Outcome>& of) {
    double time = 0.0;
    for (const Outcome& o : of) time += seconds(o);
    return std::string("<") + element + " name=\"" + escaped(name) + "\" tests=\"" + std::to_string(of.size()) +
           "\" failures=\"" + std::to_string(count(of, Status::kFailed)) + "\" errors=\"" +
           std::to_string(count(of, Status::kError) + count(of, Status::kMissing)) + "\" time=\"" +
           number(time, "%.3f") + "\">\n";
  };
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" + head("testsuites", suite.name, outcomes);
  for (std::size_t model = 0; model < suite.models.size(); ++model) {
    std::vector<Outcome> of;
    std::copy_if(outcomes.begin(), outcomes.end(), std::back_inserter(of),
                 [&](const Outcome& o) { return o.task->model == model; });
    if (of.empty()) continue;
    xml += " " + head("testsuite", suite.models[model].name, of);
    for (const Outcome& o : of) {
      xml += "  <testcase classname=\"" + escaped(suite.name + "." + suite.models[model].name) + "\" name=\"" +
             escaped(view_of(*o.task)) + "\" time=\"" + number(seconds(o), "%.3f") + "\"";
      const std::string message = " message=\"" + escaped(o.reason) + "\"";
      if (o.status == Status::kPassed)
        xml += "/>\n";
      else if (o.status == Status::kAccepted)
        xml += ">\n   <system-out>" + escaped("accepted: " + o.reason) + "</system-out>\n  </testcase>\n";
      else if (o.status == Status::kFailed)
        xml += ">\n   <failure type=\"difference\"" + message + "/>\n  </testcase>\n";
      else
        xml += ">\n   <error type=\"" + std::string(name_of(o.status)) + "\"" + message + "/>\n  </testcase>\n";
    }
    xml += " </testsuite>\n";
  }
  return xml + "</testsuites>\n";
}

core::Expected<std::string> html_report(const Suite& suite, const ResultFolder& results,
                                        const std::vector<Outcome>& outcomes, ShownImages shown,
                                        const std::string& suite_file) {
  const std::string command = "sightline-regress " + core::platform::shell_word(suite_file);
  std::vector<PageSection> sections;
  std::vector<std::vector<std::string>> rows;
  std::vector<Badge> badges;
  for (const Outcome& o : outcomes) rows.push_back(table_row(o)), badges.push_back(badge_of(o));
  HtmlBody table;
  table.table({"image", "max", "mean", "FLIP", "pixels that differ", "of another item", "seconds"}, rows,
              {"All images. Differences of a channel are 0 to 255, mean FLIP 0 to 1.", command}, badges);
  const Badge verdict = all_good(outcomes) ? badge_of(Status::kPassed, "passed") : badge_of(Status::kFailed, "failed");
  sections.push_back({"all", "All images", summary(outcomes), table.text(), verdict});
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const Outcome& o = outcomes[i];
    if (shown == ShownImages::kNone || (shown == ShownImages::kFailed && o.status == Status::kPassed)) continue;
    HtmlBody body;
    if (!o.reason.empty()) body.paragraph(o.reason);
    const auto images = images_of(suite, results, o);
    const Caption caption{o.task->name + ", " + std::to_string(o.task->size[0]) + "x" +
                              std::to_string(o.task->size[1]) + ", limits " + limits_json(o.task->limits).dump(),
                          command + " --only " + o.task->name + " --images all"};
    const std::string id = "task" + std::to_string(i);
    if (!images.empty())
      if (auto done = body.flip_images(images, caption, id + "images"); !done) return tl::unexpected(done.error());
    sections.push_back({id, o.task->name, o.reason, body.text(), badge_of(o)});
  }
  std::vector<std::string> intro = {summary(outcomes) + "."};
  if (const std::string names = renderers(outcomes); !names.empty()) intro.push_back("Drawn by " + names + ".");
  return html_page("Regression: " + suite.name, intro, sections);
}

}  // namespace sightline::apps
