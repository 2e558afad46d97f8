// Cullers against exact visibility: what each draws in frames of the tour, beside the items that rays see.
#include <algorithm>
#include <array>
#include <optional>

#include "sightline/apps/common/drawn_variant.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/report/report.h"
#include "sightline/raytrace/exact_visibility.h"

namespace sightline::apps {

namespace {

using engine::CullerChoice;
using engine::OcclusionChoice;
using Ids = std::vector<core::ItemId>;

constexpr int kMostFrames = 8;

/// A culler, and the tests after it. The first is the reference for images: nothing but frustum culling, item by
/// item.
struct CullingVariant {
  const char* label;
  CullerChoice culler;
  bool sample_test;
  OcclusionChoice occlusion;
};
constexpr CullingVariant kCullingVariants[] = {
    {"linear", CullerChoice::kLinear, false, OcclusionChoice::kOff},
    {"cpu", CullerChoice::kCpu, false, OcclusionChoice::kOff},
    {"gpu", CullerChoice::kGpu, false, OcclusionChoice::kOff},
    {"cpu, sample test", CullerChoice::kCpu, true, OcclusionChoice::kOff},
    {"gpu, sample test", CullerChoice::kGpu, true, OcclusionChoice::kOff},
    {"cpu, occlusion test", CullerChoice::kCpu, true, OcclusionChoice::kOn},
    {"gpu, occlusion test", CullerChoice::kGpu, true, OcclusionChoice::kOn},
};

struct Image : DrawnImage {
  Ids visible_in_ids;  ///< items, sorted
};

/// Results of one way of culling, by frame.
struct Drawn {
  std::vector<double> items;
  std::vector<Image> images;
  std::uint64_t lost = 0, ties = 0;  ///< items of all frames
};

std::vector<Ids> exact_sets(const Report& report, const std::vector<core::View>& views) {
  const raytrace::ExactVisibility exact(*report.tracer());
  std::vector<Ids> sets;
  for (const core::View& view : views) {
    const auto items = need(exact.compute(view, report.width(), report.height()));
    sets.emplace_back();
    for (const raytrace::VisibleItem& item : items) sets.back().push_back(item.item);
  }
  return sets;
}

Drawn draw_all(const Report& report, const CullingVariant& variant, const std::vector<core::View>& views) {
  engine::EngineConfig config = report.engine_config();
  config.culling.culler = variant.culler;
  config.culling.sample_test = variant.sample_test;
  config.culling.occlusion = variant.occlusion;
  auto drawer = need(DrawnVariant::create(report.shared_scene(), config));
  Drawn drawn;
  for (const core::View& view : views) {
    need(drawer.draw(view));
    drawn.items.push_back(double(drawer.items_drawn()));
    Image image{need(drawer.image(view)), {}};
    image.visible_in_ids = visible_in_ids(image.ids);
    drawn.images.push_back(std::move(image));
  }
  return drawn;
}

/// Items of `set` that are visible in the id image of `reference` and none of `image`. A tie: wherever the item was
/// seen, another is seen at the same depth.
void count_lost(const Ids& set, const Image& reference, const Image& image, Drawn& counts) {
  const Ids &before = reference.visible_in_ids, &now = image.visible_in_ids;
  Ids seen, lost, at_another_depth;
  std::set_intersection(set.begin(), set.end(), before.begin(), before.end(), std::back_inserter(seen));
  std::set_difference(seen.begin(), seen.end(), now.begin(), now.end(), std::back_inserter(lost));
  for (std::size_t i = 0; i < reference.ids.ids.size(); ++i)
    if (reference.ids.ids[i] != 0 && reference.depth.metres[i] != image.depth.metres[i])
      at_another_depth.push_back(core::ItemId{reference.ids.ids[i] - 1});
  std::sort(at_another_depth.begin(), at_another_depth.end());
  for (const core::ItemId item : lost)
    ++(std::binary_search(at_another_depth.begin(), at_another_depth.end(), item) ? counts.lost : counts.ties);
}

std::size_t count_missing(const Ids& set, const Ids& visible_in_ids) {
  Ids missing;
  std::set_difference(set.begin(), set.end(), visible_in_ids.begin(), visible_in_ids.end(),
                      std::back_inserter(missing));
  return missing.size();
}

/// What the variant's last step keeps, in the colours and words of the section on culling.
PanelSeries series_of(const CullingVariant& variant, const std::vector<double>& items) {
  const auto line = [&](const char* label, const char* colour) {
    return line_over_frames(label, items, PanelSeries::Style::kLine, colour);
  };
  if (variant.occlusion == OcclusionChoice::kOn) return line("drawn with the occlusion test", colours::kUnoccluded);
  if (variant.sample_test) return line("may cover a sample", colours::kSampled);
  return line("in the view volume", colours::kInView);
}

double mean_of(const std::vector<double>& values) {
  return summarise(values).mean;
}

}  // namespace

Section visibility_section(const Report& report, const SectionProgress& progress) {
  Section section;
  const int frames = std::min(kMostFrames, report.options().frames);
  const auto views = report.tour_views(frames);
  const auto sets = exact_sets(report, views);
  progress(0.3);
  std::vector<double> exact;
  for (const Ids& set : sets) exact.push_back(double(set.size()));
  const PanelSeries seen = line_over_frames("seen by rays", exact, PanelSeries::Style::kHeavyLine, colours::kSeen);
  Panel on_cpu{"CPU culler", {seen}}, on_gpu{"GPU culler", {seen}};
  std::vector<std::vector<std::string>> rows{{"seen by rays", number(mean_of(exact)), "1", "", ""}};
  section.results = {{"frames", frames}, {"exact", mean_of(exact)}};
  std::optional<Drawn> reference;
  std::uint64_t unlike = 0, lost = 0;
  for (const CullingVariant& variant : kCullingVariants) {
    auto drawn = draw_all(report, variant, views);
    const std::vector<Image>& all = reference ? reference->images : drawn.images;
    std::vector<double> excess;
    for (std::size_t i = 0; i < sets.size(); ++i) {
      count_lost(sets[i], all[i], drawn.images[i], drawn);
      if (!reference) unlike += count_missing(sets[i], all[i].visible_in_ids);
      if (exact[i] > 0.0) excess.push_back(drawn.items[i] / exact[i]);
    }
    const double ratio = excess.empty() ? 0.0 : median(excess);
    rows.push_back(
        {variant.label, number(mean_of(drawn.items)), number(ratio), grouped(drawn.lost), grouped(drawn.ties)});
    section.results["variants"].push_back({{"label", variant.label},
                                           {"drawn", mean_of(drawn.items)},
                                           {"per_exact", ratio},
                                           {"lost", drawn.lost},
                                           {"ties", drawn.ties}});
    if (variant.culler == CullerChoice::kCpu) on_cpu.series.push_back(series_of(variant, drawn.items));
    if (variant.culler == CullerChoice::kGpu) on_gpu.series.push_back(series_of(variant, drawn.items));
    if (variant.occlusion == OcclusionChoice::kOn)
      section.headline += (section.headline.empty() ? "items drawn for each that rays see: " : ", ") +
                          (variant.label + (" " + number(ratio)));
    lost += drawn.lost;
    if (!reference) reference = std::move(drawn);
    progress(0.3 + 0.7 * double(&variant - kCullingVariants + 1) / double(std::size(kCullingVariants)));
  }
  section.headline += "; lost: " + grouped(lost) + ".";
  section.results["unlike_raster"] = unlike;
  const std::string command = report.section_command("visibility");
  section.html.table(
      {"culler", "items drawn, mean", "per item seen, median", "lost", "ties"}, rows,
      {"What cullers keep in " + std::to_string(frames) + " frames of the tour at " + report.options().size +
           ", beside the exact set: the items that a ray through the centre of a pixel hits first "
           "(raytrace/exact_visibility.h). Lost: seen by rays and in the image of the linear culler, but in no pixel "
           "of this one; ties: the same, where another item has its depth. Rays do not see lines, nor what is behind "
           "transparent items; both are drawn. " +
           grouped(unlike) + " times the rasteriser itself shows no pixel of an item that rays see.",
       command});
  section.html.plot(plot_over_frames("Items drawn by each culler, and seen by rays", "items",
                                     {std::move(on_cpu), std::move(on_gpu)}, true),
                    {"The same frame by frame. The linear culler draws what the CPU culler does.", command});
  return section;
}

}  // namespace sightline::apps
