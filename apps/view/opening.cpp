#include "sightline/apps/view/opening.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "sightline/apps/view/window.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/import.h"
#include "sightline/importers/internal/extension.h"

namespace sightline::apps {
namespace {

constexpr double kShareOfEngine = 0.9;  // of the progress after reading; the rest is swapping in

}  // namespace

std::string name_of_files(const std::vector<std::string>& files) {
  std::string name = files.empty() ? "" : std::filesystem::path(files[0]).filename().string();
  if (files.size() > 1) name += " and " + std::to_string(files.size() - 1) + " more";
  return name;
}

bool readable_in_part(const std::vector<std::string>& files) {
  const auto extension = [](const std::string& file) {
    return importers::lower_case_extension(core::platform::path_of(file));
  };
  const auto is_model = [&](const std::string& file) {
    std::error_code none;
    return std::filesystem::is_regular_file(core::platform::path_of(file), none) &&
           std::ranges::count(importers::known_extensions(), extension(file)) > 0;
  };
  const auto is_cache = [&](const std::string& file) { return extension(file) == ".slc"; };
  return std::ranges::all_of(files, is_model) && !std::ranges::all_of(files, is_cache);
}

void Opening::open(const std::vector<std::string>& files, const engine::EngineConfig& config, Reading reading,
                   bool previews) {
  drop();
  ModelOptions model = options_;
  model.files = files;
  model.import.recognise = reading.recognise;
  model.import.lenient |= reading.lenient;
  if (previews) {
    preview_ = std::make_unique<Preview>(config);
    model.follow = [preview = preview_.get()](const core::Scene& scene) {
      if (preview->follow(scene)) Window::wake();
    };
  }
  // The window goes on while the engine is made.
  begin(model, [this, config, files, reading](Model& read, const auto& go_on) -> core::Expected<void> {
    const auto part = [&](double share) { return go_on(kShareOfEngine * share); };
    if (!part(0.0)) return core::fail(std::string(importers::kCancelled));
    auto session = Session::open(std::move(read), config, part);
    if (!part(1.0)) return core::fail(std::string(importers::kCancelled));
    if (!session) return tl::unexpected(session.error());
    opened_ = std::move(*session);
    opened_->files = files;
    opened_->reading = reading;
    opened_->set_default_budget(default_budget_ms_);
    return {};
  });
}

void Opening::compare(const std::string& file, const Session& open) {
  drop();
  ModelOptions older = options_;
  older.files = older_files(file, open.files);
  older.import.recognise = open.reading.recognise;
  older.import.lenient |= open.reading.lenient;
  older.import.copies = importers::MeshCopies::kExact;  // similar copies may be moved by a little
  auto found = std::make_shared<Compared>();
  begin(older, [found, open = &open.model()](Model& model, const auto& progress) -> core::Expected<void> {
    auto comparison = compare_models(model, *open, progress);
    if (!comparison) return tl::unexpected(comparison.error());
    *found = std::move(*comparison);
    return {};
  });
  found_ = std::move(found);
}

void Opening::begin(const ModelOptions& model, Loader::Work work) {
  loader_ = std::make_unique<Loader>(model, &Window::wake, std::move(work));
  steps_ = {};
  steps_.enter(OpeningStep::kReading);
  portions_ = 0;
}

void Opening::cancel() {
  if (loader_) loader_->cancel();
}

void Opening::drop() {
  steps_.enter(OpeningStep::kNone);
  loader_.reset();  // first: its thread uses preview and model
  opened_.reset();
  found_.reset();
  swapping_in_ = false;
}

core::Expected<Opening::Opened> Opening::step(gl::Context& context, const std::array<int, 2>& size) {
  if (!loader_) return Opened{};
  follow();
  auto opened = land(context, size);
  if (!opened && context.lost()) return Opened{};
  if (!opened || opened->session) preview_.reset();
  if (!opened || opened->session || opened->changes) drop();
  return opened;
}

core::Expected<Opening::Opened> Opening::land(gl::Context& context, const std::array<int, 2>& size) {
  if (!swapping_in_) {
    auto model = loader_->take();
    if (!model) return Opened{};
    if (!*model) return tl::unexpected(model->error());
    if (found_)
      return Opened{nullptr, std::make_unique<ChangeList>(files().front(), std::move(**model), std::move(*found_))};
    swapping_in_ = true;
  }
  if (loader_->cancelled()) return core::fail(std::string(importers::kCancelled));
  ++portions_;
  const auto done = opened_->begin(context, size);
  if (!done) return tl::unexpected(done.error());
  return Opened{*done ? std::move(opened_) : nullptr, nullptr};
}

/// Reading may have ended long before this frame, which is why the loader says when.
void Opening::follow() {
  if (steps_.step() == OpeningStep::kReading && loader_->read_at() != OpeningSteps::Clock::time_point())
    steps_.enter(OpeningStep::kBuilding, loader_->read_at());
  if (!swapping_in_) return;
  const OpeningStep step = opened_->uploaded() ? OpeningStep::kDrawing : OpeningStep::kUploading;
  if (step != steps_.step()) steps_.enter(step);
}

bool Opening::y_is_up(const Session* open) const {
  if (options_.import.up != importers::UpAxis::kAutomatic) return options_.import.up == importers::UpAxis::kY;
  return open && open->model().seems_y_up;
}

void Opening::toggle_up(const Session* open) {
  options_.import.up = y_is_up(open) ? importers::UpAxis::kZ : importers::UpAxis::kY;
}

}  // namespace sightline::apps
