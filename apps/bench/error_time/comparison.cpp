#include "sightline/apps/bench/error_time/comparison.h"

#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/common/svg_canvas.h"

namespace sightline::bench {
namespace {

void add_errors(const apps::ImageErrors& errors, std::size_t pixels, Measures& measures) {
  measures["flip"].push_back(errors.flip_mean);
  measures["flip_p99"].push_back(errors.flip_p99);
  measures["psnr"].push_back(errors.psnr);
  measures["ssim"].push_back(errors.ssim);
  measures["wrong_ids"].push_back(100.0 * errors.wrong_share);
  measures["wrong_ids_but_ties"].push_back(100.0 * double(errors.wrong_ids - errors.ties) / double(pixels));
}

}  // namespace

json::Value compare(const std::vector<Way>& ways, std::span<const core::View> views, int passes,
                    const ReferenceOf& reference) {
  apps::Progress progress("measuring", views.size());
  std::vector<Measures> measures(ways.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    const apps::DrawnImage expected = reference(views[v]);
    for (std::size_t i = 0; i < ways.size(); ++i) {
      apps::need(ways[i].draw(views[v]));
      const apps::DrawnImage image = ways[i].image(views[v], measures[i]);
      add_errors(apps::need(apps::image_errors(expected, image)), image.ids.ids.size(), measures[i]);
    }
    const auto took =
        apps::need(apps::in_turns(ways.size(), passes, 0, [&](std::size_t i) { return ways[i].draw(views[v]); }));
    for (std::size_t i = 0; i < ways.size(); ++i)
      for (const auto& [name, field] : {std::pair("ms", &Took::ms), {"processor_ms", &Took::processor_ms}}) {
        std::vector<double> times;
        for (const Took& frame : took[i]) times.push_back(frame.*field);
        measures[i][name].push_back(apps::median(std::move(times)));
      }
    progress.advance(v + 1);
  }
  json::Value rows = json::Value::array();
  for (std::size_t i = 0; i < ways.size(); ++i) {
    json::Value row{{"name", ways[i].name}, {"threshold", ways[i].threshold}};
    for (const auto& [name, values] : measures[i]) row[name] = apps::to_json(apps::summarise(values));
    rows.push_back(std::move(row));
  }
  return rows;
}

apps::Panel panel_of(const std::string& title, const json::Value& rows, const ErrorPlot& plot) {
  apps::Panel panel{title, {}};
  for (const json::Value& row : rows) {
    const std::string& name = row["name"].string();
    const double threshold = row["threshold"].get<double>();
    if (panel.series.empty() || panel.series.back().label != name) panel.series.push_back({name, {}});
    panel.series.back().points.push_back({row.find_pointer("/" + plot.x)->get<double>(),
                                          row.find_pointer("/" + plot.y)->get<double>(),
                                          threshold > 0.0 ? apps::short_number(threshold, 4) : ""});
  }
  return panel;
}

core::Expected<void> write_plot(const ErrorPlot& plot, std::vector<apps::Panel> panels) {
  const bool large = panels.size() == 1;
  return apps::write_text(plot.file, apps::svg_panels({.title = plot.title,
                                                       .x_label = plot.x_label,
                                                       .y_label = plot.y_label,
                                                       .panels = std::move(panels),
                                                       .large = large}));
}

}  // namespace sightline::bench
