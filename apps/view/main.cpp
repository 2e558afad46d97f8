// sightline-view: a window to look at models in, to find and hide their parts, and to see what the culler does.

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/colour_file.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/view/commands.h"
#include "sightline/apps/view/viewer.h"

namespace {

using namespace sightline;

constexpr double kDefaultBudget = 33.0;  // milliseconds

void add_options(apps::CommandLine& line, apps::ViewerOptions& o) {
  o.model.import.crease_angle = apps::kCreaseAngle;
  apps::add_model_options(line, o.model);
  line.option("MODEL").required(false);
  line.add("--size", o.size, "Of the window, in the screen's units").shows_default().accepted_by(apps::parse_size);
  apps::add_culler_option(line, o.culler);
  apps::add_gpu_variant_option(line, o.gpu_variant);
  apps::add_drawn_options(line, o.shown);
  apps::add_plain_option(line, o.shown);
  apps::add_samples_option(line, o.samples);
  line.add("--path", o.path,
           "Play this camera path first; with --frames as so many evenly spaced frames, else in its own time")
      .metavar("FILE")
      .advanced();
  line.add("--save-path", o.save_path, "Where R writes what it has recorded")
      .metavar("FILE")
      .shows_default()
      .advanced();
  line.add("--frames", o.frames, "Quit after so many frames, drawn as fast as they come, without panels")
      .positive()
      .advanced();
  line.add("--script", o.script, "Carry out the commands of this file, then quit; fails where it expects otherwise")
      .metavar("FILE")
      .existing_file();
  line.add("--screenshot", o.screenshot, "Write the last image, PNG or JPEG")
      .metavar("FILE")
      .accepted_by(apps::parse_image_name);
  line.add("--json", o.json_file, "Write state and measurements as JSON to FILE, or - for stdout, at the end")
      .metavar("FILE")
      .advanced();
  line.add_flag("!--no-smooth", o.smooth, "Leave edges as they are when nothing moves; scripts begin so").advanced();
  line.add_flag("!--no-panels", o.panels, "Show the model alone");
  line.add("--theme", o.theme, "dark or light").one_of({"dark", "light"}).shows_default();
  line.add("--scale", o.scale, "Of text and panels; as the screen suggests unless it is given").in_range(0.5, 5.0);
  line.add("--settings", o.settings,
           "Keep settings in this file instead of the user's own, which --script and --frames leave alone")
      .metavar("FILE")
      .advanced();
}

apps::SettingsFile settings_file(const apps::ViewerOptions& o) {
  if (!o.remembers()) return {};
  return apps::SettingsFile(o.settings.empty() ? apps::SettingsFile::default_place()
                                               : std::filesystem::path(o.settings));
}

/// What the command line does not say is as it was the last time.
void apply(const apps::Settings& settings, const apps::CommandLine& line, apps::ViewerOptions& o) {
  const auto unsaid = [&](const char* option) { return !line.option(option).given(); };
  if (unsaid("--theme")) o.theme = settings.light ? "light" : "dark";
  if (unsaid("--no-smooth")) o.smooth = settings.smooth;
  if (unsaid("--no-panels")) o.panels = settings.panels;
  if (unsaid("--cache")) o.model.import.cache_folder = settings.cache;
  if (unsaid("--recognise")) o.model.import.recognise = settings.recognise;
  if (o.remembers()) o.shown.looks = engine::Looks::standard();
  if (unsaid("--budget-ms") && o.remembers()) o.default_budget_ms = kDefaultBudget;
  if (unsaid("--size")) o.size = std::to_string(settings.window[0]) + "x" + std::to_string(settings.window[1]);
}

core::Expected<int> view(const apps::CommandLine& line, apps::ViewerOptions o) {
  apps::SettingsFile settings = settings_file(o);
  apply(settings.settings(), line, o);
  const auto size = apps::parse_size(o.size);
  if (!size) return tl::unexpected(size.error());
  if (o.frames > 0 && o.model.files.empty()) return core::fail("--frames needs a MODEL");
  auto window = apps::Window::open("Sightline", *size, o.frames == 0 && o.script.empty());
  if (!window) return tl::unexpected(window.error());
  auto gui = apps::Gui::create(*window, o.theme == "light" ? apps::Theme::kLight : apps::Theme::kDark, o.scale);
  if (!gui) return tl::unexpected(gui.error());
  return apps::Viewer(o, *window, std::move(*gui), std::move(settings)).run();
}

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line("Opens a window to look at models in", "sightline-view",
                         "  sightline-view plant.rvm\n"
                         "  sightline-view a.rvm b.rvm --culler hybrid --size 1920x1080\n"
                         "  sightline-view plant.rvm --script tour.txt  # --help-all lists its commands");
  line.appendix(apps::command_list());
  apps::ViewerOptions options;
  add_options(line, options);
  return line.run(argc, argv, [&] { return view(line, options); });
}
