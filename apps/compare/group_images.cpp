#include "sightline/apps/compare/group_images.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "sightline/apps/common/change_colours.h"
#include "sightline/apps/common/model.h"
#include "sightline/core/fitting.h"
#include "sightline/engine/engine.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {
namespace {

constexpr int kWidth = 400, kHeight = 300;
static_assert(3 * kWidth == 4 * kHeight && kGroupAspect == 4.0 / 3.0);
constexpr core::vec3 kOther{1.0f, 0.45f, 0.05f};  // of what is only renamed
constexpr engine::ItemStyle kShell{.ghost = true};

using Png = std::vector<std::uint8_t>;

/// Draws groups of one revision.
class Drawer {
 public:
  Drawer(const Compared& compared, core::Scene& scene, Revision revision)
      : compared_(&compared), scene_(&scene), revision_(revision) {}

  /// Empty where this revision has nothing of the group.
  core::Expected<Png> draw(const compare::Group& group) {
    const std::vector<core::ItemId> items = items_of(*compared_, group, revision_);
    if (items.empty()) return Png();
    if (auto done = begin(); !done) return tl::unexpected(done.error());
    const core::vec3 colour = change_colour(shown_as(group.way)).value_or(kOther);
    const core::AabbD box = box_of(*compared_, group, revision_);
    const auto view = core::View::fit(box, core::kOverviewDirection, kFovy, kGroupAspect, kGroupFilled);
    if (!view) return Png();  // there is nothing to see
    if (auto done = engine_->set_override(items, {.colour = colour}); !done) return tl::unexpected(done.error());
    if (const auto drawn = engine_->frame(*view); !drawn) return tl::unexpected(drawn.error());
    const auto image = engine_->read_colour();
    if (!image) return tl::unexpected(image.error());
    if (auto done = engine_->set_override(items, kShell); !done) return tl::unexpected(done.error());
    return image::encode_png(*image, image::PngSize::kSmall);
  }

 private:
  /// Makes the engine, in which everything is faint.
  core::Expected<void> begin() {
    if (engine_) return {};
    engine::EngineConfig config;
    config.draw = true;
    config.width = kWidth;
    config.height = kHeight;
    config.drawing.renderer = engine::Renderer::kRays;
    config.drawing.looks = DrawnOptions{.looks = engine::Looks::standard()}.looks_of(*scene_);
    auto made = engine::Engine::create(*scene_, config);
    if (!made) return tl::unexpected(made.error());
    std::vector<core::ItemId> all;
    for (core::ItemId item{0}; to_index(item) < scene_->item_slots(); ++item)
      if (scene_->contains_item(item)) all.push_back(item);
    engine_ = std::move(*made);
    return engine_->set_override(all, kShell);
  }

  const Compared* compared_;
  core::Scene* scene_;
  Revision revision_;
  std::optional<engine::Engine> engine_;
};

}  // namespace

core::Expected<std::vector<GroupImage>> group_images(const Compared& compared, core::Scene& before, core::Scene& after,
                                                     const std::function<void(double)>& progress) {
  Drawer older(compared, before, Revision::kOlder), newer(compared, after, Revision::kNewer);
  std::vector<GroupImage> images(std::min(kMostImages, compared.groups.all.size()));
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (const auto& [drawer, png] : {std::pair(&older, &images[i].before), std::pair(&newer, &images[i].after)}) {
      auto drawn = drawer->draw(compared.groups.all[i]);
      if (!drawn) return tl::unexpected(drawn.error());
      *png = std::move(*drawn);
    }
    if (progress) progress(double(i + 1) / double(images.size()));
  }
  return images;
}

}  // namespace sightline::apps
