// What is in the model, what the engine made of it, and how it looks.
#include <set>

#include "sightline/apps/common/report_json.h"
#include "sightline/apps/report/report.h"
#if SIGHTLINE_HAS_RAYTRACE
#include "sightline/apps/report/tour.h"
#endif

namespace sightline::apps {
namespace {

std::string place_words(const core::dvec3& p) {
  char text[96];
  std::snprintf(text, sizeof text, "%.3f, %.3f, %.3f", p.x, p.y, p.z);
  return text;
}

struct Content {
  std::uint64_t items = 0, mesh_items = 0, meshes = 0, mesh_triangles = 0, drawn_triangles = 0;
  std::uint64_t materials = 0, transparent = 0, hidden = 0;
  core::AabbD bounds;
};

Content content_of(const core::Scene& scene) {
  Content content;
  std::set<std::uint32_t> meshes;
  scene.for_each_node(
      scene.root(), [&](core::NodeId node, const core::Affine&, bool visible, std::uint32_t, core::MaterialId) {
        for (core::ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item)) {
          ++content.items;
          content.hidden += !visible || !scene.item_visible(item);
          if (int(scene.kind(item)) < core::kPrimitiveKindCount) continue;
          const core::MeshId mesh = scene.mesh_of(item);
          const std::size_t triangles = scene.mesh(mesh).indices.size() / 3;
          ++content.mesh_items;
          content.drawn_triangles += triangles;
          if (meshes.insert(mesh.index).second) ++content.meshes, content.mesh_triangles += triangles;
        }
      });
  for (std::size_t i = 0; i < scene.material_slots(); ++i) {
    const core::MaterialId material = scene.material_at(i);
    if (!material.valid()) continue;
    ++content.materials;
    content.transparent += scene.material(material).alpha < 1.0f;
  }
  content.bounds = scene.bounds(scene.root(), ~std::uint32_t{0});
  return content;
}

void add_items(const Report& report, const Content& content, Section& section) {
  const importers::ImportReport& imported = report.model().report;
  Rows rows;
  for (int k = 0; k < core::kKindCount; ++k) {
    const std::uint64_t count = imported.items[std::size_t(k)];
    if (count == 0) continue;
    const std::string name = kind_words(core::Kind(k));
    rows.push_back({name, grouped(count), percent(double(count) / double(std::max<std::uint64_t>(1, content.items)))});
  }
  rows.push_back({"all", grouped(content.items), ""});
  section.html.table(
      {"kind", "items", "share"}, rows,
      {"Items by kind; " + grouped(imported.degenerate) + " of them have no volume.", report.command("info", "")});
  section.results["items"] = items_json(imported.items);
  section.results["degenerate"] = imported.degenerate;
}

void add_content(const Report& report, const Content& content, Section& section) {
  const importers::ImportReport& imported = report.model().report;
  Rows rows = {{"nodes", grouped(report.scene().node_count())},
               {"mesh items", grouped(content.mesh_items)},
               {"meshes", grouped(content.meshes)},
               {"triangles of all meshes", grouped(content.mesh_triangles)},
               {"triangles of all mesh items", grouped(content.drawn_triangles)},
               {"materials (transparent)", grouped(content.materials) + " (" + grouped(content.transparent) + ")"},
               {"hidden items", grouped(content.hidden)},
               {"bytes read", bytes_words(imported.bytes)},
               {"length of the files' unit, m", number(imported.metres_per_unit)}};
  if (!content.bounds.empty()) {
    rows.push_back({"least corner, m", place_words(content.bounds.min)});
    rows.push_back({"greatest corner, m", place_words(content.bounds.max)});
    rows.push_back({"size, m", place_words(content.bounds.max - content.bounds.min)});
    rows.push_back({"items too far out for views of the whole", grouped(report.fitted().outliers)});
  }
  section.html.table({"", ""}, rows, {"Content of the scene.", report.command("info", "")});
  if (imported.surfaces.parts > 0) {
    section.html.paragraph("Exact surfaces: " + surface_words(imported.surfaces) + ".");
    section.results["surfaces"] = surfaces_json(imported.surfaces);
  }
  section.results["nodes"] = report.scene().node_count();
  section.results["meshes"] = content.meshes;
  section.results["mesh_items"] = content.mesh_items;
  section.results["triangles"] = {{"meshes", content.mesh_triangles}, {"items", content.drawn_triangles}};
  section.results["materials"] = content.materials;
  section.results["bytes"] = imported.bytes;
}

void add_times(const Report& report, Section& section) {
  const LoadTimes& t = report.times();
  section.html.table({"phase", "ms"},
                     {{"read files into the scene", number(t.read)},
                      {"check and publish the scene (commit)", number(t.commit)},
                      {"make the GL context", number(t.context)},
                      {"make the engine: snapshot, hierarchy, GPU memory, programs", number(t.engine)},
                      {"- of that, snapshot (measured apart)", number(t.snapshot)},
                      {"- of that, hierarchy (measured apart)", number(t.hierarchy)},
                      {"draw the first frame", number(t.first_frame)},
                      {"first image, all together", number(t.first_image())}},
                     {"Time from the files to the first image, " + report.options().size + " pixels, one run.",
                      "time " + report.command("render", report.size_option() + " --out first.png")});
  section.results["load_ms"] = {
      {"read", t.read},       {"commit", t.commit}, {"snapshot", t.snapshot},       {"hierarchy", t.hierarchy},
      {"context", t.context}, {"engine", t.engine}, {"first_frame", t.first_frame}, {"first_image", t.first_image()}};
}

void add_memory(const Report& report, Section& section) {
  const engine::MemoryReport m = report.engine().memory();
  const auto per_item = [&](std::size_t bytes) {
    return number(double(bytes) / double(std::max<std::size_t>(1, report.scene().item_count())));
  };
  Rows rows;
  for (const auto& [name, bytes] : {std::pair("scene", m.scene),
                                    {"snapshot", m.snapshot},
                                    {"hierarchy", m.bvh},
                                    {"GPU, images with ids included", m.gpu}})
    rows.push_back({name, bytes_words(bytes), per_item(bytes)});
  section.html.table({"part", "memory", "bytes an item"}, rows,
                     {"Memory of the engine.", report.command("replay", "--frames 2 " + report.size_option())});
  section.results["memory_bytes"] = {
      {"scene", m.scene}, {"snapshot", m.snapshot}, {"hierarchy", m.bvh}, {"gpu", m.gpu}, {"levels", m.levels}};
}

void add_warnings(const Report& report, Section& section) {
  constexpr std::size_t kShown = 20;
  const auto& warnings = report.model().report.warnings;
  section.results["warnings"] = warnings_json(warnings);
  if (warnings.empty()) {
    section.html.paragraph("The import has no warnings.");
    return;
  }
  Rows rows;
  for (std::size_t i = 0; i < std::min(kShown, warnings.size()); ++i)
    rows.push_back({warnings[i].file, grouped(warnings[i].offset), warnings[i].message});
  section.html.text_table(
      {"file", "byte", "warning"}, rows,
      {"Warnings of the import, " + std::to_string(rows.size()) + " of " + grouped(warnings.size()) + ".",
       report.command("info", "--json -")});
}

/// How much of the tour's images shows the model.
void add_tour(const Report& report, Section& section) {
#if SIGHTLINE_HAS_RAYTRACE
  const auto views = report.tour_views(report.options().frames);
  double least = 1.0, sum = 0.0;
  for (const core::View& view : views) {
    const auto share = need(covered_share(*report.tracer(), view, report.aspect()));
    least = std::min(least, share);
    sum += share;
  }
  const double mean = sum / double(views.size());
  section.html.paragraph("The model covers " + percent(mean) + " of the image in the mean of " +
                         std::to_string(views.size()) + " frames of the tour, and " + percent(least) +
                         " where it covers least.");
  section.results["tour"] = {{"covered", {{"least", least}, {"mean", mean}}}};
#else
  (void)report, (void)section;
#endif
}

/// A colour for each item, away from white, which is the background.
image::Image item_colours(const image::IdImage& ids) {
  image::Image out{ids.width, ids.height, std::vector<std::uint8_t>(3 * ids.ids.size(), 255)};
  for (std::size_t i = 0; i < ids.ids.size(); ++i) {
    std::uint32_t hash = ids.ids[i];
    if (hash == 0) continue;
    hash = (hash ^ hash >> 16) * 0x7feb352du;
    hash = (hash ^ hash >> 15) * 0x846ca68bu;
    hash ^= hash >> 16;
    for (unsigned c = 0; c < 3; ++c) out.pixels[3 * i + c] = std::uint8_t(30 + (hash >> (8 * c) & 255u) * 190 / 255);
  }
  return out;
}

}  // namespace

Section model_section(const Report& report, const SectionProgress&) {
  Section section;
  const Content content = content_of(report.scene());
  std::vector<std::string> files;
  for (const std::string& file : report.options().model.files) files.push_back(file);
  section.html.list(files);
  add_items(report, content, section);
  add_content(report, content, section);
  add_times(report, section);
  add_memory(report, section);
  add_warnings(report, section);
  section.headline = grouped(content.items) + " items, " + grouped(content.drawn_triangles) +
                     " triangles in meshes; first image after " + number(report.times().first_image()) + " ms.";
  return section;
}

Section plan_section(const Report& report, const SectionProgress&) {
  Section section;
  const engine::Plan& plan = report.engine().plan();
  Rows rows;
  std::size_t used = 0;
  for (const engine::PlanEntry& entry : plan.entries) {
    used += entry.used;
    rows.push_back({entry.feature, entry.used ? "used" : "left out", entry.why});
    section.results["entries"].push_back({{"feature", entry.feature}, {"used", entry.used}, {"why", entry.why}});
  }
  section.results["culler"] = name_of(plan.culler);
  section.html.text_table({"feature", "", "why"}, rows,
                          {"What the engine uses for this model, and what it leaves out. What is left out costs no "
                           "memory, no shader and no time.",
                           report.command("render", "--explain --ids items.png " + report.size_option())});
  section.headline = "culler " + std::string(name_of(plan.culler)) + "; " + std::to_string(used) + " of " +
                     std::to_string(rows.size()) + " features used.";
  return section;
}

Section images_section(const Report& report, const SectionProgress& progress) {
  Section section;
  section.html.paragraph(
      "Images at the left show the model as it is drawn, those at the right each item in a colour of its own, in place "
      "of the numbers that --ids writes. The "
      "tour is a camera path made for the model, which keeps it in sight; this command writes it:");
  section.html.commands(
      report.command("report", std::string("--sections plan --out report.html --save-path ") + kTourFile));
  add_tour(report, section);
  for (const ReportView& place : report.views()) {
    need(report.engine().frame(place.view));
    auto colour = need(report.engine().read_colour());
    const auto ids = need(report.engine().read_ids());
    const std::size_t seen = visible_in_ids(ids).size();
    const std::array images{LabelledImage{place.name, std::move(colour)},
                            LabelledImage{"items, " + place.name, item_colours(ids)}};
    need(section.html.images(images,
                             {grouped(seen) + (seen == 1 ? " item is" : " items are") + " visible in the id image.",
                              report.command("render", place.options + " --plain " + report.size_option() +
                                                           " --out image.png --ids items.png")}));
    section.results["views"].push_back({{"name", place.name}, {"visible_in_ids", seen}});
    progress(double(section.results["views"].size()) / double(report.views().size()));
  }
  section.headline = "overview and " + std::to_string(report.views().size() - 1) + " places of the tour.";
  return section;
}

}  // namespace sightline::apps
