// sightline-trace: one image of a model by rays, exact at every sample, and what of the model it shows.

#include <algorithm>
#include <cstdio>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/colour_file.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/view_options.h"
#include "sightline/core/image_rays.h"
#include "sightline/core/internal/clock.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/raytrace/exact_visibility.h"
#include "sightline/raytrace/whitted.h"
#include "sightline/render/image/image.h"

namespace {

using namespace sightline;
using apps::need;
using Json = json::Value;

struct Options {
  apps::ModelOptions model;
  apps::ViewOptions view;
  std::string out, ids, depth, visible, json_file;
  std::vector<double> pick;
  std::vector<std::string> suns;
  bool plain = false;
  raytrace::WhittedOptions whitted;
};

core::Expected<void> check_outputs(const Options& o) {
  if (o.model.explain || !o.pick.empty()) return {};
  return apps::expect_output({&o.out, &o.ids, &o.depth, &o.visible, &o.json_file});
}

void add_options(apps::CommandLine& line, Options& o) {
  o.model.import.crease_angle = apps::kCreaseAngle;
  apps::add_model_options(line, o.model);
  apps::add_view_options(line, o.view);
  line.add("--out", o.out, "Colour image, PNG or JPEG").metavar("FILE").accepted_by(apps::parse_image_name);
  line.add("--ids", o.ids, "Item-id image, PNG: item + 1 in 24 bits, R lowest, 0 background")
      .metavar("FILE")
      .accepted_by(apps::parse_png_name);
  line.add("--depth", o.depth, "Depth image, PFM: metres along the view axis")
      .metavar("FILE")
      .accepted_by(apps::parse_pfm_name);
  line.add("--visible", o.visible, "Items that the samples show, each with how many, JSON; --adaptive or not");
  line.add("--pick", o.pick, "Tell what the image shows at X,Y, in pixels from the upper left corner")
      .separated_by(',')
      .takes(2);
  line.add("--samples", o.whitted.samples, "Per pixel, for smooth edges; ids and depth are then one sample's")
      .shows_default()
      .in_range(1, 4096);
  line.add("--adaptive", o.whitted.edge_threshold,
           "Take --samples only at edges, where the gradient of a colour, 0 to 1, exceeds this")
      .in_range(0.0, 1.0)
      .accepted_by(apps::parse_finite);
  const apps::Option shadows = line.add_flag("--shadows", o.whitted.shadows, "Lights cast shadows; needs a --sun");
  const apps::Option sun =
      line.add("--sun", o.suns, "Light from the direction X,Y,Z, far away; any number of them instead of the others")
          .accepted_by(apps::parse_direction);
  line.add_flag("--plain", o.plain, "One light, from the eye, as sightline-render has it with --plain").excludes(sun);
  shadows.needs(sun);
  line.add("--reflect", o.whitted.optics.reflectivity, "Share of the light that surfaces mirror, 0 to 1")
      .shows_default()
      .in_range(0.0, 1.0)
      .accepted_by(apps::parse_finite);
  line.add("--refract", o.whitted.optics.refractive_index, "Refractive index of transparent items")
      .shows_default()
      .in_range(0.1, 10.0)
      .accepted_by(apps::parse_finite);
  line.add("--threads", o.whitted.threads, "0: all; the image does not depend on them")
      .shows_default()
      .in_range(0, 1024);
  apps::add_json_option(line, o.json_file);
  line.check([&o] { return check_outputs(o); });
}

void write_images(const Options& o, raytrace::WhittedImage& image) {
  const int width = image.width, height = image.height;
  if (!o.out.empty()) need(apps::write_colours({width, height, std::move(image.rgb)}, o.out));
  if (!o.depth.empty())
    need(image::write_pfm({width, height, std::move(image.depths)}, core::platform::path_of(o.depth)));
  if (!o.ids.empty())
    need(image::write_png(need(image::id_colours({width, height, std::move(image.ids)})),
                          core::platform::path_of(o.ids)));
}

void write_visible(const Options& o, const raytrace::Tracer& tracer, const core::View& view, int width, int height,
                   const core::Scene& scene) {
  if (o.visible.empty()) return;
  const auto items =
      need(raytrace::ExactVisibility(tracer).compute(view, width, height, o.whitted.samples, o.whitted.threads));
  Json out = Json::array();
  for (const auto& [item, samples] : items)
    out.push_back({{"item", to_index(item)},
                   {"node", scene.path(scene.node_of(item))},
                   {"kind", std::string(core::name_of(scene.kind(item)))},
                   {"samples", samples}});
  need(apps::write_text(o.visible,
                        apps::to_text(json::sorted(
                            {{"size", {width, height}}, {"samples_per_pixel", o.whitted.samples}, {"items", out}}))));
}

Json array_of(const core::dvec3& v) {
  return {v.x, v.y, v.z};
}

/// Null where nothing is hit.
Json pick(const Options& o, const raytrace::Tracer& tracer, const core::View& view, int width, int height,
          const core::Scene& scene) {
  const auto ray = need(core::image_ray(view, width, height, o.pick[0], o.pick[1]));
  const auto hit = need(tracer.nearest(ray, raytrace::filter_of(view)));
  if (!hit) return Json();
  const raytrace::Hit& h = *hit;
  Json out = {{"item", to_index(h.item)},
              {"node", scene.path(scene.node_of(h.item))},
              {"kind", std::string(core::name_of(scene.kind(h.item)))},
              {"face", std::string(core::name_of(h.face))},
              {"point", array_of(h.point)},
              {"normal", array_of(h.normal)},
              {"distance", h.t}};
  if (h.triangle != core::kNone) out["triangle"] = h.triangle;
  return out;
}

core::Expected<int> trace_model(Options& o) {
  const auto size = need(apps::parse_size(o.view.size));
  const int width = size[0], height = size[1];
  for (const std::string& sun : o.suns) o.whitted.lights.push_back({apps::parse_direction(sun).value(), true});
  const auto model = need(apps::load_model(o.model));
  need(model.scene->commit());
  const core::Snapshot snapshot(*model.scene, o.whitted.threads);
  const auto view = need(apps::choose_view(o.view, model, snapshot, double(width) / height));
  o.whitted.studio = o.suns.empty() && !o.plain;
  if (o.whitted.studio)
    for (const gpuprims::DistantLight& light : gpuprims::distant_lights(view, gpuprims::Lighting::kStudio, {}))
      o.whitted.lights.push_back({light.towards, true, core::vec3(float(light.strength))});

  const double start = core::now_seconds();
  const auto tracer = need(raytrace::Tracer::create(snapshot, o.whitted.threads));
  const double built = core::now_seconds();
  if (o.model.explain) {
    engine::Plan plan = engine::make_plan(snapshot, engine::CullerChoice::kAutomatic, false, false);
    std::erase_if(plan.entries, [](const engine::PlanEntry& entry) { return entry.feature == "ray tracer"; });
    plan.entries.push_back({"ray tracer", true, std::to_string(tracer.memory().total()) + " bytes"});
    apps::explain(plan);
  }
  auto image = [&] {
    apps::Progress progress("tracing");
    o.whitted.progress = progress.callback();
    return need(raytrace::render_whitted(tracer, view, width, height, o.whitted));
  }();
  const double traced = core::now_seconds();
  if (std::all_of(image.ids.begin(), image.ids.end(), [](std::uint32_t id) { return id == 0; }))
    std::fprintf(stderr, "warning: the image shows nothing\n");
  Json results = {{"size", {width, height}},         {"items", snapshot.size()},
                  {"samples", image.samples},        {"build_seconds", built - start},
                  {"trace_seconds", traced - built}, {"tracer_bytes", tracer.memory().total()}};
  std::fprintf(apps::table_stream(o.json_file), "%llu samples, %.2f a pixel, in %.2f s, after %.2f s of building\n",
               (unsigned long long)image.samples, double(image.samples) / (double(width) * height), traced - built,
               built - start);
  if (!o.pick.empty()) {
    const auto picked = pick(o, tracer, view, width, height, *model.scene);
    results["pick"] = picked;
    std::fprintf(apps::table_stream(o.json_file), "at %g,%g: %s\n", o.pick[0], o.pick[1],
                 picked.is_null() ? "nothing" : picked.dump().c_str());
  }
  write_images(o, image);
  write_visible(o, tracer, view, width, height, *model.scene);
  need(apps::write_json(o.json_file, json::sorted(results)));
  return apps::kExitOk;
}

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line(
      "Traces one image of a model by rays, and the items that it shows", "sightline-trace",
      "  sightline-trace plant.rvm --out plant.png --samples 16 --adaptive 0.1\n"
      "  sightline-trace plant.rvm --out plant.png --shadows --sun 1,-2,3 --sun -3,1,2 --reflect 0.1\n"
      "  sightline-trace plant.rvm --view view.json --size 640x360 --depth a.pfm --ids ids.png\n"
      "  sightline-trace plant.rvm --view view.json --samples 4 --visible seen.json\n"
      "  sightline-trace plant.rvm --view view.json --pick 640.5,360.5");
  Options options;
  add_options(line, options);
  return line.run(argc, argv, [&] { return trace_model(options); });
}
