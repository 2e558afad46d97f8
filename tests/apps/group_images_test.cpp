#include "sightline/apps/compare/group_images.h"

#include <gtest/gtest.h>

#include "sightline/apps/common/change_colours.h"
#include "sightline/render/image/image.h"

namespace sightline::tests::group_images_test {
namespace {

using apps::GroupImage;
using compare::Way;

/// A row of four boxes, of which the first stays.
struct Revision {
  core::Scene scene;
  core::NodeId file;

  explicit Revision(bool later) {
    file = scene.add_node(scene.root(), later ? "new" : "old");
    add("same", 0.0, 1.0f);
    add("moved", later ? 3.5 : 3.0, 0.9f);
    later ? add("added", 6.0, 0.8f) : add("removed", 9.0, 0.7f);
    EXPECT_TRUE(scene.commit());
  }
  void add(const char* name, double x, float side) {
    scene.add_primitive(scene.add_node(file, name), core::Box{side, side, side}, core::translation({x, 0.0, 0.0}));
  }
};

/// How many pixels have about the hue of a colour, by the shares of red, green and blue.
int pixels_of(const std::vector<std::uint8_t>& png, const core::vec3& colour) {
  const auto image = image::decode_png(png);
  EXPECT_TRUE(image);
  int count = 0;
  for (std::size_t i = 0; image && i < image->pixels.size(); i += 3) {
    const core::vec3 pixel(image->pixels[i], image->pixels[i + 1], image->pixels[i + 2]);
    const core::vec3 share = pixel / std::max(1.0f, pixel.r + pixel.g + pixel.b);
    count += glm::length(share - colour / (colour.r + colour.g + colour.b)) < 0.08f;
  }
  return count;
}

TEST(GroupImages, ShowWhatChangedBeforeAndAfter) {
  Revision before(false), after(true);
  const auto found = apps::compare_revisions({&before.scene, before.file}, {&after.scene, after.file}, {});
  ASSERT_TRUE(found);
  ASSERT_EQ(found->groups.all.size(), 3u);
  const auto images = apps::group_images(*found, before.scene, after.scene);
  ASSERT_TRUE(images) << images.error().message;
  ASSERT_EQ(images->size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const compare::Group& group = found->groups.all[i];
    const GroupImage& image = (*images)[i];
    EXPECT_EQ(image.before.empty(), group.way == Way::kAdded);
    EXPECT_EQ(image.after.empty(), group.way == Way::kRemoved);
    for (const std::vector<std::uint8_t>& png : {image.before, image.after})
      for (const compare::State state : {compare::State::kAdded, compare::State::kRemoved, compare::State::kMoved}) {
        if (png.empty()) continue;
        const int pixels = pixels_of(png, *apps::change_colour(state));
        if (state == apps::shown_as(group.way))
          EXPECT_GT(pixels, 2000) << compare::name_of(group.way);
        else
          EXPECT_LT(pixels, 50) << compare::name_of(group.way) << " in " << compare::name_of(state);
      }
  }
}

TEST(GroupImages, OfMovesAreSeenFromOnePlaceUnlessTheyAreLong) {
  Revision before(false), after(true);
  auto found = apps::compare_revisions({&before.scene, before.file}, {&after.scene, after.file}, {});
  ASSERT_TRUE(found);
  auto moved = std::find_if(found->groups.all.begin(), found->groups.all.end(),
                            [](const compare::Group& group) { return group.way == Way::kMoved; });
  ASSERT_NE(moved, found->groups.all.end());
  const auto boxes = [&] {
    return std::pair(apps::box_of(*found, *moved, apps::Revision::kOlder),
                     apps::box_of(*found, *moved, apps::Revision::kNewer));
  };
  auto [older, newer] = boxes();
  EXPECT_EQ(older.min, newer.min);
  EXPECT_NEAR(newer.size().x, 0.9 + 0.5, 1e-6);
  moved->offset = {50.0, 0.0, 0.0};
  std::tie(older, newer) = boxes();
  EXPECT_NEAR(newer.min.x - older.min.x, 50.0, 1e-6);
}

}  // namespace
}  // namespace sightline::tests::group_images_test
