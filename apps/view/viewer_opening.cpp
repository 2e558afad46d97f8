// Models, from a file's name to the image: reading, swapping into the window, and what becomes of it where that fails.
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <utility>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/view/viewer.h"
#include "sightline/importers/view_json.h"

namespace sightline::apps {
namespace {

constexpr double kShareOfEngine = 0.9;  // of the progress after reading; the rest is swapping in

std::string name_of_files(const std::vector<std::string>& files) {
  std::string name = files.empty() ? "" : std::filesystem::path(files[0]).filename().string();
  if (files.size() > 1) name += " and " + std::to_string(files.size() - 1) + " more";
  return name;
}

/// The text of the bottom line; all of the report is in the tab Item.
std::string recognised_items(const importers::RecognitionReport& report) {
  if (report.meshes == 0) return "";
  const std::uint64_t items = std::accumulate(report.items.begin(), report.items.end(), std::uint64_t{0});
  return ", " + std::to_string(items) + " of them recognised in meshes";
}

}  // namespace

void Viewer::open(const std::vector<std::string>& files) {
  drop_loading();
  ModelOptions model = options_.model;
  model.files = files;
  model.import.recognise = shown.recognise;
  if (!session_) {
    preview_ = std::make_unique<Preview>(image_config());
    model.follow = [preview = preview_.get()](const core::Scene& scene) {
      if (preview->follow(scene)) Window::wake();
    };
  }
  // The window goes on while the engine is made.
  const auto make_session = [this, config = image_config()](Model& read, const auto& go_on) -> core::Expected<void> {
    const auto part = [&](double share) { return go_on(kShareOfEngine * share); };
    if (!part(0.0)) return core::fail(std::string(importers::kCancelled));
    auto session = Session::open(std::move(read), config, part);
    if (!part(1.0)) return core::fail(std::string(importers::kCancelled));
    if (!session) return tl::unexpected(session.error());
    opened_ = std::move(*session);
    return {};
  };
  loader_ = std::make_unique<Loader>(model, &Window::wake, make_session);
  found_.reset();
  opening_ = {};
  opening_.enter(OpeningStep::kReading);
  engine_portions_ = 0;
  if (shown.dialog == Dialog::kOpen) shown.dialog = Dialog::kNone;
  tell("reading " + name_of_files(files));
}

bool Viewer::y_is_up() const {
  if (options_.model.import.up != importers::UpAxis::kAutomatic)
    return options_.model.import.up == importers::UpAxis::kY;
  return session_ && session_->model().seems_y_up;
}

void Viewer::toggle_up() {
  options_.model.import.up = y_is_up() ? importers::UpAxis::kZ : importers::UpAxis::kY;
  if (!files_.empty()) open(std::vector(files_));
}

void Viewer::drop_loading() {
  opening_.enter(OpeningStep::kNone);
  loader_.reset();  // first: its thread uses preview and model
  opened_.reset();
  swapping_in_ = false;
}

void Viewer::cancel_loading() {
  if (loader_) loader_->cancel();
}

/// Shows the model that was being read, once it is there: portion by portion, while the window goes on. What is open
/// stays where the file cannot be read.
core::Expected<void> Viewer::land() {
  if (!loader_ || export_ || model_export_) return {};
  follow_opening();
  if (!swapping_in_) {
    auto model = loader_->take();
    if (!model) return {};
    if (found_) {
      const std::string file = loader_->options().files.front();
      drop_loading();
      redraws_ = kSettlingFrames;
      return land_comparison(std::move(*model), file), core::Expected<void>();
    }
    if (!*model) return not_landed(model->error());
    swapping_in_ = true;
    if (window_.context().capabilities().software) opened_->set_default_budget(options_.default_budget_ms);
  }
  if (loader_->cancelled()) return not_landed({std::string(importers::kCancelled)});
  part_ = viewport();
  ++engine_portions_;
  const auto done = opened_->begin(window_.context(), {part_.width, part_.height});
  if (!done) return lost() ? core::Expected<void>() : not_landed(done.error());
  return *done ? landed() : core::Expected<void>();
}

/// Reading may have ended long before this frame, which is why the loader says when.
void Viewer::follow_opening() {
  if (opening_.step() == OpeningStep::kReading && loader_->read_at() != OpeningSteps::Clock::time_point())
    opening_.enter(OpeningStep::kBuilding, loader_->read_at());
  if (!swapping_in_) return;
  const OpeningStep step = opened_->uploaded() ? OpeningStep::kDrawing : OpeningStep::kUploading;
  if (step != opening_.step()) opening_.enter(step);
}

core::Expected<void> Viewer::not_landed(const core::Error& error) {
  const bool first = !session_ && loader_->options().files == options_.model.files;
  drop_loading();
  preview_.reset();
  redraws_ = kSettlingFrames;
  if (first && (options_.frames > 0 || !options_.script.empty())) return tl::unexpected(error);
  tell(error.message, true);
  if (first) std::fprintf(stderr, "sightline-view: %s\n", error.message.c_str());
  return {};
}

core::Expected<void> Viewer::landed() {
  const std::vector<std::string> files = loader_->options().files;
  const bool another = session_ != nullptr, first = !another && files == options_.model.files;
  const bool recognised = loader_->options().import.recognise;
  loader_.reset();
  preview_.reset();
  opening_.enter(OpeningStep::kNone);
  recognised_ = recognised;
  swapping_in_ = false;
  redraws_ = kSettlingFrames;
  print_warnings(opened_->model().report.warnings);
  set_walking(false);
  section_handles_.forget();
  session_ = std::move(opened_);
  keeps_moving_image_ = false;
  shown_view_.reset();
  if (const engine::EngineConfig& config = session_->engine().config();
      shown.depth_shading != config.drawing.looks.depth_shading.any() ||
      shown.hatching != config.drawing.looks.hatching.any())  // switched meanwhile
    if (auto done = apply_styles(); !done) return done;
  if (const double error = shown.levels ? options_.shown.lod_error : 0.0; error != session_->motion_error())
    if (auto done = session_->set_motion_error(error); !done) return done;
  files_ = files;
  thumbnail_due_ = true;
  for (const std::string& file : files)  // attributes alone open nothing
    if (!importers::is_attribute_file(file)) now_.add_recent(file);
  warn_of_outliers(session_->bounds());
  if (options_.model.explain) explain(session_->engine().plan());
  if (const auto& path = player_.path(); path && !another) {
    session_->camera().set_planes(path->near, path->far);
    player_.play();
  }
  window_.set_title(name_of_files(files) + " - Sightline");
  if (first && !settings_.damage().empty())
    tell(settings_.damage(), true);
  else
    tell(grouped(std::int64_t(session_->scene().item_count())) + " items" +
         recognised_items(session_->model().report.recognition) +
         (session_->model().seems_y_up ? "; y seems to point up, so it is turned: File, Y is up" : ""));
  return {};
}

core::Expected<void> Viewer::read_path() {
  if (options_.path.empty()) return {};
  auto path = importers::read_path(options_.path);
  if (path && !options_.model.translate.empty())
    path = importers::translated(*path, *parse_vector(options_.model.translate));
  if (!path) return tl::unexpected(path.error());
  player_.set_path(std::move(*path));
  return {};
}

}  // namespace sightline::apps
